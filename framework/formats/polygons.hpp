// Polygons of any number of corners as triangles.
#pragma once

#include <string>
#include <vector>

#include "beltrami/framework/formats/contents.hpp"
#include "beltrami/framework/types.hpp"

namespace beltrami::formats {

struct Triangulation {
    Cells triangles;                 ///< m x 3, in the order and with the orientation of the polygons
    std::vector<std::string> notes;  ///< what was split and dropped
};

/// Triangles stay as they are, degenerate ones too. A quadrilateral is split by the diagonal that folds
/// nothing over and leaves the smaller opposite angles (Delaunay), or else the shorter one. Larger polygons
/// take the constrained Delaunay triangulation on the plane that fits them best, or a fan where they cross
/// themselves on it. Repeated neighbouring corners are removed, polygons with fewer than three different
/// corners are dropped. positions: x y z of each vertex; all corners must be in range.
Triangulation triangulate(const Polygons& polygons, const std::vector<double>& positions);

}  // namespace beltrami::formats
