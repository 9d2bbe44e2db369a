// Where a tangent vector field turns around a point: its singularities.
//
//     const Singularities found = singularities(mesh, frames, field);
//     found.index_sum;      // on a closed surface the Euler characteristic, whatever the field (Poincare & Hopf)
//
// The index of a triangle is the number of turns that the field makes along its edges, against vectors transported along
// them (normal to normal, by the smallest rotation), plus the part of a turn that transport around the triangle itself
// makes, the area of the spherical triangle of the three normals over 2 pi. Source: Knoeppel, Crane, Pinkall & Schroeder
// 2013, section 6.1.2, with our transport; the area by van Oosterom & Strackee 1983.
#pragma once

#include <vector>

#include "beltrami/operators/tangent_frames.hpp"

namespace beltrami {

struct Singularity {
    Index triangle;
    int index;         ///< +1: source, sink or vortex; -1: saddle; rarely more
    Vector3 position;  ///< the middle of the triangle
};

struct Singularities {
    std::vector<Singularity> list;  ///< by triangle
    int index_sum = 0;
    /// Triangles with an index that is not defined: the field vanishes there and around. Not in the sum.
    Index undefined_triangles = 0;
};

/// field: n x 3, tangent (what is not is projected), in the mesh's order. A vector is zero when it is shorter than 1e-9
/// of the longest; it then takes a direction of its neighbours, their mean if there is one, so that a zero of the field is found in one of
/// the triangles around. Throws InputError for a field of another shape and for one-sided surfaces.
Singularities singularities(const Mesh& mesh, const TangentFrames& frames, const Block& field);

}  // namespace beltrami
