#include "simulate.hpp"

#include <fmt/ranges.h>

#include <cmath>

namespace beltrami::program {

void add_simulate_options(CLI::App& command, SimulateOptions& options, const std::vector<std::string>& methods) {
    options.method = methods.front();
    command.add_option("--initial-field", options.initial_field, "u at the start: a vertex field of the file")
        ->option_text("NAME");
    command.add_option("--time", options.time, "how long (default: by the size of the mesh)")->option_text("T");
    command.add_option("--steps", options.steps, fmt::format("in how many steps (default: {})", options.steps))
        ->option_text("N");
    command.add_option("--method", options.method,
                       fmt::format("{} (default: {})", fmt::join(methods, " or "), methods.front()))
        ->check(CLI::IsMember(methods))
        ->option_text("NAME");
    command.add_option("--series", options.series, "every step, as ParaView opens it")->option_text("OUT.pvd");
    command.add_option("--every", options.every, "keep each N-th step of the series (default: 1)")->option_text("N");
}

double extent(const Mesh& mesh) {
    Vector3 lower = Vector3::Constant(INFINITY);
    Vector3 upper = Vector3::Constant(-INFINITY);
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        for (Eigen::Index k = 0; k < mesh.cells().cols(); ++k) {
            const Vector3 p = mesh.points().row(mesh.cells()(c, k)).transpose();
            lower = lower.cwiseMin(p);
            upper = upper.cwiseMax(p);
        }
    }
    return mesh.cell_count() > 0 ? 0.5 * (upper - lower).norm() : 0.0;
}

void run_simulation(Run& run, const SimulateOptions& options, const Mesh& mesh, double default_time,
                    const std::function<Evolution(const EvolveOptions&)>& simulate) {
    if (options.every < 1) throw InputError(fmt::format("--every {}", options.every), "keep each step, or each N-th");
    EvolveOptions evolve;
    evolve.time = options.time.value_or(default_time);
    evolve.steps = options.steps;
    evolve.linear = run.linear_options();
    evolve.progress = run.progress();
    for (const TimeMethod method : {TimeMethod::backward_euler, TimeMethod::implicit_midpoint, TimeMethod::bdf2}) {
        if (name(method) == options.method) evolve.method = method;
    }
    std::optional<SeriesWriter> series;
    if (!options.series.empty()) {
        series.emplace(options.series);
        // The geometry once for each step, the file's own fields only in -o.
        const Mesh bare(mesh.points(), mesh.cells());
        evolve.on_frame = [&options, &series, &evolve, bare](const Frame& frame) {
            if (frame.step % options.every == 0 || frame.step == evolve.steps) {
                series->add(frame.time, bare, {{"u", frame.u}});
            }
        };
    }
    const Evolution evolution = [&] {
        const Run::Phase phase(run, "solve");
        try {
            return simulate(evolve);
        } catch (const Cancelled&) {
            if (!series || series->files().size() < 2) throw;
            throw Cancelled(fmt::format("cancelled; the {} steps written to {} are readable",
                                        series->files().size() - 1, options.series));
        }
    }();
    run.say("time", fmt::format("{:.6g} in {} steps of {}", evolve.time, evolve.steps, options.method));
    run.record(evolution.summary);
    run.result()["time"] = evolve.time;
    run.result()["steps"] = evolve.steps;
    run.result()["method"] = options.method;
    run.result()["energy_before"] = evolution.energy_before;
    run.result()["energy_after"] = evolution.energy_after;
    if (series) run.wrote(options.series);
    run.write(mesh, {{"u", evolution.u}});
    run.finish();
}

}  // namespace beltrami::program
