// Sparse matrices by rows for setting multigrid up: products several times as fast as a general library's, as nothing is
// sorted and the rows of the first factor need not be stored.
//
//     const SparseRows P = rows_of(hierarchy.prolongation(0));
//     const SparseRows KP = product(K.rows(), StiffnessRows{K}, P);
//     const SparseRows coarse = product(transpose(P), KP);      // P^T K P
#pragma once

#include <omp.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <vector>

#include "beltrami/framework/types.hpp"
#include "beltrami/operators/edge_operator.hpp"

namespace beltrami {

/// The entries of a row are in no order, no column comes twice.
struct SparseRows {
    Index columns = 0;
    std::vector<Index> begin{0};  ///< rows + 1
    std::vector<Index> column;
    std::vector<double> value;

    [[nodiscard]] Index rows() const { return static_cast<Index>(begin.size()) - 1; }
    /// f(column, value) of each entry of row i.
    template <class Function>
    void for_row(Index i, Function f) const {
        for (Index e = begin[static_cast<std::size_t>(i)]; e < begin[static_cast<std::size_t>(i) + 1]; ++e)
            f(column[static_cast<std::size_t>(e)], value[static_cast<std::size_t>(e)]);
    }
};

/// sigma M + gamma K by rows, as it stands in the operator; a view.
struct StiffnessRows {
    const EdgeOperator<double>& K;
    double gamma = 1.0;
    double sigma = 0.0;
    const Vector* M = nullptr;  ///< n; read where sigma is not zero

    template <class Function>
    void for_row(Index i, Function f) const {
        f(i, gamma * K.diagonal()[i] + (sigma != 0.0 ? sigma * (*M)[i] : 0.0));
        for (const EdgeGraph::Neighbour& n : K.graph().neighbours(i))
            f(n.vertex, gamma * K.edges()[n.edge]);
    }
};

/// Rows with a number other than 0 in `left_out` are empty; all rows where that is empty.
SparseRows rows_of(const Eigen::SparseMatrix<double, Eigen::RowMajor>& A,
                   const std::vector<char>& left_out = {});
Eigen::SparseMatrix<double> to_sparse(const SparseRows& A);
SparseRows transpose(const SparseRows& A);

/// A B, for A of so many rows: anything with for_row(). Rows are shared out to threads; each is the sum in the order of
/// A's entries, so the result does not depend on their number.
template <class Rows>
SparseRows product(Index rows, const Rows& A, const SparseRows& B);
inline SparseRows product(const SparseRows& A, const SparseRows& B) {
    return product(A.rows(), A, B);
}

/// Column j times scale[j].
void scale_columns(const Vector& scale, SparseRows& A);
/// A + B.
SparseRows sum(const SparseRows& A, const SparseRows& B);

// ------------------------------------------------------------------------------------------------------------------

namespace detail {

/// Some consecutive rows of a product, with row ends counted from the first entry.
struct RowsInWork {
    std::vector<Index> end;
    std::vector<Index> column;
    std::vector<double> value;
};
/// One after the other; the parts are emptied.
SparseRows joined(Index columns, std::vector<RowsInWork>& parts);

}  // namespace detail

template <class Rows>
SparseRows product(Index rows, const Rows& A, const SparseRows& B) {
    const int threads = rows < 10000 ? 1 : omp_get_max_threads();
    std::vector<detail::RowsInWork> parts(static_cast<std::size_t>(threads));
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int t = 0; t < threads; ++t) {
        const auto bound = [&](int s) {
            return static_cast<Index>(static_cast<std::ptrdiff_t>(rows) * s / threads);
        };
        detail::RowsInWork& part = parts[static_cast<std::size_t>(t)];
        part.end.reserve(static_cast<std::size_t>(bound(t + 1) - bound(t)));
        // Where in the row that is made a column is; older numbers lie before that row.
        std::vector<Index> position(static_cast<std::size_t>(B.columns), -1);
        Index used = 0;
        for (Index i = bound(t); i < bound(t + 1); ++i) {
            std::size_t most = static_cast<std::size_t>(used);
            A.for_row(i, [&](Index j, double) {
                most += static_cast<std::size_t>(B.begin[static_cast<std::size_t>(j) + 1] -
                                                 B.begin[static_cast<std::size_t>(j)]);
            });
            if (most > part.column.size()) {
                // As many as the rows so far let expect, and some more.
                const double made = std::max(1.0, static_cast<double>(i - bound(t)));
                const double left = static_cast<double>(bound(t + 1) - i);
                const auto room =
                    std::max(most + most / 8, static_cast<std::size_t>(used * (1.0 + 1.05 * left / made)));
                part.column.resize(made < 1000.0 ? most + most / 2 : room);
                part.value.resize(part.column.size());
            }
            const Index first = used;
            Index* const columns = part.column.data();
            double* const values = part.value.data();
            A.for_row(i, [&](Index j, double a) {
                B.for_row(j, [&](Index k, double b) {
                    Index& at = position[static_cast<std::size_t>(k)];
                    if (at < first) {
                        at = used++;
                        columns[at] = k;
                        values[at] = a * b;
                    } else {
                        values[at] += a * b;
                    }
                });
            });
            part.end.push_back(used);
        }
        part.column.resize(static_cast<std::size_t>(used));
        part.value.resize(static_cast<std::size_t>(used));
    }
    return detail::joined(B.columns, parts);
}

}  // namespace beltrami
