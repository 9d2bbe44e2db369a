// A mesh of fewer vertices that looks like a large one, for drawing.
//
//     const VertexClustering drawn = cluster_vertices(mesh, 200000);
//     drawn.mesh;                                   // at most 200000 of the mesh's own vertices
//     const Block values = u(drawn.vertex_of, Eigen::all);
//
// Source: Rossignac & Borrel 1993, Multi-resolution 3D approximations for rendering complex scenes: the vertices in one box
// of a uniform grid become one, and what is left of the cells is kept. Any topology will do and none is preserved: sheets that
// are nearer to each other than a box is wide grow together. A cluster is represented by the vertex of it that is nearest its
// mean, so that fields keep their exact values where they are shown.
#pragma once

#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

struct VertexClustering {
    Mesh mesh;  ///< with the fields of the original at the vertices that are left, which keep their order
    std::vector<Index> vertex_of;   ///< for each vertex that is left, its number in the original; ascending
    std::vector<Index> cluster_of;  ///< for each original vertex, the vertex that stands for it; -1 for none
    double box = 0.0;  ///< the side of the grid's boxes, in the file's unit; 0 where nothing was joined
};

/// The finest grid, or one that leaves nearly as many vertices, with at most `most` of them. Where the vertices that
/// cells use (all, of points) are no more than that, they are left as they are. Vertices in no cell are left out. No two
/// cells that are left have the same vertices, and none is degenerate (is_degenerate); a vertex all of whose cells collapsed
/// stays. Throws InputError for `most` below 1.
VertexClustering cluster_vertices(const Mesh& mesh, Index most);

}  // namespace beltrami
