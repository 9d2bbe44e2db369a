// Sparse rows in floats for vector registers (SELL-16, Kreutzer, Hager, Wellein, Fehske & Bishop 2014): sixteen rows are a
// slice, whose entries lie together, one of each row, filled up with zeros to the longest.
//
//     const SlicedRows A(n, [&](Index i, auto f) { ... f(j, a_ij) ... });
//     A.multiply({0, A.padded_rows()}, 1, x, y);             // y = A x
//
// Where rows of about the same length are neighbours, little is filled up: see order_by_length().
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "beltrami/framework/types.hpp"
#include "beltrami/solvers/row_range.hpp"

namespace beltrami {

/// A step of Chebyshev's iteration: see SlicedRows::chebyshev_step().
struct ChebyshevStep {
    float before = 1.0F;  ///< what d is multiplied with first
    float d = 0.0F;
    float r = 0.0F;
    bool first = false;  ///< x is zero and d the right-hand side
    bool last = false;   ///< the next correction is added to x at once, and r is left as it was
};

/// padded() rows of k numbers.
struct StepFields {
    const float* source;  ///< what the matrix is applied to
    const float* own;     ///< one number a row, none for 1 everywhere
    const float* d;
    float* r;
    float* x;
    float* next;
};

class SlicedRows {
  public:
    static constexpr Index slice_rows = 16;
    /// Rows with a multiple of slice_rows.
    static Index padded(Index rows) { return (rows + slice_rows - 1) / slice_rows * slice_rows; }

    SlicedRows() = default;
    /// for_row(i, f) calls f(j, a_ij) for the entries of row i, at least twice and from several threads.
    template <class ForRow>
    SlicedRows(Index rows, ForRow for_row);

    /// y = A x on `rows`, whose ends are multiples of slice_rows. x and y: k = 1 ... 4 numbers a row, y padded() rows.
    void multiply(RowRange rows, int k, const float* x, float* y) const;

    /// With c = before: r -= c (A source + own d), x += c d, next = step.d c d + step.r r, on `rows`.
    void chebyshev_step(RowRange rows, int k, const ChebyshevStep& step, const StepFields& fields) const;

    [[nodiscard]] Index rows() const { return rows_; }
    [[nodiscard]] Index padded_rows() const { return padded(rows_); }
    [[nodiscard]] std::size_t entry_count() const { return entries_; }
    /// The least and the largest column of the rows, or of none: the first row twice. 0 may be among them where a slice begins
    /// with an empty row.
    [[nodiscard]] std::pair<Index, Index> columns_of(RowRange rows) const;
    [[nodiscard]] std::size_t memory_bytes() const {
        return begin_.size() * sizeof(std::size_t) + column_.size() * sizeof(Index) +
               value_.size() * sizeof(float);
    }

  private:
    static std::size_t at(Index i) { return static_cast<std::size_t>(i); }

    Index rows_ = 0;
    std::size_t entries_ = 0;
    std::vector<std::size_t> begin_{0};  // of each slice in the arrays below
    std::vector<Index> column_;
    std::vector<float> value_;
};

/// The rows of blocks of block_rows by falling length.
std::vector<Index> order_by_length(const std::vector<Index>& length, Index block_rows);

template <class ForRow>
SlicedRows::SlicedRows(Index rows, ForRow for_row) : rows_(rows) {
    const Index slices = padded(rows) / slice_rows;
    begin_.assign(at(slices) + 1, 0);
    std::size_t entries = 0;
#pragma omp parallel for schedule(static) reduction(+ : entries) if (rows > 20000)
    for (Index s = 0; s < slices; ++s) {
        std::size_t longest = 0;
        for (Index i = s * slice_rows; i < std::min(rows, (s + 1) * slice_rows); ++i) {
            std::size_t length = 0;
            for_row(i, [&](Index, double) { ++length; });
            longest = std::max(longest, length);
            entries += length;
        }
        begin_[at(s) + 1] = longest * at(slice_rows);
    }
    entries_ = entries;
    for (Index s = 0; s < slices; ++s)
        begin_[at(s) + 1] += begin_[at(s)];
    column_.resize(begin_.back());
    value_.resize(begin_.back());
#pragma omp parallel for schedule(static) if (rows > 20000)
    for (Index s = 0; s < slices; ++s) {
        Index column = 0;  // one of the slice's own, for what is filled up
        for (Index i = s * slice_rows; i < (s + 1) * slice_rows; ++i) {
            std::size_t to = begin_[at(s)] + at(i % slice_rows);
            if (i < rows) {
                for_row(i, [&](Index j, double a) {
                    column = j;
                    column_[to] = j;
                    value_[to] = static_cast<float>(a);
                    to += at(slice_rows);
                });
            }
            for (; to < begin_[at(s) + 1]; to += at(slice_rows)) {
                column_[to] = column;
                value_[to] = 0.0F;
            }
        }
    }
}

}  // namespace beltrami
