// Laplace's and Poisson's equation with given values: Laplacian of u = f.
//
//     const auto [u, summary] = poisson(laplacian, f, fixed);               // f: a density, n x k
//     const auto [u, summary] = poisson_from_gradient(mesh, laplacian, vectors, fixed);   // grad u closest to vectors
//
// K u = -M f on the free vertices, with no flux through a boundary that is not fixed. With f = 0 it is Laplace's
// equation. Sign and weak form as in textbooks on finite
// elements: Laplacian of u = f, so K u = -M f.
#pragma once

#include "beltrami/framework/constraints.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "beltrami/solvers/free_components.hpp"
#include "beltrami/solvers/linear_solver.hpp"

namespace beltrami {

struct PoissonOptions {
    FreeComponents free_components = FreeComponents::refuse;
    LinearSolverOptions linear = {};
};

struct PoissonResult {
    Block u;  ///< n x k in the user's order; 0 at isolated vertices
    LinearSummary summary;
};

/// f: n x k, in units of u / length^2; fixed: k columns; both in the user's order. Throws InputError for wrong shapes,
/// vertices out of range and components that nothing holds; SolveError without convergence.
PoissonResult poisson(const Laplacian& laplacian, const Block& f, const Constraints& fixed,
                      const PoissonOptions& options = {});

/// The u whose gradient is closest to a vector field (n x 3, at the vertices): Laplacian of u = div of the field.
PoissonResult poisson_from_gradient(const Mesh& mesh, const Laplacian& laplacian, const Points& vectors,
                                    const Constraints& fixed, const PoissonOptions& options = {});

}  // namespace beltrami
