#include "beltrami/solvers/spectral_band.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "beltrami/solvers/dense_kernels.hpp"
#include "beltrami/solvers/panels.hpp"
#include "beltrami/solvers/vectorized.hpp"

namespace beltrami {

namespace {

using Size = std::ptrdiff_t;
using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// Row r of A X; X has eight columns, row-major.
__attribute__((always_inline)) inline Lanes row_of_product(const RowMatrix& A, Size r, const double* X) {
    Lanes sum{};
    for (Size e = A.outerIndexPtr()[r]; e < A.outerIndexPtr()[r + 1]; ++e)
        sum.v += A.valuePtr()[e] * lanes_at(X + 8 * static_cast<Size>(A.innerIndexPtr()[e])).v;
    return sum;
}

// Sums of the squares of K X - M X diag(values) (squares[0 ... 7]) and of M X (squares[8 ... 15]) over some rows.
BELTRAMI_VECTORIZED void add_squares(const RowMatrix& K, const double* lumped, const RowMatrix& M, Size begin,
                                     Size end, const double* X, const double* values, double* squares) {
    Lanes residual{};
    Lanes scale{};
    const Lanes lambda = lanes_at(values);
    for (Size r = begin; r < end; ++r) {
        const Lanes Kx = row_of_product(K, r, X);
        const Lanes Mx =
            lumped != nullptr ? Lanes{lumped[r] * lanes_at(X + 8 * r).v} : row_of_product(M, r, X);
        const Lanes difference{Kx.v - lambda.v * Mx.v};
        residual.v += difference.v * difference.v;
        scale.v += Mx.v * Mx.v;
    }
    lanes_at(squares).v = residual.v;
    lanes_at(squares + 8).v = scale.v;
}

}  // namespace

Vector residuals(const Eigenproblem& problem, const Vector& values, const Columns& vectors,
                 double zero_scale) {
    Vector relative(values.size());
    const Size rows = problem.rows();
    const double* const lumped = problem.lumped() ? problem.lumped_mass().data() : nullptr;
    LargeArray X(static_cast<std::size_t>(rows) * panel_width);
    Eigen::Map<Block> panel(X.data(), rows, panel_width);
    // The sums do not depend on the number of threads.
    constexpr Size runs = 16;
    for (Eigen::Index first = 0; first < relative.size(); first += panel_width) {
        const Eigen::Index count = std::min<Eigen::Index>(panel_width, relative.size() - first);
        std::array<double, panel_width> lambda{};
        std::copy_n(values.data() + first, count, lambda.data());
        std::array<std::array<double, 2 * panel_width>, runs> squares{};
#pragma omp parallel
        {
#pragma omp for schedule(static)
            for (Size run = 0; run < runs; ++run) {
                const Size begin = rows * run / runs;
                const Size size = rows * (run + 1) / runs - begin;
                panel.block(begin, 0, size, count) = vectors.block(begin, first, size, count);
                panel.block(begin, count, size, panel_width - count).setZero();
            }
#pragma omp for schedule(static)
            for (Size run = 0; run < runs; ++run) {
                add_squares(problem.stiffness(), lumped, problem.consistent_mass(), rows * run / runs,
                            rows * (run + 1) / runs, X.data(), lambda.data(), squares[run].data());
            }
        }
        for (Eigen::Index i = 0; i < count; ++i) {
            double residual = 0.0;
            double scale = 0.0;
            for (const auto& part : squares) {
                residual += part[static_cast<std::size_t>(i)];
                scale += part[static_cast<std::size_t>(panel_width + i)];
            }
            relative[first + i] =
                std::sqrt(residual) / (std::max(std::abs(values[first + i]), zero_scale) * std::sqrt(scale));
        }
    }
    return relative;
}

Columns mass_product(const Eigenproblem& problem, const Columns& X, const Columns& Y) {
    if (problem.lumped()) return transposed_product(X, problem.lumped_mass(), Y);
    Columns MY;
    problem.apply_mass(Y, MY);
    return transposed_product(X, MY);
}

Columns mass_gram(const Eigenproblem& problem, const Columns& X) {
    return problem.lumped() ? gram_matrix(X, problem.lumped_mass()) : mass_product(problem, X, X);
}

SpectralBand make_band(const Eigenproblem& problem, Eigenpairs pairs, const SpectrumEnd& lower,
                       const SpectrumEnd& upper, const Columns& before, double zero_scale) {
    SpectralBand band;
    band.first = lower.below;
    band.values = std::move(pairs.values);
    band.vectors = std::move(pairs.vectors);
    const auto count = static_cast<Index>(band.values.size());
    BandCertificate& certificate = band.certificate;
    certificate.lower = lower;
    certificate.upper = upper;
    certificate.found = count;
    certificate.kept = count;

    Columns& H = band.vectors;
    add_product(-1.0, before, mass_product(problem, before, H), H);
    // One Newton step towards H (H^T M H)^(-1/2), the orthonormal set nearest to H.
    transform(H, 1.5 * Columns::Identity(count, count) - 0.5 * mass_gram(problem, H));
    const Columns gram = mass_gram(problem, H) - Columns::Identity(count, count);
    const Columns across = mass_product(problem, before, H);
    const auto largest = [](const Columns& A) { return A.size() > 0 ? A.cwiseAbs().maxCoeff() : 0.0; };
    certificate.max_orthogonality_error = std::max(largest(gram), largest(across));

    if (count > 0)
        certificate.max_residual = residuals(problem, band.values, band.vectors, zero_scale).maxCoeff();
    return band;
}

void keep(SpectralBand& band, Index kept) {
    band.certificate.kept = kept;
    if (kept == band.values.size()) return;
    band.values.conservativeResize(kept);
    band.vectors.conservativeResize(Eigen::NoChange, kept);
}

SpectrumPlan plan_of(const Eigenproblem& problem, const ShiftInvert& pencil, double columns) {
    const auto factor = static_cast<double>(pencil.memory_bytes());
    return {factor, static_cast<double>(pencil.disk_bytes()),
            factor + sizeof(double) * columns * problem.rows() + static_cast<double>(problem.memory_bytes())};
}

double estimated_eigenvalue(const Eigenproblem& problem, double number) {
    const auto& K = problem.stiffness();
    const Eigen::SparseMatrix<double, Eigen::RowMajor> M = problem.mass_matrix();
    const Vector ratio = K.diagonal().cwiseQuotient(M.diagonal());
    std::vector<double> ratios(ratio.begin(), ratio.end());
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    // Segments have 2 neighbours, triangles about 6, tetrahedra about 14.
    const double neighbours = static_cast<double>(K.nonZeros()) / static_cast<double>(K.rows()) - 1.0;
    const int dimension = neighbours < 3.0 ? 1 : neighbours < 9.0 ? 2 : 3;
    const double constant = dimension == 1 ? 4.9 : dimension == 2 ? 3.6 : 2.5;
    return constant * *middle * std::pow(number / static_cast<double>(K.rows()), 2.0 / dimension);
}

}  // namespace beltrami
