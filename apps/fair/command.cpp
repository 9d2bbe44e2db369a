#include "../program/moving.hpp"
#include "../program/region.hpp"

namespace beltrami::program {

void add_fair(CLI::App& program, Run& run) {
    struct Options {
        RegionOptions region{.fourth_way = "--all (with --time)"};
        SeriesOptions series;
        TermWeights weights;
        std::optional<double> time;
        std::optional<int> steps;
        bool keep = false;
    };
    auto* const command = program.add_subcommand("fair", "a region made smooth while the rest stays");
    run.add_options(*command, {});
    auto options = std::make_shared<Options>();
    add_region_options(*command, options->region);
    command->add_flag("--all", options->region.all, "every vertex may move (with --time)");
    add_term_weights(*command, options->weights);
    command->add_option("--time", options->time, "let the flow run for so long (default: until rest)")
        ->option_text("T");
    command->add_option("--steps", options->steps, "in how many steps (default: 1)")->option_text("N");
    add_series_options(*command, options->series);
    add_free_components(*command, options->keep);
    command->callback([&run, options] {
        if (!options->series.path.empty()) run.also_writes(options->series.path);
        if (!options->time && (options->steps || !options->series.path.empty())) {
            throw InputError("steps and a series are those of a flow, but no --time is given",
                             "say for how long with --time T, or leave them out to go until rest");
        }
        const Mesh mesh = run.load_mesh();
        const std::vector<Index> moving = region(mesh, options->region);
        FairOptions fairing;
        fairing.laplacian = options->weights.of_laplacian();
        fairing.bilaplacian = options->weights.of_bilaplacian();
        fairing.time = options->time;
        fairing.steps = options->steps.value_or(1);
        fairing.free_components = free_components(options->keep);
        fairing.linear = run.linear_options();
        fairing.progress = run.progress();
        const Laplacian laplacian = run.build(mesh);
        FairResult result;
        run_moving(run, options->series, mesh, [&](const auto& on_frame) {
            fairing.on_frame = on_frame;
            result = fair(mesh, laplacian, moving, fairing);
        });
        run.record(result.summary);
        run.result()["region"] = moving.size();
        run.result()["stayed"] = result.stayed;
        run.say("region", fmt::format("{} of {} vertices may move", moving.size(), mesh.vertex_count()));
        if (result.stayed > 0)
            run.warn(fmt::format("{} isolated vertices of the region stay", result.stayed));
        write_moved(run, mesh, result.points);
        run.finish();
    });
}

}  // namespace beltrami::program
