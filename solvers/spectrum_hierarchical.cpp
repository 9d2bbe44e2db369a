#include "beltrami/solvers/spectrum_hierarchical.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/stopwatch.hpp"
#include "beltrami/solvers/dense_kernels.hpp"
#include "beltrami/solvers/hierarchy.hpp"
#include "beltrami/solvers/spectral_band.hpp"
#include "beltrami/solvers/spectrum_bands.hpp"
#include "beltrami/solvers/spectrum_full.hpp"

namespace beltrami {

namespace {
using Prolongation = Hierarchy::Prolongation;

/// Columns that are worked on together: solves cost a quarter a column, and products with K and M take little memory.
constexpr Index together = 32;

/// Residuals on coarse levels: their pairs differ from the mesh's by more.
constexpr double coarse_tolerance = 1e-2;

/// Of a Gram matrix with ones on its diagonal: below it one orthonormalization does not suffice.
constexpr double ill_conditioned = 1e-5;

/// Of a space that keeps so many at a restart.
Index most_columns(Index kept) {
    return 3 * kept + 200;
}

Columns random_columns(Index rows, Index columns, std::uint32_t seed) {
    Columns X(rows, columns);
    fill_random(X.data(), static_cast<std::size_t>(X.size()), seed);
    return X;
}

/// A level's eigenproblem is that of the next finer one on what its prolongation spans.
struct Coarse {
    Prolongation from_here;  // to the next finer level: unknowns there x unknowns here
    Eigenproblem problem;
};

/// The levels below a problem's, each with the vertices that are unknowns of it and of all finer ones: constraints
/// hold on every level, and reduced mass matrices are definite because each unknown is interpolated by itself.
std::vector<Coarse> coarse_levels(const Eigenproblem& problem, const Hierarchy& hierarchy, Index least) {
    std::vector<Coarse> levels;
    levels.reserve(static_cast<std::size_t>(hierarchy.level_count()));
    const Eigenproblem* fine = &problem;
    std::vector<Index> fine_vertices = problem.vertices();
    // unknown[v]: of the finer level.
    std::vector<Index> unknown(static_cast<std::size_t>(problem.vertex_count()));
    for (int level = 1; level < hierarchy.level_count(); ++level) {
        std::fill(unknown.begin(), unknown.end(), -1);
        for (std::size_t i = 0; i < fine_vertices.size(); ++i)
            unknown[static_cast<std::size_t>(fine_vertices[i])] = static_cast<Index>(i);
        std::vector<Index> vertices;
        std::vector<Index> on_fine;
        std::vector<Index> column(static_cast<std::size_t>(hierarchy.size(level)), -1);
        for (std::size_t c = 0; c < column.size(); ++c) {
            const Index v = hierarchy.vertices(level)[c];
            if (unknown[static_cast<std::size_t>(v)] < 0) continue;
            column[c] = static_cast<Index>(vertices.size());
            vertices.push_back(v);
            on_fine.push_back(unknown[static_cast<std::size_t>(v)]);
        }
        if (static_cast<Index>(vertices.size()) < least) break;
        const Prolongation& all = hierarchy.prolongation(level - 1);
        Prolongation P(fine->rows(), static_cast<Eigen::Index>(vertices.size()));
        P.reserve(all.nonZeros());
        for (Index r = 0; r < all.rows(); ++r) {
            const Index row =
                unknown[static_cast<std::size_t>(hierarchy.vertices(level - 1)[static_cast<std::size_t>(r)])];
            if (row < 0) continue;
            P.startVec(row);
            for (Prolongation::InnerIterator entry(all, r); entry; ++entry) {
                const Index c = column[static_cast<std::size_t>(entry.col())];
                if (c >= 0) P.insertBack(row, c) = entry.value();
            }
        }
        P.finalize();
        Eigenproblem coarse(galerkin_product(fine->stiffness(), P), galerkin_product(fine->mass_matrix(), P),
                            fine->constants()(on_fine, Eigen::all));
        levels.push_back({P, std::move(coarse)});
        fine = &levels.back().problem;
        fine_vertices = std::move(vertices);
    }
    return levels;
}

/// X^T K X.
Columns stiffness_product(const Eigenproblem& problem, const Columns& X) {
    const auto size = static_cast<Index>(X.cols());
    Columns upper(size, size);
    Columns product;
    for (Index first = 0; first < size; first += together) {
        const Index count = std::min(together, size - first);
        problem.apply_stiffness(X.middleCols(first, count), product);
        upper.block(0, first, first + count, count) = transposed_product(X.leftCols(first + count), product);
    }
    return upper.selfadjointView<Eigen::Upper>();
}

/// Z with Z^T B Z = I, of as many columns as B has directions that are not rounding.
struct InverseRoot {
    Columns Z;
    double least = 0.0;  // the smallest eigenvalue that is left of B with its diagonal scaled to ones
};
InverseRoot inverse_root(const Columns& B) {
    const Vector scale = B.diagonal().cwiseSqrt().cwiseInverse();
    const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * B * scale.asDiagonal());
    const double negligible = 1e-13 * eigen.values[eigen.values.size() - 1];
    const auto rank = (eigen.values.array() > negligible).count();
    const Vector values = eigen.values.tail(rank);
    return {
        scale.asDiagonal() * (eigen.vectors.rightCols(rank) * values.cwiseSqrt().cwiseInverse().asDiagonal()),
        values[0]};
}

/// An M-orthonormal basis that is M-orthogonal to the constants, the lowest Ritz pairs of K in it, and what makes it
/// grow. Blocks that are added to it are Krylov directions: the space that a restart has not cut contains all
/// polynomials of the shift-inverted operator, and so converges as block Lanczos does, not as a power iteration.
class RitzSpace {
  public:
    RitzSpace(const Eigenproblem& problem, const Progress* progress, std::string_view phase)
        : problem_(problem), progress_(progress), phase_(phase) {
        problem.apply_mass(problem.constants(), M_constants_);
    }

    [[nodiscard]] Index dimension() const { return static_cast<Index>(projected_.rows()); }
    [[nodiscard]] const Vector& values() const { return eigen_.values; }
    [[nodiscard]] std::size_t memory_bytes() const {
        return sizeof(double) * static_cast<std::size_t>(problem_.rows()) *
               static_cast<std::size_t>(dimension());
    }

    /// X <- (K - shift M)^-1 M X.
    void invert(const ShiftInvert& pencil, Columns& X) const {
        Columns some;
        for (Index first = 0; first < X.cols(); first += together) {
            const Index count = std::min(together, static_cast<Index>(X.cols()) - first);
            problem_.apply_mass(X.middleCols(first, count), some);
            pencil.solve(some);
            X.middleCols(first, count) = some;
            report(progress_, phase_, -1.0);
        }
    }

    /// Becomes what W spans.
    void start(Columns W) {
        remove_constants(W);
        InverseRoot root = inverse_root(mass_gram(problem_, W));
        if (root.least < ill_conditioned) {
            transform(W, root.Z);
            root = inverse_root(mass_gram(problem_, W));
        }
        const Columns A = stiffness_product(problem_, W);
        eigen_ = symmetric_eigen(root.Z.transpose() * A * root.Z);
        transform(W, root.Z * eigen_.vectors);
        orthogonality_error_ = 0.0;
        set(std::move(W));
    }

    /// Adds what W spans.
    void add(Columns W) {
        if (!orthonormalize(W)) return;
        Columns product;
        problem_.apply_stiffness(W, product);
        const Eigen::Index before = projected_.rows();
        projected_.conservativeResize(before + W.cols(), before + W.cols());
        Eigen::Index at = 0;
        blocks_.push_back(std::move(W));
        for (const Columns& V : blocks_) {
            projected_.block(at, before, V.cols(), product.cols()) = transposed_product(V, product);
            at += V.cols();
        }
        projected_ = Columns(projected_.selfadjointView<Eigen::Upper>());
        eigen_ = symmetric_eigen(projected_);
    }

    [[nodiscard]] Columns vectors(const std::vector<Index>& chosen) const {
        if (blocks_.size() == 1) return blocks_[0](Eigen::all, chosen);
        Columns X = Columns::Zero(problem_.rows(), static_cast<Eigen::Index>(chosen.size()));
        Eigen::Index at = 0;
        for (const Columns& V : blocks_) {
            const Columns C = eigen_.vectors(Eigen::seqN(at, V.cols()), chosen);
            add_product(1.0, V, C, X);
            at += V.cols();
        }
        return X;
    }
    [[nodiscard]] Columns lowest(Index count) const {
        std::vector<Index> chosen(static_cast<std::size_t>(std::min(count, dimension())));
        std::iota(chosen.begin(), chosen.end(), 0);
        return vectors(chosen);
    }

    /// Only the lowest stay.
    void restart(Index kept) {
        Columns X = lowest(kept);
        eigen_.values.conservativeResize(X.cols());
        set(std::move(X));
    }

    /// Applies the operator to those of the `wanted` lowest pairs whose residual is larger than the tolerance, until
    /// there is none, or until so many sweeps did not suffice or did not help. Returns the largest residual.
    double converge(const ShiftInvert& pencil, Index wanted, Index kept, double tolerance, int sweeps) {
        std::vector<Index> active(static_cast<std::size_t>(wanted));
        std::iota(active.begin(), active.end(), 0);
        // A space that is nearly all there is has no room for directions that are more than rounding.
        const auto most = std::min(most_columns(kept), 2 * problem_.rows() / 3);
        double best = std::numeric_limits<double>::infinity();
        int idle = 0;
        for (int sweep = 0;; ++sweep) {
            Columns X = vectors(active);
            const Vector residual = residuals_of(active, X);
            std::vector<Index> still;
            std::vector<Index> columns;
            for (std::size_t i = 0; i < active.size(); ++i) {
                if (residual[static_cast<Eigen::Index>(i)] <= tolerance) continue;
                still.push_back(active[i]);
                columns.push_back(static_cast<Index>(i));
            }
            if (still.empty()) return tolerance;
            report(progress_, phase_, 1.0 - static_cast<double>(still.size()) / wanted);
            idle = residual.maxCoeff() < 0.7 * best ? 0 : idle + 1;
            best = std::min(best, residual.maxCoeff());
            if (sweep == sweeps || idle == 4) return residual.maxCoeff();
            active = std::move(still);
            X = Columns(X(Eigen::all, columns));
            invert(pencil, X);
            if (dimension() + X.cols() > most) restart(kept);
            add(std::move(X));
        }
    }

  private:
    void set(Columns W) {
        const Eigen::Index size = W.cols();
        projected_ = eigen_.values.asDiagonal();
        eigen_.vectors = Columns::Identity(size, size);
        orthogonality_error_ = std::max(orthogonality_error_, 1e-15 * static_cast<double>(size));
        blocks_.clear();
        blocks_.push_back(std::move(W));
    }

    /// Of W what lies outside the space; false where that is nothing.
    bool orthonormalize(Columns& W) {
        Columns MW;
        for (int round = 0; round < 4; ++round) {
            problem_.apply_mass(W, MW);
            Vector inside = Vector::Zero(W.cols());
            const auto remove = [&](const Columns& V) {
                const Columns C = transposed_product(V, MW);
                add_product(-1.0, V, C, W);
                inside += C.colwise().squaredNorm().transpose();
            };
            remove(problem_.constants());
            for (const Columns& V : blocks_)
                remove(V);
            Columns B = mass_gram(problem_, W);
            // What is as small as rounding at first, or vanishes after it had been enlarged.
            const double least = round == 0 ? 1e-24 : 1e-2;
            std::vector<Index> outside;
            for (Index i = 0; i < W.cols(); ++i) {
                if (B(i, i) > least * (inside[i] + B(i, i))) outside.push_back(i);
            }
            if (outside.empty()) return false;
            if (static_cast<Index>(outside.size()) < W.cols()) {
                W = Columns(W(Eigen::all, outside));
                B = Columns(B(outside, outside));
                inside = Vector(inside(outside));
            }
            const InverseRoot root = inverse_root(B);
            transform(W, root.Z);
            // What the space lacks in orthonormality, and rounding, grow with what was taken away.
            const double growth = inside.cwiseQuotient(B.diagonal()).maxCoeff() / root.least;
            const double error = orthogonality_error_ * std::sqrt(growth) + 1e-16 / root.least;
            if (error < 1e-10) {
                orthogonality_error_ = std::max(orthogonality_error_, error);
                return true;
            }
        }
        return false;
    }

    void remove_constants(Columns& W) const {
        add_product(-1.0, problem_.constants(), transposed_product(M_constants_, W), W);
    }

    [[nodiscard]] Vector residuals_of(const std::vector<Index>& pairs, const Columns& X) const {
        const Vector values = eigen_.values(pairs);
        report(progress_, phase_, -1.0);
        return residuals(problem_, values, X, 1e-3 * values.cwiseAbs().maxCoeff());
    }

    const Eigenproblem& problem_;
    const Progress* progress_;
    std::string_view phase_;
    Columns M_constants_;
    std::vector<Columns> blocks_;
    Columns projected_;                 // K in the basis
    double orthogonality_error_ = 0.0;  // about
    SymmetricEigen eigen_;
};

/// Pairs that are sought besides those that are wanted: the last ones converge as fast as there are others behind them.
Index with_guard(Index wanted) {
    return wanted + wanted / 8 + 8;
}

/// The least that a level may have to start on: its pairs are then near enough to the mesh's.
Index enough_vertices(Index wanted) {
    return std::max<Index>(12 * wanted, 1000);
}

/// Half-way to the last wanted pair, in a gap. For low accuracy that makes the first solve of all columns leave about
/// the same residual in each; for high accuracy it keeps what is not wanted twice as far away as a shift near zero does.
double choose_shift(const Vector& values, Index wanted) {
    const double bottom = std::min(values[0], 0.0);
    const double middle = bottom + 0.5 * (values[wanted - 1] - bottom);
    const auto at = static_cast<Index>((values.array() < middle).count());
    double shift = middle;
    double widest = 0.0;
    for (Index i = std::max(at - 3, 0); i <= std::min(at + 3, wanted - 1); ++i) {
        const double below = i > 0 ? values[i - 1] : bottom;
        if (values[i] - below <= widest) continue;
        widest = values[i] - below;
        shift = below + 0.5 * widest;
    }
    return shift;
}

/// The number of pairs, from `least` to `most`, behind which the widest gap lies.
Index widest_gap(const Vector& values, Index least, Index most) {
    Index best = least;
    for (Index i = least; i <= most; ++i) {
        if (values[i] - values[i - 1] > values[best] - values[best - 1]) best = i;
    }
    return best;
}

class Hierarchical {
  public:
    Hierarchical(const Eigenproblem& problem, const SpectrumOptions& options, SpectrumSummary& summary)
        : problem_(problem),
          options_(options),
          summary_(summary),
          zeros_(static_cast<Index>(problem.constants().cols())),
          space_(problem, options.progress, "eigenpairs") {
        const PhaseTimer timer(summary.analysis_seconds);
        report(options.progress, "ordering", 0.0);
        pencil_.emplace(problem, options.factor);
        if (!options.on_plan) return;
        Index pairs = options.count;
        if (options.count == 0) {
            // Weyl's law: lambda grows with a power of the number.
            const double first = estimated_eigenvalue(problem, 1.0);
            const double power = std::log2(estimated_eigenvalue(problem, 2.0) / first);
            pairs =
                static_cast<Index>(std::min(std::pow(options.cutoff * options.cutoff / first, 1.0 / power),
                                            static_cast<double>(problem.rows())));
        }
        // The space at its largest, and the band with what it is made of.
        options.on_plan(plan_of(problem, *pencil_, most_columns(with_guard(pairs)) + 2 * pairs));
    }

    /// None where so many pairs are asked for that another method suits better.
    std::optional<SpectralBand> run() {
        Index wanted = std::max(options_.count - zeros_, 1);
        if (options_.cutoff > 0.0) {
            const SpectrumEnd top = inertia_at(options_.cutoff * options_.cutoff);
            if (options_.count == 0 || top.below <= options_.count) {
                top_ = top;
                wanted = std::max(top.below - zeros_, 0);
            }
        }
        if (3 * (with_guard(wanted) + zeros_) > problem_.rows()) return std::nullopt;
        if (wanted > 0) {
            kept_ = with_guard(wanted);
            Start start = from_coarse_levels(wanted);
            shift_ = inertia_at(start.shift).value;
            const PhaseTimer timer(summary_.solve_seconds);
            space_.invert(*pencil_, start.X);
            space_.start(std::move(start.X));
        }
        SpectralBand band = certified(wanted);
        summary_.factorizations = pencil_->factorizations();
        summary_.solved_columns = pencil_->solved_columns();
        summary_.disk_bytes = pencil_->disk_bytes();
        return band;
    }

  private:
    /// Factors at the shift, or close above it where it is an eigenvalue.
    SpectrumEnd inertia_at(double shift) {
        const PhaseTimer timer(summary_.factor_seconds);
        report(options_.progress, "eigenpairs", -1.0);
        for (int attempt = 0;; ++attempt) {
            try {
                pencil_->factor(shift);
                return {shift, pencil_->eigenvalues_below()};
            } catch (const SolveError&) {
                if (attempt == 3) throw;
                shift += 1e-9 * std::pow(10.0, attempt) * std::abs(shift);
            }
        }
    }

    /// Approximate pairs of the coarsest level that is used, without its zero modes.
    Eigenpairs coarsest_pairs(const Eigenproblem& coarse, Index count) const {
        // Its work is reported as this method's.
        Progress progress([&](const ProgressReport& r) {
            if (options_.progress == nullptr) return;
            options_.progress->report("coarse level", r.fraction);
            if (options_.progress->cancelled()) progress.cancel();
        });
        SpectrumOptions options;
        options.count = std::min(count + static_cast<Index>(coarse.constants().cols()), coarse.rows());
        options.method = coarse.rows() <= 500 ? SpectrumMethod::full : SpectrumMethod::bands;
        options.tolerance = coarse_tolerance;
        options.progress = &progress;
        const Spectrum found = spectrum(coarse, options);
        Columns M_constants;
        coarse.apply_mass(coarse.constants(), M_constants);
        const Vector constant_part = transposed_product(found.vectors, M_constants).rowwise().squaredNorm();
        std::vector<Index> chosen;
        for (Index i = 0; i < options.count; ++i) {
            if (constant_part[i] < 0.5) chosen.push_back(i);
        }
        return {found.values(chosen), found.vectors(Eigen::all, chosen)};
    }

    struct Start {
        double shift = 0.0;
        Columns X;
    };

    /// A subspace on the mesh, from the coarsest level on.
    Start from_coarse_levels(Index wanted) {
        const PhaseTimer timer(summary_.solve_seconds);
        std::vector<Coarse> levels = coarse_levels(problem_, *options_.hierarchy, enough_vertices(wanted));
        if (levels.empty()) levels = coarse_levels(problem_, *options_.hierarchy, 2 * (kept_ + zeros_));
        Columns X;
        double shift = 0.0;
        if (levels.empty()) {
            // Weyl's law may be wrong by a factor: a shift that is too low costs less than one that is too high.
            shift = 0.25 * estimated_eigenvalue(problem_, static_cast<double>(wanted + zeros_));
            X = random_columns(problem_.rows(), kept_, 1);
        } else {
            Eigenpairs pairs = coarsest_pairs(levels.back().problem, kept_);
            for (std::size_t l = levels.size(); --l > 0;) {
                const Eigenproblem& level = levels[l - 1].problem;
                RitzSpace space(level, options_.progress, "coarse level");
                ShiftInvert pencil(level);
                pencil.factor(choose_shift(pairs.values, wanted));
                X = levels[l].from_here * pairs.vectors;
                space.invert(pencil, X);
                space.start(std::move(X));
                space.converge(pencil, wanted, kept_, coarse_tolerance, 1);
                pairs = {space.values().head(kept_), space.lowest(kept_)};
                summary_.memory_bytes = std::max(summary_.memory_bytes, space.memory_bytes());
            }
            shift = choose_shift(pairs.values, wanted);
            X = levels[0].from_here * pairs.vectors;
        }
        return {shift, std::move(X)};
    }

    /// Converges, counts by inertia, and does more work until both agree.
    SpectralBand certified(Index wanted) {
        // Making a band of them moves vectors by rounding, which residuals show where cells are slivers.
        double tolerance = 0.9 * options_.tolerance;
        Index least = wanted;  // so many of the space's pairs lie below the upper end
        std::optional<SpectrumEnd> lower;
        BandCertificate trace;
        trace.shift = shift_;
        std::string shortage;
        bool more = false;
        for (trace.rounds = 1; trace.rounds <= 6; ++trace.rounds) {
            Index sought = 0;
            if (wanted > 0) {
                if (pencil_->shift() != shift_) inertia_at(shift_);
                const PhaseTimer timer(summary_.solve_seconds);
                if (more || least + 2 > space_.dimension()) widen(least, trace.rounds);
                if (least + 2 > space_.dimension()) break;
                more = true;
                sought = least;
                if (!top_) {
                    // Up to the widest of the next few gaps, and the value behind it.
                    const Index next = std::max<Index>(4, least / 16) << (trace.rounds - 1);
                    const Index most = std::min(least + next, space_.dimension() - 2);
                    sought = widest_gap(space_.values(), least, most) + 1;
                }
                const double residual = space_.converge(*pencil_, sought, kept_, tolerance, 40);
                trace.dimension = std::max(trace.dimension, space_.dimension());
                if (residual > tolerance) {
                    shortage = fmt::format("the largest residual is {:.1e}", residual);
                    continue;
                }
            }
            if (!lower) lower = lower_end(sought);
            SpectrumEnd upper;
            if (top_) {
                upper = *top_;
            } else {
                const Vector& values = space_.values();
                const Index last = widest_gap(values, least, sought - 1);
                const double end = 0.5 * (values[last - 1] + values[last]);
                if (!(values[last] - values[last - 1] > 1e-7 * std::abs(end))) {
                    shortage = fmt::format("more than {} eigenvalues are {:.9g}", sought - least, end);
                    least = sought;
                    more = false;
                    continue;
                }
                upper = inertia_at(end);
            }
            const Index expected = upper.below - lower->below;
            SpectralBand band = below(upper, *lower);
            BandCertificate& certificate = band.certificate;
            if (certificate.found > expected) {
                throw SolveError(
                    fmt::format("{} pairs were found below the eigenvalue {:.6g}, where there are {}",
                                certificate.found, upper.value, expected),
                    "this is a defect of beltrami; please report the mesh");
            }
            if (certificate.found < expected) {
                shortage = fmt::format("{} of {} pairs were found", certificate.found, expected);
                // Those behind the wanted ones may not have been good enough to be counted: once that is no failure.
                more = trace.rounds > 1;
                least = std::max(expected - zeros_, 1);
                // It may be that a value is still too far above a cutoff that is close behind it.
                if (top_) tolerance *= 0.01;
            } else if (certificate.max_residual > options_.tolerance) {
                shortage = fmt::format("the largest residual is {:.1e}", certificate.max_residual);
                tolerance *= 0.3;
                more = trace.rounds > 1;
            } else {
                certificate.shift = trace.shift;
                certificate.dimension = trace.dimension;
                certificate.rounds = trace.rounds;
                if (!top_) keep(band, std::min(certificate.found, options_.count));
                return band;
            }
        }
        throw SolveError(fmt::format("the lowest pairs could not be certified: {}", shortage),
                         "take --method bands, or allow larger residuals with --tolerance");
    }

    /// Below everything.
    SpectrumEnd lower_end(Index sought) {
        double scale = options_.cutoff * options_.cutoff;
        double first = 0.0;
        if (sought > 0) {
            first = space_.values()[0];
            scale = std::max(std::abs(first), 1e-3 * std::abs(space_.values()[sought - 1]));
        }
        SpectrumEnd end = inertia_at(std::min(first, 0.0) - 0.1 * scale);
        while (end.below > 0)
            end = inertia_at(10.0 * end.value);
        return end;
    }

    /// After a round that failed: a solve of all that is sought takes rounding away that large entries of K show, and
    /// random columns have a part of what is missing.
    void widen(Index least, int round) {
        kept_ = std::max(kept_, with_guard(least));
        Columns X = space_.lowest(kept_);
        space_.invert(*pencil_, X);
        space_.start(std::move(X));
        const Index room = problem_.rows() - zeros_ - space_.dimension();
        Columns more =
            random_columns(problem_.rows(), std::min(room, std::max<Index>(8, kept_ - space_.dimension())),
                           static_cast<std::uint32_t>(round));
        space_.invert(*pencil_, more);
        space_.invert(*pencil_, more);
        space_.add(std::move(more));
    }

    [[nodiscard]] SpectralBand below(const SpectrumEnd& upper, const SpectrumEnd& lower) {
        const auto found = static_cast<Index>((space_.values().array() < upper.value).count());
        const auto negative = static_cast<Index>((space_.values().head(found).array() < 0.0).count());
        Eigenpairs pairs{Vector(found + zeros_), Columns(problem_.rows(), found + zeros_)};
        pairs.values << space_.values().head(negative), Vector::Zero(zeros_),
            space_.values().segment(negative, found - negative);
        const Columns vectors = found > 0 ? space_.lowest(found) : Columns(problem_.rows(), 0);
        pairs.vectors << vectors.leftCols(negative), problem_.constants(),
            vectors.rightCols(found - negative);
        const double first = zeros_ < static_cast<Index>(pairs.values.size()) ? pairs.values[zeros_] : 0.0;
        summary_.memory_bytes = std::max(
            summary_.memory_bytes, problem_.memory_bytes() + pencil_->memory_bytes() + space_.memory_bytes() +
                                       4 * sizeof(double) * static_cast<std::size_t>(vectors.size()));
        return make_band(problem_, std::move(pairs), lower, upper, Columns(problem_.rows(), 0),
                         std::max(first, 1e-3 * upper.value));
    }

    const Eigenproblem& problem_;
    const SpectrumOptions& options_;
    SpectrumSummary& summary_;
    Index zeros_;
    RitzSpace space_;
    std::optional<ShiftInvert> pencil_;
    std::optional<SpectrumEnd> top_;  // where all pairs below a cutoff are asked for
    double shift_ = 0.0;
    Index kept_ = 0;  // that a restart leaves
};

void check(const Eigenproblem& problem, const SpectrumOptions& options) {
    if (options.hierarchy == nullptr) {
        throw InputError("the hierarchical method got no hierarchy",
                         "make one of the mesh's graph, or take another method");
    }
    if (options.hierarchy->size(0) != problem.vertex_count()) {
        throw InputError(fmt::format("a hierarchy of {} vertices for a mesh of {}",
                                     options.hierarchy->size(0), problem.vertex_count()),
                         "make it of this mesh's graph");
    }
    if (options.from > 0.0 || options.resume != nullptr) {
        throw InputError("the hierarchical method finds the lowest pairs at once",
                         "to start at a frequency or to go on with an earlier run, take the method bands");
    }
}

}  // namespace

void spectrum_hierarchically(const Eigenproblem& problem, const SpectrumOptions& options,
                             const BandSink& sink, SpectrumSummary& summary) {
    check(problem, options);
    const std::optional<SpectralBand> band = Hierarchical(problem, options, summary).run();
    if (!band) {
        summary.method = problem.rows() <= 2000 ? SpectrumMethod::full : SpectrumMethod::bands;
        summary.why =
            fmt::format("so many of {} pairs are too many for the hierarchical method", problem.rows());
        return summary.method == SpectrumMethod::full ? spectrum_in_full(problem, options, sink, summary)
                                                      : spectrum_by_bands(problem, options, sink, summary);
    }
    summary.bands.push_back(band->certificate);
    summary.count = static_cast<Index>(band->values.size());
    summary.complete = true;
    sink(*band);
}

}  // namespace beltrami
