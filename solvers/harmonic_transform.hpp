// The manifold harmonic transform: vertex data to frequency space and back, and filters between the two.
//
//     const StoredBasis basis("BASIS");
//     const Block coefficients = forward_transform(basis, mesh.points());    // pairs x 3
//     const Block again = inverse_transform(basis, coefficients);            // vertices x 3
//     HarmonicFilter filter(basis, mesh.points());
//     const Block smooth = filter.apply(FilterCurve::low_pass(20.0, 25.0));  // one sweep over the basis
//
// x~_k = <x, H^k> = (H^k)^T M x and x = sum x~_k H^k: eqs. (8) and (9) of Vallet & Levy 2007, (7) and (6) of 2008. What
// the basis does not hold is a wave packet of its own, amplified by the mean of F between the basis's cutoff and the
// mesh's Nyquist frequency: eq. (10) of 2007, (8) of 2008. Rows are vertices in the file's order; a basis is swept through
// once whatever the number of columns, from memory or from disk.
#pragma once

#include "beltrami/solvers/filter_curve.hpp"
#include "beltrami/solvers/stored_basis.hpp"

namespace beltrami {

/// x~: pairs x columns. field: vertices x columns. Throws InputError for another number of rows.
Block forward_transform(const StoredBasis& basis, const Block& field, const Progress* progress = nullptr);
/// vertices x columns, of coefficients of the lowest pairs: at most count() x columns.
Block inverse_transform(const StoredBasis& basis, const Block& coefficients,
                        const Progress* progress = nullptr);

/// omega_m: up to where a basis holds every function. The end of its last band, or, where that was cut off at a count, its
/// last frequency.
double cutoff_frequency(const StoredBasis& basis);
/// omega_M = pi / mean edge: the shortest wave that edges can hold, of two edge lengths.
double nyquist_frequency(double mean_edge);
/// The frequency of waves of so many mean edges; the papers cut off at 10.
double frequency_of_edges(double mean_edge, double edges);

/// A field in frequency space, ready for any number of filters.
class HarmonicFilter {
  public:
    /// field: vertices x columns. Keeps a copy of it; basis must outlive this.
    HarmonicFilter(const StoredBasis& basis, Block field, const Progress* progress = nullptr);

    [[nodiscard]] const Block& coefficients() const { return coefficients_; }
    /// f^hf: the mean of F over [cutoff, Nyquist].
    [[nodiscard]] double high_frequency_gain(const FilterCurve& curve) const;
    /// The filtered field, vertices x columns, in one sweep over the functions whose gain is not that of the rest.
    [[nodiscard]] Block apply(const FilterCurve& curve) const;

  private:
    const StoredBasis& basis_;
    Block field_;
    Block coefficients_;
};

struct LimitedFilterOptions {
    /// omega_m: where the wave packet of the rest begins.
    double cutoff = 0.0;
    double mean_edge = 0.0;
    /// Of the bands that are found; count, cutoff, from and resume are set here.
    SpectrumOptions spectrum = {};
};
struct LimitedFilterResult {
    Block field;  ///< problem.rows() x columns
    Index pairs = 0;
    std::vector<SpectrumSummary> summaries;  ///< one for each interval of frequencies that the filter changes
};
/// Filters without a basis: finds, uses and forgets the bands that the filter changes (section 4.2 of 2008). field:
/// problem.rows() x columns, on the unknowns. Throws as spectrum() does, and InputError for a cutoff that is not positive.
LimitedFilterResult limited_memory_filter(const Eigenproblem& problem, const Block& field,
                                          const FilterCurve& curve, const LimitedFilterOptions& options);

}  // namespace beltrami
