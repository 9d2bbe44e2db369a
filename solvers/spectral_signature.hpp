// What the eigenfunctions of a shape say about its points, about two points, and about all of it.
//
//     const StoredBasis basis("BASIS");
//     const Block hks = heat_kernel_signature(basis, heat_signature_times(basis, 100));       // vertices x 100
//     const Block wks = wave_kernel_signature(basis, wave_signature_energies(basis, 100));    // vertices x 100
//     const Block far = diffusion_distance(basis, 120, Vector::Constant(1, 0.1));             // from vertex 120
//     const Vector dna = shape_dna(basis.eigenvalues(), area, 2);
//     const SpectralPropagation heat(basis, u0);
//     const Block warm = heat.heat(0.1);                                                      // exact at any time
//
// h_k are the functions, M-orthonormal, and lambda_k their eigenvalues, k = 0, 1, ...; zero modes are those of
// StoredBasis::zero_modes(), and their lambda counts as 0. Rows are vertices in the file's order; where functions are 0,
// on isolated and held vertices, signatures are 0. A basis is swept through band by band, never held in memory.
#pragma once

#include <optional>

#include "beltrami/solvers/harmonic_transform.hpp"

namespace beltrami {

/// The eigenvalues, those of zero modes exactly 0 and none below.
Vector clean_eigenvalues(const StoredBasis& basis);
/// The first that is not that of a zero mode. Throws InputError where there is none.
double first_nonzero_eigenvalue(const StoredBasis& basis);

/// sum_k weights(k, c) h_k(x)^2: vertices x columns. weights: one row a function. Throws InputError for another number of
/// rows.
Block sum_of_squares(const StoredBasis& basis, const Block& weights, const Progress* progress = nullptr);
/// (sum_k weights(k, c) (h_k(x) - h_k(from))^2)^(1/2): vertices x columns, exactly 0 at `from`. Throws InputError for
/// another number of rows, a negative weight and a vertex out of range.
Block spectral_distance(const StoredBasis& basis, Index from, const Block& weights,
                        const Progress* progress = nullptr);

/// `count` times in length^2, evenly spaced in their logarithm from 4 ln 10 / (the largest eigenvalue) to 4 ln 10 / (the
/// first nonzero one): section 5 of Sun, Ovsjanikov & Guibas 2009. Throws InputError for a count below 1 and a basis of
/// zero modes. One time is their geometric mean.
Vector heat_signature_times(const StoredBasis& basis, Index count);
/// HKS(x, t) = sum_k exp(-lambda_k t) h_k(x)^2, in 1/measure: vertices x times. Sun, Ovsjanikov & Guibas 2009.
/// by_trace: each column over the heat trace sum_k exp(-lambda_k t), so that its integral over the shape is 1 (their scaled
/// signature). Throws InputError for times that are negative or not finite.
Block heat_kernel_signature(const StoredBasis& basis, const Vector& times, bool by_trace = false,
                            const Progress* progress = nullptr);

/// Energies are logarithms of eigenvalues.
struct SignatureEnergies {
    Vector energies;
    double sigma = 0.0;  ///< the width of the windows around them
};
/// `count` energies delta apart with sigma = 7 delta, from the logarithm of the first nonzero eigenvalue + 2 sigma to that
/// of the largest - 2 sigma: Aubry, Schlickewei & Cremers 2011, who take 100. Throws InputError for a count below 1 and
/// a basis of fewer than two different eigenvalues that are not 0.
SignatureEnergies wave_signature_energies(const StoredBasis& basis, Index count);
/// WKS(x, e) = sum_k w_k h_k(x)^2 / sum_k w_k with w_k = exp(-(e - ln lambda_k)^2 / (2 sigma^2)) over the functions that
/// are not zero modes: vertices x energies. Aubry, Schlickewei & Cremers 2011. Does not change where the unit of length
/// does, but for h^2 itself. Throws InputError for a sigma that is not positive and energies that are not finite.
Block wave_kernel_signature(const StoredBasis& basis, const SignatureEnergies& energies,
                            const Progress* progress = nullptr);

/// From a vertex, for each time: (sum_k exp(-2 lambda_k t) (h_k(x) - h_k(y))^2)^(1/2), vertices x times. Coifman & Lafon
/// 2006. Throws InputError for times that are negative or not finite and a vertex out of range.
Block diffusion_distance(const StoredBasis& basis, Index from, const Vector& times,
                         const Progress* progress = nullptr);
/// (sum_k (h_k(x) - h_k(y))^2 / lambda_k^2)^(1/2) over the functions that are not zero modes, vertices x 1. Lipman,
/// Rustamov & Funkhouser 2010. Between components it is infinite; what is returned there leaves that out.
Block biharmonic_distance(const StoredBasis& basis, Index from, const Progress* progress = nullptr);
/// The same with 1 / lambda_k: the root of the commute time of a Brownian motion, up to a factor. Grows without bound with
/// the number of functions, slowly: Green's function of a surface has a logarithmic pole.
Block commute_time_distance(const StoredBasis& basis, Index from, const Progress* progress = nullptr);

/// lambda_k measure^(2/dimension): the same for similar shapes. measure: length, area or volume, with dimension 1, 2 or 3.
/// Reuter, Wolter & Peinecke 2006, section 4. Throws InputError for a measure that is not positive.
Vector shape_dna(const Vector& eigenvalues, double measure, int dimension);
/// Weyl's law, the eigenvalue that function `number` (from 0) has on average: 4 pi^2 (number / (B measure))^(2/dimension),
/// where B is the measure of the unit ball; on a surface 4 pi number / area.
double weyl_eigenvalue(double number, double measure, int dimension);

/// |x - sum_{j <= k} x~_j h_j|_M / |x|_M for every k: what is left of a field (all its columns) of the first k + 1
/// functions; spectral mesh compression, Karni & Gotsman 2000. The last entry is computed from the difference itself, the
/// others by adding |x~_j|^2 to it from the last on, so that small errors do not come from the difference of large
/// numbers: their relative accuracy is about max_orthogonality_error() |x| / error. 0 for a field that is 0.
struct ReconstructionErrors {
    Vector amplitudes;  ///< |x~_k|, over all columns
    Vector relative;    ///< one a function
    double norm = 0.0;  ///< |x|_M
};
ReconstructionErrors reconstruction_errors(const StoredBasis& basis, const Block& field,
                                           const Progress* progress = nullptr);

/// Heat and waves from an initial state, exact in time in what the basis holds: M u' = -K u and M u'' = -K u.
/// What it does not hold is left out; see left_out().
class SpectralPropagation {
  public:
    /// u0, v0: vertices x columns, v0 the velocity of a wave (zero where it is not given). basis must outlive this.
    /// Throws InputError for other shapes.
    SpectralPropagation(const StoredBasis& basis, const Block& u0,
                        const std::optional<Block>& v0 = std::nullopt, const Progress* progress = nullptr);

    /// |u0 - its part in the basis|_M / |u0|_M, or the same of v0 where that is more.
    [[nodiscard]] double left_out() const { return left_out_; }

    /// sum exp(-lambda t) <u0, h> h, vertices x columns; time in length^2. Throws InputError for a time that is negative
    /// or not finite.
    [[nodiscard]] Block heat(double time) const;
    /// sum (cos(omega t) <u0, h> + sin(omega t) / omega <v0, h>) h with omega = lambda^(1/2); zero modes move at constant
    /// speed. Time in length, any sign. Throws InputError for a time that is not finite.
    [[nodiscard]] Block wave(double time) const;
    /// Its velocity.
    [[nodiscard]] Block wave_velocity(double time) const;

  private:
    const StoredBasis& basis_;
    Vector eigenvalues_;
    Block u_;  // coefficients, pairs x columns
    Block v_;
    double left_out_ = 0.0;
};

}  // namespace beltrami
