// What multigrid computes with: rows of 1 to 4 floats, and sparse rows whose entries come by four.
#pragma once

#include <array>
#include <cstddef>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "beltrami/framework/types.hpp"

namespace beltrami {

/// While one lives, what its thread computes is zero where it would be denormal: far from its load a sweep has little else,
/// and the processor takes a hundred times as long over it.
class FlushToZero {
  public:
#if defined(__SSE__)
    FlushToZero() {
        _mm_setcsr(before_ | 0x8040U);
    }
    ~FlushToZero() {
        _mm_setcsr(before_);
    }
#else
    FlushToZero() = default;
    ~FlushToZero() = default;
#endif
    FlushToZero(const FlushToZero&) = delete;
    FlushToZero& operator=(const FlushToZero&) = delete;

  private:
#if defined(__SSE__)
    unsigned before_ = _mm_getcsr();
#endif
};

/// The numbers of one row.
template <int K>
struct FloatRow {
    std::array<float, K> v{};
    FloatRow() = default;
    explicit FloatRow(const float* p) {
        for (int c = 0; c < K; ++c)
            v[c] = p[c];
    }
    void add(float w, const float* p) {
        for (int c = 0; c < K; ++c)
            v[c] += w * p[c];
    }
    void add_to(float w, float* p) const {
        for (int c = 0; c < K; ++c)
            p[c] += w * v[c];
    }
    void store(float w, float* p) const {
        for (int c = 0; c < K; ++c)
            p[c] = w * v[c];
    }
};

/// Rows come by four entries, filled up with zeros: most rows then are one turn of a loop, whose end is foreseen.
struct FourEntries {
    std::array<Index, 4> column;
    std::array<float, 4> value;
};

/// Four that are still empty; `column` is any that may be read.
inline FourEntries no_entries(Index column) {
    return {{column, column, column, column}, {0.0F, 0.0F, 0.0F, 0.0F}};
}

/// p += the transpose of a row, times `numbers`.
template <int K>
[[gnu::always_inline]] inline void add_four_to(const FourEntries& four, const FloatRow<K>& numbers,
                                               float* p) {
    for (std::size_t e = 0; e < 4; ++e)
        numbers.add_to(four.value[e], p + K * static_cast<std::ptrdiff_t>(four.column[e]));
}

// Left to itself the compiler calls this for every four numbers.
template <int K>
[[gnu::always_inline]] inline void subtract_four(const FourEntries& four, const float* x, FloatRow<K>& sum) {
    const auto at = [&](std::size_t e) { return x + K * static_cast<std::ptrdiff_t>(four.column[e]); };
    const std::array<const float*, 4> from{at(0), at(1), at(2), at(3)};
    for (int c = 0; c < K; ++c) {
        sum.v[c] -= (four.value[0] * from[0][c] + four.value[1] * from[1][c]) +
                    (four.value[2] * from[2][c] + four.value[3] * from[3][c]);
    }
}

}  // namespace beltrami
