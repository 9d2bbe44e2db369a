// Builders of stiffness operators: geometry -> numbers on vertices and edges.
//
//     auto graph = std::make_shared<const EdgeGraph>(mesh.vertex_count(), mesh.cells());
//     EdgeOperator<double> K = stiffness(mesh, graph);
//
// Sign and scale: K is positive semidefinite, its rows sum to zero, K_ij = -(cot a + cot b) / 2 on triangles,
// and u^T K u is the integral of |grad u|^2. -D K u approximates the Laplacian of u (no area is divided out
// of K). Degenerate cells (is_degenerate) add nothing. Mesh and graph must number the vertices alike; every
// edge of a cell that is not degenerate must be in the graph, or InputError is thrown.
#pragma once

#include <memory>

#include "beltrami/framework/mesh.hpp"
#include "beltrami/operators/edge_operator.hpp"

namespace beltrami {

/// The stiffness of linear elements of the mesh's kind: segments (1 / length), triangles or tetrahedra. Throws
/// InputError for a mesh of points.
EdgeOperator<double> stiffness(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph);

/// Triangles: K_e = A B_s B_s^T, eq. (4) of Kim & Rossignac. Throws InputError for other cells.
EdgeOperator<double> cotangent_stiffness(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph);

/// K_e of one triangle that is not degenerate: minus half the cotangent of the third angle off the diagonal.
Eigen::Matrix3d cotangent_element(const Mesh& mesh, Index cell);

/// Tetrahedra: K_ij = (area vector of face i) . (area vector of face j) / (9 V). Throws InputError for other cells.
EdgeOperator<double> tetrahedral_stiffness(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph);

/// Each K_e times the cell's area (length, volume): small cells become soft, large ones stiff (section 5.2).
/// Throws InputError for a mesh of points.
EdgeOperator<double> area_weighted_stiffness(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph);

/// K_ij = -1 for every edge, K_ii = the number of neighbours: the graph Laplacian, blind to geometry.
EdgeOperator<double> combinatorial_stiffness(std::shared_ptr<const EdgeGraph> graph);

}  // namespace beltrami
