#include "beltrami/operators/edge_operator.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

template <class Values>
void require_fit(const Values& u, const Values& y, Index rows) {
    if (u.size() > 0 && u.data() == y.data()) {
        throw InputError("a product was asked to write over the field it reads",
                         "give it another field to write to");
    }
    const Eigen::Index got = u.rows();
    if (got == rows) return;
    throw InputError(fmt::format("an operator of {} rows got a field of {} rows", rows, got),
                     "give one row a vertex, in the working order");
}

}  // namespace

template <class Scalar>
EdgeOperator<Scalar>::EdgeOperator(std::shared_ptr<const EdgeGraph> graph, Array diagonal, Array edges)
    : graph_(std::move(graph)), diagonal_(std::move(diagonal)), edges_(std::move(edges)) {
    if (diagonal_.size() != graph_->vertex_count() || edges_.size() != graph_->edge_count()) {
        throw InputError(
            fmt::format("an operator got {} vertex and {} edge values for {} vertices and {} edges",
                        diagonal_.size(), edges_.size(), graph_->vertex_count(), graph_->edge_count()),
            "give one value a vertex and one an edge of the graph");
    }
    ++builds_;
}

template <class Scalar>
void EdgeOperator<Scalar>::apply(const Values& u, Values& y) const {
    ChainWorkspace<Scalar> none;
    apply_chain(std::array{ChainLink{}}, u, y, none);
}

template <class Scalar>
void EdgeOperator<Scalar>::apply(const Array& u, Array& y) const {
    require_fit(u, y, rows());
    y.resize(u.rows());
    ChainWorkspace<Scalar> none;
    multiply_chain<Scalar>({*graph_, diagonal_.data(), edges_.data()}, std::array{ChainLink{}}, u.data(),
                           y.data(), 1, none);
}

template <class Scalar>
void EdgeOperator<Scalar>::apply_chain(std::span<const ChainLink> links, const Values& u, Values& y,
                                       ChainWorkspace<Scalar>& workspace) const {
    require_fit(u, y, rows());
    y.resize(u.rows(), u.cols());
    multiply_chain<Scalar>({*graph_, diagonal_.data(), edges_.data()}, links, u.data(), y.data(),
                           static_cast<Index>(u.cols()), workspace);
}

template <class Scalar>
Eigen::SparseMatrix<Scalar> EdgeOperator<Scalar>::to_sparse() const {
    using Sparse = Eigen::SparseMatrix<Scalar>;
    const Index n = rows();
    Sparse matrix(n, n);
    if (n == 0) return matrix;
    Eigen::Matrix<Index, Eigen::Dynamic, 1> column_size(n);
    for (Index i = 0; i < n; ++i)
        column_size[i] = 1 + graph_->degree(i);
    matrix.reserve(column_size);
    // Column j in ascending rows: the lower neighbours, the diagonal, the upper ones.
    for (Index j = 0; j < n; ++j) {
        const auto neighbours = graph_->neighbours(j);
        auto n_it = neighbours.begin();
        for (; n_it != neighbours.end() && n_it->vertex < j; ++n_it)
            matrix.insert(n_it->vertex, j) = edges_[n_it->edge];
        matrix.insert(j, j) = diagonal_[j];
        for (; n_it != neighbours.end(); ++n_it) {
            matrix.insert(n_it->vertex, j) = Eigen::numext::conj(edges_[n_it->edge]);
        }
    }
    matrix.makeCompressed();
    return matrix;
}

template class EdgeOperator<double>;
template class EdgeOperator<std::complex<double>>;

}  // namespace beltrami
