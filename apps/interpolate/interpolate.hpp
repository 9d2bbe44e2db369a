// Scattered values over a mesh: the smoothest field that takes given values at given vertices.
//
//     const Constraints fixed{{120, 0.0}, {8999, 1.0}};
//     const auto [value, summary] = interpolate(laplacian, fixed, {.laplacian = 1.0, .bilaplacian = 0.1});
//
// Solves (gamma_1 K + gamma_2 K D K) u = 0 for the free vertices: section 5.3 of Kim & Rossignac. The Laplacian alone
// stays within the given values where the mesh is Delaunay, with a spike at each; the bi-Laplacian is smooth at the
// given values and may overshoot them, unless bounds forbid it (docs/interpolate.md). Values of three columns may be
// displacements: `displaced(mesh, value)` is the mesh that they make; or colours: `clamped(value, 0.0, 1.0)`.
#pragma once

#include <optional>
#include <vector>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "beltrami/solvers/bounded_solver.hpp"
#include "beltrami/solvers/free_components.hpp"
#include "beltrami/solvers/linear_solver.hpp"

namespace beltrami {

struct InterpolateOptions {
    double laplacian = 1.0;    ///< gamma_1, not negative
    double bilaplacian = 0.0;  ///< gamma_2, in length^2, not negative; not both zero
    /// The least of the same energy within these: see range_of(). Takes a solve for each active set.
    std::optional<Bounds> bounds = {};
    FreeComponents free_components = FreeComponents::refuse;
    LinearSolverOptions linear = {};
};

struct InterpolateResult {
    Block value;  ///< n x k in the user's order; 0 at isolated vertices
    LinearSummary summary;
};

/// `fixed` in the user's numbering, k columns. Throws InputError for no constraint at all, vertices out of range,
/// components that nothing holds, coefficients that are negative or both zero and a fixed value outside the bounds;
/// SolveError without convergence.
InterpolateResult interpolate(const Laplacian& laplacian, const Constraints& fixed,
                              const InterpolateOptions& options = {});

/// Many interpolations over one mesh, such as while somebody paints: what the solver made (a factor, a hierarchy) stays
/// while constraints come, go and move.
class Interpolator {
  public:
    /// Throws InputError for coefficients that are negative or both zero.
    explicit Interpolator(const Laplacian& laplacian, const InterpolateOptions& options = {});

    /// As interpolate() with the options' coefficients, policy and solver; `bounds` instead of theirs.
    InterpolateResult operator()(const Constraints& fixed, const std::optional<Bounds>& bounds = {});

    /// What another Interpolator on the mesh, with other coefficients, can be handed in its options.
    [[nodiscard]] const LinearSolver& solver() const { return solver_; }

  private:
    Laplacian laplacian_;
    FreeComponents free_components_;
    Components components_;
    LinearSolver solver_;
    std::vector<Index> isolated_;  // of the working order; no solve moves them
    Block value_;                  // the last result, in the working order: the next one is near
};

/// The least and greatest fixed value of each column.
Bounds range_of(const Constraints& fixed);

/// The mesh with its points moved by n x 3 displacements.
inline Mesh displaced(const Mesh& mesh, const Block& displacement) {
    return mesh.with_points(mesh.points() + displacement);
}

/// Values within [low, high], and how many vertices were not, by how much at most.
struct Clamped {
    Block value;
    Index vertices = 0;
    double farthest = 0.0;
};
Clamped clamped(const Block& value, double low, double high);

}  // namespace beltrami
