// A x = b for a PdeOperator or any other LinearOperator, with held vertices: chooses among conjugate gradients with the
// diagonal or with multigrid, Cholesky and Green's functions, and says why.
//
//     LinearSolver solver(A, {.tolerance = 1e-10});
//     Constraints held{{120, 0.0}, {8999, 1.0}};
//     LinearSummary summary = solver.solve(b, held, x);      // x: start in, solution out
//     held.fix(42, 0.5);
//     summary = solver.solve(b, held, x);                    // nothing was rebuilt but, with Cholesky, the factor
//
// Everything here is in the working order of the operator's Laplacian, and a vertex is a row of A: the real form of a
// complex operator has two for each of the mesh. Vertices whose row of A is zero (isolated ones) keep what x has. A factor
// is kept while the set of held vertices stays the same, and corrected where few come and go; their values may change
// freely.
#pragma once

#include <array>
#include <concepts>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/framework/progress.hpp"
#include "beltrami/operators/pde_operator.hpp"
#include "beltrami/solvers/cholesky.hpp"
#include "beltrami/solvers/conjugate_gradients.hpp"
#include "beltrami/solvers/greens_functions.hpp"
#include "beltrami/solvers/hierarchy.hpp"
#include "beltrami/solvers/linear_summary.hpp"
#include "beltrami/solvers/multigrid.hpp"

namespace beltrami {

enum class SolverKind {
    automatic,
    cg,         ///< conjugate gradients with the diagonal as preconditioner
    multigrid,  ///< conjugate gradients with a V-cycle; a PdeOperator of order 1 or 2 on a mesh with positions
    cholesky,
    green  ///< K D K alone with few held vertices, by solves with K
};
inline constexpr std::array all_solver_kinds{SolverKind::automatic, SolverKind::cg, SolverKind::multigrid,
                                             SolverKind::cholesky, SolverKind::green};
/// The word of the program's --solver: "auto", "cg", "multigrid", "cholesky", "green".
std::string_view name(SolverKind kind);

struct LinearSolverOptions {
    SolverKind kind = SolverKind::automatic;
    /// In `norm`. Below about 1e-12 rounding may stop a solve short of it.
    double tolerance = 1e-10;
    /// Of conjugate gradients. Direct solves are refined to the tolerance in the scaled residual, or with K D
    /// K in the size of the last refinement.
    StoppingNorm norm = StoppingNorm::automatic;
    /// Conjugate gradients only.
    int max_iterations = 50000;
    /// How often solve() will be called with the same held vertices: what makes a factor worth its cost.
    int expected_solves = 1;
    /// Of the operator's mesh, for multigrid. Where none is given it is made when it is first wanted: to share it among
    /// solvers on one mesh, hand them LinearSolver::hierarchy() of the first.
    std::shared_ptr<const Hierarchy> hierarchy = nullptr;
    /// Of the pattern of the operator's matrix, for Cholesky; in the same way. All operators with one product with K on a
    /// mesh have one pattern, and all those with two.
    std::shared_ptr<const CholeskyAnalysis> analysis = nullptr;
    const Progress* progress = nullptr;

    /// Throws InputError for a tolerance or a count that is not positive.
    void check() const;
};

class LinearSolver {
  public:
    explicit LinearSolver(std::shared_ptr<const LinearOperator> A, LinearSolverOptions options = {});
    /// From an operator itself.
    template <std::derived_from<LinearOperator> Operator>
    explicit LinearSolver(Operator A, LinearSolverOptions options = {})
        : LinearSolver(std::make_shared<const Operator>(std::move(A)), options) {}

    /// b: n x k. x: n x k; the free rows are the start (used by both solvers), the held rows are set to the
    /// constraints' values. Held vertices' rows of b are not used. Throws InputError for wrong shapes, numbers that
    /// are not finite and held vertices out of range, SolveError where a factorization breaks down, Cancelled. A solve
    /// that does not converge returns with converged = false and the last iterate in x: see require_converged().
    [[nodiscard]] LinearSummary solve(const Block& b, const Constraints& held, Block& x);

    /// Makes analysis() ahead of the first solve, where a factor is what would be chosen without held vertices. Throws
    /// SolveError where memory does not suffice.
    void analyse();

    [[nodiscard]] const LinearOperator& op() const { return *A_; }

    /// What multigrid and Cholesky made or were given; null before.
    [[nodiscard]] const std::shared_ptr<const Hierarchy>& hierarchy() const { return options_.hierarchy; }
    [[nodiscard]] const std::shared_ptr<const CholeskyAnalysis>& analysis() const {
        return options_.analysis;
    }

    /// f = A x - b at the held vertices and 0 elsewhere: the reaction that holds them (row i of eq. (16) of Kim &
    /// Rossignac). The forces and the load balance: for sigma = 0 the columns of f + b sum to zero over each component.
    void reaction(const Block& b, const Block& x, const Constraints& held, Block& f) const;

  private:
    struct Choice {
        SolverKind kind;
        std::string why;
    };
    [[nodiscard]] Choice choose(const std::vector<Index>& held, Index columns) const;
    LinearSummary solve_by(SolverKind kind, const Block& b, const std::vector<Index>& held, Block& x);
    [[nodiscard]] Cholesky::Ordering ordering() const;
    void assemble();
    void analyse_all_rows();
    void factor(const std::vector<Index>& held);
    LinearSummary solve_cg(const Block& b, const std::vector<Index>& held, Block& x);
    LinearSummary solve_multigrid(const Block& b, const std::vector<Index>& held, Block& x);
    LinearSummary solve_green(const Block& b, const std::vector<Index>& held, Block& x);
    template <class Solve>
    void refine(const Block& b, const std::vector<Index>& held, Block& x, LinearSummary& summary,
                Solve solve);
    void iterate(CgOptions options, const Block& b, const std::vector<Index>& held, Block& x,
                 LinearSummary& summary) const;
    LinearSummary solve_cholesky(const Block& b, const std::vector<Index>& held, Block& x);

    std::shared_ptr<const LinearOperator> A_;
    Product product_;
    LinearSolverOptions options_;
    Vector diagonal_;
    Vector inverse_diagonal_;                     // 1 for empty rows
    const PdeOperator* for_multigrid_ = nullptr;  // A_, where multigrid can be asked for
    const PdeOperator* for_green_ = nullptr;      // A_, where Green's functions can
    std::vector<Index> empty_rows_;

    Eigen::SparseMatrix<double> matrix_;  // assembled once, when a factor is first wanted
    std::optional<Cholesky> factor_;
    std::vector<Index> factored_held_;
    std::vector<Index> free_;  // the vertex of each row of a factor of the free rows alone; else empty

    std::optional<Multigrid> multigrid_;
    std::vector<Index> multigrid_held_;
    std::unique_ptr<GreensFunctions> green_;

    struct Failure {
        SolverKind kind;
        std::vector<Index> held;
        std::string what;
    };
    std::optional<Failure> failure_;  // the last one that Cholesky took over from
};

}  // namespace beltrami
