// An order of the rows of a banded matrix in which stretches of them can be swept at once: the inner rows of all stretches,
// which no entry joins across stretches, then the separators between them.
//
//     const SweepOrder order(A, 1);
//     order.forward([&](Index i) { ... });       // a step of Gauss-Seidel on row i
//     order.backward([&](Index i) { ... });      // the reverse order
//
// The stretches depend on the matrix alone, so a sweep's result does not depend on the number of threads.
#pragma once

#include <vector>

#include "beltrami/framework/types.hpp"
#include "beltrami/solvers/float_rows.hpp"

namespace beltrami {

/// Rows first ... end - 1.
struct Rows {
    Index first;
    Index end;
    [[nodiscard]] Index count() const { return end - first; }
};

/// step(rows, t) for t = 0 ... of each of the stretches, which must not depend on each other.
template <class Step>
void sweep(const std::vector<Rows>& stretches, Step step) {
    const auto count = static_cast<int>(stretches.size());
#pragma omp parallel for schedule(static) if (count > 1)
    for (int s = 0; s < count; ++s) {
        const FlushToZero flush;
        const Rows rows = stretches[static_cast<std::size_t>(s)];
        for (Index t = 0; t < rows.count(); ++t)
            step(rows, t);
    }
}

class SweepOrder {
  public:
    /// reach: n, one more than the last column of each row or of those before it. rings: 1 where a step reads and writes
    /// the row's own unknown and reads the neighbours', 2 where it writes the neighbours' too.
    SweepOrder(const std::vector<Index>& reach, int rings);
    SweepOrder() = default;

    [[nodiscard]] const std::vector<Rows>& separators() const { return separators_; }

    template <class Step>
    void forward(Step step) const {
        sweep(inner_rows_, [&](Rows rows, Index t) { step(rows.first + t); });
        sweep(separators_, [&](Rows rows, Index t) { step(rows.first + t); });
    }
    template <class Step>
    void backward(Step step) const {
        sweep(separators_, [&](Rows rows, Index t) { step(rows.end - 1 - t); });
        sweep(inner_rows_, [&](Rows rows, Index t) { step(rows.end - 1 - t); });
    }

  private:
    std::vector<Rows> inner_rows_{{0, 0}};
    std::vector<Rows> separators_{{0, 0}};  // each before the inner rows of its stretch
};

}  // namespace beltrami
