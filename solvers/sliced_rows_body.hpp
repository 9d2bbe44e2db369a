// Included once for each instruction set by sliced_rows.cpp, which defines
//     BELTRAMI_SLICES          a namespace
//     BELTRAMI_SLICES_TARGET   an attribute, on every function here
//     BELTRAMI_SLICES_LANES    floats of a register, a divisor of 16
//     BELTRAMI_SLICES_GATHER   (const float* x, const Index* index): x at so many indices

namespace beltrami {
namespace BELTRAMI_SLICES {

constexpr int lanes = BELTRAMI_SLICES_LANES;
constexpr int registers = SlicedRows::slice_rows / lanes;
// Entries that are fetched ahead: gathers keep the processor from doing so by itself (a million rows: a sixth of the time).
constexpr std::size_t ahead = 1024;
typedef float Lanes __attribute__((vector_size(lanes * sizeof(float)), aligned(sizeof(float)), may_alias));

BELTRAMI_SLICES_TARGET static inline Lanes load(const float* p) {
    return *reinterpret_cast<const Lanes*>(p);
}
BELTRAMI_SLICES_TARGET static inline void store(float* p, Lanes v) {
    *reinterpret_cast<Lanes*>(p) = v;
}

// What the sixteen rows of a slice give, K numbers a row.
template <int K>
BELTRAMI_SLICES_TARGET static inline void product_of_slice(const Slices& A, Index slice, const float* x,
                                                           Lanes (&sum)[K * registers]) {
    constexpr int rows = SlicedRows::slice_rows;
    const std::size_t first = A.begin[slice];
    const std::size_t end = A.begin[slice + 1];
    if constexpr (K == 1) {
        for (Lanes& s : sum)
            s = Lanes{};
        for (std::size_t e = first; e < end; e += rows) {
            __builtin_prefetch(A.value + e + ahead);
            __builtin_prefetch(A.column + e + ahead);
            for (int v = 0; v < registers; ++v) {
                const std::size_t from = e + static_cast<std::size_t>(v * lanes);
                sum[v] += load(A.value + from) * BELTRAMI_SLICES_GATHER(x, A.column + from);
            }
        }
    } else {
        float numbers[K * rows];
        for (int row = 0; row < rows; ++row) {
            float own[K] = {};
            for (std::size_t e = first + static_cast<std::size_t>(row); e < end; e += rows) {
                const float* const from = x + static_cast<std::ptrdiff_t>(A.column[e]) * K;
                for (int c = 0; c < K; ++c)
                    own[c] += A.value[e] * from[c];
            }
            for (int c = 0; c < K; ++c)
                numbers[row * K + c] = own[c];
        }
        for (int v = 0; v < K * registers; ++v)
            sum[v] = load(numbers + v * lanes);
    }
}

template <int K>
BELTRAMI_SLICES_TARGET static void multiply(const Slices& A, RowRange rows, const float* x, float* y) {
    for (Index slice = rows.first / SlicedRows::slice_rows; slice < rows.end / SlicedRows::slice_rows;
         ++slice) {
        Lanes sum[K * registers];
        product_of_slice<K>(A, slice, x, sum);
        float* const to = y + static_cast<std::ptrdiff_t>(slice) * SlicedRows::slice_rows * K;
        for (int v = 0; v < K * registers; ++v)
            store(to + v * lanes, sum[v]);
    }
}

// Numbers of rows for `lanes` numbers of K columns from `at` on.
template <int K>
BELTRAMI_SLICES_TARGET static inline Lanes of_rows(const float* numbers, std::ptrdiff_t at) {
    if constexpr (K == 1) return load(numbers + at);
    Lanes result;
    for (int l = 0; l < lanes; ++l)
        result[l] = numbers[(at + l) / K];
    return result;
}

template <int K, bool first, bool last>
BELTRAMI_SLICES_TARGET static void take_step(const Slices& A, RowRange rows, const ChebyshevStep& step,
                                             const StepFields& f) {
    const float before = step.before;
    const float from_d = step.d;
    const float from_r = step.r;
    for (Index slice = rows.first / SlicedRows::slice_rows; slice < rows.end / SlicedRows::slice_rows;
         ++slice) {
        Lanes sum[K * registers];
        product_of_slice<K>(A, slice, f.source, sum);
        std::ptrdiff_t at = static_cast<std::ptrdiff_t>(slice) * SlicedRows::slice_rows * K;
        for (int v = 0; v < K * registers; ++v, at += lanes) {
            const Lanes d = load(f.d + at);
            const Lanes now = before * d;
            const Lanes own = f.own == nullptr ? now : of_rows<K>(f.own, at) * now;
            const Lanes residual = (first ? d : load(f.r + at)) - before * sum[v] - own;
            const Lanes correction = from_d * now + from_r * residual;
            Lanes x = now;
            if constexpr (!first) x += load(f.x + at);
            if constexpr (last) {
                x += correction;
            } else {
                store(f.r + at, residual);
                store(f.next + at, correction);
            }
            store(f.x + at, x);
        }
    }
}

template <int K>
BELTRAMI_SLICES_TARGET static void step(const Slices& A, RowRange rows, const ChebyshevStep& step,
                                        const StepFields& f) {
    if (step.first) {
        take_step<K, true, false>(A, rows, step, f);
    } else if (step.last) {
        take_step<K, false, true>(A, rows, step, f);
    } else {
        take_step<K, false, false>(A, rows, step, f);
    }
}

static constexpr SliceKernels all{{multiply<1>, multiply<2>, multiply<3>, multiply<4>},
                                  {step<1>, step<2>, step<3>, step<4>}};

}  // namespace BELTRAMI_SLICES
}  // namespace beltrami

#undef BELTRAMI_SLICES
#undef BELTRAMI_SLICES_TARGET
#undef BELTRAMI_SLICES_LANES
#undef BELTRAMI_SLICES_GATHER
