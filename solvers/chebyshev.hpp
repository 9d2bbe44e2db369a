// Chebyshev's iteration of the fourth kind in floats, 1 to 4 columns at once: the smoother of multigrid on every level.
//
//     const ScaledRows scaled = scaled_rows(n, A, held);
//     const Chebyshev smoother(A, scaled);            // or of a PdeOperator of order 2, whose K D K is not formed
//     smoother.descend(k, fields);                    // x = S b, r = b - A x
//     smoother.ascend(k, P, coarse_x, fields);        // x += P coarse_x, smoothed; P to this smoother's rows
//
// It works on D^(-1/2) A D^(-1/2), D the diagonal of A, with rows in an order of its own. All steps of a call run in one sweep
// over the matrix (Wavefront), and a row's numbers do not depend on the order of rows: any number of threads gives the same.
// Source: Lottes 2022, Optimal polynomial smoothers for multigrid V-cycles, section 3.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "beltrami/framework/types.hpp"
#include "beltrami/operators/pde_operator.hpp"
#include "beltrami/solvers/sliced_rows.hpp"
#include "beltrami/solvers/wavefront.hpp"

namespace beltrami {

/// The unknowns of a level, renumbered and scaled: row i of A is position[i], and its x is scale times the level's.
struct ScaledRows {
    std::vector<Index> order;     ///< the row of A in each place
    std::vector<Index> position;  ///< of each row of A
    std::vector<float> scale;     ///< of each row of A; 0 for rows that are held

    [[nodiscard]] bool is_held(Index row) const { return scale[static_cast<std::size_t>(row)] == 0.0F; }
    [[nodiscard]] Index size() const { return static_cast<Index>(order.size()); }
};

/// Rows that are held, and those whose diagonal is not positive, are held. length: entries of each row.
ScaledRows scaled_rows(const Vector& diagonal, std::vector<Index> length, const std::vector<char>& held);

/// Rows come by length in blocks of so many.
constexpr Index chebyshev_block_rows = 1024;

/// A: anything with for_row(), symmetric.
template <class Rows>
ScaledRows scaled_rows(Index n, const Rows& A, const std::vector<char>& held);

/// Of a smoother with n rows: padded(n) x k, zero at first.
struct SmootherFields {
    std::vector<float> x;
    std::vector<float> r;
    std::array<std::vector<float>, 2> d;  ///< d[0] takes the right-hand side
    std::vector<float> w;                 ///< what is between the factors of K D K; none elsewhere

    [[nodiscard]] std::size_t memory_bytes() const {
        return (x.size() + r.size() + d[0].size() + d[1].size() + w.size()) * sizeof(float);
    }
};

class Chebyshev {
  public:
    Chebyshev() = default;
    template <class Rows>
    Chebyshev(const Rows& A, const ScaledRows& scaled);
    /// A: of order 2, with a positive mass wherever there is an edge.
    Chebyshev(const PdeOperator& A, const ScaledRows& scaled);

    /// Room for k columns.
    void resize(int k, SmootherFields& fields) const;

    /// From x = 0 and b in fields.d[0]; with the residual.
    void descend(int k, SmootherFields& fields) const;
    /// With the correction P coarse, and r as descend() left it. r is of no use afterwards.
    void ascend(int k, const SlicedRows& P, const float* coarse, SmootherFields& fields) const;

    /// With the diagonal.
    [[nodiscard]] double entries_per_row() const {
        return static_cast<double>(A_.entry_count()) / std::max<double>(1.0, A_.rows()) +
               (factored() ? 0.0 : 1.0);
    }
    /// An upper bound of the eigenvalues of D^-1 A, estimated.
    [[nodiscard]] double largest_eigenvalue() const { return largest_; }
    [[nodiscard]] std::size_t memory_bytes() const {
        return A_.memory_bytes() + C_.memory_bytes() + own_.size() * sizeof(float);
    }

  private:
    static constexpr Index block_rows = chebyshev_block_rows;
    static constexpr int degree = 4;  // steps before and after

    void prepare();
    [[nodiscard]] bool factored() const { return C_.rows() > 0; }
    // Of a step: one, or two with the factors of K D K.
    [[nodiscard]] int passes() const { return factored() ? 2 : 1; }
    // Pass `pass` of a step on a block, from field d[from] to the other.
    void pass_of_step(int pass, Index block, int k, const ChebyshevStep& step, int from,
                      SmootherFields& f) const;
    [[nodiscard]] RowRange rows_of_block(Index b) const {
        return {b * block_rows, std::min(A_.padded_rows(), (b + 1) * block_rows)};
    }
    // The step after which x has `terms` terms of the sum of corrections.
    [[nodiscard]] ChebyshevStep step(int terms) const;

    // The operator is A_ without the diagonal, which is 1; or A_ C_ + own_, for K (gamma_1 + gamma_2 D K) + sigma M.
    SlicedRows A_;
    SlicedRows C_;
    std::vector<float> own_;
    Wavefront front_;
    double largest_ = 1.0;
};

/// y = A x on threads. k: 1 ... 4 numbers a row.
void multiply(const SlicedRows& A, int k, const float* x, float* y);

// ------------------------------------------------------------------------------------------------------------------

template <class Rows>
ScaledRows scaled_rows(Index n, const Rows& A, const std::vector<char>& held) {
    const auto at = [](Index i) { return static_cast<std::size_t>(i); };
    Vector diagonal = Vector::Zero(n);
    std::vector<Index> length(at(n), 0);
#pragma omp parallel for schedule(static) if (n > 20000)
    for (Index i = 0; i < n; ++i) {
        A.for_row(i, [&](Index j, double a) {
            if (i == j) diagonal[i] = a;
            if (held[at(j)] == 0) ++length[at(i)];
        });
    }
    return scaled_rows(diagonal, std::move(length), held);
}

template <class Rows>
Chebyshev::Chebyshev(const Rows& A, const ScaledRows& scaled)
    : A_(scaled.size(), [&](Index place, auto f) {
          const auto at = [](Index i) { return static_cast<std::size_t>(i); };
          const Index i = scaled.order[at(place)];
          if (scaled.is_held(i)) return;
          A.for_row(i, [&](Index j, double a) {
              if (j != i && !scaled.is_held(j))
                  f(scaled.position[at(j)], scaled.scale[at(i)] * a * scaled.scale[at(j)]);
          });
      }) {
    prepare();
}

}  // namespace beltrami
