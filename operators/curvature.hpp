// The mean-curvature normal -c K x of a triangle mesh.
//
//     MeanCurvature curvature = mean_curvature(mesh, laplacian, CurvatureCorrection::c2);
//     curvature.normal.row(v);      // of length kappa_1 + kappa_2 = 2 H, pointing to the centre of curvature
//     curvature.mean[v];            // H, positive where a surface with outward normals is convex
//
// Source: Kim & Rossignac, section 3.4.1 and the appendix; Meyer et al. 2003.
#pragma once

#include "beltrami/framework/mesh.hpp"
#include "beltrami/operators/laplacian.hpp"

namespace beltrami {

/// The factor between K x and the Laplacian of x; A is the area of all triangles at the vertex, n its valence. They
/// agree at n = 6. c1 varies less over a mesh, c2 is right on average and at sharp corners (Table 1 of the paper).
enum class CurvatureCorrection {
    c1,  ///< 4 cos^2(pi / n) / A
    c2   ///< 3 / A
};

struct MeanCurvature {
    Points normal;  ///< n x 3, the Laplacian of the position, in 1 / length
    Vector mean;    ///< n, H = (kappa_1 + kappa_2) / 2 with the sign against the vertex normal, in 1 / length
    Index boundary_vertices = 0;  ///< where curvature is not defined and both are set to zero
};

/// In the mesh's own order. `laplacian` is the mesh's, with cotangent weights. Throws InputError unless triangles.
MeanCurvature mean_curvature(const Mesh& mesh, const Laplacian& laplacian, CurvatureCorrection correction);

}  // namespace beltrami
