// The general PDE alpha u_tt + beta C u_t + K~ u = f in time: heat, waves, damped membranes and plates.
//
//     Pde heat{.beta_1 = 1.0, .gamma = {1.0}};                     // u_t = Laplacian of u
//     TimeIntegrator integrator(laplacian, heat, {.step = 0.01, .method = TimeMethod::bdf2, .steps = 100});
//     integrator.set_state(u0, v0);                                // working order
//     for (int s = 0; s < 100; ++s) integrator.advance(held);      // held values at the new time
//     integrator.u();
//
// Source: Kim & Rossignac, eq. (11) to (15), Rayleigh damping beta C = beta_1 M + beta_2 K~.
#pragma once

#include <memory>
#include <vector>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/operators/pde_operator.hpp"
#include "beltrami/solvers/linear_solver.hpp"

namespace beltrami {

/// alpha M u'' + (beta_1 M + beta_2 K~) u' + K~ u = f with K~ = foundation M + sum of gamma_i K (D K)^(i-1). Heat is
/// beta_1 = 1, gamma_1 = 1 (diffusivity); waves are alpha = 1, gamma_1 = 1 (squared speed).
struct Pde {
    double alpha = 0.0;
    double beta_1 = 0.0;
    double beta_2 = 0.0;
    std::vector<double> gamma = {1.0};
    /// The term i = 0 of eq. (13), gamma_0 K (D K)^-1 = gamma_0 M: a spring from each vertex to u = 0.
    double foundation = 0.0;

    /// Throws InputError for coefficients that are negative, not finite, or give no time derivative.
    void check() const;
};

enum class TimeMethod {
    backward_euler,     ///< eq. (14), (15) as published: first order, unconditionally stable, damps waves
    implicit_midpoint,  ///< second order, keeps the energy of an undamped wave to the tolerance of the
                        ///< solves; does not smooth heat that starts with jumps
    bdf2                ///< second order and stiffly stable: for heat. The first step is backward Euler
};
std::string_view name(TimeMethod method);

struct TimeOptions {
    double step = 0.0;  ///< in units of time; positive
    TimeMethod method = TimeMethod::backward_euler;
    int steps = 1;  ///< how many are expected: lets the linear solver decide whether a factor pays
    LinearSolverOptions linear = {};
};

class TimeIntegrator {
  public:
    /// Throws InputError for a step that is not positive and finite, or a PDE that Pde::check refuses.
    TimeIntegrator(const Laplacian& laplacian, Pde pde, TimeOptions options);

    /// u, v: n x k, displacement and velocity at time 0, in the working order. v is not used by first-order PDEs.
    void set_state(Block u, Block v);
    void set_state(Block u);

    /// One step to time() + step. `held` gives u at the new time; its vertices may differ from step to step. f: the
    /// load {f} in units of K~ u (n x k) at the new time (at the middle of the step for implicit midpoint), none if
    /// null. Throws InputError for wrong shapes and held vertices out of range, SolveError when the linear
    /// solve does not converge, and then the state is that before the step.
    void advance(const Constraints& held, const Block* f = nullptr);

    [[nodiscard]] const Block& u() const { return u_; }
    [[nodiscard]] const Block& v() const { return v_; }
    [[nodiscard]] double time() const { return step_count_ * options_.step; }
    [[nodiscard]] int step_count() const { return step_count_; }

    /// The forces that held the vertices in the last step (n x k, zero at free ones), row i of eq. (16): what must be
    /// added to f there.
    [[nodiscard]] const Block& reaction() const { return reaction_; }

    /// alpha/2 v^T M v + 1/2 u^T K~ u, for each column.
    [[nodiscard]] Vector energy() const;

    /// All linear solves so far: counts and seconds added up, the worst error.
    [[nodiscard]] const LinearSummary& summary() const { return summary_; }

  private:
    /// One step of any of the methods is  ((c_m alpha / dt + beta_1) M + (beta_2 + c_k dt) K~) v = load.
    struct Weights {
        double c_m;
        double c_k;
    };
    [[nodiscard]] std::unique_ptr<LinearSolver> make_solver(Weights weights) const;

    Laplacian laplacian_;
    Pde pde_;
    TimeOptions options_;
    PdeOperator stiffness_;
    std::unique_ptr<LinearSolver> start_;  // the first step of bdf2
    std::unique_ptr<LinearSolver> main_;   // of bdf2 after its first step
    std::vector<Index> isolated_;          // vertices without mass
    Block u_, v_, u_before_, v_before_;
    Block reaction_;
    int step_count_ = 0;
    LinearSummary summary_;
};

}  // namespace beltrami
