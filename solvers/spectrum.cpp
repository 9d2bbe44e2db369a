#include "beltrami/solvers/spectrum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/stopwatch.hpp"
#include "beltrami/solvers/dense_kernels.hpp"
#include "beltrami/solvers/large_array.hpp"
#include "beltrami/solvers/spectral_band.hpp"
#include "beltrami/solvers/spectrum_bands.hpp"
#include "beltrami/solvers/spectrum_full.hpp"
#include "beltrami/solvers/spectrum_hierarchical.hpp"

namespace beltrami {

std::string_view name(SpectrumMethod method) {
    switch (method) {
        case SpectrumMethod::automatic:
            return "automatic";
        case SpectrumMethod::bands:
            return "bands";
        case SpectrumMethod::full:
            return "full";
        case SpectrumMethod::hierarchical:
            return "hierarchical";
    }
    return "";
}

namespace {

/// Unknowns up to which all pairs are found densely: its seconds grow with the cube.
constexpr Index largest_full = 6000;

void check(const Eigenproblem& problem, const SpectrumOptions& options) {
    if (options.count < 0 || (options.count == 0 && !(options.cutoff > 0.0))) {
        throw InputError("no pair is asked for", "give a positive count, or a cutoff frequency above 0");
    }
    if (options.count > problem.rows()) {
        throw InputError(fmt::format("{} eigenpairs are asked for, but there are {} unknowns", options.count,
                                     problem.rows()),
                         fmt::format("ask for {} at most", problem.rows()));
    }
    if (!(options.tolerance > 0.0) || !std::isfinite(options.cutoff) || !std::isfinite(options.from) ||
        options.cutoff < 0.0 || options.from < 0.0 || options.band < 0) {
        throw InputError("the spectrum's tolerance, cutoff, start or sizes are not usable",
                         "give a positive tolerance, and frequencies and sizes that are not negative");
    }
}

SpectrumMethod choose(const Eigenproblem& problem, const SpectrumOptions& options, std::string& why) {
    if (options.method != SpectrumMethod::automatic) {
        why = "as asked";
        return options.method;
    }
    const Index n = problem.rows();
    if (n <= 500) {
        why = fmt::format("{} unknowns are few", n);
        return SpectrumMethod::full;
    }
    if (n <= largest_full && options.count > n / 5) {
        why = fmt::format("{} of {} pairs are many", options.count, n);
        return SpectrumMethod::full;
    }
    why = fmt::format("{} unknowns", n);
    return SpectrumMethod::bands;
}

}  // namespace

SpectrumSummary spectrum(const Eigenproblem& problem, const SpectrumOptions& options, const BandSink& sink) {
    check(problem, options);
    const Stopwatch watch;
    SpectrumSummary summary;
    summary.tolerance = options.tolerance;
    summary.components = static_cast<Index>(problem.constants().cols());
    summary.method = choose(problem, options, summary.why);
    // Random sums of all vectors so far, to see how far new ones are from orthogonal to them: the mean square of an
    // entry of H^T M (H_before signs) is the sum of squares of a row of H^T M H_before.
    constexpr Index sums = 8;
    Columns sketch = Columns::Zero(problem.rows(), sums);
    std::mt19937 engine(7);
    const BandSink counting = [&](const SpectralBand& band) {
        const Vector across = mass_product(problem, band.vectors, sketch).rowwise().norm() /
                              std::sqrt(static_cast<double>(sums));
        if (across.size() > 0)
            summary.max_orthogonality_error = std::max(summary.max_orthogonality_error, across.maxCoeff());
        add_product(
            1.0, band.vectors,
            Columns::NullaryExpr(band.vectors.cols(), sums, [&] { return engine() % 2 == 0 ? 1.0 : -1.0; }),
            sketch);
        if (band.values.size() > 0) {
            summary.largest = band.values[band.values.size() - 1];
            const double zero = 1e-9 * std::max(band.certificate.upper.value, 0.0);
            summary.zero_modes += static_cast<Index>((band.values.array().abs() <= zero).count());
        }
        summary.max_residual = std::max(summary.max_residual, band.certificate.max_residual);
        summary.max_orthogonality_error =
            std::max(summary.max_orthogonality_error, band.certificate.max_orthogonality_error);
        sink(band);
    };
    if (summary.method == SpectrumMethod::full) {
        spectrum_in_full(problem, options, counting, summary);
    } else if (summary.method == SpectrumMethod::hierarchical) {
        spectrum_hierarchically(problem, options, counting, summary);
    } else {
        spectrum_by_bands(problem, options, counting, summary);
    }
    summary.total_seconds = watch.seconds();
    return summary;
}

Spectrum spectrum(const Eigenproblem& problem, const SpectrumOptions& options) {
    Spectrum result;
    Eigen::Index found = 0;
    // With a count the room is known; pages are taken as they are written to.
    const Index room = std::clamp(options.count, Index{0}, problem.rows());
    result.values.resize(room);
    result.vectors.resize(problem.rows(), room);
    use_large_pages(result.vectors.data(), static_cast<std::size_t>(result.vectors.size()));
    result.summary = spectrum(problem, options, [&](const SpectralBand& band) {
        const Eigen::Index more = band.values.size();
        if (found + more > result.values.size()) {
            result.values.conservativeResize(found + more);
            result.vectors.conservativeResize(Eigen::NoChange, found + more);
        }
        result.values.segment(found, more) = band.values;
        result.vectors.middleCols(found, more) = band.vectors;
        found += more;
    });
    if (found < result.values.size()) {
        result.values.conservativeResize(found);
        result.vectors.conservativeResize(Eigen::NoChange, found);
    }
    return result;
}

std::string SpectrumSummary::brief() const {
    return fmt::format("{}: {} pairs up to lambda = {:.4g}, {}, residuals to {:.1e}, in {:.2f} s",
                       name(method), count, largest, complete ? "complete" : "NOT COMPLETE", max_residual,
                       total_seconds);
}

std::string SpectrumSummary::full() const {
    std::string text = fmt::format(
        "method             {} ({})\n"
        "pairs              {} up to lambda = {:.8g}, {}\n"
        "zero modes         {} for {} free component{}\n"
        "residual           {:.2e} at most, tolerance {:.1e}\n"
        "orthogonality      {:.2e} at most\n"
        "factorizations     {}, columns solved {}\n"
        "seconds            {:.2f}: analysis {:.2f}, factors {:.2f}, Krylov spaces {:.2f}\n"
        "memory             {:.1f} MB, on disk {:.1f} MB\n",
        name(method), why, count, largest, complete ? "complete" : "NOT COMPLETE", zero_modes, components,
        components == 1 ? "" : "s", max_residual, tolerance, max_orthogonality_error, factorizations,
        solved_columns, total_seconds, analysis_seconds, factor_seconds, solve_seconds,
        static_cast<double>(memory_bytes) / 1e6, static_cast<double>(disk_bytes) / 1e6);
    for (const BandCertificate& band : bands) {
        text += fmt::format(
            "band               {:.6g} to {:.6g}: inertia {} to {}, found {}, residual {:.1e}, dimension "
            "{}{}\n",
            band.lower.value, band.upper.value, band.lower.below, band.upper.below, band.found,
            band.max_residual, band.dimension,
            band.rounds > 1 ? fmt::format(" in {} spaces", band.rounds) : "");
    }
    return text;
}

}  // namespace beltrami
