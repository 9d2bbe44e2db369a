// Scattered values over a mesh: the smoothest field that takes given values at given vertices.
//
//     const Constraints fixed{{120, 0.0}, {8999, 1.0}};
//     const auto [value, summary] = interpolate(laplacian, fixed, {.laplacian = 1.0, .bilaplacian = 0.1});
//
// Solves (gamma_1 K + gamma_2 K D K) u = 0 for the free vertices: section 5.3 of Kim & Rossignac. The Laplacian alone
// stays within the given values where the mesh is Delaunay, with a spike at each; the bi-Laplacian is smooth at the
// given values and may overshoot them (docs/interpolate.md).
#pragma once

#include "beltrami/framework/constraints.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "beltrami/solvers/free_components.hpp"
#include "beltrami/solvers/linear_solver.hpp"

namespace beltrami {

struct InterpolateOptions {
    double laplacian = 1.0;    ///< gamma_1, not negative
    double bilaplacian = 0.0;  ///< gamma_2, in length^2, not negative; not both zero
    FreeComponents free_components = FreeComponents::refuse;
    LinearSolverOptions linear = {};
};

struct InterpolateResult {
    Block value;  ///< n x k in the user's order; 0 at isolated vertices
    LinearSummary summary;
};

/// `fixed` in the user's numbering, k columns. Throws InputError for no constraint at all, vertices out of range,
/// components that nothing holds and coefficients that are negative or both zero; SolveError without convergence.
InterpolateResult interpolate(const Laplacian& laplacian, const Constraints& fixed,
                              const InterpolateOptions& options = {});

}  // namespace beltrami
