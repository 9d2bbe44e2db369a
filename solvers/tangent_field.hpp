// Tangent vector fields that take given vectors: from constraints in space to unknowns in tangent planes and back.
//
//     const TangentVectors given = project(frames, fixed);
//     const TangentField field = solve_by_connection(mesh, laplacian, frames, given.vectors, {1.0, 0.1}, options);
//
// Everything is in the user's order, which is the frames'.
#pragma once

#include <vector>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/operators/tangent_frames.hpp"
#include "beltrami/solvers/linear_solver.hpp"

namespace beltrami {

struct TangentVectors {
    Constraints vectors;        ///< three columns, tangent
    double largest_tilt = 0.0;  ///< the largest angle between a vector and its projection, in degrees
    Index most_tilted = -1;     ///< the vertex of that vector; -1 where all are zero
};

/// Each vector's part along the surface. Throws InputError for other than three columns, vertices out of range, a
/// vector at a vertex without a tangent plane, and one at a right angle to it (to 1e-6).
TangentVectors project(const TangentFrames& frames, const Constraints& given);

struct TangentField {
    Block vectors;  ///< n x 3; 0 at vertices without a tangent plane
    LinearSummary summary;
};

/// (sum of gamma_i K (D K)^(i-1)) u = 0 for each coordinate of the vectors, held at the given ones, then projected on the
/// tangent planes: section 5.3 of Kim & Rossignac. Throws SolveError without convergence.
TangentField solve_by_coordinates(const Laplacian& laplacian, const TangentFrames& frames,
                                  const Constraints& held, const std::vector<double>& gamma,
                                  const LinearSolverOptions& options);

/// The same with the connection Laplacian in the place of K and one complex number a vertex. Throws InputError as
/// connection_laplacian() and SolveError without convergence.
TangentField solve_by_connection(const Mesh& mesh, const Laplacian& laplacian, const TangentFrames& frames,
                                 const Constraints& held, const std::vector<double>& gamma,
                                 const LinearSolverOptions& options);

/// The field with the lengths that `held` has, interpolated by (sum of gamma_i K (D K)^(i-1)) u = 0 (not below 0), and
/// directions as they are; where it is zero it stays zero. The summary is that of both solves. As in Sharp, Soliman &
/// Crane 2019, "The vector heat method", which parts directions and lengths alike. Throws SolveError without convergence.
TangentField with_interpolated_lengths(const TangentField& field, const Laplacian& laplacian,
                                       const Constraints& held, const std::vector<double>& gamma,
                                       const LinearSolverOptions& options);

}  // namespace beltrami
