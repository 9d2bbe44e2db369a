// Where a field on a triangle mesh has a given value, as polylines.
//
//     const Isolines nodal = isolines(mesh, mesh.field("height").values.col(0), 0.0);
//     nodal.length;  nodal.lines.size();
//     write_mesh("lines.vtu", nodal.segments);
//
// The field is linear in every triangle, and a vertex that has the very value counts as above it: an infinitesimal shift
// of the value (Edelsbrunner & Mucke 1990, simulation of simplicity), after which a line enters a triangle by one edge
// and leaves it by another. So on a manifold every line is simple, and ends on the boundary or nowhere; where it passes
// through a vertex it has a point on each of several edges there, all at the same place.
#pragma once

#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

/// Points of a polyline in their order, as numbers of Isolines::segments' vertices. A closed line goes on from its last
/// point to its first, which is not repeated.
struct Polyline {
    std::vector<Index> points;
    bool closed = false;
};

struct Isolines {
    Mesh segments;  ///< kind segment; one for each triangle that is crossed, joined at points on common edges
    std::vector<Polyline> lines;  ///< every segment is in one; at points of other than two segments lines end
    double length = 0.0;          ///< of all segments
};

/// values: one number a vertex. Triangles that name a vertex twice are not crossed; non-manifold edges are where three
/// and more lines meet. Throws InputError for a mesh of other cells than triangles, for another number of values, and for
/// a value or a level that is not finite.
Isolines isolines(const Mesh& mesh, const Vector& values, double level);

}  // namespace beltrami
