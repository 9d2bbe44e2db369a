#include "beltrami/apps/spectrum/spectrum_table.hpp"

#include "../program/spectral.hpp"

namespace beltrami::program {

namespace {

// Refuses what the disk cannot hold before any work.
void check_space(const std::filesystem::path& folder, double bytes) {
    std::error_code error;
    const std::filesystem::space_info space = std::filesystem::space(folder, error);
    if (error || static_cast<double>(space.available) > bytes) return;
    throw InputError(fmt::format("the basis takes {:.1f} GB and the disk of {} has {:.1f} GB left",
                                 bytes / 1e9, folder.string(), static_cast<double>(space.available) / 1e9),
                     "free some space, ask for fewer pairs, or store them with --float");
}

/// The lowest functions, and the spectrum.
void gather(Report& report, const StoredBasis& basis, const Mesh& mesh, double measure) {
    constexpr Index most_functions = 12;
    for (Index k = 0; k < std::min(basis.count(), most_functions); ++k)
        report.also_show({{fmt::format("function-{}", k), basis.function(k)}});
    const SpectrumTable table = spectrum_table(basis, measure, mesh.kind(), nullptr);
    for (const Chart& chart : spectrum_charts(table, "spectrum"))
        report.chart(chart);
    const Eigen::Index n = table.frequencies.size();
    report.chart({.title = "frequencies",
                  .across = "number",
                  .up = "radians a unit of length",
                  .lines = {{.name = {},
                             .x = Vector::LinSpaced(n, 0.0, static_cast<double>(n - 1)),
                             .y = table.frequencies}}});
}

}  // namespace

void add_harmonics(CLI::App& program, Run& run) {
    struct Options {
        OperatorOptions op;
        SpectrumCommandOptions spectrum;
        std::string folder;
        int count = 0;
        std::string cutoff;
        std::optional<Index> shown;
        bool resume = false;
        bool single = false;
    };
    auto* const command = program.add_subcommand(
        "harmonics",
        "the manifold harmonics: eigenfunctions of the Laplacian, with a proof that none is missing");
    run.add_options(*command, {.output = false, .solver = false, .picture = true});
    auto options = std::make_shared<Options>();
    auto* const count =
        command->add_option("-k,--count", options->count, "so many of the lowest")->option_text("N");
    command
        ->add_option("--cutoff", options->cutoff,
                     "all up to this frequency: radians a unit of length, or 10e for waves of 10 mean edges")
        ->excludes(count)
        ->option_text("W");
    command->add_option("-o,--output", options->folder, "the folder of the basis, for NumPy and beltrami")
        ->required()
        ->option_text("BASIS");
    add_spectrum_options(*command, options->spectrum);
    add_operator_options(*command, options->op);
    command->add_flag("--resume", options->resume, "go on with what an earlier run left in the folder");
    command->add_option("--show", options->shown, "the function in the picture, from 0 (default: the last)")
        ->option_text("K");
    command->add_flag("--float", options->single, "store functions in 4 bytes a number instead of 8");
    command->callback([&run, options] {
        if (options->count <= 0 && options->cutoff.empty()) {
            throw InputError("it is not said which functions are wanted",
                             "give a positive count with -k N, or a frequency with --cutoff W");
        }
        if (options->shown &&
            (*options->shown < 0 || (options->count > 0 && *options->shown >= options->count))) {
            throw InputError(
                fmt::format("--show {} is not one of {} functions", *options->shown, options->count),
                "functions are counted from 0");
        }
        const Mesh mesh = run.load_mesh();
        const SpectralProblem made = spectral_problem(run, mesh, options->op);
        SpectrumOptions spectral =
            spectrum_options(run, options->spectrum, mesh, made.laplacian, options->folder);
        spectral.count = options->count;
        if (!options->cutoff.empty()) {
            spectral.cutoff = parse_frequency(options->cutoff, {.mean_edge = run.mesh_report().mean_edge});
            if (!(spectral.cutoff > 0.0)) {
                throw InputError(fmt::format("the cutoff {} is not a frequency above 0", options->cutoff),
                                 "give a positive number, or 10e for waves of 10 mean edges");
            }
        }
        if (spectral.count > made.problem.rows()) {
            throw InputError(fmt::format("{} functions are asked for, and there are {} free vertices",
                                         spectral.count, made.problem.rows()),
                             fmt::format("ask for {} at most", made.problem.rows()));
        }
        BasisWriter writer(options->folder, mesh, made.laplacian, made.problem, made.description,
                           {.type = options->single ? NpyType::float32 : NpyType::float64,
                            .resume = options->resume,
                            .plain_product = options->op.laplacian == name(SpectralLaplacian::weighted)});
        if (writer.satisfies(spectral)) {
            run.say("basis",
                    fmt::format("{} is complete already: {} functions", options->folder, writer.present()));
        } else {
            if (writer.present() > 0)
                run.say("resume", fmt::format("{} functions are there already", writer.present()));
            spectral = writer.continued(spectral);
            const Index more = std::max<Index>(spectral.count - writer.present(), 0);
            check_space(options->folder, writer.disk_bytes(more));
            spectral.on_plan = [&run, &writer, &spectral](const SpectrumPlan& plan) {
                run.say("needs",
                        fmt::format("{:.0f} MB of memory, {:.0f} MB of it for a factor{}{}",
                                    plan.memory_bytes / 1e6, plan.factor_bytes / 1e6,
                                    plan.factor_disk_bytes > 0.0
                                        ? fmt::format(", which has {:.0f} MB more on disk",
                                                      plan.factor_disk_bytes / 1e6)
                                        : std::string(),
                                    spectral.count > 0 ? fmt::format("; {:.0f} MB on disk for the basis",
                                                                     writer.disk_bytes(spectral.count) / 1e6)
                                                       : std::string()));
            };
            try {
                const SpectrumSummary summary =
                    run.timed("solve", [&] { return spectrum(made.problem, spectral, writer.sink()); });
                writer.finish(summary);
                record(run, summary);
            } catch (const Cancelled&) {
                throw Cancelled(fmt::format("cancelled: {} functions are kept in {}, go on with --resume",
                                            writer.present(), options->folder));
            }
        }
        const StoredBasis basis(options->folder);
        run.result()["certificate"] = {{"complete", basis.complete()},
                                       {"max_residual", basis.max_residual()},
                                       {"max_orthogonality_error", basis.max_orthogonality_error()}};
        run.result()["count"] = basis.count();
        run.wrote(options->folder);
        if ((run.wants_picture() || run.wants_report()) && basis.count() > 0) {
            const Index shown = options->shown.value_or(basis.count() - 1);
            run.write(mesh, {{fmt::format("function-{}", shown), basis.function(shown)}});
        }
        if (Report* const report = run.for_report()) gather(*report, basis, mesh, run.mesh_report().measure);
        run.finish();
    });
}

}  // namespace beltrami::program
