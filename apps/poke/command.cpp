#include <cmath>

#include "../program/run.hpp"
#include "../program/text.hpp"

namespace beltrami::program {

namespace {

ContactPath read_path(const std::filesystem::path& file, const Mesh& mesh) {
    const std::string hint = "write rows time,vertex,dx,dy,dz or time,x,y,z,dx,dy,dz";
    ContactPath path;
    bool header = false;  // one line of names may come first
    for_each_line(file, hint, [&](const std::string& place, std::string_view text) {
        const std::vector<double> numbers = parse_numbers(text);
        if (numbers.empty() && path.empty() && !header) {
            header = true;
            return;
        }
        Waypoint waypoint;
        waypoint.place = place;
        if (numbers.size() == 5) {
            const double vertex = numbers[1];
            if (!(vertex >= 0.0 && vertex < mesh.vertex_count() && vertex == std::floor(vertex))) {
                throw InputError(fmt::format("{} names vertex {}, but the vertices are 0 to {}", place,
                                             vertex, mesh.vertex_count() - 1),
                                 "vertex numbers are those of the file, from 0");
            }
            waypoint.point = mesh.points().row(static_cast<Index>(vertex)).transpose();
        } else if (numbers.size() == 7) {
            waypoint.point = {numbers[1], numbers[2], numbers[3]};
        } else {
            throw InputError(fmt::format("{} is not a waypoint: '{}'", place, text), hint);
        }
        waypoint.time = numbers[0];
        const std::size_t last = numbers.size() - 3;
        waypoint.displacement = {numbers[last], numbers[last + 1], numbers[last + 2]};
        path.push_back(waypoint);
    });
    if (path.empty()) throw InputError(fmt::format("{} holds no waypoints", file.string()), hint);
    return path;
}

void append_log(std::string& log, const PokeStep& step) {
    const LocalStep& l = step.local;
    log += fmt::format("{},{:.9g},{},{},{},{},{},{:.0f},{:.1f},{},{:.1f},{:.6g},{:.6g},{:.9g},{:.9g},{:.9g}",
                       step.step, step.time, l.active, l.slots, l.rounds, l.iterations, l.products, l.bytes,
                       1e6 * l.seconds, l.in_time ? 0 : 1, 1e6 * step.lag, l.error_bound, l.scale, l.energy,
                       l.work, l.dissipated);
    for (const ContactState& c : step.contacts) {
        log +=
            fmt::format(",{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}", c.touching ? 1 : 0, c.at.point.x(),
                        c.at.point.y(), c.at.point.z(), c.force.x(), c.force.y(), c.force.z());
    }
    log += '\n';
}

std::string log_header(std::size_t contacts) {
    std::string header =
        "step,time,active,slots,rounds,iterations,products,bytes,microseconds,late,lag_microseconds,error_"
        "bound,scale,"
        "energy,work,dissipated";
    for (std::size_t i = 0; i < contacts; ++i)
        header += fmt::format(",touching_{0},x_{0},y_{0},z_{0},fx_{0},fy_{0},fz_{0}", i);
    return header + "\n";
}

// The colours of Figure 3 of Kim & Rossignac: the domain in blue, the rings around it in red.
Block domain_colours(const Block& domain) {
    Block colours(domain.rows(), 3);
    for (Eigen::Index v = 0; v < domain.rows(); ++v) {
        const double level = domain(v, 0);
        colours.row(v) = level == 2.0   ? Eigen::RowVector3d(0.25, 0.45, 0.85)
                         : level == 1.0 ? Eigen::RowVector3d(0.85, 0.25, 0.2)
                                        : Eigen::RowVector3d(0.8, 0.8, 0.8);
    }
    return colours;
}

// 2 for active vertices, 1 for the rings around them, 0 elsewhere; in the user's order.
Block domain_field(const ActiveDomain& domain, const Renumbering& order) {
    Block field = Block::Zero(order.vertex_count(), 1);
    for (Index s = 1; s < domain.slot_count(); ++s)
        field(order.user(domain.vertex(s)), 0) = s < domain.end(0) ? 2.0 : 1.0;
    return field;
}

/// What the report's charts are of, a number for each step.
struct History {
    std::vector<double> times;
    std::vector<double> active;
    std::vector<double> milliseconds;
    std::vector<double> energy;
    std::vector<std::vector<double>> forces;  // of each contact

    void add(const PokeStep& step) {
        times.push_back(step.time);
        active.push_back(static_cast<double>(step.local.active));
        milliseconds.push_back(1e3 * step.local.seconds);
        energy.push_back(step.local.energy);
        forces.resize(step.contacts.size());
        for (std::size_t i = 0; i < forces.size(); ++i)
            forces[i].push_back(step.contacts[i].force.norm());
    }

    void draw(Report& report) const {
        std::vector<ChartLine> lines;
        for (std::size_t i = 0; i < forces.size(); ++i)
            lines.push_back(
                line_of(forces.size() == 1 ? std::string() : fmt::format("contact {}", i), times, forces[i]));
        report.chart({.title = "force", .across = "time", .up = "force", .lines = lines});
        const auto chart = [&](const char* title, const char* up, const std::vector<double>& values) {
            report.chart({.title = title, .across = "time", .up = up, .lines = {line_of("", times, values)}});
        };
        chart("size of the domain", "active vertices", active);
        chart("time of each step", "milliseconds", milliseconds);
        chart("energy", "energy", energy);
    }
};

struct Moment {
    double time = 0.0;
    double energy = -1.0;
    Index active = 0;
    Block displacement;
    Block domain;
};

}  // namespace

void add_poke(CLI::App& program, Run& run) {
    struct Options {
        std::vector<std::string> paths;
        std::vector<double> gamma;
        std::vector<double> damping;
        std::optional<double> foundation;
        std::optional<double> density;
        PokeOptions poke;
        std::string series;
        int every = 20;
        std::string log;
    };
    auto* const command =
        program.add_subcommand("poke", "a surface that gives way where it is touched, in real time");
    run.add_options(*command, {.solver = false});
    auto options = std::make_shared<Options>();
    command
        ->add_option("--path", options->paths,
                     "a contact: rows time,vertex,dx,dy,dz or time,x,y,z,dx,dy,dz; one file for each contact")
        ->required()
        ->option_text("FILE.csv ...");
    command
        ->add_option(
            "--gamma", options->gamma,
            "stiffness of the skin: of the Laplacian and the bi-Laplacian (default: by the size of the mesh)")
        ->delimiter(',')
        ->expected(1, 2)
        ->option_text("G1[,G2]");
    command
        ->add_option("--foundation", options->foundation,
                     "the spring from each point to its place (default: (20 pi)^2)")
        ->option_text("G0");
    command->add_option("--density", options->density, "mass of the skin for each unit of area (default: 1)")
        ->option_text("ALPHA");
    command
        ->add_option("--damping", options->damping, "Rayleigh damping: 1/time, and time (default: 40 pi,0)")
        ->delimiter(',')
        ->expected(1, 2)
        ->option_text("B1[,B2]");
    command->add_option("--rate", options->poke.rate, "steps per unit of time (default: 1000)")
        ->option_text("R");
    command
        ->add_option("--time", options->poke.time, "how long (default: until rest, for ten swings at most)")
        ->option_text("T");
    command
        ->add_option("--tolerance", options->poke.local.tolerance,
                     "of the error of each step against the whole mesh (default: 0.01)")
        ->option_text("X");
    command->add_flag(
        "--real-time", options->poke.real_time,
        "give each step 1 / rate seconds; late steps stop where they are, say so, and catch up");
    command->add_option("--log", options->log, "force, domain, work and time of every step")
        ->option_text("FILE.csv");
    command->add_option("--series", options->series, "the moving surface, as ParaView opens it")
        ->option_text("OUT.pvd");
    command->add_option("--every", options->every, "keep each N-th step of the series (default: 20)")
        ->option_text("N");
    command->callback([&run, options] {
        if (!options->series.empty()) run.also_writes(options->series);
        if (!options->log.empty()) run.also_writes(options->log);
        if (options->every < 1)
            throw InputError(fmt::format("--every {}", options->every), "keep each step, or each N-th");
        const Mesh mesh = run.load_mesh();
        std::vector<ContactPath> paths;
        for (const std::string& file : options->paths)
            paths.push_back(read_path(file, mesh));
        PokeOptions& poke_options = options->poke;
        poke_options.skin = skin_of(mesh);
        Pde& skin = poke_options.skin;
        if (!options->gamma.empty()) skin.gamma = options->gamma;
        if (options->foundation) skin.foundation = *options->foundation;
        if (options->density) skin.alpha = *options->density;
        if (!options->damping.empty()) {
            skin.beta_1 = options->damping[0];
            skin.beta_2 = options->damping.size() > 1 ? options->damping[1] : 0.0;
        }
        poke_options.progress = run.progress();
        std::optional<SeriesWriter> series;
        if (!options->series.empty()) series.emplace(options->series);
        const Laplacian laplacian = run.build(mesh);
        const Renumbering& order = laplacian.order();
        const Mesh bare(mesh.points(), mesh.cells());

        std::string log = log_header(paths.size());
        Moment fullest;
        Report* const report = run.for_report();
        History history;
        poke_options.on_step = [&](const PokeStep& step) {
            append_log(log, step);
            if (report != nullptr) {
                history.add(step);
                report->moment("displacement", /*displaced=*/true, step.time,
                               [&] { return order.to_user(step.motion.u()); });
            }
            const bool in_series = series && (step.step - 1) % options->every == 0;
            // Copies of whole fields are made for few steps: the energy must have grown by a tenth.
            const bool is_fullest = run.wants_picture() && step.local.energy > 1.1 * fullest.energy;
            if (!in_series && !is_fullest) return;
            const Block displacement = order.to_user(step.motion.u());
            const Block domain = domain_field(step.motion.domain(), order);
            if (in_series) {
                series->add(step.time, bare.with_points(bare.points() + displacement),
                            {{"displacement", displacement}, {"domain", domain}});
            }
            if (is_fullest) fullest = {step.time, step.local.energy, step.local.active, displacement, domain};
        };
        const auto write_log = [&] {
            if (options->log.empty()) return;
            write_whole(options->log, [&](std::ostream& out) { out << log; });
            run.wrote(options->log);
        };
        const PokeResult result = run.timed("solve", [&] {
            try {
                return poke(mesh, laplacian, paths, poke_options);
            } catch (const Cancelled&) {
                write_log();
                throw;
            }
        });
        run.result()["steps"] = result.steps;
        run.result()["at_rest"] = result.at_rest;
        run.result()["most_active"] = result.most_active;
        run.result()["largest_force"] = result.largest_force;
        run.result()["largest_put_in"] = result.largest_put_in;
        run.result()["error_bound"] = result.error_bound;
        run.result()["late_steps"] = result.late_steps;
        run.result()["work"] = result.work;
        run.result()["dissipated"] = result.dissipated;
        run.result()["iterations"] = result.iterations;
        run.result()["step_seconds"] = {{"median", result.median_seconds},
                                        {"percentile_99", result.percentile_99_seconds},
                                        {"most", result.most_seconds}};
        run.result()["whole"] = result.whole;
        run.say("steps",
                fmt::format("{} of 1/{:g}; each {:.3g} ms (median), {:.3g} ms (99 of 100), {:.3g} ms (most)",
                            result.steps, poke_options.rate, 1e3 * result.median_seconds,
                            1e3 * result.percentile_99_seconds, 1e3 * result.most_seconds));
        run.say("domain",
                fmt::format("at most {} of {} vertices; {}", result.most_active, mesh.vertex_count(),
                            result.at_rest ? "empty at the end" : "still moving at the end"));
        run.say("force", fmt::format("at most {:.6g}", result.largest_force));
        run.say(
            "error",
            fmt::format("each step puts in at most {:.2g} of the largest energy norm; all of them together "
                        "below {:.2g} while contacts keep their places",
                        result.largest_put_in, result.error_bound));
        if (result.whole) {
            run.warn(
                fmt::format("the domain grew to {}: those steps were global ones",
                            result.whole_mesh ? "the whole mesh" : "all of the component that is touched"));
        }
        if (result.late_steps > 0) {
            run.warn(
                fmt::format("{} of {} steps were late: they stopped at their last iterate, which the "
                            "error counts",
                            result.late_steps, result.steps));
        }
        if (result.unconverged_steps > 0) {
            throw SolveError(
                fmt::format("{} of {} steps did not converge", result.unconverged_steps, result.steps),
                "use a larger tolerance; nothing but the series was written");
        }
        write_log();
        if (series) run.wrote(options->series);
        if (report != nullptr) {
            report->last_moment(history.times.back(), result.displacement);
            history.draw(*report);
        }
        run.write(mesh.with_points(mesh.points() + result.displacement),
                  {{"displacement", result.displacement}}, [&](PictureOptions picture) {
                      picture.width /= 2;
                      const Mesh pressed = bare.with_points(bare.points() + fullest.displacement);
                      const Block length = fullest.displacement.rowwise().norm();
                      picture.title = fmt::format("displacement at t = {:.3g}", fullest.time);
                      const Image left = draw(pressed, &length, picture);
                      picture.title =
                          fmt::format("{} of {} vertices are active", fullest.active, mesh.vertex_count());
                      const Block colours = domain_colours(fullest.domain);
                      return side_by_side({left, draw(pressed, &colours, picture)}, 2);
                  });
        run.finish();
    });
}

}  // namespace beltrami::program
