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

// Costs in microseconds a vertex on one thread, from the measurements in docs/solvers.md: they decide which solver is expected
// to be done first, never what the answer is.
constexpr double cg_step = 0.03;
constexpr double size_of_measurement = 150e3;

// For operators with one and with two products with K.
struct Costs {
    double fill;    // entries of a factor, a vertex, at the size of the measurement
    double factor;  // the factor there, with the analysis
    double growth;  // by which power of n that grows
    double direct;  // a direct solve with its refinement
    double setup;   // of multigrid, with the hierarchy
    double cycle;   // an iteration with it
    double cycles_a_digit;
};
constexpr Costs first_order{40.0, 2.5, 0.25, 0.25, 1.3, 0.06, 2.4};
constexpr Costs second_order{200.0, 8.5, 0.5, 0.8, 4.0, 0.12, 11.5};

// Below this a factor is always as fast; above this many Green's functions take more room than a factor of K D K.
constexpr Index worth_multigrid = 30000;
constexpr std::size_t most_greens_functions = 60;
// Multigrid that has not converged by then is not going to.
constexpr int most_cycles = 400;
constexpr double multigrid_radius = 2.3;
// The part of the rows up to which it costs less to factor those that are held with the others than to analyse anew.
constexpr double most_held = 0.1;
// From so many solves on METIS's smaller factor is worth its longer search (K D K at a million vertices: 5 s against 0.08 s a
// solve; K: 6 s against 0.01).
constexpr int worth_metis = 100;

// A graph of a solid has about seven edges a vertex, one of a surface three.
bool is_solid(const EdgeGraph& graph) {
    return graph.edge_count() > 5.0 * graph.vertex_count();
}

// K D K without mass somewhere has lost an equation there.
bool has_mass_at_edges(const Laplacian& laplacian) {
    for (Index v = 0; v < laplacian.vertex_count(); ++v) {
        if (laplacian.mass()[v] <= 0.0 && laplacian.graph().degree(v) > 0) return false;
    }
    return true;
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

std::string_view name(SolverKind kind) {
    switch (kind) {
        case SolverKind::automatic:
            return "auto";
        case SolverKind::cg:
            return "cg";
        case SolverKind::multigrid:
            return "multigrid";
        case SolverKind::cholesky:
            return "cholesky";
        case SolverKind::green:
            return "green";
    }
    return "";
}

LinearSolver::LinearSolver(std::shared_ptr<const LinearOperator> A, LinearSolverOptions options)
    : A_(std::move(A)),
      product_(A_->product()),
      options_(std::move(options)),
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
    if (const auto* const A_pde = dynamic_cast<const PdeOperator*>(A_.get())) {
        const bool alone = A_pde->order() == 2 && A_pde->sigma() == 0.0 && A_pde->gamma()[0] == 0.0;
        if (alone) for_green_ = A_pde;
        const bool of_use =
            A_pde->order() == 1 || (A_pde->order() == 2 && has_mass_at_edges(A_pde->laplacian()));
        if (of_use && (options_.hierarchy || A_pde->laplacian().points())) for_multigrid_ = A_pde;
    }
    if (options_.norm == StoppingNorm::automatic) {
        options_.norm = A_->order() >= 2 ? StoppingNorm::energy_error : StoppingNorm::scaled_residual;
    }
}

LinearSolver::Choice LinearSolver::choose(const std::vector<Index>& held, Index columns) const {
    if (options_.kind != SolverKind::automatic) return {options_.kind, "asked for"};

    const auto unknowns = static_cast<Index>(A_->rows() - static_cast<Index>(held.size()));
    const double n = std::max<Index>(unknowns, 1);
    const bool bilaplacian = A_->order() >= 2;
    const bool solid = is_solid(A_->graph());
    const Costs& costs = bilaplacian ? second_order : first_order;
    const double solves = options_.expected_solves;

    // Entries of the factor: n log n on surfaces, n^(4/3) in solids (nested dissection).
    const double growth = std::log(std::max(n, 10.0)) / std::log(size_of_measurement);
    // Where a vertex has two numbers, an entry of the factor is a block of two by two.
    const double block = A_->rows() / std::max<double>(1.0, A_->graph().vertex_count());
    const double thicker = block * (solid ? std::max(1.0, 4.0 * std::cbrt(n / 1e4)) : growth);
    const double per_vertex = costs.fill * thicker;
    const double factor_bytes = 8.0 * n * per_vertex;
    const bool fits = factor_bytes < 0.5 * physical_memory();
    const double factor =
        costs.factor *
        (solid ? thicker * thicker : block * block * std::pow(n / size_of_measurement, costs.growth));
    const double direct = factor + solves * costs.direct * columns * thicker;

    // Three more columns cost as much as one alone.
    const double cycles = costs.cycles_a_digit * std::max(1.0, -std::log10(options_.tolerance));
    const double by_multigrid =
        costs.setup + solves * cycles * costs.cycle * (0.7 + 0.3 * columns) * (solid ? 2.0 : 1.0);
    const bool multigrid = (n > worth_multigrid || !fits) && for_multigrid_ != nullptr;

    // With P = diag(A): lambda_max(P^-1 A) is near 2, and the mass term alone bounds lambda_min from below.
    const double mass = A_->total_mass();
    const double smallest = mass / std::max(diagonal_.sum(), std::numeric_limits<double>::min());
    const double digits = std::log(2.0 / options_.tolerance);
    const double by_condition = 0.5 * std::sqrt(2.0 / std::max(smallest, 1e-30)) * digits;
    const double by_size = solid ? 2.0 * std::cbrt(n) * digits / 3.0 : 2.7 * std::sqrt(n) * digits / 19.0;
    const double iterations = std::min(by_condition, by_size);
    const double by_cg = bilaplacian ? std::numeric_limits<double>::infinity()
                                     : solves * iterations * cg_step * block * columns;

    const std::string no_room =
        fmt::format("a factor of {} unknowns would take about {:.0f} GB", unknowns, factor_bytes / 1e9);
    if (!fits && !multigrid) return {SolverKind::cg, no_room};
    const double by_factor = fits ? direct : std::numeric_limits<double>::infinity();
    if (by_cg < by_factor && (!multigrid || by_cg < by_multigrid)) {
        return {SolverKind::cg,
                fmt::format("about {:.0f} iterations for each of {} solves cost less than a factor",
                            std::ceil(iterations), options_.expected_solves)};
    }
    // Solves with K, one for each held vertex, and two with their refinement for each right-hand side.
    if (for_green_ != nullptr && held.size() <= most_greens_functions) {
        const double inner = static_cast<double>(held.size()) + 4.0 * solves * columns;
        const double by_green =
            std::min(first_order.factor * thicker + inner * first_order.direct * thicker,
                     first_order.setup + inner * 11.0 * first_order.cycles_a_digit * first_order.cycle);
        if (n > worth_multigrid && by_green < std::min(by_factor, multigrid ? by_multigrid : by_factor)) {
            return {SolverKind::green,
                    fmt::format("{} held vertices: solves with K alone cost less", held.size())};
        }
    }
    if (multigrid && by_multigrid < by_factor) {
        return {SolverKind::multigrid,
                fits ? fmt::format("{} solves with about {:.0f} cycles cost less than a factor",
                                   options_.expected_solves, std::ceil(cycles))
                     : no_room};
    }
    if (bilaplacian)
        return {SolverKind::cholesky,
                "conjugate gradients converge too slowly on K D K, and a factor costs least"};
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
    Choice choice = choose(masked, static_cast<Index>(b.cols()));
    if (failure_ && failure_->kind == choice.kind && failure_->held == masked)
        choice = {SolverKind::cholesky, failure_->what};
    const bool may_fall_back = options_.kind == SolverKind::automatic &&
                               (choice.kind == SolverKind::multigrid || choice.kind == SolverKind::green);
    LinearSummary summary;
    std::string failure;
    const Block start = may_fall_back ? x : Block();
    try {
        summary = solve_by(choice.kind, b, masked, x);
        if (summary.reason != StopReason::converged) failure = sentence(summary.reason);
    } catch (const SolveError& error) {
        if (!may_fall_back) throw;
        failure = error.what();
    }
    summary.why = choice.why;
    if (may_fall_back && !failure.empty()) {
        failure_ = {choice.kind, masked,
                    fmt::format("{} was tried first and failed: {}", name(choice.kind), failure)};
        multigrid_.reset();
        green_.reset();
        const LinearSummary tried = summary;
        x = start;
        summary = solve_by(SolverKind::cholesky, b, masked, x);
        summary.setup_seconds += tried.setup_seconds + tried.solve_seconds;
        summary.why = failure_->what;
    }
    summary.tolerance = options_.tolerance;
    summary.unknowns = unknowns;
    summary.columns = static_cast<Index>(b.cols());
    summary.converged = summary.reason == StopReason::converged;
    return summary;
}

LinearSummary LinearSolver::solve_by(SolverKind kind, const Block& b, const std::vector<Index>& held,
                                     Block& x) {
    switch (kind) {
        case SolverKind::cg:
            return solve_cg(b, held, x);
        case SolverKind::multigrid:
            return solve_multigrid(b, held, x);
        case SolverKind::green:
            return solve_green(b, held, x);
        default:
            return solve_cholesky(b, held, x);
    }
}

// The recurrence can fall below the true residual: starts again from x until they agree.
void LinearSolver::iterate(CgOptions options, const Block& b, const std::vector<Index>& held, Block& x,
                           LinearSummary& summary) const {
    options.tolerance = options_.tolerance;
    const bool preconditioned = static_cast<bool>(options.preconditioner);
    options.norm = preconditioned && options_.norm == StoppingNorm::energy_error ? StoppingNorm::refinement
                                                                                 : options_.norm;
    options.progress = options_.progress;
    summary.norm = options.norm;
    for (int start = 0; start < 3; ++start) {
        const CgResult result = conjugate_gradients(product_, inverse_diagonal_, held, b, x, options);
        options.max_iterations -= result.iterations;
        summary.iterations += result.iterations;
        summary.history.insert(summary.history.end(), result.history.begin(), result.history.end());
        summary.products += result.products;
        summary.memory_bytes = std::max(summary.memory_bytes, result.memory_bytes);
        summary.reason = result.reason;
        summary.error = result.error;
        summary.relative_residual = result.relative_residual;
        // Only residuals were computed afresh, and may say that it has not converged after all.
        const bool judged_afresh =
            options.norm == StoppingNorm::residual || options.norm == StoppingNorm::scaled_residual;
        if (result.reason != StopReason::converged || !judged_afresh ||
            result.error <= 2.0 * options_.tolerance) {
            break;
        }
        summary.reason = StopReason::stagnated;
    }
}

// A direct solve and its refinement: the first pass solves for the whole change from the start, each later one with the
// matrix-free residual. For K D K the residual says little, so there the size of the last refinement is the error.
template <class Solve>
void LinearSolver::refine(const Block& b, const std::vector<Index>& held, Block& x, LinearSummary& summary,
                          Solve solve) {
    const bool bilaplacian = A_->order() >= 2;
    summary.norm = bilaplacian ? StoppingNorm::refinement : StoppingNorm::scaled_residual;
    summary.reason = StopReason::converged;
    Block r;
    masked_residual(product_, held, b, x, r);
    ++summary.products;
    const auto zero = zero_start(product_, held, b, x);
    summary.products += zero ? 1 : 0;
    const Vector load = column_norms(zero ? zero->r : r, inverse_diagonal_);
    constexpr int most_passes = 8;
    double last = std::numeric_limits<double>::infinity();
    Block correction;
    for (int pass = 0; pass < most_passes; ++pass) {
        correction = Block::Zero(x.rows(), x.cols());
        solve(r, correction);
        x += correction;
        masked_residual(product_, held, b, x, r);
        ++summary.products;
        summary.relative_residual = worst_ratio(column_norms(r, inverse_diagonal_), load);
        const double change = pass == 0 ? 0.0
                                        : worst_ratio(correction.cwiseAbs().colwise().maxCoeff().transpose(),
                                                      x.cwiseAbs().colwise().maxCoeff().transpose());
        report(options_.progress, "refining", -1.0);
        summary.error = bilaplacian ? change : summary.relative_residual;
        if (pass > 0) summary.history.push_back(summary.error);
        const bool reached = bilaplacian ? pass > 0 && change <= options_.tolerance
                                         : summary.relative_residual <= options_.tolerance;
        summary.iterations += pass > 0 ? 1 : 0;
        if (reached) return;
        // Refinement that no longer halves the error has met the limit of double precision.
        const double now = bilaplacian && pass == 0 ? std::numeric_limits<double>::infinity() : summary.error;
        const bool slower = pass > 0 && !(now < 0.5 * last);
        if (slower || pass + 1 == most_passes) {
            summary.reason = StopReason::stagnated;
            return;
        }
        last = now;
    }
}

LinearSummary LinearSolver::solve_cg(const Block& b, const std::vector<Index>& held, Block& x) {
    const Stopwatch watch;
    LinearSummary summary;
    summary.solver = "cg";
    iterate({.max_iterations = options_.max_iterations}, b, held, x, summary);
    summary.solve_seconds = watch.seconds();
    return summary;
}

LinearSummary LinearSolver::solve_multigrid(const Block& b, const std::vector<Index>& held, Block& x) {
    const PdeOperator* const A = for_multigrid_;
    if (A == nullptr) {
        throw InputError("multigrid serves sigma M + gamma_1 K + gamma_2 K D K on meshes with positions only",
                         "use the solver auto");
    }
    const Stopwatch setup;
    LinearSummary summary;
    summary.solver = "multigrid";
    if (!options_.hierarchy) {
        options_.hierarchy = std::make_shared<const Hierarchy>(
            A->graph(), *A->laplacian().points(),
            HierarchyOptions{.radius = multigrid_radius, .progress = options_.progress});
    }
    if (!multigrid_ || multigrid_held_ != held) {
        multigrid_.reset();
        multigrid_.emplace(*A, *options_.hierarchy, held, options_.progress);
        multigrid_held_ = held;
        ++summary.factorizations;
    }
    summary.setup_seconds = setup.seconds();

    const Stopwatch watch;
    iterate({.max_iterations = std::min(most_cycles, options_.max_iterations),
             .preconditioner = multigrid_->preconditioner()},
            b, held, x, summary);
    summary.memory_bytes += multigrid_->memory_bytes() + options_.hierarchy->memory_bytes();
    summary.solve_seconds = watch.seconds();
    return summary;
}

LinearSummary LinearSolver::solve_green(const Block& b, const std::vector<Index>& held, Block& x) {
    const PdeOperator* const A = for_green_;
    if (A == nullptr) {
        throw InputError("Green's functions serve K D K alone, without K and without mass",
                         "use the solver auto");
    }
    const Stopwatch setup;
    LinearSummary summary;
    summary.solver = "green";
    if (!green_ || green_->held() != held) {
        green_.reset();
        green_ = std::make_unique<GreensFunctions>(
            A->laplacian(), held,
            LinearSolverOptions{.hierarchy = options_.hierarchy, .progress = options_.progress});
    }
    summary.setup_seconds = setup.seconds();

    const Stopwatch watch;
    refine(b, held, x, summary,
           [&](const Block& r, Block& correction) { green_->solve(A->gamma()[1], r, correction, summary); });
    summary.memory_bytes = green_->memory_bytes();
    summary.solve_seconds = watch.seconds();
    return summary;
}

Cholesky::Ordering LinearSolver::ordering() const {
    return options_.expected_solves >= worth_metis ? Cholesky::Ordering::metis : Cholesky::Ordering::amd;
}

void LinearSolver::analyse() {
    if (choose({}, 1).kind == SolverKind::cholesky) analyse_all_rows();
}

void LinearSolver::assemble() {
    if (matrix_.rows() == 0) matrix_ = A_->to_sparse();
}

void LinearSolver::analyse_all_rows() {
    assemble();
    if (!options_.analysis) options_.analysis = std::make_shared<const CholeskyAnalysis>(matrix_, ordering());
}

// Where few rows are held the factor is of all rows, with those that are held as in the identity: one analysis serves any
// set of them. Where many are, of the free rows alone.
void LinearSolver::factor(const std::vector<Index>& held) {
    if (static_cast<double>(held.size()) <= most_held * static_cast<double>(A_->rows())) {
        analyse_all_rows();
        if (factor_ && free_.empty()) {
            factor_->change_held(matrix_, held);
        } else {
            factor_.reset();
            factor_.emplace(matrix_, options_.analysis, held);
        }
        free_.clear();
        return;
    }
    assemble();
    factor_.reset();
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
    factor_.emplace(A_ff, ordering());
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
        const int before = factor_ && free_.empty() ? factor_->factorizations() : 0;
        factor(held);
        report(options_.progress, "factorizing", -1.0);
        summary.factorizations += factor_->factorizations() - (free_.empty() ? before : 0);
        factored_held_ = held;
    }
    summary.memory_bytes = factor_->memory_bytes();
    summary.setup_seconds = setup.seconds();

    const Stopwatch watch;
    Block r_free(static_cast<Eigen::Index>(free_.size()), b.cols());
    Block x_free;
    refine(b, held, x, summary, [&](const Block& r, Block& correction) {
        if (free_.empty()) {
            factor_->solve(r, correction);
            return;
        }
        for (std::size_t v = 0; v < free_.size(); ++v)
            r_free.row(static_cast<Eigen::Index>(v)) = r.row(free_[v]);
        factor_->solve(r_free, x_free);
        for (std::size_t v = 0; v < free_.size(); ++v)
            correction.row(free_[v]) = x_free.row(static_cast<Eigen::Index>(v));
    });
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
