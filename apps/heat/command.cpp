#include "../program/simulate.hpp"
#include "../program/values.hpp"

namespace beltrami::program {

void add_heat(CLI::App& program, Run& run) {
    struct Options : SimulateOptions {
        std::vector<std::string> source;
        std::vector<std::string> initial;
    };
    auto* const command =
        program.add_subcommand("heat", "heat that spreads from held and initial temperatures");
    run.add_options(*command, {});
    auto options = std::make_shared<Options>();
    command->add_option("--source", options->source, "a vertex held at a temperature")
        ->option_text("V=T ...");
    command->add_option("--initial", options->initial, "a vertex's temperature at the start")
        ->option_text("V=T ...");
    add_simulate_options(*command, *options, {"backward-euler", "bdf2"});
    command->callback([&run, options] {
        if (!options->series.empty()) run.also_writes(options->series);
        const Mesh mesh = run.load_mesh();
        Block start = field_or_zero(mesh, options->initial_field, 1);
        const auto columns = static_cast<Index>(start.cols());
        const Constraints initial =
            parse_values("--initial", options->initial, {}, columns, mesh.vertex_count());
        const Constraints sources =
            parse_values("--source", options->source, {}, columns, mesh.vertex_count());
        if (initial.empty() && sources.empty() && options->initial_field.empty()) {
            throw InputError("there is no heat: neither a source nor an initial temperature is given",
                             "hold a vertex at a temperature with --source VERTEX=100");
        }
        initial.impose(start);
        const Laplacian laplacian = run.build(mesh);
        run_simulation(run, *options, mesh, usual_heat_time(mesh), [&](const EvolveOptions& evolve) {
            Evolution evolution = heat(laplacian, start, sources, evolve);
            Block given = start;
            sources.impose(given);
            run.warn_outside(laplacian, evolution.u, given);
            return evolution;
        });
    });
}

}  // namespace beltrami::program
