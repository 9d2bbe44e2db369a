#include "../program/simulate.hpp"
#include "../program/values.hpp"

namespace beltrami::program {

void add_wave(CLI::App& program, Run& run) {
    struct Options : SimulateOptions {
        std::vector<std::string> impulse;
        std::vector<double> damping;
    };
    auto* const command =
        program.add_subcommand("wave", "waves that travel from impulses or an initial displacement");
    run.add_options(*command, {});
    auto options = std::make_shared<Options>();
    options->steps = 200;
    command->add_option("--impulse", options->impulse, "a vertex and the momentum it is given")
        ->option_text("V=A ...");
    command->add_option("--damping", options->damping, "Rayleigh damping: 1/time, and time (default: 0,0)")
        ->delimiter(',')
        ->expected(1, 2)
        ->option_text("B1[,B2]");
    add_simulate_options(*command, *options, {"midpoint", "backward-euler"});
    command->callback([&run, options] {
        if (!options->series.empty()) run.also_writes(options->series);
        const Mesh mesh = run.load_mesh();
        const Block start = field_or_zero(mesh, options->initial_field, 1);
        const Constraints impulses = parse_values("--impulse", options->impulse, {},
                                                  static_cast<Index>(start.cols()), mesh.vertex_count());
        if (impulses.empty() && options->initial_field.empty()) {
            throw InputError("nothing moves: neither an impulse nor an initial displacement is given",
                             "strike a vertex with --impulse VERTEX=1");
        }
        Damping damping;
        if (!options->damping.empty()) damping.beta_1 = options->damping[0];
        if (options->damping.size() > 1) damping.beta_2 = options->damping[1];
        const Laplacian laplacian = run.build(mesh);
        run_simulation(run, *options, mesh, usual_wave_time(mesh), [&](const EvolveOptions& evolve) {
            return wave(laplacian, start, impulses, evolve, damping);
        });
    });
}

}  // namespace beltrami::program
