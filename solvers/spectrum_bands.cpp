#include "beltrami/solvers/spectrum_bands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/stopwatch.hpp"
#include "beltrami/solvers/block_lanczos.hpp"
#include "beltrami/solvers/dense_kernels.hpp"
#include "beltrami/solvers/spectral_band.hpp"

namespace beltrami {

namespace {

/// Pairs in a band: orthogonalization costs (2 band + 100)^2 products a band, so that fewer and more both cost more a pair.
constexpr Index default_band = 64;
constexpr double infinity = std::numeric_limits<double>::infinity();

// Pairs without a gap in their numbers: the lowest of a band.
struct Found {
    Vector values;              // ascending, all above the lower end
    double next = infinity;     // what the pair behind them has about
    std::optional<double> end;  // where the band can end; none while pairs are missing
};

class Bands {
  public:
    Bands(const Eigenproblem& problem, const SpectrumOptions& options, const BandSink& sink,
          SpectrumSummary& summary)
        : problem_(problem), options_(options), sink_(sink), summary_(summary) {
        const PhaseTimer timer(summary.analysis_seconds);
        report(options.progress, "ordering", 0.0);
        ShiftInvertOptions factor = options.factor;
        factor.few_solves = factor.few_solves || (options.count > 0 && options.count <= default_band);
        pencil_.emplace(problem, factor);
        if (!options.on_plan) return;
        // The space, the pairs that converge in it on both sides of the shift, the band and the one before it.
        const double columns = 3.0 * band_size() + 30.0 * panel_width + 4.0 * band_size();
        options.on_plan(plan_of(problem, *pencil_, columns));
    }

    void run() {
        SpectrumEnd lower = start();
        if (options_.resume != nullptr) {
            lower = options_.resume->last.upper;
            before_ = options_.resume->before;
        }
        const double top = options_.cutoff > 0.0 ? options_.cutoff * options_.cutoff : infinity;
        const Index all = problem_.rows();
        const Index wanted = options_.count > 0 ? std::min(options_.count + from_below_, all) : all;
        double density = 1.0 / estimated_eigenvalue(problem_, 1.0);
        if (options_.count > 0) {
            density = static_cast<double>(options_.count) /
                      estimated_eigenvalue(problem_, static_cast<double>(options_.count));
        }
        const auto density_of = [](const BandCertificate& band) {
            return band.found / (band.upper.value - std::max(band.lower.value, 0.0));
        };
        if (options_.resume != nullptr && options_.resume->last.found > 1)
            density = density_of(options_.resume->last);
        while (lower.below < wanted && lower.value < top) {
            report(options_.progress, "eigenpairs",
                   options_.count > 0
                       ? static_cast<double>(lower.below - from_below_) / static_cast<double>(options_.count)
                       : std::max(0.0, lower.value / top));
            SpectralBand band = next_band(lower, wanted, top, density);
            lower = band.certificate.upper;
            if (band.certificate.found > 1) density = density_of(band.certificate);
            summary_.bands.push_back(band.certificate);
            summary_.count += static_cast<Index>(band.values.size());
            sink_(band);
            before_ = std::move(band.vectors);
        }
        summary_.complete = true;
        summary_.factorizations = pencil_->factorizations();
        summary_.solved_columns = pencil_->solved_columns();
        summary_.disk_bytes = pencil_->disk_bytes();
    }

  private:
    SpectrumEnd inertia_at(double shift) {
        const PhaseTimer timer(summary_.factor_seconds);
        pencil_->factor(shift);
        report(options_.progress, "eigenpairs", -1.0);
        return {shift, pencil_->eigenvalues_below()};
    }

    // Below every pair that is asked for.
    SpectrumEnd start() {
        if (options_.from > 0.0) {
            const SpectrumEnd end = inertia_at(options_.from * options_.from);
            from_below_ = end.below;
            return end;
        }
        // K may be indefinite where its weights are not a finite-element stiffness.
        double shift = -0.1 * estimated_eigenvalue(problem_, 1.0);
        SpectrumEnd end = inertia_at(shift);
        while (end.below > 0) {
            shift *= 10.0;
            end = inertia_at(shift);
        }
        return end;
    }

    struct Goal {
        double lower;  // nothing at or below it counts
        Index left;    // pairs between it and the shift
        Index count;   // pairs to find
        bool last;     // no more than these are needed
        double top;    // nothing above it is needed
    };

    SpectralBand next_band(const SpectrumEnd& lower, Index wanted, double top, double density) {
        const Index remaining = wanted - lower.below;
        // Rather a few more pairs in each than a band more.
        const Index bands = std::max((remaining + 3 * band_size() / 4) / band_size(), 1);
        // Bands of even sizes; a cutoff leaves it open how many there are.
        const Index target =
            options_.count > 0 ? std::max<Index>((remaining + bands - 1) / bands, 1) : band_size();
        BandCertificate trace;
        const double shift = choose_shift(lower, std::min(target, remaining), top, density);
        const Index left = pencil_->eigenvalues_below() - lower.below;

        // What was found and is kept out of the next space: the constants, and pairs around the shift.
        const bool first = lower.value < 0.0;
        Eigenpairs pairs{Vector::Zero(0), Columns(problem_.rows(), 0)};
        if (first) {
            pairs.vectors = problem_.constants();
            pairs.values = Vector::Zero(pairs.vectors.cols());
        }
        double tolerance = 0.1 * options_.tolerance;
        const Goal goal{lower.value, left, std::min(target, remaining), target >= remaining, top};
        Index missing = goal.count;
        int worse = 0;
        std::string shortage;
        // Equal eigenvalues come in as many spaces as it takes, eight of each in one.
        for (int idle = 0; idle < 3;) {
            ++trace.rounds;
            const Eigen::Index known = pairs.values.size();
            const Found found = krylov(goal, tolerance, missing, pairs, trace);
            idle = pairs.values.size() > known ? 0 : idle + 1;
            missing = std::max<Index>(goal.count - static_cast<Index>(found.values.size()), panel_width);
            if (!found.end) {
                shortage = fmt::format("{} of {} pairs were found", found.values.size(), goal.count);
                continue;
            }
            const SpectrumEnd upper = inertia_at(*found.end);
            SpectralBand band = between(pairs, lower, upper);
            const Index expected = upper.below - lower.below;
            if (band.certificate.found < expected) {
                shortage = fmt::format("{} of {} pairs were found", band.certificate.found, expected);
            } else if (band.certificate.found > expected) {
                throw SolveError(
                    fmt::format(
                        "{} pairs were found between the eigenvalues {:.6g} and {:.6g}, where there are {}",
                        band.certificate.found, lower.value, upper.value, expected),
                    "this is a defect of beltrami; please report the mesh");
            } else if (band.certificate.max_residual > options_.tolerance) {
                shortage = fmt::format("the largest residual is {:.1e}", band.certificate.max_residual);
                // Pairs that are locked do not get better.
                tolerance *= 0.01;
                ++worse;
                if (worse > 3) break;
                missing = goal.count;
                pairs.values.conservativeResize(first ? problem_.constants().cols() : 0);
                pairs.vectors.conservativeResize(Eigen::NoChange, pairs.values.size());
            } else {
                trace.lower = lower;
                trace.upper = upper;
                trace.found = band.certificate.found;
                trace.max_residual = band.certificate.max_residual;
                trace.max_orthogonality_error = band.certificate.max_orthogonality_error;
                trace.shift = shift;
                band.certificate = trace;
                keep(band, std::min(band.certificate.found, remaining));
                return band;
            }
            inertia_at(shift);
        }
        throw SolveError(fmt::format("the pairs behind the eigenvalue {:.6g} could not be certified: {}",
                                     lower.value, shortage),
                         "allow larger residuals with --tolerance, or look for slivers with beltrami info");
    }

    // Factors at a shift with about half of the band below it.
    double choose_shift(const SpectrumEnd& lower, Index target, double top, double density) {
        const double base = std::max(lower.value, 0.0);
        double reach = 0.5 * static_cast<double>(target) / density;
        if (top < infinity) reach = std::min(reach, 0.5 * (top - base));
        double shift = base + reach;
        for (int attempt = 0; attempt < 12; ++attempt) {
            shift = base + reach;
            Index below = 0;
            try {
                below = inertia_at(shift).below - lower.below;
            } catch (const SolveError&) {
                if (attempt == 11) throw;
                reach *= 1.0 + 1e-3 * (attempt + 1);
                continue;
            }
            const double ratio = (below + 0.5) / (0.5 * target + 0.5);
            const bool too_many = below > 3 * target / 4 + 1;
            const bool too_few = ratio < 0.3 && attempt < 4 && below + lower.below < problem_.rows() &&
                                 2.0 * reach < top - base;
            if (!too_many && !too_few) break;
            reach /= std::clamp(ratio, 0.2, 8.0);
        }
        return shift;
    }

    // A Krylov space around the shift until the goal's pairs are there, or it is full; what converged in it is added
    // to `pairs` and locked for the next.
    Found krylov(const Goal& goal, double tolerance, Index missing, Eigenpairs& pairs,
                 BandCertificate& trace) {
        constexpr Index size = panel_width;
        BlockLanczosOptions space;
        space.capacity = std::max<Index>(3 * missing + 30 * size, 8 * size);
        space.seed = static_cast<std::uint32_t>(trace.rounds) + 1000U * bands_done();
        BlockLanczos lanczos(problem_, *pencil_, pairs.vectors, space, std::move(room_));
        Found found;
        RitzValues ritz;
        std::vector<Index> accepted;
        Index next_look = std::max<Index>(missing + 4 * size, 6 * size);
        for (bool more = true; more;) {
            {
                const PhaseTimer timer(summary_.solve_seconds);
                more = lanczos.extend();
            }
            report(options_.progress, "eigenpairs", -1.0);
            if (lanczos.dimension() == 0) break;
            if (more && lanczos.dimension() < next_look) continue;
            ritz = lanczos.ritz();
            next_look = lanczos.dimension() + std::max(size, lanczos.dimension() / 12);
            accepted.clear();
            for (Index i = 0; i < ritz.values.size(); ++i) {
                if (ritz.residuals[i] <= tolerance * std::abs(ritz.values[i])) accepted.push_back(i);
            }
            found = without_gaps(pairs.values, ritz, accepted, goal.lower);
            found.end = choose_end(found, goal);
            if (found.end) break;
        }
        trace.dimension += lanczos.dimension();
        memory(lanczos.memory_bytes() + static_cast<std::size_t>(pairs.vectors.size()) * sizeof(double));
        // Where the band can end, what converged outside is of no use.
        if (found.end) {
            std::erase_if(accepted, [&](Index i) {
                return ritz.values[i] <= goal.lower || ritz.values[i] >= *found.end;
            });
        }
        if (!accepted.empty()) add(pairs, ritz, accepted, lanczos);
        room_ = lanczos.release();
        return found;
    }

    // The locked and the accepted values above `lower`, up to the first Ritz value that is not accepted.
    static Found without_gaps(const Vector& locked, const RitzValues& ritz,
                              const std::vector<Index>& accepted, double lower) {
        Found found;
        std::vector<double> values(locked.begin(), locked.end());
        auto next_accepted = accepted.begin();
        for (Index i = 0; i < ritz.values.size(); ++i) {
            if (next_accepted != accepted.end() && *next_accepted == i) {
                values.push_back(ritz.values[i]);
                ++next_accepted;
            } else if (ritz.values[i] > lower) {
                found.next = std::min(found.next, ritz.values[i]);
            }
        }
        std::erase_if(values, [&](double v) { return v <= lower || v >= found.next; });
        std::sort(values.begin(), values.end());
        found.values = Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
        return found;
    }

    // The middle of the widest of the gaps where the band may end; none while pairs are missing.
    static std::optional<double> choose_end(const Found& found, const Goal& goal) {
        const Vector& v = found.values;
        const auto size = static_cast<Index>(v.size());
        if (size < goal.left) return std::nullopt;
        const double reached = found.next < infinity ? found.next : size > 0 ? v[size - 1] : goal.lower;
        if (goal.top < infinity && reached > goal.top) return goal.top;
        const Index least = goal.last ? goal.count : std::max<Index>(goal.count - goal.count / 16, 1);
        const Index most = goal.last ? goal.count + std::max<Index>(4, goal.count / 10) : goal.count;
        if (size < (goal.last ? least : most)) return std::nullopt;
        double widest = 0.0;
        double end = 0.0;
        const auto look = [&](Index first, Index last) {
            for (Index i = first; i <= last; ++i) {
                const double below = v[i - 1];
                const double above = i < size ? v[i] : found.next;
                // Behind the last of all eigenvalues there is nothing.
                const double gap = above < infinity ? above - below : std::max(std::abs(below), 1e-300);
                if (gap <= widest) continue;
                widest = gap;
                end = below + 0.5 * gap;
            }
            // Between two eigenvalues that are closer the count would be left to rounding.
            return widest > 1e-9 * std::abs(end);
        };
        if (look(least, std::min(size, most))) return end;
        // All of these are one multiple eigenvalue: behind it, or before it.
        if (look(least, size)) return end;
        if (!goal.last && look(std::max<Index>(goal.left, 1), size)) return end;
        return std::nullopt;
    }

    void add(Eigenpairs& pairs, const RitzValues& ritz, const std::vector<Index>& accepted,
             const BlockLanczos& lanczos) {
        std::vector<Index> chosen;
        chosen.reserve(accepted.size());
        for (const Index i : accepted)
            chosen.push_back(ritz.vector[static_cast<std::size_t>(i)]);
        Eigenpairs more{ritz.values(accepted), lanczos.vectors(chosen)};
        refine(more);
        const Eigen::Index before = pairs.values.size();
        if (before == 0) {
            pairs = std::move(more);
            return;
        }
        pairs.values.conservativeResize(before + more.values.size());
        pairs.values.tail(more.values.size()) = more.values;
        pairs.vectors.conservativeResize(Eigen::NoChange, pairs.values.size());
        pairs.vectors.rightCols(more.values.size()) = more.vectors;
    }

    // Blocks of the space carry rounding that is large against their smooth part, and stiff cells enlarge it: an
    // inverse iteration takes it away where it shows. Where that leaves too much the solves were not good enough, and the
    // next one is corrected by what it leaves. Pairs that are nearer to the shift grow in it, so it can do harm too.
    void refine(Eigenpairs& pairs) {
        const double good = 0.3 * options_.tolerance;
        Vector residual = residuals(problem_, pairs.values, pairs.vectors, 0.0);
        for (const bool corrected : {false, true}) {
            std::vector<Index> rough;
            for (Index i = 0; i < residual.size(); ++i) {
                if (residual[i] > good) rough.push_back(i);
            }
            if (rough.empty()) return;
            const Columns better = inverse_iteration(pairs, rough, corrected);
            const Vector after = residuals(problem_, pairs.values(rough), better, 0.0);
            for (Eigen::Index i = 0; i < after.size(); ++i) {
                const Index pair = rough[static_cast<std::size_t>(i)];
                if (!(after[i] < residual[pair])) continue;
                pairs.vectors.col(pair) = better.col(i);
                residual[pair] = after[i];
            }
        }
    }

    Columns inverse_iteration(const Eigenpairs& pairs, const std::vector<Index>& chosen, bool corrected) {
        Columns Mh;
        problem_.apply_mass(pairs.vectors(Eigen::all, chosen), Mh);
        Columns h = Mh;
        pencil_->solve(h);
        if (corrected) {
            Columns product;
            problem_.apply_stiffness(h, product);
            Mh -= product;
            problem_.apply_mass(h, product);
            Mh += pencil_->shift() * product;
            pencil_->solve(Mh);
            h += Mh;
        }
        const Vector distance = pairs.values(chosen).array() - pencil_->shift();
        return h * distance.asDiagonal();
    }

    SpectralBand between(const Eigenpairs& pairs, const SpectrumEnd& lower, const SpectrumEnd& upper) {
        std::vector<Index> chosen;
        for (Index i = 0; i < pairs.values.size(); ++i) {
            if (pairs.values[i] > lower.value && pairs.values[i] < upper.value) chosen.push_back(i);
        }
        std::sort(chosen.begin(), chosen.end(),
                  [&](Index a, Index b) { return pairs.values[a] < pairs.values[b]; });
        const Index zeros = lower.value < 0.0 ? static_cast<Index>(problem_.constants().cols()) : 0;
        const double zero_scale = zeros < static_cast<Index>(chosen.size())
                                      ? pairs.values[chosen[static_cast<std::size_t>(zeros)]]
                                      : 0.0;
        return make_band(problem_, {pairs.values(chosen), pairs.vectors(Eigen::all, chosen)}, lower, upper,
                         before_, std::max(zero_scale, 1e-3 * upper.value));
    }

    [[nodiscard]] std::uint32_t bands_done() const {
        return static_cast<std::uint32_t>(summary_.bands.size()) +
               static_cast<std::uint32_t>(options_.resume != nullptr ? options_.resume->bands : 0);
    }
    [[nodiscard]] Index band_size() const { return options_.band > 0 ? options_.band : default_band; }

    void memory(std::size_t spaces) {
        const std::size_t bytes = problem_.memory_bytes() + pencil_->memory_bytes() + spaces +
                                  static_cast<std::size_t>(before_.size()) * sizeof(double);
        summary_.memory_bytes = std::max(summary_.memory_bytes, bytes);
    }

    const Eigenproblem& problem_;
    const SpectrumOptions& options_;
    const BandSink& sink_;
    SpectrumSummary& summary_;
    std::optional<ShiftInvert> pencil_;
    LargeArray room_;  // of the last space
    Columns before_ = Columns(problem_.rows(), 0);
    Index from_below_ = 0;
};

}  // namespace

void spectrum_by_bands(const Eigenproblem& problem, const SpectrumOptions& options, const BandSink& sink,
                       SpectrumSummary& summary) {
    Bands(problem, options, sink, summary).run();
}

}  // namespace beltrami
