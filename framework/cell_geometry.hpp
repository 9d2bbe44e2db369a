// Length, area or volume of cells, and which of them have none.
#pragma once

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

class EdgeGraph;

/// Length of a segment, area of a triangle, det(p1 - p0, p2 - p0, p3 - p0) / 6 of a tetrahedron (negative where it is
/// inverted), 0 for a point; in the file's unit to the power of the cell's dimension.
double signed_measure(const Mesh& mesh, Index cell);

/// |signed_measure| of every cell.
Vector cell_measures(const Mesh& mesh);

/// The longest edge of a cell.
double longest_edge(const Mesh& mesh, Index cell);

/// A cell of no dimension of its own: two of its vertices are one.
bool names_a_vertex_twice(const Mesh& mesh, Index cell);

/// A cell names a vertex twice, or its measure is at most 1e-12 times the longest edge to the power of its
/// dimension: it has no area or volume that double precision can divide by, and operators leave it out.
bool is_degenerate(const Mesh& mesh, Index cell);

/// The cells that are not degenerate, in their order.
Cells non_degenerate_cells(const Mesh& mesh);

/// The length of every edge of a graph between points, in the graph's order.
Vector edge_lengths(const EdgeGraph& graph, const Points& points);

}  // namespace beltrami
