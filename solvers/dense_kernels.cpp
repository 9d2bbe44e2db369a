#include "beltrami/solvers/dense_kernels.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <random>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/blas_threads.hpp"
#include "beltrami/solvers/vectorized.hpp"

extern "C" void dsyevd_(const char* jobz, const char* uplo, const int* n, double* a, const int* lda,
                        double* w, double* work, const int* lwork, int* iwork, const int* liwork, int* info);

namespace beltrami {

namespace {

using Size = std::ptrdiff_t;

// A chunk of three hundred columns fits the second-level cache.
constexpr Size chunk = 256;

struct Tall {
    const double* data;
    Size stride;
};

// C (I x J) += the product of I columns of X with J columns of Y over some rows.
template <int I, int J>
__attribute__((always_inline)) inline void dots(Size rows, Tall X, Tall Y, double* C, Size c_stride) {
    std::array<std::array<Lanes, J>, I> sum{};
    Size r = 0;
    for (; r + lane_count <= rows; r += lane_count) {
        std::array<Lanes, J> y;
        for (int j = 0; j < J; ++j)
            y[j].v = lanes_at(Y.data + j * Y.stride + r).v;
        for (int i = 0; i < I; ++i) {
            const Lanes x = lanes_at(X.data + i * X.stride + r);
            for (int j = 0; j < J; ++j)
                sum[i][j].v += x.v * y[j].v;
        }
    }
    for (int i = 0; i < I; ++i) {
        for (int j = 0; j < J; ++j) {
            double total = 0.0;
            for (int l = 0; l < lane_count; ++l)
                total += sum[i][j].v[l];
            for (Size tail = r; tail < rows; ++tail)
                total += X.data[i * X.stride + tail] * Y.data[j * Y.stride + tail];
            C[j * c_stride + i] += total;
        }
    }
}

template <int J>
__attribute__((always_inline)) inline void dots_with(Size rows, Tall X, Size a, Tall Y, double* C,
                                                     Size c_stride) {
    Size i = 0;
    for (; i + 3 <= a; i += 3)
        dots<3, J>(rows, {X.data + i * X.stride, X.stride}, Y, C + i, c_stride);
    for (; i < a; ++i)
        dots<1, J>(rows, {X.data + i * X.stride, X.stride}, Y, C + i, c_stride);
}

// C (a x b) += X^T Y over some rows; upper: on and above the diagonal at least.
BELTRAMI_VECTORIZED void transposed_chunk(Size rows, Tall X, Size a, Tall Y, Size b, bool upper, double* C) {
    const auto height = [&](Size end) { return upper ? std::min(a, end) : a; };
    Size j = 0;
    for (; j + 8 <= b; j += 8)
        dots_with<8>(rows, X, height(j + 8), {Y.data + j * Y.stride, Y.stride}, C + j * a, a);
    for (; j + 4 <= b; j += 4)
        dots_with<4>(rows, X, height(j + 4), {Y.data + j * Y.stride, Y.stride}, C + j * a, a);
    for (; j < b; ++j)
        dots_with<1>(rows, X, height(j + 1), {Y.data + j * Y.stride, Y.stride}, C + j * a, a);
}

// J columns of Y += scale X C, V x 8 rows.
template <int V, int J>
__attribute__((always_inline)) inline void combine(double scale, Tall X, Size a, const double* C,
                                                   Size c_stride, double* Y, Size y_stride) {
    std::array<std::array<Lanes, V>, J> sum{};
    for (Size i = 0; i < a; ++i) {
        std::array<Lanes, V> x;
        for (int v = 0; v < V; ++v)
            x[v].v = lanes_at(X.data + i * X.stride + v * lane_count).v;
        for (int j = 0; j < J; ++j) {
            const double c = C[j * c_stride + i];
            for (int v = 0; v < V; ++v)
                sum[j][v].v += x[v].v * c;
        }
    }
    for (int j = 0; j < J; ++j) {
        for (int v = 0; v < V; ++v) {
            lanes_at(Y + j * y_stride + v * lane_count).v += scale * sum[j][v].v;
        }
    }
}

template <int J>
__attribute__((always_inline)) inline void combine_rows(Size rows, double scale, Tall X, Size a,
                                                        const double* C, Size c_stride, double* Y,
                                                        Size y_stride) {
    Size r = 0;
    for (; r + 2 * lane_count <= rows; r += 2 * lane_count)
        combine<2, J>(scale, {X.data + r, X.stride}, a, C, c_stride, Y + r, y_stride);
    for (; r + lane_count <= rows; r += lane_count)
        combine<1, J>(scale, {X.data + r, X.stride}, a, C, c_stride, Y + r, y_stride);
    for (; r < rows; ++r) {
        for (int j = 0; j < J; ++j) {
            double sum = 0.0;
            for (Size i = 0; i < a; ++i)
                sum += X.data[i * X.stride + r] * C[j * c_stride + i];
            Y[j * y_stride + r] += scale * sum;
        }
    }
}

BELTRAMI_VECTORIZED void add_chunk(Size rows, double scale, Tall X, Size a, const double* C, Size c_stride,
                                   double* Y, Size y_stride, Size b) {
    Size j = 0;
    for (; j + 8 <= b; j += 8)
        combine_rows<8>(rows, scale, X, a, C + j * c_stride, c_stride, Y + j * y_stride, y_stride);
    for (; j + 4 <= b; j += 4)
        combine_rows<4>(rows, scale, X, a, C + j * c_stride, c_stride, Y + j * y_stride, y_stride);
    for (; j < b; ++j)
        combine_rows<1>(rows, scale, X, a, C + j * c_stride, c_stride, Y + j * y_stride, y_stride);
}

Size chunks(Size rows) {
    return (rows + chunk - 1) / chunk;
}

}  // namespace

namespace {

Columns products(const TallColumns& X, const double* weights, const TallColumns& Y, bool upper) {
    const Size a = X.cols();
    const Size b = Y.cols();
    const Size rows = X.rows();
    Columns total = Columns::Zero(a, b);
    if (a == 0 || b == 0) return total;
    // Partial sums over runs of chunks that depend on the number of rows only.
    const Size runs = std::min<Size>(chunks(rows), 8);
    std::vector<Columns> partial(static_cast<std::size_t>(runs));
#pragma omp parallel for schedule(dynamic, 1) if (rows * a * b > 100000)
    for (Size run = 0; run < runs; ++run) {
        Columns& sum = partial[static_cast<std::size_t>(run)];
        sum = Columns::Zero(a, b);
        Columns weighted;
        const Size end = chunks(rows) * (run + 1) / runs;
        for (Size c = chunks(rows) * run / runs; c < end; ++c) {
            const Size first = c * chunk;
            const Size size = std::min(chunk, rows - first);
            Tall right{Y.data() + first, Y.outerStride()};
            if (weights != nullptr) {
                weighted =
                    Eigen::Map<const Vector>(weights + first, size).asDiagonal() * Y.middleRows(first, size);
                right = {weighted.data(), weighted.outerStride()};
            }
            transposed_chunk(size, {X.data() + first, X.outerStride()}, a, right, b, upper, sum.data());
        }
    }
    for (const Columns& sum : partial)
        total += sum;
    return total;
}

}  // namespace

Columns transposed_product(const TallColumns& X, const TallColumns& Y) {
    return products(X, nullptr, Y, false);
}
Columns transposed_product(const TallColumns& X, const Vector& weights, const TallColumns& Y) {
    return products(X, weights.data(), Y, false);
}
Columns gram_matrix(const TallColumns& X, const Vector& weights) {
    const Columns upper = products(X, weights.data(), X, true);
    return upper.selfadjointView<Eigen::Upper>();
}

void add_product(double scale, const TallColumns& X, const Eigen::Ref<const Columns>& C,
                 Eigen::Ref<Columns, 0, Eigen::OuterStride<>> Y) {
    const Size rows = X.rows();
#pragma omp parallel for schedule(static) if (rows * X.cols() * Y.cols() > 100000)
    for (Size c = 0; c < chunks(rows); ++c) {
        const Size first = c * chunk;
        add_chunk(std::min(chunk, rows - first), scale, {X.data() + first, X.outerStride()}, X.cols(),
                  C.data(), C.outerStride(), Y.data() + first, Y.outerStride(), Y.cols());
    }
}

void transform(Columns& X, const Columns& C) {
    const Size rows = X.rows();
    const Size a = X.cols();
    const Size b = C.cols();
#pragma omp parallel for schedule(static) if (rows * a * b > 100000)
    for (Size c = 0; c < chunks(rows); ++c) {
        const Size first = c * chunk;
        const Size size = std::min(chunk, rows - first);
        const Columns before = X.middleRows(first, size);
        X.block(first, 0, size, b).setZero();
        add_chunk(size, 1.0, {before.data(), before.outerStride()}, a, C.data(), C.outerStride(),
                  X.data() + first, X.outerStride(), b);
    }
    if (b < a) X.conservativeResize(Eigen::NoChange, b);
}

void fill_random(double* values, std::size_t size, std::uint32_t seed) {
    std::mt19937 engine(seed);
    std::generate_n(values, size, [&] { return 2.0 * (static_cast<double>(engine()) / 4294967295.0) - 1.0; });
}

SymmetricEigen symmetric_eigen(Columns A) {
    const auto n = static_cast<int>(A.rows());
    SymmetricEigen eigen{Vector(n), {}};
    if (n == 0) return eigen;
    const BlasThreads threads(n < 1000 ? 1 : omp_get_max_threads());
    double work_size = 0.0;
    int integer_size = 0;
    int info = 0;
    const int query = -1;
    dsyevd_("V", "L", &n, A.data(), &n, eigen.values.data(), &work_size, &query, &integer_size, &query,
            &info);
    const auto size = static_cast<int>(work_size);
    std::vector<double> work(static_cast<std::size_t>(size));
    std::vector<int> integers(static_cast<std::size_t>(integer_size));
    dsyevd_("V", "L", &n, A.data(), &n, eigen.values.data(), work.data(), &size, integers.data(),
            &integer_size, &info);
    if (info != 0) {
        throw SolveError("a dense eigenproblem of " + std::to_string(n) + " rows did not converge",
                         "look for values that are not finite");
    }
    eigen.vectors = std::move(A);
    return eigen;
}

}  // namespace beltrami
