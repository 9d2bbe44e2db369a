// An order of the rows of a banded matrix in which stretches of them can be swept at once: the inner rows of all stretches,
// which no entry joins across stretches, then the separators between them.
//
//     const SweepOrder order(A, 1);
//     order.forward([&](Index i) { ... });       // a step of Gauss-Seidel on row i
//     order.backward([&](Index i) { ... });      // the reverse order
//
// The stretches depend on the matrix alone, so a sweep's result does not depend on the number of threads.
#pragma once

#include <algorithm>
#include <vector>

#include "beltrami/framework/types.hpp"
#include "beltrami/solvers/float_rows.hpp"

namespace beltrami {

class SweepOrder {
  public:
    /// reach: n, one more than the last column of each row or of those before it. rings: 1 where a step reads and writes
    /// the row's own unknown and reads the neighbours', 2 where it writes the neighbours' too.
    SweepOrder(const std::vector<Index>& reach, int rings);
    SweepOrder() = default;

    /// Whether row i comes before row j.
    [[nodiscard]] bool before(Index i, Index j) const {
        const bool i_separates = separates(i);
        const bool j_separates = separates(j);
        return i_separates == j_separates ? i < j : j_separates;
    }
    [[nodiscard]] bool separates(Index i) const {
        const auto stretch = std::upper_bound(first_.begin(), first_.end(), i) - first_.begin() - 1;
        return i < inner_[static_cast<std::size_t>(stretch)];
    }
    [[nodiscard]] int stretches() const { return static_cast<int>(inner_.size()); }

    template <class Step>
    void forward(Step step) const {
        const int count = stretches();
#pragma omp parallel if (count > 1)
        {
            const FlushToZero flush;
#pragma omp for schedule(static)
            for (int s = 0; s < count; ++s) {
                for (Index i = inner_[at(s)]; i < first_[at(s + 1)]; ++i)
                    step(i);
            }
#pragma omp for schedule(static)
            for (int s = 0; s < count; ++s) {
                for (Index i = first_[at(s)]; i < inner_[at(s)]; ++i)
                    step(i);
            }
        }
    }
    template <class Step>
    void backward(Step step) const {
        const int count = stretches();
#pragma omp parallel if (count > 1)
        {
            const FlushToZero flush;
#pragma omp for schedule(static)
            for (int s = 0; s < count; ++s) {
                for (Index i = inner_[at(s)]; i-- > first_[at(s)];)
                    step(i);
            }
#pragma omp for schedule(static)
            for (int s = 0; s < count; ++s) {
                for (Index i = first_[at(s + 1)]; i-- > inner_[at(s)];)
                    step(i);
            }
        }
    }

  private:
    static std::size_t at(int s) {
        return static_cast<std::size_t>(s);
    }
    std::vector<Index> first_{0, 0};  // of each stretch, and the end
    std::vector<Index> inner_{0};     // of each stretch; rows before it, from first_ on, are its separator
};

}  // namespace beltrami
