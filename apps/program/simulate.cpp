#include "simulate.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace beltrami::program {

void add_simulate_options(CLI::App& command, SimulateOptions& options,
                          const std::vector<std::string>& methods) {
    options.method = methods.front();
    command
        .add_option("--initial-field", options.initial_field, "u at the start: a vertex field of the file")
        ->option_text("NAME");
    command.add_option("--time", options.time, "how long (default: by the size of the mesh)")
        ->option_text("T");
    command
        .add_option("--steps", options.steps, fmt::format("in how many steps (default: {})", options.steps))
        ->option_text("N");
    command
        .add_option("--method", options.method,
                    fmt::format("{} (default: {})", fmt::join(methods, " or "), methods.front()))
        ->check(CLI::IsMember(methods))
        ->option_text("NAME");
    command.add_option("--series", options.series, "every step, as ParaView opens it")
        ->option_text("OUT.pvd");
    command.add_option("--every", options.every, "keep each N-th step of the series (default: 1)")
        ->option_text("N");
}

namespace {

// Six moments of a simulation on one colour scale.
class Sheet {
  public:
    explicit Sheet(int steps) : steps_(steps) {}

    void add(const Frame& frame) {
        const int last = static_cast<int>(moments_.size());
        if (frame.step > 0 && frame.step * moments >= (last + 1) * steps_)
            moments_.push_back({frame.time, frame.u});
    }

    [[nodiscard]] Image draw(const Mesh& mesh, PictureOptions options) const {
        if (!options.range) options.range = range();
        options.width /= 2;
        options.height /= 2;
        std::vector<Image> images;
        for (const Moment& moment : moments_) {
            options.title = fmt::format("t = {:.3g}", moment.time);
            images.push_back(beltrami::draw(mesh, &moment.u, options));
        }
        return side_by_side(images, 3);
    }

  private:
    static constexpr int moments = 6;
    struct Moment {
        double time;
        Block u;
    };

    // The few values near a point source or impulse are far above all others: the scale ends at the 99th percentile.
    [[nodiscard]] std::optional<std::pair<double, double>> range() const {
        std::vector<double> sizes;
        double low = 0.0;
        for (const Moment& moment : moments_) {
            for (const double value : moment.u.reshaped()) {
                sizes.push_back(std::abs(value));
                low = std::min(low, value);
            }
        }
        const auto at =
            sizes.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(sizes.size() - 1));
        std::nth_element(sizes.begin(), at, sizes.end());
        if (*at == 0.0) return std::nullopt;
        return std::pair{low < 0.0 ? -*at : 0.0, *at};
    }

    int steps_;
    std::vector<Moment> moments_;
};

}  // namespace

void run_simulation(Run& run, const SimulateOptions& options, const Mesh& mesh, double default_time,
                    const std::function<Evolution(const EvolveOptions&)>& simulate) {
    if (options.every < 1)
        throw InputError(fmt::format("--every {}", options.every), "keep each step, or each N-th");
    EvolveOptions evolve;
    evolve.time = options.time.value_or(default_time);
    evolve.steps = options.steps;
    evolve.linear = run.linear_options();
    evolve.progress = run.progress();
    for (const TimeMethod method :
         {TimeMethod::backward_euler, TimeMethod::implicit_midpoint, TimeMethod::bdf2}) {
        if (name(method) == options.method) evolve.method = method;
    }
    std::optional<SeriesWriter> series;
    if (!options.series.empty()) series.emplace(options.series);
    const Mesh bare(mesh.points(), mesh.cells());  // the file's own fields are in -o only, not in every step
    Sheet sheet(evolve.steps);
    Report* const report = run.for_report();
    std::vector<double> times;
    std::vector<double> energies;
    if (series || run.wants_picture() || report != nullptr) {
        evolve.on_frame = [&](const Frame& frame) {
            if (series && (frame.step % options.every == 0 || frame.step == evolve.steps)) {
                series->add(frame.time, bare, {{"u", frame.u}});
            }
            if (run.wants_picture()) sheet.add(frame);
            if (report == nullptr) return;
            times.push_back(frame.time);
            energies.push_back(frame.energy);
            report->moment("u", /*displaced=*/false, frame.time, [&] { return frame.u; });
        };
    }
    const Evolution evolution = run.timed("solve", [&] {
        try {
            return simulate(evolve);
        } catch (const Cancelled&) {
            if (!series || series->files().size() < 2) throw;
            throw Cancelled(fmt::format("cancelled; the {} steps written to {} are readable",
                                        series->files().size() - 1, options.series));
        }
    });
    run.say("time", fmt::format("{:.6g} in {} steps of {}", evolve.time, evolve.steps, options.method));
    run.record(evolution.summary);
    run.result()["time"] = evolve.time;
    run.result()["steps"] = evolve.steps;
    run.result()["method"] = options.method;
    run.result()["energy_before"] = evolution.energy_before;
    run.result()["energy_after"] = evolution.energy_after;
    if (series) run.wrote(options.series);
    if (report != nullptr) {
        report->last_moment(times.back(), evolution.u);
        report->chart(
            {.title = "energy", .across = "time", .up = "energy", .lines = {line_of("", times, energies)}});
    }
    run.write(mesh, {{"u", evolution.u}},
              [&](const PictureOptions& picture) { return sheet.draw(mesh, picture); });
    run.finish();
}

}  // namespace beltrami::program
