#include "beltrami/solvers/spectral_signature.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// Vertices that a thread works on at once: with a band of some hundred functions they stay in the second-level cache.
constexpr Eigen::Index chunk = 256;

template <class Scalar>
void add_band(const NpyArray& band, std::optional<Index> from, const Eigen::Ref<const Block>& weights,
              Block& sum) {
    using Functions = Eigen::Map<const BlockOf<Scalar>, 0, Eigen::OuterStride<>>;
    Vector origin = Vector::Zero(band.rows());
    if (from) {
        for (Eigen::Index k = 0; k < band.rows(); ++k)
            origin[k] = band.row<Scalar>(k)[*from];
    }
#pragma omp parallel for schedule(static)
    for (Eigen::Index first = 0; first < sum.rows(); first += chunk) {
        const Eigen::Index size = std::min(chunk, sum.rows() - first);
        const Functions functions(band.row<Scalar>(0) + first, band.rows(), size,
                                  Eigen::OuterStride<>(band.columns()));
        const Block squares = (functions.template cast<double>().colwise() - origin).cwiseAbs2();
        sum.middleRows(first, size).noalias() += squares.transpose() * weights;
    }
}

Block weighted_squares(const StoredBasis& basis, std::optional<Index> from, const Block& weights,
                       const Progress* progress) {
    if (weights.rows() != basis.count()) {
        throw InputError(
            fmt::format("{} weights meet a basis of {} functions", weights.rows(), basis.count()),
            "give one row a function");
    }
    Block sum = Block::Zero(basis.vertex_count(), weights.cols());
    Eigen::Index first = 0;
    for (const NpyArray& band : basis.bands()) {
        report(progress, "signature", static_cast<double>(first) / std::max<Index>(basis.count(), 1));
        if (band.rows() == 0) continue;
        const auto rows = weights.middleRows(first, band.rows());
        if (band.type() == NpyType::float64) {
            add_band<double>(band, from, rows, sum);
        } else {
            add_band<float>(band, from, rows, sum);
        }
        first += band.rows();
    }
    return sum;
}

void check_times(const Vector& times) {
    for (const double t : times) {
        if (t >= 0.0 && std::isfinite(t)) continue;
        throw InputError(fmt::format("{} is not a time", t), "give finite times that are not negative");
    }
}

// exp(-factor lambda_k t_c)
Block decay(const Vector& eigenvalues, const Vector& times, double factor) {
    return (-factor * eigenvalues * times.transpose()).array().exp();
}

// power(lambda_k), 0 for zero modes
template <class Power>
Block inverse_weights(const StoredBasis& basis, Power power) {
    const Vector eigenvalues = clean_eigenvalues(basis);
    Block weights = Block::Zero(eigenvalues.size(), 1);
    for (Eigen::Index k = 0; k < eigenvalues.size(); ++k) {
        if (eigenvalues[k] > 0.0) weights(k, 0) = power(eigenvalues[k]);
    }
    return weights;
}

Vector evenly(double low, double high, Index count) {
    if (count < 1) throw InputError(fmt::format("{} columns of a signature", count), "ask for one or more");
    if (count == 1) return Vector::Constant(1, 0.5 * (low + high));
    return Vector::LinSpaced(count, low, high);
}

// |x|_M over all columns
double mass_norm(const StoredBasis& basis, const Block& field) {
    return std::sqrt(std::max((field.array() * basis.apply_mass(field).array()).sum(), 0.0));
}

}  // namespace

Vector clean_eigenvalues(const StoredBasis& basis) {
    Vector values = basis.eigenvalues().cwiseMax(0.0);
    values.head(std::min<Eigen::Index>(basis.zero_modes(), values.size())).setZero();
    return values;
}

double first_nonzero_eigenvalue(const StoredBasis& basis) {
    for (const double value : clean_eigenvalues(basis)) {
        if (value > 0.0) return value;
    }
    throw InputError(fmt::format("all {} functions of {} are constant on each component", basis.count(),
                                 basis.folder().string()),
                     "make a basis of more functions with beltrami harmonics -k N");
}

Block sum_of_squares(const StoredBasis& basis, const Block& weights, const Progress* progress) {
    return weighted_squares(basis, std::nullopt, weights, progress);
}

Block spectral_distance(const StoredBasis& basis, Index from, const Block& weights,
                        const Progress* progress) {
    if (from < 0 || from >= basis.vertex_count()) {
        throw InputError(
            fmt::format("there is no vertex {}: they are 0 to {}", from, basis.vertex_count() - 1),
            "vertex numbers are those of the file, from 0");
    }
    if (!(weights.array() >= 0.0).all())
        throw InputError("a distance has weights that are negative or no numbers", "give weights from 0 on");
    return weighted_squares(basis, from, weights, progress).cwiseSqrt();
}

Vector heat_signature_times(const StoredBasis& basis, Index count) {
    const double scale = 4.0 * std::numbers::ln10;
    const double high = scale / first_nonzero_eigenvalue(basis);
    const double low = scale / basis.eigenvalues()[basis.count() - 1];
    return evenly(std::log(low), std::log(high), count).array().exp();
}

Block heat_kernel_signature(const StoredBasis& basis, const Vector& times, bool by_trace,
                            const Progress* progress) {
    check_times(times);
    Block weights = decay(clean_eigenvalues(basis), times, 1.0);
    if (by_trace) weights.array().rowwise() /= weights.colwise().sum().eval().array();
    return sum_of_squares(basis, weights, progress);
}

SignatureEnergies wave_signature_energies(const StoredBasis& basis, Index count) {
    const double low = std::log(first_nonzero_eigenvalue(basis));
    const double high = std::log(basis.eigenvalues()[basis.count() - 1]);
    if (!(high > low)) {
        throw InputError("a wave kernel signature needs two different eigenvalues that are not 0",
                         "make a basis of more functions with beltrami harmonics -k N");
    }
    // Of the whole range, (count - 1) steps lie between the energies and 2 x 2 sigma = 28 steps beyond them.
    const double step = (high - low) / (std::max<Index>(count, 1) - 1 + 28);
    const double sigma = 7.0 * step;
    return {evenly(low + 2.0 * sigma, high - 2.0 * sigma, count), sigma};
}

Block wave_kernel_signature(const StoredBasis& basis, const SignatureEnergies& energies,
                            const Progress* progress) {
    if (!(energies.sigma > 0.0) || !std::isfinite(energies.sigma) || !energies.energies.allFinite()) {
        throw InputError(
            fmt::format("a wave kernel signature cannot have windows of width {} at these energies",
                        energies.sigma),
            "energies are logarithms of eigenvalues, and the width is positive");
    }
    const Vector eigenvalues = clean_eigenvalues(basis);
    first_nonzero_eigenvalue(basis);  // throws where there is none
    Block weights = Block::Zero(eigenvalues.size(), energies.energies.size());
    for (Eigen::Index e = 0; e < weights.cols(); ++e) {
        // Relative to the nearest eigenvalue's, so that energies far from all of them do not become 0 / 0.
        Vector exponents = Vector::Constant(eigenvalues.size(), -HUGE_VAL);
        for (Eigen::Index k = 0; k < eigenvalues.size(); ++k) {
            if (!(eigenvalues[k] > 0.0)) continue;
            const double away = (energies.energies[e] - std::log(eigenvalues[k])) / energies.sigma;
            exponents[k] = -0.5 * away * away;
        }
        weights.col(e) = (exponents.array() - exponents.maxCoeff()).exp();
        weights.col(e) /= weights.col(e).sum();
    }
    return sum_of_squares(basis, weights, progress);
}

Block diffusion_distance(const StoredBasis& basis, Index from, const Vector& times,
                         const Progress* progress) {
    check_times(times);
    return spectral_distance(basis, from, decay(clean_eigenvalues(basis), times, 2.0), progress);
}

Block biharmonic_distance(const StoredBasis& basis, Index from, const Progress* progress) {
    return spectral_distance(
        basis, from, inverse_weights(basis, [](double value) { return 1.0 / (value * value); }), progress);
}

Block commute_time_distance(const StoredBasis& basis, Index from, const Progress* progress) {
    return spectral_distance(basis, from, inverse_weights(basis, [](double value) { return 1.0 / value; }),
                             progress);
}

Vector shape_dna(const Vector& eigenvalues, double measure, int dimension) {
    if (!(measure > 0.0) || dimension < 1) {
        throw InputError(
            fmt::format("a shape of measure {} and dimension {} has no spectrum", measure, dimension),
            "give the length, area or volume, and 1, 2 or 3");
    }
    return eigenvalues * std::pow(measure, 2.0 / dimension);
}

double weyl_eigenvalue(double number, double measure, int dimension) {
    const double d = dimension;
    const double ball = std::pow(std::numbers::pi, 0.5 * d) / std::tgamma(0.5 * d + 1.0);
    return 4.0 * std::numbers::pi * std::numbers::pi * std::pow(number / (ball * measure), 2.0 / d);
}

ReconstructionErrors reconstruction_errors(const StoredBasis& basis, const Block& field,
                                           const Progress* progress) {
    const Block coefficients = forward_transform(basis, field, progress);
    const double left = mass_norm(basis, field - inverse_transform(basis, coefficients, progress));
    ReconstructionErrors result{coefficients.rowwise().norm(), Vector::Zero(basis.count()),
                                mass_norm(basis, field)};
    if (!(result.norm > 0.0)) return result;
    double squared = left * left;
    for (Eigen::Index k = basis.count() - 1; k >= 0; --k) {
        result.relative[k] = std::sqrt(squared) / result.norm;
        squared += result.amplitudes[k] * result.amplitudes[k];
    }
    return result;
}

SpectralPropagation::SpectralPropagation(const StoredBasis& basis, const Block& u0,
                                         const std::optional<Block>& v0, const Progress* progress)
    : basis_(basis),
      eigenvalues_(clean_eigenvalues(basis)),
      u_(forward_transform(basis, u0, progress)),
      v_(Block::Zero(u_.rows(), u_.cols())) {
    const auto missing = [&](const Block& state, const Block& coefficients) {
        const double norm = mass_norm(basis, state);
        if (!(norm > 0.0)) return 0.0;
        return mass_norm(basis, state - inverse_transform(basis, coefficients, progress)) / norm;
    };
    left_out_ = missing(u0, u_);
    if (!v0) return;
    if (v0->cols() != u0.cols()) {
        throw InputError(
            fmt::format("a velocity of {} columns meets a displacement of {}", v0->cols(), u0.cols()),
            "give both as many");
    }
    v_ = forward_transform(basis, *v0, progress);
    left_out_ = std::max(left_out_, missing(*v0, v_));
}

Block SpectralPropagation::heat(double time) const {
    check_times(Vector::Constant(1, time));
    return inverse_transform(basis_, (-time * eigenvalues_).array().exp().matrix().asDiagonal() * u_);
}

Block SpectralPropagation::wave(double time) const {
    if (!std::isfinite(time)) throw InputError(fmt::format("{} is not a time", time), "give a finite one");
    Block coefficients(u_.rows(), u_.cols());
    for (Eigen::Index k = 0; k < u_.rows(); ++k) {
        const double omega = std::sqrt(eigenvalues_[k]);
        const double of_v = omega > 0.0 ? std::sin(omega * time) / omega : time;
        coefficients.row(k) = std::cos(omega * time) * u_.row(k) + of_v * v_.row(k);
    }
    return inverse_transform(basis_, coefficients);
}

Block SpectralPropagation::wave_velocity(double time) const {
    if (!std::isfinite(time)) throw InputError(fmt::format("{} is not a time", time), "give a finite one");
    Block coefficients(u_.rows(), u_.cols());
    for (Eigen::Index k = 0; k < u_.rows(); ++k) {
        const double omega = std::sqrt(eigenvalues_[k]);
        coefficients.row(k) =
            -omega * std::sin(omega * time) * u_.row(k) + std::cos(omega * time) * v_.row(k);
    }
    return inverse_transform(basis_, coefficients);
}

}  // namespace beltrami
