#include "beltrami/solvers/chebyshev.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace beltrami {

namespace {

constexpr Index worth_threads = 20000;

}  // namespace

void SmootherFields::resize(Index rows, int k) {
    const auto size = static_cast<std::size_t>(SlicedRows::padded(rows)) * static_cast<std::size_t>(k);
    for (std::vector<float>* field : {&x, &r, d.data(), d.data() + 1}) {
        if (field->size() < size) field->assign(size, 0.0F);
    }
}

void multiply(const SlicedRows& A, int k, const float* x, float* y) {
    const Index blocks = (A.padded_rows() + chebyshev_block_rows - 1) / chebyshev_block_rows;
#pragma omp parallel if (A.rows() > worth_threads)
    {
        const FlushToZero flush;
#pragma omp for schedule(static)
        for (Index b = 0; b < blocks; ++b) {
            A.multiply({b * chebyshev_block_rows, std::min(A.padded_rows(), (b + 1) * chebyshev_block_rows)},
                       k, x, y);
        }
    }
}

void Chebyshev::prepare() {
    const Index blocks = (A_.padded_rows() + block_rows - 1) / block_rows;
    front_ = Wavefront(blocks, [&](Index b) {
        const auto [least, largest] = A_.columns_of(rows_of_block(b));
        return std::pair{least / block_rows, largest / block_rows};
    });

    // Lanczos' iteration from a random start; sums by blocks, so that they do not depend on threads.
    constexpr int steps = 10;
    constexpr double safety = 1.1;
    const auto size = static_cast<std::size_t>(A_.padded_rows());
    std::vector<float> before(size, 0.0F);
    std::vector<float> v(size, 0.0F);
    std::vector<float> w(size);
    std::uint32_t state = 1;
    for (Index i = 0; i < A_.rows(); ++i) {
        state = state * 1664525U + 1013904223U;
        v[static_cast<std::size_t>(i)] = static_cast<float>(state >> 8U) * 0x1p-24F - 0.5F;
    }
    std::vector<double> partial(static_cast<std::size_t>(blocks));
    const auto dot = [&](const std::vector<float>& a, const std::vector<float>& b) {
#pragma omp parallel for schedule(static) if (A_.rows() > worth_threads)
        for (Index block = 0; block < blocks; ++block) {
            const auto [first, end] = rows_of_block(block);
            double sum = 0.0;
#pragma omp simd reduction(+ : sum)
            for (Index i = first; i < end; ++i) {
                sum += static_cast<double>(a[static_cast<std::size_t>(i)]) *
                       static_cast<double>(b[static_cast<std::size_t>(i)]);
            }
            partial[static_cast<std::size_t>(block)] = sum;
        }
        double sum = 0.0;
        for (const double p : partial)
            sum += p;
        return sum;
    };
    std::vector<double> diagonal;
    std::vector<double> off_diagonal;
    double beta = std::sqrt(dot(v, v));
    for (int step = 0; step < steps && beta > 1e-6 * static_cast<double>(size > 0); ++step) {
        const auto inverse = static_cast<float>(1.0 / beta);
        for (float& number : v)
            number *= inverse;
        multiply(A_, 1, v.data(), w.data());
        const double alpha = dot(v, w);
        for (std::size_t i = 0; i < size; ++i)
            w[i] -=
                static_cast<float>(alpha) * v[i] + (step > 0 ? static_cast<float>(beta) * before[i] : 0.0F);
        diagonal.push_back(1.0 + alpha);
        beta = std::sqrt(dot(w, w));
        off_diagonal.push_back(beta);
        std::swap(before, v);
        std::swap(v, w);
    }
    if (diagonal.empty()) return;
    const auto m = static_cast<Eigen::Index>(diagonal.size());
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
    eigen.computeFromTridiagonal(Eigen::Map<const Vector>(diagonal.data(), m),
                                 Eigen::Map<const Vector>(off_diagonal.data(), m - 1),
                                 Eigen::EigenvaluesOnly);
    largest_ = safety * eigen.eigenvalues().maxCoeff();
}

ChebyshevStep Chebyshev::step(int terms) const {
    const double j = terms;
    ChebyshevStep result;
    if (terms == 0) {
        result.r = static_cast<float>(4.0 / (3.0 * largest_));
        return result;
    }
    result.d = static_cast<float>((2.0 * j - 1.0) / (2.0 * j + 3.0));
    result.r = static_cast<float>((8.0 * j + 4.0) / ((2.0 * j + 3.0) * largest_));
    return result;
}

void Chebyshev::descend(int k, SmootherFields& f) const {
    front_.run(degree, A_.rows() > worth_threads, [&](int pass, Index block) {
        ChebyshevStep now = step(pass + 1);
        if (pass == 0) {
            now.first = true;
            now.before = step(0).r;
        }
        A_.chebyshev_step(rows_of_block(block), k, now, f.d[pass % 2].data(), f.r.data(), f.x.data(),
                          f.d[1 - pass % 2].data());
    });
}

void Chebyshev::ascend(int k, const SlicedRows& P, const float* coarse, SmootherFields& f) const {
    front_.run(degree + 1, A_.rows() > worth_threads, [&](int pass, Index block) {
        if (pass == 0) return P.multiply(rows_of_block(block), k, coarse, f.d[0].data());
        ChebyshevStep now = step(pass - 1);
        now.last = pass == degree;
        A_.chebyshev_step(rows_of_block(block), k, now, f.d[(pass - 1) % 2].data(), f.r.data(), f.x.data(),
                          f.d[pass % 2].data());
    });
}

}  // namespace beltrami
