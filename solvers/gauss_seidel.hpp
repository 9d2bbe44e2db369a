// Symmetric Gauss-Seidel in floats, 1 to 4 columns at once: the smoother of multigrid on every level whose operator is stored.
//
//     const GaussSeidel smoother(n, A, held);
//     smoother.down<1>(b, x);                     // x = (D + L)^-1 b
//     smoother.residual_of_down<1>(i, x);         // row i of b - A x, from what down() has not seen
//     smoother.up<1>(b, x);                       // x += (D + U)^-1 (b - A x)
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "beltrami/framework/types.hpp"
#include "beltrami/solvers/float_rows.hpp"
#include "beltrami/solvers/sweep_order.hpp"

namespace beltrami {

class GaussSeidel {
  public:
    GaussSeidel() = default;
    /// A: anything with for_row(), symmetric. Rows that are held, or whose diagonal is not positive, stay at zero.
    template <class Rows>
    GaussSeidel(Index n, const Rows& A, const std::vector<char>& held);

    /// x = (D + L)^-1 b.
    template <int K>
    void down(const float* b, float* x) const {
        order_.forward([&](Index i) {
            FloatRow<K> sum(b + K * at(i));
            subtract(begin_[at(i)], later_[at(i)], x, sum);
            sum.store(inverse_[at(i)], x + K * at(i));
        });
    }
    template <int K>
    void up(const float* b, float* x) const {
        order_.backward([&](Index i) { step<K>(i, b, x); });
    }
    /// Of row i, where x is what down() made: what it has seen cancels.
    template <int K>
    [[nodiscard]] FloatRow<K> residual_of_down(Index i, const float* x) const {
        FloatRow<K> r;
        subtract(later_[at(i)], begin_[at(i) + 1], x, r);
        return r;
    }

    [[nodiscard]] Index rows() const { return static_cast<Index>(inverse_.size()); }
    [[nodiscard]] bool is_held(Index i) const { return inverse_[at(i)] == 0.0F; }
    /// With the diagonal.
    [[nodiscard]] double entries_per_row() const { return entries_ / std::max<double>(1.0, rows()); }
    [[nodiscard]] std::size_t memory_bytes() const {
        return (begin_.size() + later_.size()) * sizeof(Index) + entry_.size() * sizeof(FourEntries) +
               inverse_.size() * sizeof(float);
    }

  private:
    static std::size_t at(Index i) { return static_cast<std::size_t>(i); }

    template <int K>
    void step(Index i, const float* b, float* x) const {
        FloatRow<K> sum(b + K * at(i));
        subtract(begin_[at(i)], begin_[at(i) + 1], x, sum);
        sum.store(inverse_[at(i)], x + K * at(i));
    }
    template <int K>
    void subtract(Index begin, Index end, const float* x, FloatRow<K>& sum) const {
        for (Index e = begin; e < end; ++e)
            subtract_four<K>(entry_[at(e)], x, sum);
    }

    SweepOrder order_;
    // Rows without their diagonal: first the columns that are swept before, then those after.
    std::vector<Index> begin_;
    std::vector<Index> later_;
    std::vector<FourEntries> entry_;
    std::vector<float> inverse_;  // of the diagonal; 0 for rows that are held
    double entries_ = 0.0;
};

template <class Rows>
GaussSeidel::GaussSeidel(Index n, const Rows& A, const std::vector<char>& held) {
    begin_.assign(at(n) + 1, 0);
    later_.assign(at(n), 0);
    inverse_.assign(at(n), 0.0F);
    std::vector<Index> reach(at(n));
    Index last = 0;
    for (Index i = 0; i < n; ++i) {
        A.for_row(i, [&](Index j, double) { last = std::max(last, j + 1); });
        reach[at(i)] = last;
    }
    order_ = SweepOrder(reach, 1);
    std::vector<char> separates(at(n), 0);
    for (const RowRange& rows : order_.separators())
        std::fill(separates.begin() + rows.first, separates.begin() + rows.end, 1);
    const auto earlier = [&](Index j, Index i) {
        return separates[at(i)] == separates[at(j)] ? j < i : separates[at(j)] < separates[at(i)];
    };
    for (Index i = 0; i < n; ++i) {
        Index before = 0;
        Index after = 0;
        A.for_row(i, [&](Index j, double) { ++(j != i && earlier(j, i) ? before : after); });
        entries_ += before + after;
        // The diagonal was counted with those after.
        later_[at(i)] = begin_[at(i)] + (before + 3) / 4;
        begin_[at(i) + 1] = later_[at(i)] + (after + 2) / 4;
    }
    entry_.resize(at(begin_.back()));
#pragma omp parallel for schedule(static) if (n > 20000)
    for (Index i = 0; i < n; ++i) {
        for (Index e = begin_[at(i)]; e < begin_[at(i) + 1]; ++e)
            entry_[at(e)] = no_entries(i);
        Index front = 4 * begin_[at(i)];
        Index back = 4 * later_[at(i)];
        A.for_row(i, [&](Index j, double a) {
            if (j == i) {
                inverse_[at(i)] = a > 0.0 && held[at(i)] == 0 ? static_cast<float>(1.0 / a) : 0.0F;
                return;
            }
            const Index to = earlier(j, i) ? front++ : back++;
            entry_[at(to / 4)].column[at(to % 4)] = j;
            entry_[at(to / 4)].value[at(to % 4)] = static_cast<float>(a);
        });
    }
}

}  // namespace beltrami
