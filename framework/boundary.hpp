// The boundary of a mesh.
#pragma once

#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

/// The vertices, ascending, of facets that belong to one cell only: ends of segments, edges of one triangle, faces of
/// one tetrahedron. Degenerate cells do not count as cells. Empty for closed meshes and points.
std::vector<Index> boundary_vertices(const Mesh& mesh);

/// The faces of exactly one tetrahedron, m x 3, seen counter-clockwise from outside, inverted tetrahedra too. Those that
/// name a vertex twice do not count. Throws InputError for other cells.
Cells boundary_triangles(const Mesh& tetrahedra);

}  // namespace beltrami
