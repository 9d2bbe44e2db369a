#include <cmath>

#include "../program/run.hpp"
#include "../program/values.hpp"

namespace beltrami::program {

void add_interpolate(CLI::App& program, Run& run) {
    struct Options {
        std::vector<std::string> fix;
        std::string fix_file;
        std::optional<double> laplacian;
        std::optional<double> bilaplacian;
        bool keep = false;
    };
    auto* const command = program.add_subcommand(
        "interpolate", "the smoothest field that takes given values at given vertices");
    run.add_options(*command, {});
    auto options = std::make_shared<Options>();
    command->add_option("--fix", options->fix, "a vertex and its value")->option_text("V=x[,y,z] ...");
    command->add_option("--fix-file", options->fix_file, "rows vertex,x[,y,z]")->option_text("FILE.csv");
    command
        ->add_option("--laplacian", options->laplacian,
                     "weight of the Laplacian (default: 1 if neither is given)")
        ->option_text("G1");
    command
        ->add_option("--bilaplacian", options->bilaplacian,
                     "weight of the bi-Laplacian, in length^2 (default: 0)")
        ->option_text("G2");
    add_free_components(*command, options->keep);
    command->callback([&run, options] {
        const Mesh mesh = run.load_mesh();
        const Constraints fixed =
            parse_values("--fix", options->fix, options->fix_file, 0, mesh.vertex_count());
        const bool neither = !options->laplacian && !options->bilaplacian;
        InterpolateOptions interpolation;
        interpolation.laplacian = options->laplacian.value_or(neither ? 1.0 : 0.0);
        interpolation.bilaplacian = options->bilaplacian.value_or(0.0);
        interpolation.free_components = free_components(options->keep);
        interpolation.linear = run.linear_options();
        const Laplacian laplacian = run.build(mesh);
        const InterpolateResult result =
            run.timed("solve", [&] { return interpolate(laplacian, fixed, interpolation); });
        run.record(result.summary);
        if (interpolation.bilaplacian == 0.0) {
            // What is not given is NaN; components that are kept at zero hold zeros.
            Block given = Block::Constant(result.value.rows(), result.value.cols(), NAN);
            hold_free_components(laplacian, fixed, interpolation.free_components).impose(given);
            run.warn_outside(laplacian, result.value, given);
        }
        run.write(mesh, {{"value", result.value}});
        run.finish();
    });
}

}  // namespace beltrami::program
