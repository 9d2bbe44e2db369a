// Delaunay triangulation of points on the unit sphere.
#pragma once

#include "beltrami/framework/types.hpp"

namespace beltrami::shapes {

/// Rows 1, 2, ... in the order of a Hilbert curve, so that neighbours lie close in memory; row 0 stays.
void sort_along_curve(Points& points);

/// The convex hull of different points on the unit sphere, the first of which is the north pole (0, 0, 1): 2 n - 4
/// triangles, seen counterclockwise from outside.
Cells triangulate_sphere(const Points& points);

}  // namespace beltrami::shapes
