#include "moving.hpp"

namespace beltrami::program {

void add_series_options(CLI::App& command, SeriesOptions& options) {
    command.add_option("--series", options.path, "every step, as ParaView opens it")->option_text("OUT.pvd");
    command.add_option("--every", options.every, "keep each N-th step of the series (default: 1)")
        ->option_text("N");
}

void run_moving(Run& run, const SeriesOptions& options, const Mesh& mesh,
                const std::function<void(const std::function<void(const Frame&)>& on_frame)>& work) {
    if (options.every < 1)
        throw InputError(fmt::format("--every {}", options.every), "keep each step, or each N-th");
    Report* const report = run.for_report();
    if (options.path.empty() && report == nullptr) {
        run.timed("solve", [&] { work({}); });
        return;
    }
    std::optional<SeriesWriter> series;
    if (!options.path.empty()) series.emplace(options.path);
    const Mesh bare(mesh.points(), mesh.cells());  // the file's own fields are in -o only, not in every step
    const auto add = [&](double time, const Points& points) {
        series->add(time, bare.with_points(points), {{"displacement", points - mesh.points()}});
    };
    std::optional<std::pair<double, Points>> left_out;  // the last step, where it is no N-th
    std::vector<double> times;
    std::vector<double> energies;
    std::optional<Points> last;
    const auto gather = [&](const Frame& frame) {
        times.push_back(frame.time);
        energies.push_back(frame.energy);
        last = frame.u;
        report->moment("displacement", /*displaced=*/true, frame.time,
                       [&]() -> Block { return frame.u - mesh.points(); });
    };
    run.timed("solve", [&] {
        try {
            work([&](const Frame& frame) {
                if (report != nullptr) gather(frame);
                if (!series) return;
                left_out.reset();
                if (frame.step % options.every == 0) {
                    add(frame.time, frame.u);
                } else {
                    left_out.emplace(frame.time, frame.u);
                }
            });
        } catch (const Cancelled&) {
            if (!series || series->files().size() < 2) throw;
            throw Cancelled(fmt::format("cancelled; the {} steps written to {} are readable",
                                        series->files().size() - 1, options.path));
        }
    });
    if (left_out) add(left_out->first, left_out->second);
    if (series) run.wrote(options.path);
    if (times.empty()) return;  // until rest at once, without a flow
    report->last_moment(times.back(), *last - mesh.points());
    report->chart({.title = "what the flow lowers",
                   .across = "time",
                   .up = "energy",
                   .lines = {line_of("", times, energies)}});
}

void write_moved(Run& run, const Mesh& mesh, const Points& points) {
    const Block displacement = points - mesh.points();
    const Mesh moved = mesh.with_points(points);
    run.write(moved, {{"displacement", displacement}}, [&](const PictureOptions& options) {
        constexpr Index most_with_edges = 20000;
        PictureOptions picture = options;
        picture.width /= 2;
        picture.edges = mesh.cell_count() <= most_with_edges;
        picture.title = "before";
        const Image before = draw(mesh, nullptr, picture);
        picture.title = "after";
        return side_by_side({before, draw(moved, nullptr, picture)}, 2);
    });
}

}  // namespace beltrami::program
