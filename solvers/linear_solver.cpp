#include "beltrami/solvers/linear_solver.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/stopwatch.hpp"

namespace beltrami {

namespace {

double physical_memory() {
    return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
}

// Costs in microseconds a vertex, from the measurements in docs/solvers.md: they decide which solver is expected to be
// done first, never what the answer is.
constexpr double cg_step = 0.03;
constexpr double factor_surface = 6.0;  // K at 150 K vertices; grows as n^0.3
constexpr double direct_solve = 0.25;
constexpr double size_of_measurement = 150e3;

// The number of entries of a factor, a vertex, at that size: 40 for K, 200 for K D K on surfaces.
constexpr double fill_surface = 40.0;
constexpr double fill_bilaplacian = 200.0;

// A graph of a solid has about seven edges a vertex, one of a surface three.
bool is_solid(const EdgeGraph& graph) {
    return graph.edge_count() > 5.0 * graph.vertex_count();
}

}  // namespace

void LinearSolverOptions::check() const {
    if (!(tolerance > 0.0) || !std::isfinite(tolerance)) {
        throw InputError(fmt::format("the tolerance is {}", tolerance),
                         "give a small positive number, such as 1e-10");
    }
    if (norm == StoppingNorm::refinement) {
        throw InputError("a solve cannot be asked to stop on its refinement",
                         "use automatic, which does so where it can");
    }
    if (max_iterations < 1 || expected_solves < 1) {
        throw InputError("the limit of iterations or the expected number of solves is less than 1",
                         "allow at least one");
    }
}

LinearSolver::LinearSolver(std::shared_ptr<const LinearOperator> A, LinearSolverOptions options)
    : A_(std::move(A)),
      product_(A_->product()),
      options_(options),
      diagonal_(A_->diagonal()),
      inverse_diagonal_(Vector::Ones(A_->rows())) {
    options_.check();
    for (Index i = 0; i < A_->rows(); ++i) {
        if (!std::isfinite(diagonal_[i]) || diagonal_[i] < 0.0) {
            throw SolveError(
                fmt::format("the operator has {} on its diagonal", diagonal_[i]),
                "the mesh's coordinates are too large or too small, or its cells too thin: rescale it");
        }
        if (diagonal_[i] == 0.0) {
            empty_rows_.push_back(i);
        } else {
            inverse_diagonal_[i] = 1.0 / diagonal_[i];
        }
    }
    if (options_.norm == StoppingNorm::automatic) {
        options_.norm = A_->order() >= 2 ? StoppingNorm::energy_error : StoppingNorm::scaled_residual;
    }
}

LinearSolver::Choice LinearSolver::choose(Index unknowns, Index columns) const {
    if (options_.kind == SolverKind::cg) return {SolverKind::cg, "asked for"};
    if (options_.kind == SolverKind::cholesky) return {SolverKind::cholesky, "asked for"};

    const double n = std::max<Index>(unknowns, 1);
    const bool bilaplacian = A_->order() >= 2;
    const bool solid = is_solid(A_->graph());

    // Entries of the factor: n log n on surfaces, n^(4/3) in solids (nested dissection).
    const double growth = std::log(std::max(n, 10.0)) / std::log(size_of_measurement);
    // Where a vertex has two numbers, an entry of the factor is a block of two by two.
    const double block = A_->rows() / std::max<double>(1.0, A_->graph().vertex_count());
    const double per_vertex = block * (bilaplacian ? fill_bilaplacian : fill_surface) *
                              (solid ? std::max(1.0, 4.0 * std::cbrt(n / 1e4)) : growth);
    const double factor_bytes = 8.0 * n * per_vertex;
    if (factor_bytes > 0.5 * physical_memory()) {
        return {SolverKind::cg, fmt::format("a factor of {} unknowns would take about {:.0f} GB", unknowns,
                                            factor_bytes / 1e9)};
    }
    if (bilaplacian) {
        return {SolverKind::cholesky, "conjugate gradients converge too slowly on K D K"};
    }

    // With P = diag(A): lambda_max(P^-1 A) is near 2, and the mass term alone bounds lambda_min from below.
    const double mass = A_->total_mass();
    const double smallest = mass / std::max(diagonal_.sum(), std::numeric_limits<double>::min());
    const double digits = std::log(2.0 / options_.tolerance);
    const double by_condition = 0.5 * std::sqrt(2.0 / std::max(smallest, 1e-30)) * digits;
    const double by_size = solid ? 2.0 * std::cbrt(n) * digits / 3.0 : 2.7 * std::sqrt(n) * digits / 19.0;
    const double iterations = std::min(by_condition, by_size);

    const double solves = options_.expected_solves;
    const double cg = solves * iterations * cg_step * block * columns;
    const double factor = factor_surface * (solid ? per_vertex * per_vertex / (fill_surface * fill_surface)
                                                  : block * block * std::pow(n / size_of_measurement, 0.3));
    const double direct =
        factor + solves * direct_solve * columns * (solid ? per_vertex / fill_surface : block);
    if (cg < direct) {
        return {SolverKind::cg,
                fmt::format("about {:.0f} iterations for each of {} solves cost less than a factor",
                            std::ceil(iterations), options_.expected_solves)};
    }
    return {SolverKind::cholesky, fmt::format("a factor costs less than {} solves of about {:.0f} iterations",
                                              options_.expected_solves, std::ceil(iterations))};
}

LinearSummary LinearSolver::solve(const Block& b, const Constraints& held, Block& x) {
    if (b.rows() != A_->rows() || x.rows() != A_->rows() || x.cols() != b.cols()) {
        throw InputError(fmt::format("a solve of {} vertices got b of {} x {} and x of {} x {}", A_->rows(),
                                     b.rows(), b.cols(), x.rows(), x.cols()),
                         "give both one row a vertex and the same columns");
    }
    if (!held.empty() && held.columns() != b.cols()) {
        throw InputError(
            fmt::format("constraints of {} columns for a right-hand side of {}", held.columns(), b.cols()),
            "make both of the same width");
    }
    held.check_range(A_->rows());
    held.impose(x);
    if (!b.allFinite() || !x.allFinite()) {
        throw InputError("the load or the start of a solve has a number that is not finite",
                         "look for NaN and infinity in the values given");
    }
    std::vector<Index> masked = held.vertices();
    for (const Index v : empty_rows_) {
        if (!held.is_fixed(v)) masked.push_back(v);
    }
    std::sort(masked.begin(), masked.end());

    const auto unknowns = static_cast<Index>(A_->rows() - static_cast<Index>(masked.size()));
    const Choice choice = choose(unknowns, static_cast<Index>(b.cols()));
    LinearSummary summary =
        choice.kind == SolverKind::cg ? solve_cg(b, masked, x) : solve_cholesky(b, masked, x);
    summary.why = choice.why;
    summary.tolerance = options_.tolerance;
    summary.unknowns = unknowns;
    summary.columns = static_cast<Index>(b.cols());
    summary.converged = summary.reason == StopReason::converged;
    return summary;
}

LinearSummary LinearSolver::solve_cg(const Block& b, const std::vector<Index>& held, Block& x) {
    const Stopwatch watch;
    CgOptions options;
    options.tolerance = options_.tolerance;
    options.norm = options_.norm;
    options.max_iterations = options_.max_iterations;
    options.progress = options_.progress;

    LinearSummary summary;
    summary.solver = "cg";
    summary.norm = options_.norm;
    // The recurrence can fall below the true residual: start again from x until they agree.
    for (int start = 0; start < 3; ++start) {
        const CgResult result = conjugate_gradients(product_, inverse_diagonal_, held, b, x, options);
        options.max_iterations -= result.iterations;
        summary.iterations += result.iterations;
        summary.products += result.products;
        summary.memory_bytes = result.memory_bytes;
        summary.reason = result.reason;
        summary.error = result.error;
        summary.relative_residual = result.relative_residual;
        if (result.reason != StopReason::converged || options_.norm == StoppingNorm::energy_error ||
            result.error <= 2.0 * options_.tolerance) {
            break;
        }
        summary.reason = StopReason::stagnated;
    }
    summary.solve_seconds = watch.seconds();
    return summary;
}

void LinearSolver::factor(const std::vector<Index>& held) {
    factor_.reset();
    if (matrix_.rows() == 0) matrix_ = A_->to_sparse();
    std::vector<Index> row_of_vertex(static_cast<std::size_t>(A_->rows()), 0);
    for (const Index v : held)
        row_of_vertex[static_cast<std::size_t>(v)] = -1;
    free_.clear();
    for (Index v = 0; v < A_->rows(); ++v) {
        Index& row = row_of_vertex[static_cast<std::size_t>(v)];
        if (row < 0) continue;
        row = static_cast<Index>(free_.size());
        free_.push_back(v);
    }
    const auto n = static_cast<Eigen::Index>(free_.size());
    Eigen::SparseMatrix<double> A_ff(n, n);
    A_ff.reserve(matrix_.nonZeros());
    for (Eigen::Index column = 0; column < n; ++column) {
        A_ff.startVec(column);
        const Index vertex = free_[static_cast<std::size_t>(column)];
        for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix_, vertex); entry; ++entry) {
            const Index row = row_of_vertex[static_cast<std::size_t>(entry.row())];
            if (row >= 0 && row <= column) A_ff.insertBack(row, column) = entry.value();
        }
    }
    A_ff.finalize();
    factor_.emplace(A_ff,
                    options_.expected_solves >= 3 ? Cholesky::Ordering::metis : Cholesky::Ordering::amd);
    factored_held_ = held;
}

LinearSummary LinearSolver::solve_cholesky(const Block& b, const std::vector<Index>& held, Block& x) {
    LinearSummary summary;
    summary.solver = "cholesky";
    summary.norm = A_->order() >= 2 ? StoppingNorm::refinement : StoppingNorm::scaled_residual;
    summary.reason = StopReason::converged;
    if (static_cast<Index>(held.size()) == A_->rows() || b.cols() == 0) return summary;

    const Stopwatch setup;
    if (!factor_ || factored_held_ != held) {
        report(options_.progress, "factorizing", -1.0);
        factor(held);
        report(options_.progress, "factorizing", -1.0);
        ++summary.factorizations;
    }
    summary.memory_bytes = factor_->memory_bytes();
    summary.setup_seconds = setup.seconds();

    const Stopwatch watch;
    const auto n = static_cast<Eigen::Index>(free_.size());
    Block r;
    Block r_free(n, b.cols());
    Block correction;
    // The first pass solves for the whole change from the start; each later one refines with the matrix-free residual.
    // For K D K the residual says little, so there the size of the last refinement is the error.
    masked_residual(product_, held, b, x, r);
    ++summary.products;
    const auto zero = zero_start(product_, held, b, x);
    summary.products += zero ? 1 : 0;
    const Vector load = column_norms(zero ? zero->r : r, inverse_diagonal_);
    const bool bilaplacian = A_->order() >= 2;
    constexpr int most_passes = 8;
    double last = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < most_passes; ++pass) {
        for (Eigen::Index v = 0; v < n; ++v)
            r_free.row(v) = r.row(free_[static_cast<std::size_t>(v)]);
        factor_->solve(r_free, correction);
        for (Eigen::Index v = 0; v < n; ++v)
            x.row(free_[static_cast<std::size_t>(v)]) += correction.row(v);
        masked_residual(product_, held, b, x, r);
        ++summary.products;
        summary.relative_residual = worst_ratio(column_norms(r, inverse_diagonal_), load);
        const double change = pass == 0 ? 0.0
                                        : worst_ratio(correction.cwiseAbs().colwise().maxCoeff().transpose(),
                                                      x.cwiseAbs().colwise().maxCoeff().transpose());
        report(options_.progress, "refining", -1.0);
        summary.error = bilaplacian ? change : summary.relative_residual;
        summary.iterations = pass;
        const bool reached = bilaplacian ? pass > 0 && change <= options_.tolerance
                                         : summary.relative_residual <= options_.tolerance;
        if (reached) break;
        // Refinement that no longer halves the error has met the limit of double precision.
        const double now = bilaplacian && pass == 0 ? std::numeric_limits<double>::infinity() : summary.error;
        const bool slower = pass > 0 && !(now < 0.5 * last);
        if (slower || pass + 1 == most_passes) {
            summary.reason = StopReason::stagnated;
            break;
        }
        last = now;
    }
    summary.solve_seconds = watch.seconds();
    return summary;
}

void LinearSolver::reaction(const Block& b, const Block& x, const Constraints& held, Block& f) const {
    Block residual;
    A_->apply(x, residual);
    residual -= b;
    f = Block::Zero(x.rows(), x.cols());
    for (const Index v : held.vertices())
        f.row(v) = residual.row(v);
}

}  // namespace beltrami
