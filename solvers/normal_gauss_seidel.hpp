// Symmetric Gauss-Seidel on sigma M + gamma_1 K + gamma_2 K D K in floats without forming K D K, 1 to 4 columns at once: the
// smoother of multigrid on the finest level.
//
// With w = gamma_1 x + gamma_2 D K x kept along, the residual of row i is b_i - sigma M_i x_i - (K w)_i, one row of K, and a
// change of x_i changes w at i's neighbours only. For sigma = gamma_1 = 0 it is Kaczmarz's iteration in K D^(1/2).
#pragma once

#include <cmath>
#include <vector>

#include "beltrami/operators/pde_operator.hpp"
#include "beltrami/solvers/float_rows.hpp"
#include "beltrami/solvers/sweep_order.hpp"

namespace beltrami {

class NormalGaussSeidel {
  public:
    NormalGaussSeidel() = default;
    /// A: of order 2, with a positive mass wherever there is an edge. Rows that are held stay at zero.
    NormalGaussSeidel(const PdeOperator& A, const std::vector<char>& held);

    /// From x = 0.
    template <int K>
    void down(const float* b, float* x, float* w) const {
        std::fill_n(x, K * at(rows()), 0.0F);
        std::fill_n(w, K * at(rows()), 0.0F);
        order_.forward([&](Index i) { step<K>(i, b, x, w); });
    }
    template <int K>
    void up(const float* b, float* x, float* w) const {
        order_.backward([&](Index i) { step<K>(i, b, x, w); });
    }
    /// r = b - A x.
    template <int K>
    void residual(const float* b, const float* x, const float* w, float* r) const {
        order_.forward([&](Index i) { residual<K>(i, b, x, w).store(1.0F, r + K * at(i)); });
    }
    /// x += e, with w.
    template <int K>
    void add(const float* e, float* x, float* w) const {
        order_.forward([&](Index i) { change<K>(i, FloatRow<K>(e + K * at(i)), x, w); });
    }

    [[nodiscard]] Index rows() const { return static_cast<Index>(inverse_.size()); }
    [[nodiscard]] bool is_held(Index i) const { return inverse_[at(i)] == 0.0F; }
    [[nodiscard]] double entries_per_row() const { return entries_ / std::max<double>(1.0, rows()); }
    [[nodiscard]] std::size_t memory_bytes() const {
        return begin_.size() * sizeof(Index) + entry_.size() * sizeof(FourEntries) +
               (diagonal_.size() + inverse_.size() + mass_.size() + own_.size() + patch_inverses_.size()) *
                   sizeof(float) +
               (patch_of_row_.size() + patch_rows_.size()) * sizeof(Index) + patches_.size() * sizeof(Patch);
    }

  private:
    static std::size_t at(Index i) { return static_cast<std::size_t>(i); }

    template <int K>
    [[nodiscard]] [[gnu::always_inline]] FloatRow<K> residual(Index i, const float* b, const float* x,
                                                              const float* w) const {
        FloatRow<K> r;
        if (inverse_[at(i)] == 0.0F) return r;
        r = FloatRow<K>(b + K * at(i));
        r.add(-mass_[at(i)], x + K * at(i));
        r.add(-diagonal_[at(i)], w + K * at(i));
        for (Index e = begin_[at(i)]; e < begin_[at(i) + 1]; ++e)
            subtract_four<K>(entry_[at(e)], w, r);
        return r;
    }
    static constexpr Index largest_patch = 16;
    struct Patch {
        Index rows;  // where they begin in patch_rows_
        Index size;
        std::size_t inverse;  // size x size, of A on them
    };
    void make_patches(const PdeOperator& A);

    template <int K>
    void step(Index i, const float* b, float* x, float* w) const {
        const Index patch = patch_of_row_[at(i)];
        if (patch == covered) return;
        if (patch != alone) return step_of_patch<K>(patches_[at(patch)], b, x, w);
        FloatRow<K> delta = residual<K>(i, b, x, w);
        for (int c = 0; c < K; ++c)
            delta.v[c] *= inverse_[at(i)];
        change<K>(i, delta, x, w);
    }
    // All of a patch at once.
    template <int K>
    void step_of_patch(const Patch& patch, const float* b, float* x, float* w) const {
        std::array<FloatRow<K>, largest_patch> r;
        std::array<FloatRow<K>, largest_patch> delta;
        const Index* const rows = patch_rows_.data() + patch.rows;
        const float* inverse = patch_inverses_.data() + patch.inverse;
        for (Index a = 0; a < patch.size; ++a)
            r[at(a)] = residual<K>(rows[a], b, x, w);
        for (Index a = 0; a < patch.size; ++a, inverse += patch.size) {
            for (Index c = 0; c < patch.size; ++c)
                delta[at(a)].add(inverse[c], r[at(c)].v.data());
        }
        for (Index a = 0; a < patch.size; ++a)
            change<K>(rows[a], delta[at(a)], x, w);
    }
    template <int K>
    [[gnu::always_inline]] void change(Index i, const FloatRow<K>& delta, float* x, float* w) const {
        delta.add_to(1.0F, x + K * at(i));
        delta.add_to(own_[at(i)], w + K * at(i));
        for (Index e = begin_[at(i)]; e < begin_[at(i) + 1]; ++e)
            add_four_to<K>(entry_[at(e)], delta, w);
    }

    SweepOrder order_;
    // With d = (gamma_2 D)^(1/2): K_ij d_j by rows, without the diagonal; w is scaled by 1 / d.
    std::vector<Index> begin_;
    std::vector<FourEntries> entry_;
    std::vector<float> diagonal_;  // K_ii d_i
    std::vector<float> own_;       // K_ii d_i + gamma_1 / d_i: what w_i gains by x_i
    std::vector<float> mass_;      // sigma M_i
    std::vector<float> inverse_;   // of the diagonal of A; 0 for rows that are held
    double entries_ = 0.0;
    // A vertex with little mass pulls at all its neighbours together: they are solved for together.
    static constexpr Index alone = -1;
    static constexpr Index covered = -2;
    std::vector<Index> patch_of_row_;
    std::vector<Patch> patches_;
    std::vector<Index> patch_rows_;
    std::vector<float> patch_inverses_;
};

}  // namespace beltrami
