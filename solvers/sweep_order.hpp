// An order of the rows of a banded matrix in which stretches of them can be swept at once: the inner rows of all stretches,
// which no entry joins across stretches, then the separators between them.
//
//     const SweepOrder order(reach, 1);
//     order.forward([&](Index i) { ... });       // a step of Gauss-Seidel on row i
//     order.backward([&](Index i) { ... });      // the reverse order
//
// The stretches depend on the matrix alone, so a sweep's result does not depend on the number of threads.
#pragma once

#include <cstddef>
#include <vector>

#include "beltrami/framework/types.hpp"
#include "beltrami/solvers/float_rows.hpp"
#include "beltrami/solvers/row_range.hpp"

namespace beltrami {

/// work(stretch) of each, shared out to threads: they must not depend on each other.
template <class Work>
void for_each_stretch(const std::vector<RowRange>& stretches, Work work) {
    const auto count = static_cast<int>(stretches.size());
#pragma omp parallel for schedule(static) if (count > 1)
    for (int s = 0; s < count; ++s) {
        const FlushToZero flush;
        work(stretches[static_cast<std::size_t>(s)]);
    }
}

/// step(i) of the rows of each stretch, ascending.
template <class Step>
void sweep(const std::vector<RowRange>& stretches, Step step) {
    for_each_stretch(stretches, [&](RowRange rows) {
        for (Index i = rows.first; i < rows.end; ++i)
            step(i);
    });
}
/// The same, descending.
template <class Step>
void sweep_back(const std::vector<RowRange>& stretches, Step step) {
    for_each_stretch(stretches, [&](RowRange rows) {
        for (Index i = rows.end; i-- > rows.first;)
            step(i);
    });
}

class SweepOrder {
  public:
    /// reach: n, one more than the last column of each row or of those before it. rings: 1 where a step reads and writes
    /// the row's own unknown and reads the neighbours', 2 where it writes the neighbours' too, and so on.
    SweepOrder(const std::vector<Index>& reach, int rings);
    SweepOrder() = default;

    [[nodiscard]] const std::vector<RowRange>& separators() const { return separators_; }

    template <class Step>
    void forward(Step step) const {
        sweep(inner_rows_, step);
        sweep(separators_, step);
    }
    template <class Step>
    void backward(Step step) const {
        sweep_back(separators_, step);
        sweep_back(inner_rows_, step);
    }

  private:
    std::vector<RowRange> inner_rows_{{0, 0}};
    std::vector<RowRange> separators_{{0, 0}};  // each before the inner rows of its stretch
};

}  // namespace beltrami
