// What a linear solve did.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "beltrami/framework/types.hpp"

namespace beltrami {

/// In which norm, and against what, a solve is stopped. r = b - A x on the free vertices, r_0 the same with the free
/// values at zero (so constraints count as load), P = diag(A).
enum class StoppingNorm {
    automatic,        ///< energy_error for operators with K D K, scaled_residual for all others
    residual,         ///< |r|_2 / |r_0|_2
    scaled_residual,  ///< (r^T P^-1 r)^(1/2) / (r_0^T P^-1 r_0)^(1/2): blind to units and to slivers' large
                      ///< entries
    energy_error,  ///< an estimate of |x - x*|_A / |x*|_A; cg only. A small residual of K D K says little about
                   ///< x, this does
    refinement  ///< the largest change of a refinement over the largest |x|: how cholesky, green and multigrid
                ///< are judged on an operator with K D K. That of multigrid is its cycle's on the residual,
                ///< divided by the smallest Ritz value, which says how little of an error a cycle may see
};
std::string_view name(StoppingNorm norm);

enum class StopReason { converged, iteration_limit, stagnated, not_definite };
std::string_view sentence(StopReason reason);

struct LinearSummary {
    std::string solver;  ///< "cg", "multigrid", "cholesky" or "green"
    std::string why;     ///< why it was chosen
    StopReason reason = StopReason::iteration_limit;
    bool converged = false;
    StoppingNorm norm = StoppingNorm::scaled_residual;
    double tolerance = 0.0;
    double error = 0.0;  ///< in `norm`, the largest of the columns, when the solve stopped
    double relative_residual =
        0.0;             ///< the scaled residual, computed afresh from x; the largest of the columns
    int iterations = 0;  ///< of conjugate gradients, or of refinement after a direct solve
    long products = 0;   ///< with A
    int factorizations = 0;
    Index unknowns = 0;  ///< free vertices
    Index columns = 0;
    double setup_seconds = 0.0;
    double solve_seconds = 0.0;
    std::size_t memory_bytes = 0;  ///< of the factor, or of the work fields
    /// The error in `norm` after each iteration of the last solve, the largest of the columns, as the solver itself saw it: by
    /// recurrences, where `error` may be computed afresh. NaN where there is no estimate yet (the first of energy_error).
    std::vector<double> history = {};

    /// "cg: 98 iterations to 9.1e-11 (scaled residual) for 34835 unknowns x 1 in 0.21 s".
    [[nodiscard]] std::string brief() const;
    /// A line for each fact.
    [[nodiscard]] std::string full() const;

    /// Adds a later solve: counts and seconds add up, errors keep the worst, the solver and the history are those
    /// of the later one.
    void add(const LinearSummary& later);
};

/// Throws SolveError that names the solver, the error that was reached and the tolerance, unless converged.
void require_converged(const LinearSummary& summary);

}  // namespace beltrami
