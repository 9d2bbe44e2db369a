#include "beltrami/solvers/sliced_rows.hpp"

#include <array>
#include <numeric>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace beltrami {

namespace {

struct Slices {
    const std::size_t* begin;
    const Index* column;
    const float* value;
};
// For one to four numbers a row.
struct SliceKernels {
    std::array<void (*)(const Slices&, RowRange, const float*, float*), 4> multiply;
    std::array<void (*)(const Slices&, RowRange, const ChebyshevStep&, const StepFields&), 4> step;
};

}  // namespace

}  // namespace beltrami

#define BELTRAMI_SLICES slices_on_any_machine
#define BELTRAMI_SLICES_TARGET
#define BELTRAMI_SLICES_LANES 4
#define BELTRAMI_SLICES_GATHER(x, index) \
    (Lanes{(x)[(index)[0]], (x)[(index)[1]], (x)[(index)[2]], (x)[(index)[3]]})
#include "beltrami/solvers/sliced_rows_body.hpp"

#if defined(__x86_64__)
// Gathers with a mask: those without read a register that nothing has written, of which gcc warns.
#define BELTRAMI_SLICES slices_with_avx2
#define BELTRAMI_SLICES_TARGET __attribute__((target("avx2,fma")))
#define BELTRAMI_SLICES_LANES 8
#define BELTRAMI_SLICES_GATHER(x, index) \
    reinterpret_cast<Lanes>(             \
        _mm256_i32gather_ps(x, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(index)), 4))
#include "beltrami/solvers/sliced_rows_body.hpp"

#define BELTRAMI_SLICES slices_with_avx512
#define BELTRAMI_SLICES_TARGET __attribute__((target("avx512f,avx2,fma")))
#define BELTRAMI_SLICES_LANES 16
#define BELTRAMI_SLICES_GATHER(x, index) \
    reinterpret_cast<Lanes>(             \
        _mm512_mask_i32gather_ps(_mm512_setzero_ps(), 0xFFFF, _mm512_loadu_si512(index), x, 4))
#include "beltrami/solvers/sliced_rows_body.hpp"
#endif

namespace beltrami {

namespace {

const SliceKernels& kernels() {
#if defined(__x86_64__)
    static const SliceKernels& best = []() -> const SliceKernels& {
        const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
        if (avx2 && __builtin_cpu_supports("avx512f")) return slices_with_avx512::all;
        return avx2 ? slices_with_avx2::all : slices_on_any_machine::all;
    }();
    return best;
#else
    return slices_on_any_machine::all;
#endif
}

}  // namespace

void SlicedRows::multiply(RowRange rows, int k, const float* x, float* y) const {
    kernels().multiply.at(at(k - 1))({begin_.data(), column_.data(), value_.data()}, rows, x, y);
}

void SlicedRows::chebyshev_step(RowRange rows, int k, const ChebyshevStep& step,
                                const StepFields& fields) const {
    kernels().step.at(at(k - 1))({begin_.data(), column_.data(), value_.data()}, rows, step, fields);
}

std::pair<Index, Index> SlicedRows::columns_of(RowRange rows) const {
    const auto first = column_.begin() + static_cast<std::ptrdiff_t>(begin_[at(rows.first / slice_rows)]);
    const auto end = column_.begin() + static_cast<std::ptrdiff_t>(begin_[at(rows.end / slice_rows)]);
    if (first == end) return {rows.first, rows.first};
    const auto [least, largest] = std::minmax_element(first, end);
    return {*least, *largest};
}

std::vector<Index> order_by_length(const std::vector<Index>& length, Index block_rows) {
    const auto n = static_cast<Index>(length.size());
    std::vector<Index> order(length.size());
    std::iota(order.begin(), order.end(), 0);
#pragma omp parallel for schedule(static) if (n > 20000)
    for (Index first = 0; first < n; first += block_rows) {
        std::stable_sort(order.begin() + first, order.begin() + std::min(n, first + block_rows),
                         [&](Index i, Index j) {
                             return length[static_cast<std::size_t>(i)] > length[static_cast<std::size_t>(j)];
                         });
    }
    return order;
}

}  // namespace beltrami
