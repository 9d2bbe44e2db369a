#include "beltrami/solvers/local_integrator.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// The parts of a step's tolerance, in the energy norm: what vertices that are let go may hold, and (squared) what the
// iteration may leave inside.
constexpr double share_of_removal = 0.3;
constexpr double share_inside = 0.25;

// K~ u is updated with K~ times the velocity, which each step has at hand, so often before rounding is cleared away.
constexpr int most_updates = 64;

// How many steps of backward Euler halve any free motion in the energy norm; -1 where some motion does not die out. All
// operators are functions of M^-1 K~, so a step is a 2 x 2 matrix for each of its eigenvalues, which are the foundation
// or more, with the held points too.
long halving_steps(const Pde& pde, double dt) {
    if (!(pde.foundation > 0.0) || !(pde.alpha > 0.0)) return -1;
    constexpr int frequencies = 600;
    std::vector<Eigen::Matrix2d> steps;
    for (int i = 0; i < frequencies; ++i) {
        // From the foundation up by 20 orders of magnitude, densely where motion dies slowest.
        const double lambda =
            pde.foundation * std::pow(10.0, 20.0 * std::pow(static_cast<double>(i) / frequencies, 2));
        // v' = (alpha v - dt lambda u) / d, u' = u + dt v', in the coordinates (alpha^1/2 v, lambda^1/2 u).
        const double d = pde.alpha + pde.beta_1 * dt + (pde.beta_2 + dt) * dt * lambda;
        const double across = dt * std::sqrt(lambda * pde.alpha) / d;
        Eigen::Matrix2d step;
        step << pde.alpha / d, -across, across, 1.0 - dt * dt * lambda / d;
        steps.push_back(step);
    }
    // The limit of high frequencies.
    Eigen::Matrix2d highest = Eigen::Matrix2d::Zero();
    highest(1, 1) = pde.beta_2 / (pde.beta_2 + dt);
    steps.push_back(highest);
    for (long count = 1; count < (1L << 30); count *= 2) {
        double norm = 0.0;
        for (Eigen::Matrix2d& step : steps) {
            norm = std::max(norm, step.operatorNorm());
            step = step * step;
        }
        if (norm <= 0.45) return count;  // a little less than a half, as frequencies are sampled
    }
    return -1;
}

}  // namespace

void LocalIntegrator::ErrorBound::add(double put_in, bool same_places) {
    // What halves an error is the same step again and again: with other points held, it begins anew.
    if (!same_places) {
        older_ += std::exchange(block_, 0.0);
        steps_ = 0;
    }
    block_ += put_in;
    if (halving_steps_ < 0 || ++steps_ < halving_steps_) return;
    older_ = block_ + 0.5 * older_;
    block_ = 0.0;
    steps_ = 0;
}

LocalIntegrator::LocalIntegrator(const Laplacian& laplacian, Pde pde, double step, Index columns,
                                 LocalOptions options)
    : pde_(std::move(pde)),
      step_(step),
      options_(options),
      system_(PdeOperator((pde_.check(), laplacian), pde_.foundation, pde_.gamma), columns),
      u_(columns),
      v_(columns),
      stretched_(columns),
      weights_{pde_.alpha + pde_.beta_1 * step, (pde_.beta_2 + step) * step},
      forces_(0, columns) {
    options_.check();
    if (!std::isfinite(step) || step <= 0.0) {
        throw InputError(fmt::format("the time step is {}", step), "give a positive number");
    }
    error_ = ErrorBound(halving_steps(pde_, step));
}

// K~ x of the system's unknown, from A x = b - r: its residual is at hand.
double LocalIntegrator::stretching(Index s, Index c) const {
    const double mass = weights_.mass * system_.op().mass()[static_cast<std::size_t>(s)];
    return (system_.b[s][c] - system_.r[s][c] - mass * system_.x[s][c]) / weights_.stiffness;
}

// Of the state that the system's unknown leads to.
LocalIntegrator::Energies LocalIntegrator::energies_of_trial() const {
    double moving = 0.0;  // x^T M x
    double elastic = 0.0;
    double damped_stiffness = 0.0;
    for (Index s = 1; s < system_.domain().end(0); ++s) {
        const double mass = system_.op().mass()[static_cast<std::size_t>(s)];
        for (Index c = 0; c < system_.columns(); ++c) {
            const double x = system_.x[s][c];
            const double change = stretching(s, c);
            moving += mass * x * x;
            elastic += (u_[s][c] + step_ * x) * (stretched_[s][c] + step_ * change);
            damped_stiffness += x * change;
        }
    }
    return {0.5 * pde_.alpha * moving + 0.5 * std::max(0.0, elastic),
            step_ * (pde_.beta_1 * moving + pde_.beta_2 * damped_stiffness)};
}

LocalStep LocalIntegrator::advance(std::span<const Hold> holds, std::optional<Clock::time_point> deadline) {
    const auto start = Clock::now();
    report(options_.progress, "local step", -1.0);
    const std::vector<Index> touched = system_.vertices_of(holds);
    LocalStep result;
    if (holds.empty() && domain().empty()) {
        ++step_count_;
        forces_.resize(0, system_.columns());
        error_.add(0.0, same_places(holds));
        result.error_bound = error_.bound();
        return result;
    }
    const long products_before = system_.op().products();
    const double bytes_before = system_.bytes();

    const auto grow = [&](std::span<const Index> vertices) {
        system_.activate(vertices, u_, v_, stretched_);
    };
    grow(touched);
    const ActiveDomain& domain = this->domain();

    // b = alpha M v - dt K~ u on all slots.
    if (stretched_age_ < 0 || stretched_age_ >= most_updates) {
        system_.op().apply(domain, {0.0, 1.0}, u_, stretched_, domain.rings());
        stretched_age_ = 0;
    }
    for (Index s = 1; s < domain.slot_count(); ++s) {
        const double mass = pde_.alpha * system_.op().mass()[static_cast<std::size_t>(s)];
        for (Index c = 0; c < u_.width(); ++c) {
            system_.b[s][c] = mass * v_[s][c] - step_ * stretched_[s][c];
            system_.x[s][c] = v_[s][c];
        }
    }
    // Held points give velocities: (u' - C u) / dt.
    std::vector<Hold> velocities(holds.begin(), holds.end());
    for (Hold& hold : velocities) {
        for (std::size_t c = 0; c < hold.value.size(); ++c) {
            double now = 0.0;
            for (std::size_t j = 0; j < hold.vertices.size(); ++j)
                now += hold.weights[j] * u_[domain.slot(hold.vertices[j])][c];
            hold.value[c] = (hold.value[c] - now) / step_;
        }
    }
    system_.prepare(weights_, velocities);
    system_.impose();
    system_.compute_residual();

    // What the domain leaves out is measured against the largest state so far, so that it shrinks as a wave dies. What the
    // iteration leaves inside is measured against the present one: it would otherwise keep the surface trembling.
    const double tolerance = options_.tolerance * options_.tolerance * 2.0 * system_.sigma();
    LocalSystem::Missing missing;
    Energies trial{};
    result.converged = false;
    const auto measure = [&] {
        missing = system_.missing();
        trial = energies_of_trial();
        if (std::isfinite(missing.total() + trial.stored + trial.dissipated)) return;
        throw SolveError("the numbers of a local step overflow",
                         "rescale the mesh, the coefficients or the path");
    };
    measure();
    while (result.iterations < options_.max_iterations) {
        const double allowed_inside = share_inside * tolerance * std::max(energy_, trial.stored);
        const double allowed_outside =
            (1.0 - share_inside) * tolerance * std::max(peak_energy_, trial.stored);
        // Before growing, no more accuracy is needed than what growing is about to change.
        const bool grows = missing.outside > allowed_outside;
        const double inside =
            grows ? std::max(allowed_inside, share_inside * missing.outside) : allowed_inside;
        // The old velocities are a good start, but kept as they are nothing would ever change in short steps.
        const int least = result.iterations == 0 ? 1 : 0;
        if (missing.inside > inside || (least == 1 && missing.inside > 0.0)) {
            const auto run =
                system_.iterate(inside, options_.max_iterations - result.iterations, deadline, least);
            result.iterations += run.count;
            const double before = missing.inside;
            system_.compute_residual();
            measure();
            result.in_time = run.in_time;
            if (!run.in_time || !run.definite) break;
            if (missing.inside > inside && missing.inside > 0.25 * before) break;
            if (run.count > 0) continue;
        }
        if (!grows) {
            result.converged = true;
            break;
        }
        if (deadline && Clock::now() >= *deadline) {
            result.in_time = false;
            break;
        }
        grow(system_.growth(0.5 * allowed_outside));
        ++result.rounds;
        system_.prepare(weights_, velocities);
        system_.compute_residual();
        measure();
    }

    const auto close_books = [&] {
        forces_ = system_.forces() / step_;
        result.work = 0.0;
        for (std::size_t h = 0; h < velocities.size(); ++h) {
            for (std::size_t c = 0; c < velocities[h].value.size(); ++c) {
                result.work += step_ * velocities[h].value[c] *
                               forces_(static_cast<Eigen::Index>(h), static_cast<Eigen::Index>(c));
            }
        }
        result.dissipated = trial.dissipated;
        result.taken_out = result.work - result.dissipated - (trial.stored - energy_);
    };
    close_books();
    if (result.taken_out < 0.0) {
        system_.balance();
        measure();
        close_books();
    }
    result.put_in = std::sqrt(missing.total() / (2.0 * system_.sigma()));

    for (Index s = 1; s < domain.slot_count(); ++s) {
        for (Index c = 0; c < u_.width(); ++c) {
            u_[s][c] += step_ * system_.x[s][c];
            v_[s][c] = system_.x[s][c];
            stretched_[s][c] += step_ * stretching(s, c);
        }
    }
    ++stretched_age_;
    ++step_count_;
    peak_energy_ = std::max(peak_energy_, trial.stored);
    result.scale = std::sqrt(peak_energy_);
    energy_ = trial.stored;
    reserve_ += result.taken_out;

    result.active = domain.active_count();
    result.slots = domain.slot_count() - 1;
    result.whole = result.active > 0 && result.slots == result.active;
    result.put_in += let_go(result, !holds.empty());
    error_.add(result.put_in, same_places(holds));
    result.error_bound = error_.bound();
    result.energy = energy_;
    result.products = system_.op().products() - products_before;
    result.bytes = system_.bytes() - bytes_before;
    result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return result;
}

// Whether the points are held where those of the last step were.
bool LocalIntegrator::same_places(std::span<const Hold> holds) {
    std::vector<std::pair<Index, double>> places;
    for (const Hold& hold : holds) {
        for (std::size_t j = 0; j < hold.vertices.size(); ++j)
            places.emplace_back(hold.vertices[j], hold.weights[j]);
    }
    const bool same = places == places_;
    places_ = std::move(places);
    return same;
}

// Lets quiet vertices go; the energy norm of what they held.
double LocalIntegrator::let_go(LocalStep& result, bool held) {
    const ActiveDomain& domain = system_.domain();
    const double budget = std::pow(share_of_removal * options_.tolerance, 2) * peak_energy_;
    if (!held && energy_ <= options_.tolerance * options_.tolerance * peak_energy_) {
        const double norm = std::sqrt(energy_);
        result.taken_out += energy_;
        reserve_ += energy_;
        energy_ = 0.0;
        peak_energy_ = 0.0;
        system_.clear(u_, v_, stretched_);
        return norm;
    }
    const auto moving = [&](Index s) {
        double square = 0.0;
        for (Index c = 0; c < v_.columns(); ++c)
            square += v_[s][c] * v_[s][c];
        return pde_.alpha * system_.op().mass()[static_cast<std::size_t>(s)] * square;
    };
    // A vertex weighs what it holds, or what missing it would put into the error of the next step if that is more.
    const double reach = step_ * step_ / system_.sigma();
    const std::vector<Index> quiet = system_.quiet_vertices(0.25 * budget, [&](Index s) {
        const auto at = static_cast<std::size_t>(s);
        const double diagonal = system_.op().diagonal()[at];
        double displaced = 0.0;
        for (Index c = 0; c < u_.columns(); ++c)
            displaced += u_[s][c] * u_[s][c];
        return 0.5 * moving(s) +
               0.5 * diagonal * displaced * (1.0 + reach * diagonal * system_.op().inverse_mass()[at]);
    });
    // Not worth a product for a handful.
    if (quiet.empty() || std::ssize(quiet) * 50 < domain.active_count()) return 0.0;

    // E(du, dv) of what they hold, and E(u - du, v - dv) - E(u, v).
    const LocalSystem::Part pull = system_.part(quiet, u_);
    double momentum = 0.0;  // alpha dv^T M v
    for (const Index v : quiet)
        momentum += moving(domain.slot(v));
    const double own = 0.5 * momentum + 0.5 * pull.own;
    const double change = own - momentum - pull.all;
    if (own > budget || change > reserve_) return 0.0;
    reserve_ -= change;
    energy_ += change;
    result.taken_out -= change;
    stretched_age_ = -1;
    system_.deactivate(quiet, u_, v_, stretched_);
    return std::sqrt(std::max(0.0, own));
}

Block LocalIntegrator::u() const {
    return scattered(system_.domain(), u_, system_.op().op().rows());
}
Block LocalIntegrator::v() const {
    return scattered(system_.domain(), v_, system_.op().op().rows());
}

std::size_t LocalIntegrator::memory_bytes() const {
    std::size_t bytes = system_.memory_bytes();
    for (const SlotField* field : {&u_, &v_, &stretched_})
        bytes += field->memory_bytes();
    return bytes;
}

}  // namespace beltrami
