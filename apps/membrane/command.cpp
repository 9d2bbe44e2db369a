#include <numeric>

#include "../program/moving.hpp"
#include "../program/region.hpp"

namespace beltrami::program {

void add_membrane(CLI::App& program, Run& run) {
    struct Options {
        RegionOptions region{.fourth_way = "--fix-boundary"};
        SeriesOptions series;
        std::string weights = "area";
        double step = 1.0;
        std::optional<int> steps;
        bool keep = false;
    };
    auto* const command =
        program.add_subcommand("membrane", "the film of least area that the fixed part of a surface holds");
    run.add_options(*command, {});
    auto options = std::make_shared<Options>();
    command->add_flag("--fix-boundary", options->region.off_boundary,
                      "the region that moves: all but the boundary");
    add_region_options(*command, options->region);
    command
        ->add_option("--weights", options->weights,
                     "area keeps triangles equal, cotangent lets them collapse (default: area)")
        ->check(CLI::IsMember({"area", "cotangent"}))
        ->option_text("NAME");
    command
        ->add_option("--step", options->step,
                     "of the flow; in time 1 it smooths across the region (default: 1)")
        ->option_text("S");
    command->add_option("--steps", options->steps, "at most so many steps (default: until rest)")
        ->option_text("N");
    add_series_options(*command, options->series);
    add_free_components(*command, options->keep);
    command->callback([&run, options] {
        if (!options->series.path.empty()) run.also_writes(options->series.path);
        if (options->steps && *options->steps < 1)
            throw InputError(fmt::format("--steps {}", *options->steps), "take at least one");
        const Mesh mesh = run.load_mesh();
        if (options->region.off_boundary && boundary_vertices(mesh).empty()) {
            throw InputError("--fix-boundary on a mesh that has no boundary",
                             "name the region that moves with --region-file, --region-field or --box");
        }
        const std::vector<Index> moving = region(mesh, options->region);
        MembraneOptions shrinking;
        shrinking.flow.weights = options->weights == "area" ? Weights::area_weighted : Weights::cotangent;
        shrinking.flow.step = options->step;
        shrinking.flow.linear = run.linear_options();
        shrinking.steps = options->steps.value_or(0);
        shrinking.free_components = free_components(options->keep);
        shrinking.progress = run.progress();
        const Laplacian laplacian = run.build(mesh);
        MembraneResult result;
        run_moving(run, options->series, mesh, [&](const auto& on_frame) {
            shrinking.on_frame = on_frame;
            result = membrane(mesh, laplacian, moving, shrinking);
        });
        run.record(result.summary);
        if (Report* const report = run.for_report()) {
            std::vector<double> numbers(result.areas.size());
            std::iota(numbers.begin(), numbers.end(), 0.0);
            report->chart({.title = "area of the region",
                           .across = "step",
                           .up = "area",
                           .lines = {line_of("", numbers, result.areas)}});
        }
        const std::size_t steps = result.areas.size() - 1;
        run.say("region", fmt::format("{} of {} vertices may move", moving.size(), mesh.vertex_count()));
        run.say("flow", fmt::format("{} steps to time {:.3g}, {}; area of the region from {:.6g} to {:.6g}",
                                    steps, result.time, result.at_rest ? "at rest" : "not yet at rest",
                                    result.areas.front(), result.areas.back()));
        run.result()["region"] = moving.size();
        run.result()["stayed"] = result.stayed;
        run.result()["weights"] = options->weights;
        run.result()["time"] = result.time;
        run.result()["steps"] = steps;
        run.result()["at_rest"] = result.at_rest;
        run.result()["areas"] = result.areas;
        run.result()["energy"] = result.energy;
        if (result.stayed > 0)
            run.warn(fmt::format("{} isolated vertices of the region stay", result.stayed));
        write_moved(run, mesh, result.points);
        run.finish();
    });
}

}  // namespace beltrami::program
