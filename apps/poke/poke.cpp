#include "beltrami/apps/poke/poke.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

double diagonal_of(const Mesh& mesh) {
    return (mesh.points().colwise().maxCoeff() - mesh.points().colwise().minCoeff()).norm();
}

void check_path(const ContactPath& path, const SurfaceSearch& surface, double reach) {
    if (path.empty()) throw InputError("a contact has no path", "give at least one waypoint");
    for (std::size_t i = 0; i < path.size(); ++i) {
        const Waypoint& w = path[i];
        if (!std::isfinite(w.time) || !w.displacement.allFinite()) {
            throw InputError(fmt::format("{} a waypoint's time or displacement is not finite", w.place),
                             "write numbers");
        }
        if (i > 0 && !(w.time > path[i - 1].time)) {
            throw InputError(fmt::format("{} the time goes from {} to {}", w.place, path[i - 1].time, w.time),
                             "times of a path must ascend; several contacts have a path each");
        }
        const SurfacePoint hit = surface.closest(w.point);
        if (hit.distance > reach) {
            throw InputError(
                fmt::format("{} the path leaves the surface: ({:g}, {:g}, {:g}) is {:.3g} away from it, more "
                            "than {:.3g}",
                            w.place, w.point.x(), w.point.y(), w.point.z(), hit.distance, reach),
                "give points of the undeformed surface; the displacement says how far they are moved");
        }
    }
}

// Nothing outside the path.
std::optional<Contact> at_time(const ContactPath& path, double time, double slack) {
    if (time < path.front().time - slack || time > path.back().time + slack) return std::nullopt;
    const auto next = std::upper_bound(path.begin(), path.end(), time,
                                       [](double t, const Waypoint& w) { return t < w.time; });
    if (next == path.begin()) return Contact{path.front().point, path.front().displacement};
    if (next == path.end()) return Contact{path.back().point, path.back().displacement};
    const Waypoint& a = *(next - 1);
    const double part = (time - a.time) / (next->time - a.time);
    return Contact{a.point + part * (next->point - a.point),
                   a.displacement + part * (next->displacement - a.displacement)};
}

// Every step's contact before the first is made: between waypoints the straight way may leave the surface, or come closer
// to another part of it.
void check_way(const ContactPath& path, const SurfaceSearch& surface, double reach, double dt,
               const Progress* progress) {
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
        const Waypoint& a = path[i];
        const Waypoint& b = path[i + 1];
        const double length = (b.point - a.point).norm();
        if (length == 0.0) continue;
        const double steps = std::ceil((b.time - a.time) / dt);
        // An arc of a quarter of a circle is as far from its chord as a fifth of the chord's length.
        const double far = reach + 0.25 * length;
        const double jump = reach + 4.0 * length / steps;
        Vector3 before = surface.closest(a.point).point;
        for (double step = 1.0; step <= steps; ++step) {
            report(progress, "path", -1.0);
            const SurfacePoint hit =
                surface.closest(a.point + std::min(1.0, step / steps) * (b.point - a.point));
            if (hit.distance > far || (hit.point - before).norm() > jump) {
                throw InputError(
                    fmt::format("{} the straight way from the last waypoint leaves the surface", b.place),
                    "write waypoints in between, along the surface");
            }
            before = hit.point;
        }
    }
}

// Corners that weigh next to nothing only make the domain larger.
Hold hold_of(const ContactState& contact, const Renumbering& order) {
    Hold hold{{}, {}, {contact.displacement.begin(), contact.displacement.end()}};
    for (std::size_t k = 0; k < 3; ++k) {
        if (contact.at.weights[k] < 1e-12) continue;
        hold.vertices.push_back(order.working(contact.at.vertices[k]));
        hold.weights.push_back(contact.at.weights[k]);
    }
    return hold;
}

// The least that a step takes here: one iteration on what a contact touches first.
double least_seconds(const Laplacian& laplacian, const PokeOptions& options, const SurfaceSearch& surface,
                     const Contact& contact) {
    double least = std::numeric_limits<double>::infinity();
    const ContactState moved{true, surface.closest(contact.point),
                             contact.displacement + Vector3::Constant(1e-3)};
    const std::array hold{hold_of(moved, laplacian.order())};
    for (int trial = 0; trial < 3; ++trial) {
        LocalIntegrator motion(laplacian, options.skin, 1.0 / options.rate, 3, options.local);
        least = std::min(least, motion.advance(hold, LocalIntegrator::Clock::time_point::min()).seconds);
    }
    return least;
}

void check_rate(double rate) {
    if (std::isfinite(rate) && rate > 0.0) return;
    throw InputError(fmt::format("the rate is {} steps per unit of time", rate),
                     "give a positive number, such as 1000");
}

const PokeOptions& checked(const PokeOptions& options) {
    check_rate(options.rate);
    if (options.skin.alpha > 0.0) return options;
    throw InputError("the skin has no mass: alpha is 0", "give alpha a positive value");
}

}  // namespace

TouchedSurface::TouchedSurface(const Mesh& mesh, const Laplacian& laplacian, const PokeOptions& options)
    : laplacian_(laplacian),
      surface_(mesh),
      motion_(laplacian, checked(options).skin, 1.0 / options.rate, 3, options.local) {}

LocalStep TouchedSurface::advance(std::span<const std::optional<Contact>> contacts,
                                  std::optional<LocalIntegrator::Clock::time_point> deadline) {
    contacts_.assign(contacts.size(), {});
    std::vector<Hold> holds;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        if (!contacts[i]) continue;
        contacts_[i] = {true, surface_.closest(contacts[i]->point), contacts[i]->displacement};
        holds.push_back(hold_of(contacts_[i], laplacian_.order()));
    }
    const LocalStep step = motion_.advance(holds, deadline);
    Eigen::Index row = 0;
    for (ContactState& contact : contacts_) {
        if (contact.touching) contact.force = motion_.forces().row(row++).transpose();
    }
    return step;
}

Pde skin_of(const Mesh& mesh) {
    constexpr double omega = 2.0 * std::numbers::pi * 10.0;
    const double length = 0.015 * diagonal_of(mesh);
    const double l2 = length * length;
    const double w2 = omega * omega;
    return {.alpha = 1.0,
            .beta_1 = 2.0 * omega,
            .beta_2 = 0.0,
            .gamma = {0.2 * w2 * l2, w2 * l2 * l2},
            .foundation = w2};
}

PokeResult poke(const Mesh& mesh, const Laplacian& laplacian, const std::vector<ContactPath>& paths,
                const PokeOptions& options) {
    if (paths.empty()) throw InputError("nothing touches the surface", "give at least one path");
    check_rate(options.rate);
    if (options.time && !(std::isfinite(*options.time) && *options.time > 0.0)) {
        throw InputError(fmt::format("the time is {}", *options.time), "give a positive number");
    }
    TouchedSurface skin(mesh, laplacian, options);
    const SurfaceSearch& surface = skin.surface();
    const double dt = 1.0 / options.rate;
    const double reach = options.reach * diagonal_of(mesh);
    double start = std::numeric_limits<double>::infinity();
    double end = -start;
    for (const ContactPath& path : paths) {
        check_path(path, surface, reach);
        check_way(path, surface, reach, dt, options.progress);
        start = std::min(start, path.front().time);
        end = std::max(end, path.back().time);
    }
    const double touched = end - start + dt;
    const double periods =
        options.skin.foundation > 0.0
            ? 10.0 * 2.0 * std::numbers::pi * std::sqrt(options.skin.alpha / options.skin.foundation)
            : 0.0;
    const double steps =
        std::max(1.0, std::ceil(options.time.value_or(touched + std::max(touched, periods)) / dt - 1e-9));
    if (steps > std::numeric_limits<int>::max()) {
        throw InputError(fmt::format("{:.3g} steps", steps), "lower the rate, or shorten the path");
    }

    const auto contacts_at = [&](double time) {
        std::vector<std::optional<Contact>> contacts;
        contacts.reserve(paths.size());
        for (const ContactPath& path : paths)
            contacts.push_back(at_time(path, time, 1e-6 * dt));
        return contacts;
    };
    if (options.real_time) {
        const auto contacts = contacts_at(start);
        const auto first = std::find_if(contacts.begin(), contacts.end(),
                                        [](const auto& contact) { return contact.has_value(); });
        const double least = least_seconds(laplacian, options, surface, **first);
        if (least > dt) {
            throw InputError(
                fmt::format("{:g} steps per second cannot be met: the smallest step takes {:.2g} s here",
                            options.rate, least),
                fmt::format("lower the rate below {:.2g}, or do without real time", 1.0 / least));
        }
    }

    const Index connected = laplacian.vertex_count() - laplacian.isolated_vertices();
    PokeResult result;
    std::vector<double> seconds;
    double lag = 0.0;
    double scale = 0.0;
    for (int step = 1; step <= static_cast<int>(steps); ++step) {
        report(options.progress, "poke", (step - 1) / steps);
        const double time = start + (step - 1) * dt;
        const auto tick = LocalIntegrator::Clock::now();
        const std::vector<std::optional<Contact>> contacts = contacts_at(time);
        std::optional<LocalIntegrator::Clock::time_point> deadline;
        if (options.real_time) {
            deadline = tick + std::chrono::duration_cast<LocalIntegrator::Clock::duration>(
                                  std::chrono::duration<double>(dt - std::min(lag, dt)));
        }
        const LocalStep local = skin.advance(contacts, deadline);
        for (const ContactState& contact : skin.contacts())
            result.largest_force = std::max(result.largest_force, contact.force.norm());
        const double taken = std::chrono::duration<double>(LocalIntegrator::Clock::now() - tick).count();
        if (options.real_time) lag = std::max(0.0, lag + taken - dt);
        seconds.push_back(taken);
        result.steps = step;
        result.most_active = std::max(result.most_active, local.active);
        result.whole = result.whole || local.whole;
        result.whole_mesh = result.whole_mesh || (local.whole && local.active == connected);
        result.late_steps += local.in_time ? 0 : 1;
        result.unconverged_steps += local.in_time && !local.converged ? 1 : 0;
        result.work += local.work;
        result.dissipated += local.dissipated;
        result.iterations += local.iterations;
        scale = std::max(scale, local.scale);
        if (local.scale > 0.0)
            result.largest_put_in = std::max(result.largest_put_in, local.put_in / local.scale);
        result.error_bound = scale > 0.0 ? local.error_bound / scale : 0.0;
        if (options.on_step)
            options.on_step(
                {step, static_cast<int>(steps), time, local, lag, skin.contacts(), skin.motion()});
        result.at_rest = skin.motion().domain().empty();
        if (!options.time && time > end && result.at_rest) break;
    }
    result.displacement = laplacian.order().to_user(skin.motion().u());
    std::sort(seconds.begin(), seconds.end());
    result.median_seconds = seconds[seconds.size() / 2];
    result.percentile_99_seconds = seconds[std::min(seconds.size() - 1, seconds.size() * 99 / 100)];
    result.most_seconds = seconds.back();
    return result;
}

}  // namespace beltrami
