// A tangent plane at every vertex of a surface, in which tangent vectors are complex numbers.
//
//     const TangentFrames frames = tangent_frames(mesh);
//     const std::complex<double> z = frames.to_number(v, Vector3(1, 0, 0));    // projected on the plane
//     const Vector3 along = frames.to_vector(v, z);
//
// The number 1 is the vector `axis`, i is `normal x axis`. Which axis is chosen is a gauge: no vector depends on it.
// Everything is in the mesh's own order.
#pragma once

#include <complex>
#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

struct TangentFrames {
    /// n x 3, of unit length: the mean of the triangles' normals by area, triangles turned so that neighbours run alike
    /// (orientation.hpp). Where these cancel, the normal of the largest triangle; 0 at vertices without a triangle.
    Points normal;
    Points axis;  ///< n x 3, unit vectors of the tangent planes; 0 where the normal is
    std::vector<char>
        has_plane;  ///< n; 0 where normals cancel and at vertices in no triangle or degenerate ones only
    Points triangle_normal;  ///< m x 3, of unit length, turned likewise; 0 for degenerate triangles
    bool one_sided = false;  ///< the surface has no consistent normal, nor has any choice of it

    /// The vector's part along the surface.
    [[nodiscard]] std::complex<double> to_number(Index v, const Vector3& vector) const;
    [[nodiscard]] Vector3 to_vector(Index v, std::complex<double> number) const;

    /// How many vertices of triangles that are not degenerate have no tangent plane, because their normals cancel.
    [[nodiscard]] Index cancelled() const;
};

/// Throws InputError unless the mesh has triangles.
TangentFrames tangent_frames(const Mesh& mesh);

/// A tangent vector at the unit normal `from`, turned with it to the unit normal `to` by the smallest rotation, which is
/// the parallel transport along the great arc between them. Where they are opposite there is none; it is then turned
/// about `hinge`, a unit vector perpendicular to both.
Vector3 turned(const Vector3& tangent, const Vector3& from, const Vector3& to, const Vector3& hinge);

}  // namespace beltrami
