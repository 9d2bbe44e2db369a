// The least energy 1/2 u^T A u - b^T u within bounds: what a LinearSolver solves, without overshooting.
//
//     LinearSolver solver(PdeOperator(laplacian, 0.0, {0.0, 1.0}));
//     BoundedSummary summary = solve_bounded(solver, b, held, {.low = low, .high = high}, u);
//
// Everything in the working order. The primal-dual active set method (Hintermueller, Ito and Kunisch 2002): vertices
// outside their bounds are held there, those whose reaction pulls them back inside are let go, until neither happens.
// On stiffness matrices without positive weights it cannot cycle; on K D K it can, and then a projected Newton method
// takes over (Bertsekas 1982), whose steps are shortened until they lower the energy.
#pragma once

#include "beltrami/framework/constraints.hpp"
#include "beltrami/solvers/linear_solver.hpp"

namespace beltrami {

/// A number a column; infinite where a column has no bound on that side.
struct Bounds {
    Vector low;
    Vector high;
};

struct BoundedOptions {
    /// Active sets that are tried before the projected Newton method takes over.
    int active_sets = 100;
};

struct BoundedSummary {
    LinearSummary linear;  ///< of all solves
    int sets = 0;          ///< active sets tried, the column that took the most
    int projected = 0;     ///< of these by the projected Newton method
    Index at_bounds = 0;   ///< free vertices at a bound at the end, over all columns
};

/// b, u: n x k. u: held rows are set to the constraints' values, vertices whose row of A is zero keep what they have.
/// Columns are independent: each has an active set of its own. At the end the rest is within the bounds; A u = b where it is
/// strictly inside; at a low bound A u - b >= 0, at a high one <= 0, to the accuracy of the linear solves. Held values
/// may lie outside. Throws InputError for bounds of another number of columns and a low bound above its high one;
/// SolveError without convergence; and what LinearSolver::solve() throws.
BoundedSummary solve_bounded(LinearSolver& solver, const Block& b, const Constraints& held,
                             const Bounds& bounds, Block& u, const BoundedOptions& options = {});

}  // namespace beltrami
