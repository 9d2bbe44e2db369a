// Scattered tangent vectors over a surface: the smoothest tangent vector field that takes given vectors at given
// vertices.
//
//     Constraints fixed(3);
//     fixed.fix(120, std::array{1.0, 0.0, 0.0});
//     const VectorsResult result = vectors(mesh, laplacian, fixed, {.bilaplacian = 0.05});
//     result.vectors.row(v);                       // tangent at vertex v
//     result.singularities.list;                   // where the field turns around a point
//
// Section 5.3 of Kim & Rossignac interpolates each coordinate by itself and projects the result on the tangent planes,
// which shortens vectors wherever the surface turns and gives the field singularities that nothing asks for. The
// connection Laplacian turns vectors with the surface instead (connection_laplacian.hpp). No field on a curved surface is
// parallel, so its solution fades away from few vectors; their lengths are therefore interpolated by themselves, as in
// Sharp, Soliman & Crane 2019, "The vector heat method" (docs/vectors.md).
#pragma once

#include <optional>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "beltrami/operators/singularities.hpp"
#include "beltrami/solvers/free_components.hpp"
#include "beltrami/solvers/linear_solver.hpp"

namespace beltrami {

enum class VectorMethod {
    connection,  ///< (gamma_1 K_c + gamma_2 K_c D K_c) z = 0 for complex z, with K_c the connection Laplacian
    coordinates  ///< (gamma_1 K + gamma_2 K D K) u = 0 for x, y and z by themselves, then projected
};

enum class VectorLengths {
    solved,  ///< of the solution: linear in the given vectors, but few of them fade out on curved surfaces
    interpolated  ///< of the given vectors, interpolated as numbers; the directions are the solution's
};

struct VectorsOptions {
    VectorMethod method = VectorMethod::connection;
    /// Without it, interpolated for the connection and solved, as published, for coordinates.
    std::optional<VectorLengths> lengths = {};
    double laplacian = 1.0;    ///< gamma_1, not negative
    double bilaplacian = 0.0;  ///< gamma_2, in length^2, not negative; not both zero
    FreeComponents free_components = FreeComponents::refuse;
    LinearSolverOptions linear = {};
};

struct VectorsResult {
    /// n x 3 in the user's order, tangent; 0 at vertices without a tangent plane.
    Block vectors;
    LinearSummary summary;
    /// Empty, with every triangle undefined, on one-sided surfaces.
    Singularities singularities;
    /// How far the given vectors were off the tangent planes that they were projected on: the largest angle in degrees,
    /// and its vertex (-1 where all given vectors are zero).
    double largest_tilt = 0.0;
    Index most_tilted = -1;
    /// Vertices in triangles whose normals cancel (tangent_frames.hpp).
    Index without_plane = 0;
};

/// `fixed`: three columns, in the user's numbering; projected on the tangent plane of their vertex. `laplacian` is the
/// mesh's. Throws InputError for other cells than triangles, no constraint at all, other than three columns, a vector at
/// a vertex without a tangent plane or at a right angle to it, vertices out of range, components that nothing holds,
/// coefficients that are negative or both zero, and one-sided surfaces with the method connection; SolveError without
/// convergence.
VectorsResult vectors(const Mesh& mesh, const Laplacian& laplacian, const Constraints& fixed,
                      const VectorsOptions& options = {});

}  // namespace beltrami
