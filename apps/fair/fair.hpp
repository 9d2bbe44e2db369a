// Fairing: a region of a mesh is made smooth while the rest stays where it is.
//
//     const FairResult rest = fair(mesh, laplacian, region, {.bilaplacian = 1.0});      // where the flow comes to rest
//     const FairResult step = fair(mesh, laplacian, everything, {.laplacian = 1.0, .time = 1e-3});
//     write_mesh("out.ply", mesh.with_points(rest.points));
//
// Solves (gamma_1 K + gamma_2 K D K) x = 0 for the positions of the region, coordinate by coordinate: section 5.2 and
// Figure 6 of Kim & Rossignac. K is that of the mesh given and is kept: the right Laplacian for small displacements
// only. The Laplacian alone spans the region like a soap film that meets the rest with a crease, and gathers vertices;
// the bi-Laplacian goes on smoothly over the rim, whose two outer rings of held vertices give it place and slope.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "beltrami/apps/evolve.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "beltrami/solvers/free_components.hpp"

namespace beltrami {

struct FairOptions {
    double laplacian = 0.0;    ///< gamma_1, not negative
    double bilaplacian = 0.0;  ///< gamma_2, in length^2 against gamma_1, not negative; not both zero
    /// The flow M x' = -(gamma_1 K + gamma_2 K D K) x for so long, by backward Euler: one step of it is implicit
    /// fairing (Desbrun, Meyer, Schroeder and Barr 1999). In length^2 / gamma_1. Without it, until rest.
    std::optional<double> time = {};
    int steps = 1;  ///< of the flow
    /// Until rest: components that lie in the region as a whole have no place of their own.
    FreeComponents free_components = FreeComponents::refuse;
    LinearSolverOptions linear = {};
    const Progress* progress = nullptr;
    std::function<void(const Frame&)> on_frame = {};  ///< of the flow; u are the positions
};

struct FairResult {
    Points points;  ///< n x 3 in the user's order
    LinearSummary summary;
    Index stayed = 0;  ///< vertices of the region without a cell: they have no equation and stay
};

/// `region` in the user's numbering: the vertices that may move. Throws InputError for a region without vertices, one
/// out of range, one that leaves nothing fixed (until rest only), coefficients that are negative or both zero, a time
/// or number of steps that is not positive; SolveError without convergence.
FairResult fair(const Mesh& mesh, const Laplacian& laplacian, std::span<const Index> region,
                const FairOptions& options);

}  // namespace beltrami
