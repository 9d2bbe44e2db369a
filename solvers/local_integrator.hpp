// The general PDE in time on a domain that adjusts itself: grows with the wave front, shrinks as it dies, empty at rest.
//
//     Pde pde{.alpha = 1.0, .beta_1 = 5.0, .gamma = {1.0, 1e-3}, .foundation = 100.0};
//     LocalIntegrator motion(laplacian, pde, 1e-3, 3, {.tolerance = 1e-3});
//     LocalStep step = motion.advance(std::array{Hold{{v}, {1.0}, {0.0, 0.0, -0.1}}});    // held: u at the new time
//     motion.forces();                          // what holds the points: the i-th row of eq. (16)
//     step = motion.advance({});                // let go
//     motion.domain().empty();                  // true some time later
//
// Backward Euler as published, eq. (14) and (15) of Kim & Rossignac with Rayleigh damping; the domain of section 4.2.
//
// The error bound. The energy norm is |(u, v)|_E^2 = alpha/2 v^T M v + 1/2 u^T K~ u. A step whose equation is missed by r
// (local_system.hpp) puts at most (r^T M^-1 r / 2 sigma)^(1/2) into the error, vertices that are let go put in their own
// energy, and backward Euler never makes an error larger; with a foundation and damping it halves any error in a number of
// steps that is known from the coefficients. So the error against the simulation of the whole mesh is at most the sum of
// what the steps put in, halved as it ages: LocalStep::error_bound. The domain grows until the part of a step is within the
// tolerance, and shrinks while it stays so. The bound is proven while the held points keep their places on
// the mesh. A point that is caught or slides takes hold where both simulations differ a little, which gives the difference a
// kick that the bound does not count.
//
// Passive: the work that the held points put in is never less than the energy stored plus dissipated. What a shrinking
// domain could add is paid from what backward Euler has taken out, or the vertices stay.
#pragma once

#include <optional>
#include <span>

#include "beltrami/solvers/local_solver.hpp"
#include "beltrami/solvers/time_integrator.hpp"

namespace beltrami {

struct LocalStep {
    Index active = 0;    ///< vertices that were solved for, held ones among them
    Index slots = 0;     ///< active vertices and the rings around them
    bool whole = false;  ///< nothing lies outside: this was a global step
    int rounds = 0;      ///< of growing
    int iterations = 0;  ///< of conjugate gradients
    long products = 0;   ///< with K, over the domain
    double bytes = 0.0;  ///< of compact storage streamed through
    double seconds = 0.0;
    bool in_time = true;       ///< false: stopped at the deadline; the error put in dies out with the motion
    bool converged = true;     ///< false: late, or the limit of iterations
    double put_in = 0.0;       ///< the step's part of the error bound, in the energy norm
    double error_bound = 0.0;  ///< of all steps so far
    double scale =
        0.0;  ///< the largest energy norm since the domain was last empty: what errors are relative to
    double energy = 0.0;      ///< stored: kinetic and elastic
    double work = 0.0;        ///< of the held points in this step
    double dissipated = 0.0;  ///< by beta_1 and beta_2 in this step
    double taken_out = 0.0;   ///< by backward Euler and by what was let go, in this step
};

class LocalIntegrator {
  public:
    using Clock = LocalSystem::Clock;

    /// Throws InputError for a step that is not positive and finite, and as Pde::check, LocalOptions::check and
    /// LocalSystem do. options.tolerance is for each step's part of the error, relative to the largest energy norm so far.
    LocalIntegrator(const Laplacian& laplacian, Pde pde, double step, Index columns,
                    LocalOptions options = {});

    /// One step to time() + step. holds: points with their u at the new time, in the working order. With a deadline the
    /// solver stops at the last iterate when it passes, scaled so that it adds no energy: late steps stay stable. Throws
    /// InputError for a hold that is not one or on an isolated vertex, Cancelled; the state is then that before the step.
    LocalStep advance(std::span<const Hold> holds, std::optional<Clock::time_point> deadline = {});

    /// c x k of the last step's held points, in units of K~ u.
    [[nodiscard]] const Block& forces() const { return forces_; }
    [[nodiscard]] const ActiveDomain& domain() const { return system_.domain(); }
    [[nodiscard]] double time() const { return static_cast<double>(step_count_) * step_; }
    [[nodiscard]] double step() const { return step_; }

    /// Of a slot of the domain: k numbers.
    [[nodiscard]] std::span<const double> u(Index slot) const {
        return {u_[slot], static_cast<std::size_t>(u_.columns())};
    }
    /// n x k in the working order.
    [[nodiscard]] Block u() const;
    [[nodiscard]] Block v() const;

    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    struct Energies {
        double stored;
        double dissipated;
    };
    [[nodiscard]] double stretching(Index slot, Index column) const;
    [[nodiscard]] Energies energies_of_trial() const;
    double let_go(LocalStep& result, bool held);
    bool same_places(std::span<const Hold> holds);

    class ErrorBound {
      public:
        explicit ErrorBound(long halving_steps = -1) : halving_steps_(halving_steps) {}
        void add(double put_in, bool same_places);
        [[nodiscard]] double bound() const { return block_ + older_; }

      private:
        long halving_steps_;
        long steps_ = 0;
        double block_ = 0.0;  // of the last steps, fewer than halve anything
        double older_ = 0.0;
    };

    Pde pde_;
    double step_;
    LocalOptions options_;
    LocalSystem system_;  // its unknown is the new velocity
    SlotField u_, v_, stretched_;
    LocalOperator::Weights weights_;
    std::vector<std::pair<Index, double>> places_;  // of the points held in the last step
    Block forces_;
    int stretched_age_ = -1;  // steps since K~ u was computed afresh; -1: it has to be
    long step_count_ = 0;
    double energy_ = 0.0;
    double peak_energy_ = 0.0;
    ErrorBound error_;
    double reserve_ = 0.0;  // energy that backward Euler took out and shrinking has not yet used
};

}  // namespace beltrami
