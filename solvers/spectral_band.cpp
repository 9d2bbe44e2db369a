#include "beltrami/solvers/spectral_band.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "beltrami/solvers/dense_kernels.hpp"

namespace beltrami {

Vector residuals(const Eigenproblem& problem, const Vector& values, const Columns& vectors,
                 double zero_scale) {
    Vector relative(values.size());
    Columns Kh;
    Columns Mh;
    // A few at once: a band is large.
    constexpr Eigen::Index group = 16;
    for (Eigen::Index first = 0; first < relative.size(); first += group) {
        const Eigen::Index count = std::min(group, relative.size() - first);
        problem.apply_stiffness(vectors.middleCols(first, count), Kh);
        problem.apply_mass(vectors.middleCols(first, count), Mh);
        for (Eigen::Index i = 0; i < count; ++i) {
            const double value = values[first + i];
            const double scale = std::max(std::abs(value), zero_scale) * Mh.col(i).norm();
            relative[first + i] = (Kh.col(i) - value * Mh.col(i)).norm() / scale;
        }
    }
    return relative;
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

    Columns Mh;
    problem.apply_mass(band.vectors, Mh);
    add_product(-1.0, before, transposed_product(before, Mh), band.vectors);
    // One Newton step towards H (H^T M H)^(-1/2), the orthonormal set nearest to H.
    problem.apply_mass(band.vectors, Mh);
    Columns H = Columns::Zero(band.vectors.rows(), count);
    add_product(1.0, band.vectors,
                1.5 * Columns::Identity(count, count) - 0.5 * transposed_product(band.vectors, Mh), H);
    band.vectors = std::move(H);

    problem.apply_mass(band.vectors, Mh);
    const Columns gram = transposed_product(band.vectors, Mh) - Columns::Identity(count, count);
    const Columns across = transposed_product(before, Mh);
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
