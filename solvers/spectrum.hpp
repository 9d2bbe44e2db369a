// The lowest eigenpairs of K h = lambda M h, with a proof that none is missing.
//
//     const Eigenproblem problem(laplacian);
//     const auto [values, vectors, summary] = spectrum(problem, {.count = 300});
//     summary = spectrum(problem, {.count = 5000}, [&](const SpectralBand& band) { store(band); });   // streamed
//
// The numbers of negative pivots of K - a M at both ends of a band say how many eigenvalues lie between them
// (Sylvester's law of inertia); a band is handed over only when it holds just so many pairs, each with a small residual
// and all orthonormal. What cannot be certified is an error, never a result.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "beltrami/framework/progress.hpp"
#include "beltrami/solvers/shift_invert.hpp"

namespace beltrami {

enum class SpectrumMethod {
    automatic,
    bands,  ///< shift-invert block Lanczos, band after band: section 4 of Vallet & Levy, made exact
    full,   ///< all pairs by a dense solver, for small meshes
    /// A few pairs (up to about 50) to low accuracy (1e-2), from coarse levels to fine: in the style of HSIM, Nasikun &
    /// Hildebrandt 2022. There it solves for about half as many columns as bands do, in about the same seconds; for more
    /// pairs, or to 1e-8, it takes up to three times as long (docs/spectrum.md): automatic never chooses it.
    hierarchical
};
std::string_view name(SpectrumMethod method);

/// An end of a band, and how many eigenvalues lie below it.
struct SpectrumEnd {
    double value = 0.0;
    Index below = 0;
};

struct SpectrumResume;
class Hierarchy;

/// What a spectrum will take, told before it is taken.
struct SpectrumPlan {
    double factor_bytes = 0.0;       ///< of a factor, in memory
    double factor_disk_bytes = 0.0;  ///< of a factor that is kept on disk
    double memory_bytes = 0.0;       ///< in all, factor included
};

struct SpectrumOptions {
    /// So many of the lowest pairs; 0: as many as the cutoff leaves.
    Index count = 0;
    /// Pairs of frequency sqrt(lambda) up to this, in radians a unit of length; 0: no cutoff.
    double cutoff = 0.0;
    /// Leave out the pairs below this frequency.
    double from = 0.0;
    SpectrumMethod method = SpectrumMethod::automatic;
    /// For every pair |K h - lambda M h| <= tolerance lambda |M h|, in the 2-norm.
    double tolerance = 1e-8;
    /// Pairs in a band; 0: by what they cost.
    Index band = 0;
    ShiftInvertOptions factor = {};
    /// For a run that goes on, with the same options as the earlier one.
    const SpectrumResume* resume = nullptr;
    /// Called once, before the first factorization.
    std::function<void(const SpectrumPlan&)> on_plan = {};
    /// Of the mesh's graph in the working order; for the hierarchical method.
    std::shared_ptr<const Hierarchy> hierarchy = {};
    const Progress* progress = nullptr;
};

/// What proves a band.
struct BandCertificate {
    SpectrumEnd lower;
    SpectrumEnd upper;
    Index found = 0;  ///< pairs between the ends: upper.below - lower.below
    Index kept = 0;   ///< of these, from the lowest on: fewer in the last band of a count
    double max_residual =
        0.0;  ///< |K h - lambda M h| / (lambda |M h|); zero modes: lambda of the first other
    double max_orthogonality_error = 0.0;  ///< entries of H^T M H - I, the band before it included
    double shift = 0.0;
    Index dimension = 0;  ///< of the Krylov spaces, all together
    int rounds = 0;  ///< Krylov spaces it took: more than one where multiple eigenvalues outnumber the block
};

/// Where an earlier run ended.
struct SpectrumResume {
    BandCertificate last;  ///< of its last band, of which nothing was cut off
    Columns before;        ///< the vectors of that band, problem.rows() x last.found
    Index bands = 0;       ///< how many there were
};

struct SpectralBand {
    Index first = 0;  ///< the number of its first pair in the spectrum, from 0
    Vector values;    ///< lambda, ascending
    Columns vectors;  ///< problem.rows() x kept, M-orthonormal
    BandCertificate certificate;
};
using BandSink = std::function<void(const SpectralBand&)>;

struct SpectrumSummary {
    SpectrumMethod method = SpectrumMethod::automatic;
    std::string why;
    bool complete = false;  ///< every band is certified
    Index count = 0;        ///< pairs handed over
    Index zero_modes = 0;   ///< of these, with the eigenvalue 0
    Index components = 0;   ///< connected components that nothing holds: as many zero modes there must be
    double largest = 0.0;   ///< the last eigenvalue
    double tolerance = 0.0;
    double max_residual = 0.0;
    /// Entries of H^T M H - I: within a band and to the one before it the largest; to all earlier bands the root of the
    /// sum of squares of a row, estimated by eight random sums.
    double max_orthogonality_error = 0.0;
    std::vector<BandCertificate> bands;
    int factorizations = 0;
    long solved_columns = 0;
    double analysis_seconds = 0.0;
    double factor_seconds = 0.0;
    double solve_seconds = 0.0;
    double total_seconds = 0.0;
    std::size_t memory_bytes = 0;  ///< the most that factor, space and bands took together
    std::size_t disk_bytes = 0;    ///< of a factor on disk

    /// "bands: 315 pairs up to lambda = 3.1e+02, complete, residuals to 4.1e-09, in 9.5 s".
    [[nodiscard]] std::string brief() const;
    /// A line for each fact and each band.
    [[nodiscard]] std::string full() const;
};

/// Hands the bands to `sink` in ascending order. Throws InputError for options that ask for nothing or for more pairs
/// than there are unknowns; SolveError where a band cannot be certified (the bands before it were handed over).
SpectrumSummary spectrum(const Eigenproblem& problem, const SpectrumOptions& options, const BandSink& sink);

/// All pairs in memory: vectors is problem.rows() x pairs.
struct Spectrum {
    Vector values;
    Columns vectors;
    SpectrumSummary summary;
};
Spectrum spectrum(const Eigenproblem& problem, const SpectrumOptions& options);

}  // namespace beltrami
