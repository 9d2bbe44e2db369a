#include "beltrami/solvers/chebyshev.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace beltrami {

namespace {

constexpr Index worth_threads = 20000;

}  // namespace

ScaledRows scaled_rows(const Vector& diagonal, std::vector<Index> length, const std::vector<char>& held) {
    ScaledRows result;
    result.scale.resize(length.size());
    for (std::size_t i = 0; i < length.size(); ++i) {
        const double d = diagonal[static_cast<Eigen::Index>(i)];
        const bool is_free = held[i] == 0 && d > 0.0;
        result.scale[i] = is_free ? static_cast<float>(1.0 / std::sqrt(d)) : 0.0F;
        if (!is_free) length[i] = 0;
    }
    result.order = order_by_length(length, chebyshev_block_rows);
    result.position.resize(length.size());
    for (std::size_t place = 0; place < length.size(); ++place)
        result.position[static_cast<std::size_t>(result.order[place])] = static_cast<Index>(place);
    return result;
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

Chebyshev::Chebyshev(const PdeOperator& A, const ScaledRows& scaled) {
    const auto at = [](Index i) { return static_cast<std::size_t>(i); };
    const EdgeOperator<double>& K = A.laplacian().stiffness();
    const double gamma_1 = A.gamma()[0];
    const Vector root = (A.gamma()[1] * A.laplacian().inverse_mass()).cwiseSqrt();
    A_ = SlicedRows(scaled.size(), [&](Index place, auto f) {
        const Index i = scaled.order[at(place)];
        if (scaled.is_held(i)) return;
        const double scale = scaled.scale[at(i)];
        f(place, scale * K.diagonal()[i] * root[i]);
        for (const EdgeGraph::Neighbour& j : K.graph().neighbours(i))
            f(scaled.position[at(j.vertex)], scale * K.edges()[j.edge] * root[j.vertex]);
    });
    // Rows that are held too: what is between the factors is known everywhere.
    C_ = SlicedRows(scaled.size(), [&](Index place, auto f) {
        const Index i = scaled.order[at(place)];
        if (!scaled.is_held(i)) {
            f(place,
              (root[i] * K.diagonal()[i] + (gamma_1 > 0.0 ? gamma_1 / root[i] : 0.0)) * scaled.scale[at(i)]);
        }
        for (const EdgeGraph::Neighbour& j : K.graph().neighbours(i)) {
            if (!scaled.is_held(j.vertex)) {
                f(scaled.position[at(j.vertex)], root[i] * K.edges()[j.edge] * scaled.scale[at(j.vertex)]);
            }
        }
    });
    own_.assign(at(A_.padded_rows()), 0.0F);
    for (Index place = 0; place < scaled.size(); ++place) {
        const Index i = scaled.order[at(place)];
        const double scale = scaled.scale[at(i)];
        own_[at(place)] = static_cast<float>(A.sigma() * A.laplacian().mass()[i] * scale * scale);
    }
    prepare();
}

void Chebyshev::resize(int k, SmootherFields& fields) const {
    const auto size = static_cast<std::size_t>(A_.padded_rows()) * static_cast<std::size_t>(k);
    for (std::vector<float>* field : {&fields.x, &fields.r, &fields.d[0], &fields.d[1], &fields.w}) {
        if (field->size() < size && (field != &fields.w || factored())) field->assign(size, 0.0F);
    }
}

void Chebyshev::prepare() {
    const Index blocks = (A_.padded_rows() + block_rows - 1) / block_rows;
    front_ = Wavefront(blocks, [&](Index b) {
        auto [least, largest] = A_.columns_of(rows_of_block(b));
        if (factored()) {
            // Rows that are held have entries here alone.
            const auto of_C = C_.columns_of(rows_of_block(b));
            least = std::min(least, of_C.first);
            largest = std::max(largest, of_C.second);
        }
        return std::pair{least / block_rows, largest / block_rows};
    });

    // Lanczos' iteration from a random start; sums by blocks, so that they do not depend on threads.
    constexpr int steps = 10;
    constexpr double safety = 1.1;
    const auto size = static_cast<std::size_t>(A_.padded_rows());
    std::vector<float> before(size, 0.0F);
    std::vector<float> v(size, 0.0F);
    std::vector<float> w(size);
    std::vector<float> between(factored() ? size : 0);
    const auto apply = [&] {
        if (factored()) multiply(C_, 1, v.data(), between.data());
        multiply(A_, 1, factored() ? between.data() : v.data(), w.data());
        for (std::size_t i = 0; i < size; ++i)
            w[i] += (factored() ? own_[i] : 1.0F) * v[i];
    };
    std::uint32_t state = 1;
    for (Index i = 0; i < A_.rows(); ++i) {
        state = state * 1664525U + 1013904223U;
        v[static_cast<std::size_t>(i)] = static_cast<float>(state >> 8U) * 0x1p-24F - 0.5F;
    }
    std::vector<double> partial(static_cast<std::size_t>(blocks));
    const auto dot = [&](const std::vector<float>& a, const std::vector<float>& b) {
#pragma omp parallel for schedule(static) if (A_.rows() > worth_threads)
        for (Index block = 0; block < blocks; ++block) {
            const RowRange rows = rows_of_block(block);
            double sum = 0.0;
#pragma omp simd reduction(+ : sum)
            for (Index i = rows.first; i < rows.end; ++i) {
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
        apply();
        const double alpha = dot(v, w);
        for (std::size_t i = 0; i < size; ++i)
            w[i] -=
                static_cast<float>(alpha) * v[i] + (step > 0 ? static_cast<float>(beta) * before[i] : 0.0F);
        diagonal.push_back(alpha);
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

void Chebyshev::pass_of_step(int pass, Index block, int k, const ChebyshevStep& step, int from,
                             SmootherFields& f) const {
    const RowRange rows = rows_of_block(block);
    const float* const d = f.d[static_cast<std::size_t>(from)].data();
    if (pass + 1 < passes()) return C_.multiply(rows, k, d, f.w.data());
    A_.chebyshev_step(rows, k, step,
                      {.source = factored() ? f.w.data() : d,
                       .own = factored() ? own_.data() : nullptr,
                       .d = d,
                       .r = f.r.data(),
                       .x = f.x.data(),
                       .next = f.d[static_cast<std::size_t>(1 - from)].data()});
}

void Chebyshev::descend(int k, SmootherFields& f) const {
    front_.run(degree * passes(), A_.rows() > worth_threads, [&](int pass, Index block) {
        const int n = pass / passes();
        ChebyshevStep now = step(n + 1);
        if (n == 0) {
            now.first = true;
            now.before = step(0).r;
        }
        pass_of_step(pass % passes(), block, k, now, n % 2, f);
    });
}

void Chebyshev::ascend(int k, const SlicedRows& P, const float* coarse, SmootherFields& f) const {
    front_.run(1 + degree * passes(), A_.rows() > worth_threads, [&](int pass, Index block) {
        if (pass == 0) return P.multiply(rows_of_block(block), k, coarse, f.d[0].data());
        const int n = (pass - 1) / passes();
        ChebyshevStep now = step(n);
        now.last = n + 1 == degree;
        pass_of_step((pass - 1) % passes(), block, k, now, n % 2, f);
    });
}

}  // namespace beltrami
