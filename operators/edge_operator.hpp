// The class of the one idea: a symmetric operator on a mesh is one number a vertex and one number an edge.
//
//     EdgeOperator<double> K = cotangent_stiffness(mesh, graph);
//     K.apply(u, y);                                   // y = K u; u is n x k row-major, or a vector
//     Eigen::SparseMatrix<double> A = K.to_sparse();   // only for direct solvers and tests
//
// Stiffness, consistent mass, graph Laplacians, surfaces, solids, non-manifold meshes: the same class with different
// numbers in it (Kim & Rossignac, section 3.3: K_ii is stored with the vertex, K_ij with the edge).
#pragma once

#include <Eigen/SparseCore>
#include <atomic>
#include <complex>
#include <memory>
#include <span>

#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/types.hpp"
#include "beltrami/operators/product_chain.hpp"

namespace beltrami {

/// Self-adjoint: A_ii = diagonal[i] and A_ij = edge[e], A_ji = conj(edge[e]) for edge e from i to j > i. Immutable.
template <class Scalar>
class EdgeOperator {
  public:
    using Array = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
    using Values = BlockOf<Scalar>;

    /// diagonal: n, edges: m, in the order of the graph. Throws InputError for other lengths.
    EdgeOperator(std::shared_ptr<const EdgeGraph> graph, Array diagonal, Array edges);

    [[nodiscard]] Index rows() const { return graph_->vertex_count(); }
    [[nodiscard]] const EdgeGraph& graph() const { return *graph_; }
    /// For another operator on the same edges.
    [[nodiscard]] std::shared_ptr<const EdgeGraph> shared_graph() const { return graph_; }
    [[nodiscard]] const Array& diagonal() const { return diagonal_; }
    [[nodiscard]] const Array& edges() const { return edges_; }

    /// y = A u. u is n x k; y is resized. One sweep over the edges, on the threads that OpenMP has when the work is
    /// worth them; the numbers do not depend on how many. Throws InputError for a number of rows other than n, and
    /// where y is u.
    void apply(const Values& u, Values& y) const;
    void apply(const Array& u, Array& y) const;
    /// Several products and what is between them (product_chain.hpp), still in one sweep. At least one link.
    void apply_chain(std::span<const ChainLink> links, const Values& u, Values& y,
                     ChainWorkspace<Scalar>& workspace) const;

    /// The same numbers as an n x n matrix, both triangles.
    [[nodiscard]] Eigen::SparseMatrix<Scalar> to_sparse() const;

    [[nodiscard]] std::size_t memory_bytes() const {
        return sizeof(Scalar) * static_cast<std::size_t>(diagonal_.size() + edges_.size());
    }

    /// How many operators were made (not copied) in this process: for tests that count rebuilding.
    static long builds() { return builds_.load(); }

  private:
    std::shared_ptr<const EdgeGraph> graph_;
    Array diagonal_;
    Array edges_;
    static inline std::atomic<long> builds_ = 0;
};

extern template class EdgeOperator<double>;
extern template class EdgeOperator<std::complex<double>>;

}  // namespace beltrami
