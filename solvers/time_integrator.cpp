#include "beltrami/solvers/time_integrator.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

void require_not_negative(double value, const char* what) {
    if (!std::isfinite(value) || value < 0.0) {
        throw InputError(fmt::format("{} is {}", what, value),
                         "give a number that is finite and not negative");
    }
}

}  // namespace

std::string_view name(TimeMethod method) {
    switch (method) {
        case TimeMethod::backward_euler:
            return "backward-euler";
        case TimeMethod::implicit_midpoint:
            return "midpoint";
        case TimeMethod::bdf2:
            return "bdf2";
    }
    return "";
}

void Pde::check() const {
    require_not_negative(alpha, "the coefficient alpha");
    require_not_negative(beta_1, "the damping beta_1");
    require_not_negative(beta_2, "the damping beta_2");
    require_not_negative(foundation, "the foundation gamma_0");
    for (const double g : gamma)
        require_not_negative(g, "a coefficient gamma");
    if (alpha == 0.0 && beta_1 == 0.0) {
        throw InputError("the PDE has no time derivative: alpha and beta_1 are both 0",
                         "set beta_1 = 1 for heat, alpha = 1 for waves");
    }
}

TimeIntegrator::TimeIntegrator(const Laplacian& laplacian, Pde pde, TimeOptions options)
    : laplacian_(laplacian),
      pde_(std::move(pde)),
      options_(std::move(options)),
      stiffness_((pde_.check(), laplacian), pde_.foundation, pde_.gamma) {
    if (!std::isfinite(options_.step) || options_.step <= 0.0) {
        throw InputError(fmt::format("the time step is {}", options_.step), "give a positive number");
    }
    if (options_.steps < 1)
        throw InputError(fmt::format("{} time steps", options_.steps), "take at least one");
    options_.linear.expected_solves = options_.steps;
    switch (options_.method) {
        case TimeMethod::backward_euler:
            main_ = make_solver({1.0, 1.0});
            break;
        case TimeMethod::implicit_midpoint:
            main_ = make_solver({2.0, 0.5});
            break;
        case TimeMethod::bdf2:
            options_.linear.expected_solves = 1;
            start_ = make_solver({1.0, 1.0});
            options_.linear.expected_solves = options_.steps;
            break;
    }
    for (Index i = 0; i < laplacian_.vertex_count(); ++i) {
        if (laplacian_.mass()[i] == 0.0) isolated_.push_back(i);
    }
    set_state(Block::Zero(laplacian_.vertex_count(), 1));
}

std::unique_ptr<LinearSolver> TimeIntegrator::make_solver(Weights weights) const {
    const double dt = options_.step;
    const double stiff = pde_.beta_2 + weights.c_k * dt;
    const double sigma = weights.c_m * pde_.alpha / dt + pde_.beta_1 + stiff * pde_.foundation;
    std::vector<double> gamma = pde_.gamma;
    for (double& g : gamma)
        g *= stiff;
    return std::make_unique<LinearSolver>(PdeOperator(laplacian_, sigma, std::move(gamma)), options_.linear);
}

void TimeIntegrator::set_state(Block u, Block v) {
    const Index n = laplacian_.vertex_count();
    if (u.rows() != n || v.rows() != n || u.cols() != v.cols()) {
        throw InputError(fmt::format("a state of {} x {} and {} x {} for {} vertices", u.rows(), u.cols(),
                                     v.rows(), v.cols(), n),
                         "give u and v one row a vertex and the same columns");
    }
    u_ = std::move(u);
    v_ = std::move(v);
    for (const Index i : isolated_)
        v_.row(i).setZero();
    reaction_ = Block::Zero(u_.rows(), u_.cols());
    step_count_ = 0;
}

void TimeIntegrator::set_state(Block u) {
    Block v = Block::Zero(u.rows(), u.cols());
    set_state(std::move(u), std::move(v));
}

void TimeIntegrator::advance(const Constraints& held, const Block* f) {
    if (f != nullptr && (f->rows() != u_.rows() || f->cols() != u_.cols())) {
        throw InputError(fmt::format("a load of {} x {} for a state of {} x {}", f->rows(), f->cols(),
                                     u_.rows(), u_.cols()),
                         "give the load the shape of u");
    }
    if (!held.empty() && held.columns() != u_.cols()) {
        throw InputError(
            fmt::format("constraints of {} columns for a state of {}", held.columns(), u_.cols()),
            "make both of the same width");
    }
    const double dt = options_.step;
    const Vector& M = laplacian_.mass();
    const bool multistep = options_.method == TimeMethod::bdf2 && step_count_ > 0;
    if (multistep && !main_) {
        // What the first step made of the mesh serves the others too.
        options_.linear.hierarchy = start_->hierarchy();
        options_.linear.analysis = start_->analysis();
        main_ = make_solver({1.5, 2.0 / 3.0});
    }
    LinearSolver& solver = start_ && !multistep ? *start_ : *main_;

    // Every method solves for a velocity w with A w = inertia - K~ base + f, and then u = base + reach w.
    Block base = u_;
    double reach = dt;
    Block inertia = pde_.alpha / dt * v_;
    if (multistep) {
        base = (4.0 * u_ - u_before_) / 3.0;
        reach = 2.0 / 3.0 * dt;
        inertia = pde_.alpha / dt * (2.0 * v_ - 0.5 * v_before_);
    } else if (options_.method == TimeMethod::implicit_midpoint) {
        inertia *= 2.0;
    }
    Block load;
    stiffness_.apply(base, load);
    load = M.asDiagonal() * inertia - load;
    if (f != nullptr) load += *f;

    Constraints held_velocity(held.empty() ? static_cast<Index>(u_.cols()) : held.columns());
    held.check_range(laplacian_.vertex_count());
    std::vector<double> value(static_cast<std::size_t>(held_velocity.columns()));
    for (const Index i : held.vertices()) {
        for (std::size_t c = 0; c < value.size(); ++c) {
            value[c] = (held.value(i)[c] - base(i, static_cast<Eigen::Index>(c))) / reach;
        }
        held_velocity.fix(i, value);
    }

    Block w = v_;
    const LinearSummary step = solver.solve(load, held_velocity, w);
    summary_.add(step);
    require_converged(step);
    solver.reaction(load, w, held_velocity, reaction_);

    u_before_ = std::exchange(u_, base + reach * w);
    // The midpoint's w is the mean of the old and new velocities; a first-order PDE has no velocity to carry on, and
    // that of a held vertex is what moves it.
    if (options_.method == TimeMethod::implicit_midpoint && pde_.alpha > 0.0) {
        Block mean = w;
        w = 2.0 * w - v_;
        for (const Index i : held.vertices())
            w.row(i) = mean.row(i);
    }
    v_before_ = std::exchange(v_, std::move(w));
    // An isolated vertex has no equation: once let go it stays where it was put.
    for (const Index i : isolated_) {
        v_.row(i).setZero();
        v_before_.row(i).setZero();
        u_before_.row(i) = u_.row(i);
    }
    ++step_count_;
}

Vector TimeIntegrator::energy() const {
    Block stretched;
    stiffness_.apply(u_, stretched);
    const Vector kinetic =
        0.5 * pde_.alpha *
        (laplacian_.mass().asDiagonal() * v_.cwiseAbs2()).eval().colwise().sum().transpose();
    return kinetic + 0.5 * u_.cwiseProduct(stretched).colwise().sum().transpose();
}

}  // namespace beltrami
