#include "beltrami/solvers/conjugate_gradients.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace beltrami {

namespace {

// Sums over rows are taken in slices of this many, so that they do not depend on the number of threads.
constexpr Eigen::Index slice = 1 << 13;

// Steps with a preconditioner that do not lower the error by a fifth, after which none will.
constexpr int most_without_gain = 50;

// sum over i of term(i, c) for each column c, and of `other` in the same pass.
template <class Term, class Other>
std::pair<Vector, Vector> column_sums(Eigen::Index n, Eigen::Index k, Term term, Other other) {
    const Eigen::Index slices = (n + slice - 1) / slice;
    Block partial = Block::Zero(slices, 2 * k);
#pragma omp parallel for schedule(static) if (n * k > 30000)
    for (Eigen::Index s = 0; s < slices; ++s) {
        double* const sums = partial.data() + s * 2 * k;
        const Eigen::Index end = std::min(n, (s + 1) * slice);
        if (k == 1) {
            double sum = 0.0;
            double other_sum = 0.0;
#pragma omp simd reduction(+ : sum, other_sum)
            for (Eigen::Index i = s * slice; i < end; ++i) {
                sum += term(i, i);
                other_sum += other(i, i);
            }
            sums[0] = sum;
            sums[1] = other_sum;
        } else {
            for (Eigen::Index i = s * slice; i < end; ++i) {
                for (Eigen::Index c = 0; c < k; ++c) {
                    sums[c] += term(i, i * k + c);
                    sums[k + c] += other(i, i * k + c);
                }
            }
        }
    }
    const Vector all = partial.colwise().sum().transpose();
    return {all.head(k), all.tail(k)};
}
template <class Term>
Vector column_sums(Eigen::Index n, Eigen::Index k, Term term) {
    return column_sums(n, k, term, [](Eigen::Index, Eigen::Index) { return 0.0; }).first;
}

// f(flat index, column) for every number of an n x k block.
template <class Function>
void for_each_number(Eigen::Index n, Eigen::Index k, Function f) {
#pragma omp parallel for schedule(static) if (n * k > 30000)
    for (Eigen::Index i = 0; i < n; ++i) {
        for (Eigen::Index c = 0; c < k; ++c)
            f(i * k + c, c);
    }
}

void clear_rows(std::span<const Index> rows, Block& block) {
    for (const Index i : rows)
        block.row(i).setZero();
}

// The error in the energy norm, from the terms by which each step lowers its square: the sum of the next `delay` terms
// bounds it from below, closely once convergence is steady (Hestenes & Stiefel 1952; Strakos & Tichy 2002).
class EnergyError {
  public:
    // All terms add up to |x* - x_0|^2; `beyond` is what is missing to the square of the solution itself.
    void start(double beyond) { total_ = beyond; }
    void step(double term) {
        recent_.push_back(term);
        total_ += term;
        if (recent_.size() > delay) recent_.pop_front();
    }
    [[nodiscard]] double relative() const {
        if (recent_.size() < delay) return std::numeric_limits<double>::max();
        // Summed afresh: a running sum would keep the rounding of terms that were larger by many orders.
        const double recent = std::accumulate(recent_.begin(), recent_.end(), 0.0);
        if (recent == 0.0) return 0.0;
        return total_ > 0.0 ? std::sqrt(recent / total_) : std::numeric_limits<double>::max();
    }

  private:
    static constexpr std::size_t delay = 20;
    std::deque<double> recent_;
    double total_ = 0.0;
};

// The smallest Ritz value of B A, from the step lengths: the tridiagonal matrix of Lanczos' iteration that conjugate
// gradients run without saying so (Golub & Van Loan 2013, section 11.3).
class RitzValues {
  public:
    void step(double alpha, double beta) {
        diagonal_.push_back(1.0 / alpha + from_before_);
        from_before_ = beta / alpha;
        off_diagonal_.push_back(std::sqrt(beta) / alpha);
    }
    [[nodiscard]] double smallest() const {
        const auto n = static_cast<Eigen::Index>(diagonal_.size());
        if (n == 0) return unknown;
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
        eigen.computeFromTridiagonal(Eigen::Map<const Vector>(diagonal_.data(), n),
                                     Eigen::Map<const Vector>(off_diagonal_.data(), n - 1),
                                     Eigen::EigenvaluesOnly);
        return std::max(eigen.eigenvalues().minCoeff(), std::numeric_limits<double>::min());
    }

  private:
    // What multigrid on K D K comes to on meshes with some slivers.
    static constexpr double unknown = 0.02;
    std::vector<double> diagonal_;
    std::vector<double> off_diagonal_;
    double from_before_ = 0.0;
};

}  // namespace

void masked_residual(const Product& apply, std::span<const Index> held, const Block& b, const Block& x,
                     Block& r) {
    apply(x, r);
    r = b - r;
    clear_rows(held, r);
}

std::optional<ZeroStart> zero_start(const Product& apply, std::span<const Index> held, const Block& b,
                                    const Block& x) {
    ZeroStart zero{Block::Zero(x.rows(), x.cols()), {}};
    for (const Index i : held)
        zero.x.row(i) = x.row(i);
    if (zero.x == x) return std::nullopt;
    masked_residual(apply, held, b, zero.x, zero.r);
    return zero;
}

Vector column_norms(const Block& r, const Vector& weight) {
    const double* const values = r.data();
    return column_sums(r.rows(), r.cols(),
                       [&](Eigen::Index i, Eigen::Index at) { return weight[i] * values[at] * values[at]; })
        .cwiseSqrt();
}

double worst_ratio(const Vector& norms, const Vector& loads) {
    double worst = 0.0;
    for (Eigen::Index c = 0; c < norms.size(); ++c) {
        // Written so that NaN is the worst of all.
        if (loads[c] > 0.0 && !(norms[c] / loads[c] <= worst)) worst = norms[c] / loads[c];
    }
    return std::isnan(worst) ? std::numeric_limits<double>::infinity() : worst;
}

CgResult conjugate_gradients(const Product& apply, const Vector& inverse_diagonal,
                             std::span<const Index> held, const Block& b, Block& x,
                             const CgOptions& options) {
    const Eigen::Index n = b.rows();
    const Eigen::Index k = b.cols();
    CgResult result;
    result.memory_bytes = 4 * sizeof(double) * static_cast<std::size_t>(n * k);

    const Vector ones = Vector::Ones(n);
    const bool energy = options.norm == StoppingNorm::energy_error;
    const bool refinement = options.norm == StoppingNorm::refinement && options.preconditioner;
    const Vector& weight = options.norm == StoppingNorm::residual ? ones : inverse_diagonal;

    Block r(n, k);
    Block q(n, k);
    masked_residual(apply, held, b, x, r);
    ++result.products;

    // Everything is measured against the load with the free values at zero.
    Vector load = column_norms(r, weight);
    Vector scaled_load = column_norms(r, inverse_diagonal);
    std::vector<EnergyError> energy_errors(static_cast<std::size_t>(k));
    std::vector<RitzValues> ritz_values(static_cast<std::size_t>(k));
    Vector smallest_ritz = Vector::Ones(k);
    if (const auto zero = zero_start(apply, held, b, x)) {
        ++result.products;
        load = column_norms(zero->r, weight);
        scaled_load = column_norms(zero->r, inverse_diagonal);
        // |x* - s|^2 = |x* - x|^2 + (x - s)^T (r_s + r) with s the start at zero and r_s its residual.
        for (Eigen::Index c = 0; c < k; ++c) {
            const double beyond = (x.col(c) - zero->x.col(c)).dot(zero->r.col(c) + r.col(c));
            energy_errors[static_cast<std::size_t>(c)].start(beyond);
            // Nothing pulls: the answer is zero, wherever the start was.
            if (load[c] == 0.0) {
                x.col(c) = zero->x.col(c);
                r.col(c).setZero();
            }
        }
    }

    Block p(n, k);
    double* const rs = r.data();
    double* const ps = p.data();
    double* const qs = q.data();
    double* const xs = x.data();
    const double* const P = inverse_diagonal.data();
    Block z = options.preconditioner ? Block(n, k) : Block();
    const double* zs = z.data();
    // z = B r; r^T B r, and with a preconditioner z^T q.
    const auto precondition = [&]() -> std::pair<Vector, Vector> {
        if (!options.preconditioner) {
            return {
                column_sums(n, k, [&](Eigen::Index i, Eigen::Index at) { return P[i] * rs[at] * rs[at]; }),
                {}};
        }
        options.preconditioner(r, z);
        zs = z.data();
        return column_sums(
            n, k, [&](Eigen::Index, Eigen::Index at) { return rs[at] * zs[at]; },
            [&](Eigen::Index, Eigen::Index at) { return zs[at] * qs[at]; });
    };

    const auto preconditioned = [&](Eigen::Index i, Eigen::Index at) {
        return zs != nullptr ? zs[at] : P[i] * rs[at];
    };

    q.setZero();
    Vector rz = precondition().first;
    Vector alpha(k);
    Vector beta(k);
    std::vector<char> done(static_cast<std::size_t>(k), 0);
    Vector errors = Vector::Zero(k);
    const auto check = [&](bool first) {
        const bool as_rz = options.norm != StoppingNorm::residual && !options.preconditioner;
        Vector norms(k);
        if (refinement) {
            norms = z.cwiseAbs().colwise().maxCoeff().transpose().cwiseQuotient(
                x.cwiseAbs().colwise().maxCoeff().transpose());
        } else if (!energy) {
            norms = as_rz ? Vector(rz.cwiseSqrt()) : column_norms(r, weight);
        }
        bool all = true;
        for (Eigen::Index c = 0; c < k; ++c) {
            if (done[static_cast<std::size_t>(c)] != 0) continue;
            if (load[c] == 0.0 || rz[c] == 0.0) {
                errors[c] = 0.0;
            } else if (refinement) {
                if (norms[c] <= options.tolerance || result.iterations % 10 == 0)
                    smallest_ritz[c] = std::min(1.0, ritz_values[static_cast<std::size_t>(c)].smallest());
                errors[c] = norms[c] / smallest_ritz[c];
            } else if (energy) {
                // At the start nothing is known of the energy error but that a residual at rounding ends it.
                errors[c] = first ? std::numeric_limits<double>::max()
                                  : energy_errors[static_cast<std::size_t>(c)].relative();
                if (std::sqrt(rz[c]) <= 1e-15 * load[c]) errors[c] = std::min(errors[c], 1e-15);
            } else {
                errors[c] = norms[c] / load[c];
            }
            done[static_cast<std::size_t>(c)] = errors[c] <= options.tolerance ? 1 : 0;
            all = all && done[static_cast<std::size_t>(c)] != 0;
        }
        return all;
    };

    bool all_done = check(true);
    if (!all_done) {
#pragma omp parallel for schedule(static) if (n * k > 30000)
        for (Eigen::Index i = 0; i < n; ++i) {
            for (Eigen::Index c = 0; c < k; ++c)
                ps[i * k + c] = preconditioned(i, i * k + c);
        }
    }
    bool indefinite = false;
    // Where rounding, or a preconditioner in floats, keeps the error from falling.
    double best = std::numeric_limits<double>::infinity();
    int since_best = 0;
    while (!all_done && !indefinite && since_best < most_without_gain &&
           result.iterations < options.max_iterations) {
        report(options.progress, "conjugate gradients", -1.0);
        apply(p, q);
        ++result.products;
        ++result.iterations;
        clear_rows(held, q);
        const Vector pq = column_sums(n, k, [&](Eigen::Index, Eigen::Index at) { return ps[at] * qs[at]; });
        for (Eigen::Index c = 0; c < k; ++c) {
            const bool stopped = done[static_cast<std::size_t>(c)] != 0;
            // Written so that NaN counts as indefinite.
            if (!stopped && !(pq[c] > 0.0)) indefinite = true;
            alpha[c] = stopped || indefinite ? 0.0 : rz[c] / pq[c];
            if (!stopped && !indefinite) energy_errors[static_cast<std::size_t>(c)].step(alpha[c] * rz[c]);
        }
        if (indefinite) break;
        for_each_number(n, k, [&](Eigen::Index at, Eigen::Index c) {
            xs[at] += alpha[c] * ps[at];
            rs[at] -= alpha[c] * qs[at];
        });
        const auto [next, zq] = precondition();
        for (Eigen::Index c = 0; c < k; ++c)
            beta[c] = done[static_cast<std::size_t>(c)] != 0 || rz[c] == 0.0 ? 0.0 : next[c] / rz[c];
        if (options.preconditioner) {
            // z^T (r - r_before) / (r^T z)_before: r - r_before = -alpha q.
            for (Eigen::Index c = 0; c < k; ++c)
                beta[c] = beta[c] == 0.0 ? 0.0 : std::max(0.0, -alpha[c] * zq[c] / rz[c]);
        }
        for (Eigen::Index c = 0; c < k; ++c) {
            if (refinement && alpha[c] > 0.0)
                ritz_values[static_cast<std::size_t>(c)].step(alpha[c], beta[c]);
        }
        rz = next;
        all_done = check(false);
        const double monitored = errors.maxCoeff();
        const bool estimated = monitored < std::numeric_limits<double>::max();
        result.history.push_back(estimated ? monitored : std::numeric_limits<double>::quiet_NaN());
        if (all_done) break;
        if (options.preconditioner) {
            // Without the Ritz values, which fall while they converge.
            const double worst =
                (refinement ? Vector(errors.cwiseProduct(smallest_ritz)) : errors).maxCoeff();
            const bool gained = worst < 0.8 * best;
            best = gained ? worst : best;
            since_best = gained ? 0 : since_best + 1;
        }
#pragma omp parallel for schedule(static) if (n * k > 30000)
        for (Eigen::Index i = 0; i < n; ++i) {
            for (Eigen::Index c = 0; c < k; ++c)
                ps[i * k + c] = preconditioned(i, i * k + c) + beta[c] * ps[i * k + c];
        }
    }

    // The recurrence drifts from the true residual: report what x really is.
    masked_residual(apply, held, b, x, r);
    ++result.products;
    result.relative_residual = worst_ratio(column_norms(r, inverse_diagonal), scaled_load);
    result.error = errors.size() > 0 ? errors.maxCoeff() : 0.0;
    if (!energy && !refinement) result.error = worst_ratio(column_norms(r, weight), load);
    if (indefinite || !std::isfinite(result.relative_residual)) {
        result.reason = StopReason::not_definite;
    } else if (!all_done) {
        result.reason = since_best < most_without_gain ? StopReason::iteration_limit : StopReason::stagnated;
    } else {
        result.reason = StopReason::converged;
    }
    return result;
}

}  // namespace beltrami
