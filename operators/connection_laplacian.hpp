// The connection Laplacian of a surface: the Laplacian of tangent vector fields.
//
//     const TangentFrames frames = tangent_frames(mesh);
//     const EdgeOperator<std::complex<double>> K = connection_laplacian(mesh, laplacian, frames);
//
// A field is one complex number a vertex (tangent_frames.hpp). z^* K z is the integral of the squared covariant
// derivative: in each triangle the vectors of the corners are transported to its plane, each by the smallest rotation
// that takes the vertex's normal to the triangle's, and interpolated linearly there. So an entry off the diagonal is, of
// both triangles of the edge, minus half the cotangent times a unit rotation, and the diagonal is that of the cotangent
// stiffness. Every triangle adds a square, so K is Hermitian positive semidefinite on any mesh, also where cotangents are
// negative and where many triangles meet in an edge.
//
// Sources: Knoeppel, Crane, Pinkall & Schroeder 2013, "Globally optimal direction fields", and Sharp, Soliman & Crane
// 2019, "The vector heat method", where the rotation is found from the angles around a vertex instead. Both ways
// converge alike (docs/vectors.md); this one needs no order around a vertex.
#pragma once

#include <complex>

#include "beltrami/operators/laplacian.hpp"
#include "beltrami/operators/tangent_frames.hpp"

namespace beltrami {

/// In the working order and on the graph of `laplacian`, the mesh's own; on a flat surface with equal axes it is the
/// cotangent stiffness. No unit. Where the normals of a vertex and a triangle are opposite, the rotation is about one of
/// the triangle's edges. Throws InputError for other cells than triangles, another mesh's Laplacian, and one-sided
/// surfaces, where turning left at one vertex is turning right at another and complex numbers do not suffice.
EdgeOperator<std::complex<double>> connection_laplacian(const Mesh& mesh, const Laplacian& laplacian,
                                                        const TangentFrames& frames);

}  // namespace beltrami
