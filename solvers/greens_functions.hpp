// gamma K D K u = b with some held vertices, from the Green's functions of K at them: as many solves with K as vertices are
// held, and one more for each right-hand side, instead of anything with K D K.
//
//     GreensFunctions green(laplacian, held, {.hierarchy = hierarchy});
//     green.solve(1.0, b, x);            // x: the held rows in, all rows out
//
// With v = D K u and loads lambda at the held vertices, K v = b + E lambda and K u = M v: two solves with K, whose constants are
// fixed by M v and K v having no sum on a component, and a dense system of the size of the constraints for lambda
// (DESIGN.md; NOTES on the bi-Laplacian: exact, where preconditioned iterations with K D K are not).
#pragma once

#include <Eigen/Cholesky>
#include <memory>
#include <vector>

#include "beltrami/operators/laplacian.hpp"
#include "beltrami/solvers/linear_summary.hpp"

namespace beltrami {

class LinearSolver;
struct LinearSolverOptions;

class GreensFunctions {
  public:
    /// held: ascending, at least one on every component that has an edge; isolated vertices are left as they are. options are
    /// for the solves with K. Throws SolveError where a component is not held or a solve does not converge, Cancelled.
    GreensFunctions(const Laplacian& laplacian, std::vector<Index> held, const LinearSolverOptions& options);
    ~GreensFunctions();
    GreensFunctions(const GreensFunctions&) = delete;
    GreensFunctions& operator=(const GreensFunctions&) = delete;

    [[nodiscard]] const std::vector<Index>& held() const { return held_; }

    /// b: n x k, whose held rows are not used. x: n x k, the held rows are read and the others set. What the solves with K did
    /// is added to `summary`.
    void solve(double gamma, const Block& b, Block& x, LinearSummary& summary);

    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    void solve_stiffness(const Block& load, Block& x);
    void remove_constants(Block& x) const;

    Laplacian laplacian_;
    std::vector<Index> held_;
    std::vector<Index> component_;  // of each vertex
    Vector component_mass_;
    std::vector<Index> pins_;    // one held vertex of each component
    std::vector<Index> others_;  // the other held ones
    std::unique_ptr<LinearSolver> stiffness_;
    Block
        functions_;  // n x |others|: of load 1 at one of them and -1 at the component's pin, without constants
    Eigen::LLT<Eigen::MatrixXd> coupling_;
    LinearSummary done_;  // the solves of K since they were last asked for
};

}  // namespace beltrami
