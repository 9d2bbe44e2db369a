// A static solve that touches only the part of the mesh where something happens, with a bound on what that costs.
//
//     LocalSolver solver(PdeOperator(laplacian, foundation, {gamma_1, gamma_2}), 3, {.tolerance = 1e-3});
//     LocalSummary summary = solver.solve(std::array{Hold{{v}, {1.0}, {0.0, 0.0, -0.1}}});
//     summary.error_bound;                 // |u - u*|_A / |u|_A is not more, u* the solution on the whole mesh
//     solver.forces();                     // what holds the points
//     solver.value();                      // n x k, zero where nothing happens
//
// Solves A u = 0 with points held, A = foundation M + gamma_1 K + gamma_2 K D K + ...: eq. (13) of Kim & Rossignac with its
// term i = 0, gamma_0 M, a spring from each vertex to its place. Without it a poke moves the whole mesh and nothing is
// local. The domain (section 4.2) grows where the equation of the whole mesh is missed most, until the bound is met
// (local_system.hpp); what is known from the last solve is kept, and what is quiet is let go.
#pragma once

#include <optional>
#include <string>

#include "beltrami/framework/progress.hpp"
#include "beltrami/solvers/local_system.hpp"

namespace beltrami {

struct LocalOptions {
    /// Of the error against the global solution, in the energy norm |e|_A = (e^T A e)^(1/2), relative to the solution's.
    double tolerance = 1e-3;
    /// Conjugate gradients, over all rounds of a solve or a step.
    int max_iterations = 50000;
    const Progress* progress = nullptr;

    /// Throws InputError for a tolerance that is not between 0 and 1 and a limit below 1.
    void check() const;
};

struct LocalSummary {
    bool converged = false;
    double tolerance = 0.0;
    double error_bound = 0.0;  ///< of |u - u*|_A / |u|_A
    Index active = 0;          ///< vertices that were solved for, held ones among them
    Index slots = 0;           ///< active vertices and the rings around them
    bool whole = false;  ///< nothing lies outside: the solve was a global one (of the components it touches)
    int rounds = 0;      ///< of growing
    int iterations = 0;
    long products = 0;   ///< with K, over the domain
    double bytes = 0.0;  ///< of compact storage streamed through
    std::size_t memory_bytes = 0;
    double seconds = 0.0;

    /// "local: 812 of 34835 vertices, 57 iterations in 9 rounds, error below 8.1e-4 in 0.003 s".
    [[nodiscard]] std::string brief() const;
    Index vertices = 0;  ///< of the mesh
};

class LocalSolver {
  public:
    /// Throws InputError for an operator without foundation (sigma = 0), and as LocalSystem does.
    LocalSolver(PdeOperator A, Index columns, LocalOptions options = {});

    /// Points to hold, in the working order; none give u = 0 and an empty domain. Throws InputError as
    /// LocalSystem::vertices_of, and for two points in one place with different values; SolveError for numbers that
    /// overflow; Cancelled. A solve that does not converge returns with converged = false: see require_converged().
    [[nodiscard]] LocalSummary solve(std::span<const Hold> holds);

    /// c x k: row i of A u at the held points of the last solve (eq. (16)), the force that holds each. With one
    /// displacement d for all points, relative error at most error_bound^2.
    [[nodiscard]] const Block& forces() const { return forces_; }
    [[nodiscard]] const ActiveDomain& domain() const { return system_.domain(); }
    /// Of a slot of the domain: k numbers.
    [[nodiscard]] std::span<const double> value(Index slot) const {
        return {system_.x[slot], static_cast<std::size_t>(system_.columns())};
    }
    /// n x k in the working order.
    [[nodiscard]] Block value() const;

  private:
    double let_go(double scale);

    LocalOptions options_;
    LocalSystem system_;
    Block forces_;
};

/// n x k from a field over slots.
Block scattered(const ActiveDomain& domain, const SlotField& field, Index rows);

/// Throws SolveError that says what was reached, unless converged.
void require_converged(const LocalSummary& summary);

}  // namespace beltrami
