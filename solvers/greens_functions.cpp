#include "beltrami/solvers/greens_functions.hpp"

#include <algorithm>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/linear_solver.hpp"

namespace beltrami {

GreensFunctions::GreensFunctions(const Laplacian& laplacian, std::vector<Index> held,
                                 const LinearSolverOptions& options)
    : laplacian_(laplacian), held_(std::move(held)) {
    const Index n = laplacian.vertex_count();
    Components components = connected_components(laplacian.graph());
    component_ = std::move(components.of_vertex);
    component_mass_ = Vector::Zero(components.count);
    for (Index v = 0; v < n; ++v)
        component_mass_[component_[static_cast<std::size_t>(v)]] += laplacian.mass()[v];

    std::vector<char> pinned(static_cast<std::size_t>(components.count), 0);
    for (const Index v : held_) {
        if (laplacian.graph().degree(v) == 0) continue;
        char& pin = pinned[static_cast<std::size_t>(component_[static_cast<std::size_t>(v)])];
        (pin == 0 ? pins_ : others_).push_back(v);
        pin = 1;
    }
    for (Index v = 0; v < n; ++v) {
        if (laplacian.graph().degree(v) > 0 &&
            pinned[static_cast<std::size_t>(component_[static_cast<std::size_t>(v)])] == 0) {
            throw SolveError("nothing holds a component of the mesh, so K D K is singular there",
                             "every component needs a constraint");
        }
    }
    LinearSolverOptions inner = options;
    inner.norm = StoppingNorm::scaled_residual;
    inner.tolerance = 1e-11;
    inner.expected_solves = static_cast<int>(others_.size()) + 4;
    stiffness_ = std::make_unique<LinearSolver>(PdeOperator(laplacian, 0.0, {1.0}), inner);

    const auto count = static_cast<Eigen::Index>(others_.size());
    functions_ = Block::Zero(n, count);
    constexpr Eigen::Index at_once = 16;
    for (Eigen::Index first = 0; first < count; first += at_once) {
        report(options.progress, "Green's functions",
               static_cast<double>(first) / static_cast<double>(count));
        const Eigen::Index columns = std::min(at_once, count - first);
        Block load = Block::Zero(n, columns);
        for (Eigen::Index c = 0; c < columns; ++c)
            load(others_[static_cast<std::size_t>(first + c)], c) = 1.0;
        Block x;
        solve_stiffness(load, x);
        functions_.middleCols(first, columns) = x;
    }
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
    constexpr Eigen::Index slice = 4096;
    for (Eigen::Index v = 0; v < n && count > 0; v += slice) {
        const auto rows = functions_.middleRows(v, std::min<Eigen::Index>(slice, n - v));
        matrix.noalias() += rows.transpose() * (laplacian.mass().segment(v, rows.rows()).asDiagonal() * rows);
    }
    coupling_.compute(matrix);
    if (count > 0 && coupling_.info() != Eigen::Success)
        throw SolveError("held vertices lie so close that their Green's functions cannot be told apart",
                         "use the solver cholesky or multigrid");
}
GreensFunctions::~GreensFunctions() = default;

// K x = load, with what is missing to a sum of zero on each component as load of its pin; no constants in x.
void GreensFunctions::solve_stiffness(const Block& load, Block& x) {
    Constraints pins(static_cast<Index>(load.cols()));
    const std::vector<double> zero(static_cast<std::size_t>(load.cols()), 0.0);
    for (const Index v : pins_)
        pins.fix(v, zero);
    x = Block::Zero(load.rows(), load.cols());
    const LinearSummary summary = stiffness_->solve(load, pins, x);
    // Short of the tolerance is as good as rounding allows: what uses this refines.
    if (!summary.converged && !(summary.relative_residual < 1e-6)) require_converged(summary);
    done_.add(summary);
    remove_constants(x);
}

void GreensFunctions::remove_constants(Block& x) const {
    Block sums = Block::Zero(component_mass_.size(), x.cols());
    for (Eigen::Index v = 0; v < x.rows(); ++v)
        sums.row(component_[static_cast<std::size_t>(v)]) += laplacian_.mass()[v] * x.row(v);
    for (Eigen::Index c = 0; c < sums.rows(); ++c)
        sums.row(c) *= component_mass_[c] > 0.0 ? 1.0 / component_mass_[c] : 0.0;
    for (Eigen::Index v = 0; v < x.rows(); ++v)
        x.row(v) -= sums.row(component_[static_cast<std::size_t>(v)]);
}

void GreensFunctions::solve(double gamma, const Block& b, Block& x, LinearSummary& summary) {
    Block load = b / gamma;
    for (const Index v : held_)
        load.row(v).setZero();
    Block v = Block::Zero(x.rows(), x.cols());
    if (load.cwiseAbs().maxCoeff() > 0.0) solve_stiffness(load, v);
    Block pin_values = Block::Zero(component_mass_.size(), x.cols());
    for (const Index pin : pins_)
        pin_values.row(component_[static_cast<std::size_t>(pin)]) = x.row(pin);

    if (!others_.empty()) {
        Block wanted(static_cast<Eigen::Index>(others_.size()), x.cols());
        for (std::size_t i = 0; i < others_.size(); ++i) {
            wanted.row(static_cast<Eigen::Index>(i)) =
                x.row(others_[i]) - pin_values.row(component_[static_cast<std::size_t>(others_[i])]);
        }
        wanted -= functions_.transpose() * (laplacian_.mass().asDiagonal() * v);
        v += functions_ * Block(coupling_.solve(wanted));
    }
    const Block kept = x(held_, Eigen::all);
    Block u;
    solve_stiffness(laplacian_.mass().asDiagonal() * v, u);
    // The constants that solve_stiffness() took away come back with the pins' values.
    Block shift = pin_values;
    for (const Index pin : pins_)
        shift.row(component_[static_cast<std::size_t>(pin)]) -= u.row(pin);
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
        if (laplacian_.graph().degree(static_cast<Index>(i)) > 0)
            x.row(i) = u.row(i) + shift.row(component_[static_cast<std::size_t>(i)]);
    }
    x(held_, Eigen::all) = kept;
    summary.iterations += done_.iterations;
    summary.products += done_.products;
    summary.factorizations += done_.factorizations;
    done_ = {};
}

std::size_t GreensFunctions::memory_bytes() const {
    return sizeof(double) * static_cast<std::size_t>(functions_.size() + coupling_.matrixLLT().size());
}

}  // namespace beltrami
