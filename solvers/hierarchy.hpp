// Coarser and coarser graphs of a mesh, and how values on a coarse one read on the finer one: what multigrid and
// hierarchical eigensolvers stand on.
//
//     const Hierarchy hierarchy(laplacian.graph(), laplacian.order().to_working(mesh).points());
//     const auto& P = hierarchy.prolongation(0);           // level 1 -> the mesh
//     Eigen::SparseMatrix<double> K1 = galerkin_product(laplacian.stiffness().to_sparse(), P);
//
// It is made of an EdgeGraph and positions alone, so it serves surfaces, solids, segments, point clouds and
// non-manifold meshes, and knows no operator and no constraints: one hierarchy serves them all. The construction is of
// the kind of Gravo MG (Wiersma, Nasikun, Eisemann & Hildebrandt 2023): graph Voronoi cells, and interpolation in
// triangles of adjacent cells.
#pragma once

#include <Eigen/SparseCore>
#include <cstddef>
#include <vector>

#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/progress.hpp"
#include "beltrami/framework/types.hpp"

namespace beltrami {

struct HierarchyOptions {
    /// A coarse vertex covers what is, along the graph, within radius x the mean edge length at either of the two: so
    /// coarse levels are dense where the mesh is. Larger is coarser: 2.0 suits K and heat, 2.3 suits K D K.
    double radius = 2.0;
    /// No level is added below one of so many vertices or fewer.
    Index coarsest = 3000;
    const Progress* progress = nullptr;
};

/// Immutable. The same input gives the same hierarchy, whatever the number of threads, and so does a mesh that is moved
/// or scaled, but for rounding.
class Hierarchy {
  public:
    using Prolongation = Eigen::SparseMatrix<double, Eigen::RowMajor>;

    /// points: n x 3, numbered as the graph. Adds levels until one has options.coarsest vertices or fewer, or a further
    /// one would not be smaller by a factor of 1.5. Throws InputError for points of another number or not finite, a
    /// radius that is not positive and finite, and coarsest < 1; Cancelled where asked to stop.
    Hierarchy(const EdgeGraph& graph, const Points& points, const HierarchyOptions& options = {});

    /// At least 1: level 0 is the mesh. The functions below throw InputError for a level that does not exist.
    [[nodiscard]] int level_count() const { return static_cast<int>(vertices_.size()); }
    /// The number of vertices.
    [[nodiscard]] Index size(int level) const { return static_cast<Index>(vertices(level).size()); }
    /// Which vertex of the mesh each vertex of a level is, ascending; levels are nested. Vertices without an edge are
    /// on level 0 only; of every other connected component each level has a vertex.
    [[nodiscard]] const std::vector<Index>& vertices(int level) const;
    /// From level + 1 to level, size(level) x size(level + 1): the barycentric coordinates of the closest point on
    /// triangles (segments where there are none) between the vertex of the cell and those of adjacent cells. At most
    /// three entries a row, in (0, 1], with sum 1; one where the vertex is on both levels, none where it has no edge.
    [[nodiscard]] const Prolongation& prolongation(int level) const;

    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    std::vector<std::vector<Index>> vertices_;
    std::vector<Prolongation> prolongations_;
};

/// P^T A P: A on the coarse space that P spans (Galerkin), both triangles. A: n x n, P: n x m.
Eigen::SparseMatrix<double> galerkin_product(const Eigen::SparseMatrix<double>& A,
                                             const Hierarchy::Prolongation& P);

}  // namespace beltrami
