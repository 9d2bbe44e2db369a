#include "beltrami/solvers/sparse_rows.hpp"

#include <numeric>
#include <utility>

namespace beltrami {

namespace {

std::size_t at(Eigen::Index i) {
    return static_cast<std::size_t>(i);
}

}  // namespace

SparseRows rows_of(const Eigen::SparseMatrix<double, Eigen::RowMajor>& A, const std::vector<char>& left_out) {
    SparseRows rows;
    rows.columns = static_cast<Index>(A.cols());
    rows.begin.reserve(at(A.rows()) + 1);
    rows.column.reserve(at(A.nonZeros()));
    rows.value.reserve(at(A.nonZeros()));
    for (Eigen::Index i = 0; i < A.rows(); ++i) {
        const bool keep = left_out.empty() || left_out[at(i)] == 0;
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(A, i); entry && keep;
             ++entry) {
            rows.column.push_back(static_cast<Index>(entry.col()));
            rows.value.push_back(entry.value());
        }
        rows.begin.push_back(static_cast<Index>(rows.column.size()));
    }
    return rows;
}

Eigen::SparseMatrix<double> to_sparse(const SparseRows& A) {
    // What transpose() makes has its entries in order, and its rows are the columns of A.
    const SparseRows columns = transpose(A);
    return Eigen::Map<const Eigen::SparseMatrix<double>>(
        A.rows(), A.columns, static_cast<Eigen::Index>(columns.column.size()), columns.begin.data(),
        columns.column.data(), columns.value.data());
}

SparseRows transpose(const SparseRows& A) {
    SparseRows result;
    result.columns = A.rows();
    result.begin.assign(at(A.columns) + 1, 0);
    for (const Index j : A.column)
        ++result.begin[at(j) + 1];
    std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
    result.column.resize(A.column.size());
    result.value.resize(A.column.size());
    std::vector<Index> next = result.begin;
    for (Index i = 0; i < A.rows(); ++i) {
        A.for_row(i, [&](Index j, double a) {
            const auto to = at(next[at(j)]++);
            result.column[to] = i;
            result.value[to] = a;
        });
    }
    return result;
}

void scale_columns(const Vector& scale, SparseRows& A) {
    for (std::size_t e = 0; e < A.column.size(); ++e)
        A.value[e] *= scale[A.column[e]];
}

SparseRows sum(const SparseRows& A, const SparseRows& B) {
    SparseRows result;
    result.columns = A.columns;
    result.begin.reserve(A.begin.size());
    result.column.reserve(A.column.size() + B.column.size());
    result.value.reserve(A.column.size() + B.column.size());
    std::vector<Index> position(at(A.columns), -1);
    for (Index i = 0; i < A.rows(); ++i) {
        const auto first = static_cast<Index>(result.column.size());
        const auto add = [&](Index j, double a) {
            if (position[at(j)] < first) {
                position[at(j)] = static_cast<Index>(result.column.size());
                result.column.push_back(j);
                result.value.push_back(a);
            } else {
                result.value[at(position[at(j)])] += a;
            }
        };
        A.for_row(i, add);
        B.for_row(i, add);
        result.begin.push_back(static_cast<Index>(result.column.size()));
    }
    return result;
}

SparseRows detail::joined(Index columns, std::vector<RowsInWork>& parts) {
    SparseRows result;
    result.columns = columns;
    if (parts.size() == 1) {
        result.column = std::move(parts[0].column);
        result.value = std::move(parts[0].value);
        result.begin.insert(result.begin.end(), parts[0].end.begin(), parts[0].end.end());
        return result;
    }
    for (RowsInWork& part : parts) {
        const auto before = static_cast<Index>(result.column.size());
        for (const Index end : part.end)
            result.begin.push_back(before + end);
        result.column.insert(result.column.end(), part.column.begin(), part.column.end());
        result.value.insert(result.value.end(), part.value.begin(), part.value.end());
        part = {};
    }
    return result;
}

}  // namespace beltrami
