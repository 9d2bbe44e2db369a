// Builders of mass: lumped (a number a vertex) and consistent (an EdgeOperator).
//
//     Vector M = lumped_mass(mesh);                           // sums to the total area
//     EdgeOperator<double> full = consistent_mass(mesh, graph);   // row sums equal the barycentric M
//
// Units: length, area or volume. Degenerate cells add nothing; an isolated vertex has mass 0.
#pragma once

#include <memory>

#include "beltrami/framework/mesh.hpp"
#include "beltrami/operators/edge_operator.hpp"

namespace beltrami {

enum class Mass {
    barycentric,  ///< an equal share of every cell: the D of eq. (6) of Kim & Rossignac is 1 / this
    voronoi       ///< mixed Voronoi cells of Meyer et al. 2003 (halves and quarters at obtuse triangles);
                  ///< triangles only, the same as barycentric on segments
};

/// n. Throws InputError for Voronoi mass of tetrahedra, which can be negative, and for a mesh of points.
Vector lumped_mass(const Mesh& mesh, Mass kind = Mass::barycentric);

/// integral of (hat i)(hat j): measure / ((d + 1)(d + 2)) off the diagonal and twice that on it, for cells of
/// dimension d. Throws InputError for a mesh of points and a graph without the mesh's edges.
EdgeOperator<double> consistent_mass(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph);

}  // namespace beltrami
