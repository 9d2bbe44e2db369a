// An operator as solvers see it: real, symmetric, and anything that multiplies.
//
//     y = A u with A.apply(u, y);   diag(A) with A.diagonal();   A itself with A.to_sparse()
//
// PdeOperator is one; HermitianPdeOperator is the real form of a complex one.
#pragma once

#include <Eigen/SparseCore>
#include <functional>

#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/types.hpp"

namespace beltrami {

/// y = A u for n x k blocks.
using Product = std::function<void(const Block& u, Block& y)>;

class LinearOperator {
  public:
    LinearOperator() = default;
    LinearOperator(const LinearOperator&) = default;
    LinearOperator(LinearOperator&&) = default;
    LinearOperator& operator=(const LinearOperator&) = default;
    LinearOperator& operator=(LinearOperator&&) = default;
    virtual ~LinearOperator() = default;

    [[nodiscard]] virtual Index rows() const = 0;
    /// y = A u for n x k blocks, in the working order. Throws InputError for another number of rows.
    virtual void apply(const Block& u, Block& y) const = 0;
    /// apply() with room of its own for intermediate fields: for who applies often, from one thread, while the
    /// operator lives.
    [[nodiscard]] virtual Product product() const = 0;
    /// n.
    [[nodiscard]] virtual Vector diagonal() const = 0;
    /// Both triangles, for direct solvers and tests.
    [[nodiscard]] virtual Eigen::SparseMatrix<double> to_sparse() const = 0;

    // What the choice of a solver goes by.

    /// How many products with a stiffness one apply() takes: from two on it is ill-conditioned.
    [[nodiscard]] virtual int order() const = 0;
    /// Of the vertices; each has rows() / vertex_count() rows.
    [[nodiscard]] virtual const EdgeGraph& graph() const = 0;
    /// The sum of the mass term's diagonal.
    [[nodiscard]] virtual double total_mass() const = 0;
};

}  // namespace beltrami
