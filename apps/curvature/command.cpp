#include "../program/run.hpp"

namespace beltrami::program {

void add_curvature(CLI::App& program, Run& run) {
    auto* const command = program.add_subcommand("curvature", "mean curvature and its normal, -c K x");
    run.add_options(*command, {.output = true, .solver = false});
    auto correction = std::make_shared<std::string>("c2");
    command->add_option("--correction", *correction, "c1 = 4 cos^2(pi/n)/A or c2 = 3/A (default: c2)")
        ->check(CLI::IsMember({"c1", "c2"}));
    command->callback([&run, correction] {
        const Mesh mesh = run.load_mesh();
        const Laplacian laplacian = run.build(mesh);
        const MeanCurvature curvature = run.timed("solve", [&] {
            return mean_curvature(mesh, laplacian,
                                  *correction == "c1" ? CurvatureCorrection::c1 : CurvatureCorrection::c2);
        });
        if (curvature.boundary_vertices > 0) {
            run.warn(fmt::format("{} boundary vertices have no mean curvature: it is set to 0 there",
                                 curvature.boundary_vertices));
        }
        run.write(mesh, {{"mean_curvature", curvature.mean}, {"mean_curvature_normal", curvature.normal}});
        run.finish();
    });
}

}  // namespace beltrami::program
