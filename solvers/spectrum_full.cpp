#include "beltrami/solvers/spectrum_full.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/dense_kernels.hpp"
#include "beltrami/solvers/spectral_band.hpp"

namespace beltrami {

namespace {

// With M = L L^T: the eigenpairs (lambda, g) of L^-1 K L^-T, and h = L^-T g.
Eigenpairs dense_pairs(const Eigenproblem& problem) {
    Columns A(problem.stiffness());
    if (problem.lumped()) {
        const Vector scale = problem.lumped_mass().cwiseSqrt().cwiseInverse();
        A = scale.asDiagonal() * A * scale.asDiagonal();
        SymmetricEigen eigen = symmetric_eigen(std::move(A));
        eigen.vectors = scale.asDiagonal() * eigen.vectors;
        return {std::move(eigen.values), std::move(eigen.vectors)};
    }
    const Eigen::LLT<Columns> mass{Columns(problem.mass_matrix())};
    mass.matrixL().solveInPlace(A);
    A.transposeInPlace();
    mass.matrixL().solveInPlace(A);
    SymmetricEigen eigen = symmetric_eigen(std::move(A));
    mass.matrixU().solveInPlace(eigen.vectors);
    return {std::move(eigen.values), std::move(eigen.vectors)};
}

// The dense solver's zero modes carry its rounding against the largest eigenvalue; the constants are exact.
void put_constants(const Eigenproblem& problem, Eigenpairs& pairs) {
    const Eigen::Index zeros = problem.constants().cols();
    pairs.values.head(zeros).setZero();
    pairs.vectors.leftCols(zeros) = problem.constants();
}

}  // namespace

void spectrum_in_full(const Eigenproblem& problem, const SpectrumOptions& options, const BandSink& sink,
                      SpectrumSummary& summary) {
    const double bytes = 3.0 * sizeof(double) * problem.rows() * static_cast<double>(problem.rows());
    if (options.on_plan) options.on_plan({0.0, 0.0, bytes});
    report(options.progress, "eigenpairs", -1.0);
    Eigenpairs pairs = dense_pairs(problem);
    const Index n = problem.rows();
    const auto zeros = static_cast<Index>(problem.constants().cols());
    const double largest = pairs.values.cwiseAbs().maxCoeff();
    const bool semidefinite = pairs.values[0] > -1e-10 * largest;
    if (semidefinite && (zeros == 0 || zeros == n || pairs.values[zeros - 1] < 1e-10 * largest))
        put_constants(problem, pairs);

    ShiftInvert pencil(problem, options.factor);
    const auto end_at = [&](double value) {
        pencil.factor(value);
        return SpectrumEnd{value, pencil.eigenvalues_below()};
    };
    const double step = zeros < n ? std::max(pairs.values[zeros], 1e-6 * largest) : 1.0;
    const SpectrumEnd lower = end_at(options.from > 0.0 ? options.from * options.from
                                                        : std::min(pairs.values[0], 0.0) - 0.1 * step);
    const double top =
        options.cutoff > 0.0 ? options.cutoff * options.cutoff : std::numeric_limits<double>::infinity();
    const auto first = static_cast<Index>((pairs.values.array() < lower.value).count());
    Index last = static_cast<Index>((pairs.values.array() <= top).count());
    const Index start = options.resume != nullptr ? 0 : first;
    if (options.count > 0) last = std::min(last, std::min(start + options.count, n));
    last = std::max(last, first);
    // The end lies in the widest gap among the next few.
    Index end = last;
    const auto gap_behind = [&](Index i) {
        return i == n ? largest + step : pairs.values[i] - (i > 0 ? pairs.values[i - 1] : lower.value);
    };
    for (Index i = last; i <= std::min(n, last + 8); ++i) {
        if (gap_behind(i) > gap_behind(end)) end = i;
    }
    const SpectrumEnd upper =
        end_at(end == n ? largest * 1.01 + step : pairs.values[end] - 0.5 * gap_behind(end));

    Eigenpairs inside{pairs.values.segment(first, end - first), pairs.vectors.middleCols(first, end - first)};
    pairs = {};
    SpectralBand band = make_band(problem, std::move(inside), lower, upper, Columns(n, 0), step);
    band.certificate.rounds = 1;
    band.certificate.dimension = n;
    if (band.certificate.found != upper.below - lower.below) {
        throw SolveError(fmt::format("the dense solver found {} pairs where there are {}",
                                     band.certificate.found, upper.below - lower.below),
                         "take --method bands");
    }
    if (band.certificate.max_residual > options.tolerance) {
        throw SolveError(
            fmt::format("the dense solver's largest residual is {:.1e}, above the tolerance {:.1e}",
                        band.certificate.max_residual, options.tolerance),
            "take --method bands, or allow larger residuals with --tolerance");
    }
    keep(band, last - first);
    summary.memory_bytes = static_cast<std::size_t>(bytes);
    summary.factorizations = pencil.factorizations();
    summary.bands.push_back(band.certificate);
    summary.count = last - first;
    summary.complete = true;
    sink(band);
}

}  // namespace beltrami
