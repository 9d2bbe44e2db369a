#include "beltrami/apps/spectrum/spectrum_table.hpp"

#include "../program/spectral.hpp"

namespace beltrami::program {

void add_spectrum(CLI::App& program, Run& run) {
    struct Options {
        std::string basis;
        std::string on;
        std::string output;
        std::string picture;
    };
    auto* const command = program.add_subcommand(
        "spectrum", "eigenvalues, shape DNA and the spectrum of what lies on a mesh, as a table and a chart");
    run.add_options(*command, {.output = false, .solver = false});
    auto options = std::make_shared<Options>();
    add_basis_option(*command, options->basis);
    command
        ->add_option("--on", options->on,
                     "positions, normals, colors or a field's name: its amplitude at each function, and the "
                     "error of what is made of the functions so far")
        ->option_text("WHAT");
    command->add_option("-o,--output", options->output, "the table")->option_text("SPECTRUM.csv");
    command->add_option("--picture", options->picture, "the chart")->option_text("FILE.png");
    command->callback([&run, options] {
        if (options->output.empty() && options->picture.empty() && !run.wants_report())
            throw InputError("nothing would be written",
                             "say where to with -o SPECTRUM.csv, --picture FILE.png or --report FILE.html");
        if (!options->output.empty()) run.also_writes(options->output, "-o");
        if (!options->picture.empty()) {
            run.also_writes(options->picture, "--picture");
            if (!options->picture.ends_with(".png"))
                throw InputError("--picture " + options->picture + " is not a .png", "name it FILE.png");
        }
        const Mesh mesh = run.load_mesh();
        if (mesh.kind() == CellKind::point)
            throw InputError("points alone have no spectrum", "give a mesh with cells");
        Block field;
        if (!options->on.empty()) field = field_on(mesh, options->on);
        const StoredBasis basis = open_basis(run, options->basis, mesh);
        const double measure = run.mesh_report().measure;
        const SpectrumTable table = run.timed("solve", [&] {
            return spectrum_table(basis, measure, mesh.kind(), options->on.empty() ? nullptr : &field,
                                  run.progress());
        });
        const Eigen::Index last = table.eigenvalues.size() - 1;
        run.result()["count"] = table.eigenvalues.size();
        run.result()["zero_modes"] = basis.zero_modes();
        run.result()["measure"] = measure;
        run.result()["largest"] = table.eigenvalues[last];
        run.result()["weyl_ratio"] = last > 0 ? table.eigenvalues[last] / table.weyl[last] : 1.0;
        run.say("spectrum", fmt::format("{} eigenvalues up to {:.6g}; Weyl's law has {:.6g} there", last + 1,
                                        table.eigenvalues[last], table.weyl[last]));
        if (!options->on.empty()) {
            run.result()["on"] = options->on;
            run.result()["error"] = table.errors[last];
            run.say("error", fmt::format("{:.4g} of {} is left by {} functions", table.errors[last],
                                         options->on, last + 1));
        }
        if (!options->output.empty()) {
            write_whole(options->output, [&](std::ostream& out) { out << to_csv(table); });
            run.wrote(options->output);
        }
        const std::string title =
            options->on.empty() ? std::string("spectrum") : "spectrum, and " + options->on + " in it";
        if (Report* const report = run.for_report()) {
            for (const Chart& chart : spectrum_charts(table, title))
                report->chart(chart);
        }
        if (!options->picture.empty()) {
            run.timed("write", [&] { write_picture(options->picture, draw_spectrum(table, title)); });
            run.wrote(options->picture);
        }
        run.finish();
    });
}

}  // namespace beltrami::program
