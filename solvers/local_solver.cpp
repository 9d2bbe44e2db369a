#include "beltrami/solvers/local_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/stopwatch.hpp"

namespace beltrami {

namespace {

// The part of the tolerance that what is let go in the end may use up.
constexpr double share_of_removal = 0.15;

PdeOperator with_foundation(PdeOperator A) {
    if (A.sigma() > 0.0) return A;
    throw InputError("a local solve needs a foundation: without one a held point moves the whole mesh",
                     "give gamma_0 (sigma) a positive value, step in time, or solve on the whole mesh");
}

}  // namespace

void LocalOptions::check() const {
    if (!(tolerance > 0.0 && tolerance < 1.0)) {
        throw InputError(fmt::format("the tolerance is {}", tolerance),
                         "give a number between 0 and 1, such as 1e-3");
    }
    if (max_iterations < 1) throw InputError("the limit of iterations is less than 1", "allow at least one");
}

std::string LocalSummary::brief() const {
    return fmt::format(
        "local: {} of {} vertices{}, {} iterations in {} rounds, error below {:.2g}{} in {:.2g} s", active,
        vertices, whole ? " (all there is: a global solve)" : "", iterations, rounds, error_bound,
        converged ? "" : ", not converged", seconds);
}

void require_converged(const LocalSummary& summary) {
    if (summary.converged) return;
    throw SolveError(
        fmt::format("the local solve stopped after {} iterations with an error bound of {:.2g}, above {:.2g}",
                    summary.iterations, summary.error_bound, summary.tolerance),
        "allow more iterations or a larger tolerance");
}

Block scattered(const ActiveDomain& domain, const SlotField& field, Index rows) {
    Block result = Block::Zero(rows, field.columns());
    for (Index s = 1; s < domain.end(0); ++s)
        result.row(domain.vertex(s)) = Eigen::Map<const Eigen::RowVectorXd>(field[s], field.columns());
    return result;
}

LocalSolver::LocalSolver(PdeOperator A, Index columns, LocalOptions options)
    : options_(options), system_(with_foundation(std::move(A)), columns), forces_(0, columns) {
    options_.check();
}

LocalSummary LocalSolver::solve(std::span<const Hold> holds) {
    const Stopwatch watch;
    const std::vector<Index> touched = system_.vertices_of(holds);
    system_.forget_factor();  // of a solve that was cancelled
    LocalSummary summary;
    summary.tolerance = options_.tolerance;
    summary.vertices = system_.op().op().rows();
    if (holds.empty()) {
        system_.clear();
        forces_.resize(0, system_.columns());
        summary.converged = true;
        return summary;
    }
    const long products_before = system_.op().products();
    const double bytes_before = system_.bytes();
    constexpr LocalOperator::Weights A{0.0, 1.0};

    system_.activate(touched);
    system_.prepare(A, holds);
    system_.impose();
    system_.compute_residual();

    // |u|_A^2 = u^T (b - r) with b = 0.
    const auto energy = [&] { return std::max(0.0, -system_.dot(system_.x, system_.r)); };
    // The part of what is missing that the iteration may leave inside.
    constexpr double share_inside = 0.01;
    const double for_missing = std::pow(0.8 * options_.tolerance, 2);
    // A factor costs about as much as this many iterations. Where Jacobi needs more for one round (K D K, slivers), each
    // further round gets a factor of its own.
    constexpr int worth_a_factor = 150;
    bool direct = false;
    bool fresh_factor = false;
    bool factor_failed = false;
    double outside_before = 0.0;
    int since_growth = 0;
    LocalSystem::Missing missing = system_.missing();
    double scale = energy();
    while (summary.iterations < options_.max_iterations) {
        report(options_.progress, "local solve", -1.0);
        const double allowed = for_missing * scale * system_.sigma();
        if (missing.total() <= allowed) {
            summary.converged = true;
            break;
        }
        if (!std::isfinite(missing.total() + scale)) {
            throw SolveError("the numbers of a local solve overflow", "rescale the mesh or the coefficients");
        }
        // Growing needs no more accuracy inside than what it is about to change.
        const double inside = share_inside * std::max(allowed, missing.outside);
        if (missing.inside > inside) {
            if (direct && !fresh_factor && !factor_failed) {
                fresh_factor = system_.factorize();
                factor_failed = !fresh_factor;
            }
            const auto run = system_.iterate(
                inside, std::min(worth_a_factor, options_.max_iterations - summary.iterations), {});
            summary.iterations += run.count;
            since_growth += run.count;
            const double before = missing.inside;
            system_.compute_residual();
            missing = fresh_factor ? system_.missing_by_factor() : system_.missing();
            scale = energy();
            if (missing.inside > inside) {
                const bool better = run.definite && missing.inside < 0.25 * before;
                // What even a factor does not improve is rounding.
                if (fresh_factor && !better) break;
                if (!better && factor_failed) break;
                if (!better || since_growth >= worth_a_factor) direct = true;
            }
            continue;
        }
        std::vector<Index> grown = system_.growth(0.5 * allowed);
        if (grown.empty()) break;
        system_.activate(grown);
        // As many rings more as the decay of the last round promises to be needed, within reason.
        const double decay = std::log(outside_before / missing.outside);
        const double wanted = decay > 0.0 ? 0.5 * std::log(missing.outside / allowed) / decay : 0.0;
        for (int ring = 0; ring < static_cast<int>(std::min(wanted, summary.rounds / 3.0)); ++ring) {
            grown.clear();
            for (Index s = system_.domain().end(0); s < system_.domain().end(1); ++s)
                grown.push_back(system_.domain().vertex(s));
            system_.activate(grown);
        }
        outside_before = missing.outside;
        since_growth = 0;
        fresh_factor = false;
        ++summary.rounds;
        system_.prepare(A, holds);
        system_.compute_residual();
        missing = system_.missing();
    }
    system_.forget_factor();
    // Along the field itself the solution is the best there is: the error is not larger, and the force is as good as its
    // square.
    system_.balance();
    forces_ = system_.forces();
    summary.active = system_.domain().active_count();
    summary.slots = system_.domain().slot_count() - 1;
    summary.whole = summary.active > 0 && summary.slots == summary.active;

    const double error = std::sqrt(missing.total() / system_.sigma());
    const double let_go = summary.converged ? this->let_go(scale) : 0.0;
    summary.error_bound = scale > 0.0 ? (error + let_go) / (std::sqrt(scale) - let_go) : 0.0;
    summary.products = system_.op().products() - products_before;
    summary.bytes = system_.bytes() - bytes_before;
    summary.memory_bytes = system_.memory_bytes();
    summary.seconds = watch.seconds();
    return summary;
}

// Lets quiet vertices go; the energy norm of what they held. `scale` is the energy of all.
double LocalSolver::let_go(double scale) {
    const double budget = std::pow(share_of_removal * options_.tolerance, 2) * scale;
    const std::vector<Index> quiet = system_.quiet_vertices(0.25 * budget, [&](Index s) {
        double square = 0.0;
        for (Index c = 0; c < system_.columns(); ++c)
            square += system_.x[s][c] * system_.x[s][c];
        return system_.op().diagonal()[static_cast<std::size_t>(s)] * square;
    });
    if (quiet.empty()) return 0.0;
    const double energy = system_.part(quiet, system_.x).own;
    if (!(energy <= budget)) return 0.0;
    system_.deactivate(quiet);
    return std::sqrt(std::max(0.0, energy));
}

Block LocalSolver::value() const {
    return scattered(system_.domain(), system_.x, system_.op().op().rows());
}

}  // namespace beltrami
