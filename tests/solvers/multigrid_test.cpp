#include "beltrami/solvers/multigrid.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/pde_operator.hpp"
#include "beltrami/solvers/conjugate_gradients.hpp"
#include "beltrami/solvers/linear_solver.hpp"
#include "threads.hpp"

namespace beltrami {
namespace {

struct Problem {
    Laplacian laplacian;
    Hierarchy hierarchy;
    PdeOperator A;
    std::vector<Index> held;

    Problem(const Mesh& mesh, double sigma, std::vector<double> gamma, std::vector<Index> fixed,
            Index coarsest = 60)
        : laplacian(mesh),
          hierarchy(laplacian.graph(), laplacian.order().to_working(mesh).points(), {.coarsest = coarsest}),
          A(laplacian, sigma, std::move(gamma)),
          held(std::move(fixed)) {}

    [[nodiscard]] Multigrid cycle() const { return {A, hierarchy, held}; }
};

std::vector<Index> every(Index step, Index n) {
    std::vector<Index> rows;
    for (Index i = 0; i < n; i += step)
        rows.push_back(i);
    return rows;
}

TEST(Multigrid, IsSymmetricPositiveDefiniteAndCloseToTheInverse) {
    for (const Problem& problem : {Problem(shapes::bumpy_sphere(400), 1.0, {0.1}, {}),
                                   Problem(shapes::grid(20, 20), 0.0, {1.0}, {7, 150, 300}),
                                   Problem(shapes::tetrahedral_ball(4), 0.1, {1.0}, {3}),
                                   Problem(shapes::fins(3, 10), 0.0, {1.0}, {0, 9}),
                                   Problem(shapes::bumpy_sphere(400), 0.0, {0.0, 1.0}, {3, 50, 51, 200}),
                                   Problem(shapes::grid(20, 20), 0.5, {1.0, 0.1}, {}),
                                   Problem(shapes::tetrahedral_ball(4), 0.0, {0.0, 1.0}, {3, 80, 81})}) {
        const Multigrid cycle = problem.cycle();
        EXPECT_GE(cycle.level_count(), 2);
        const Index n = problem.A.rows();
        Block B;
        cycle.apply(Block::Identity(n, n), B);
        EXPECT_LT((B - B.transpose()).cwiseAbs().maxCoeff(), 1e-5 * B.cwiseAbs().maxCoeff());
        std::vector<Index> free;
        for (Index i = 0; i < n; ++i) {
            if (!std::binary_search(problem.held.begin(), problem.held.end(), i)) free.push_back(i);
        }
        for (const Index i : problem.held)
            EXPECT_EQ(B.row(i).cwiseAbs().maxCoeff(), 0.0);
        const Eigen::MatrixXd A = Eigen::MatrixXd(problem.A.to_sparse())(free, free);
        const Eigen::MatrixXd symmetric = 0.5 * (B + B.transpose())(free, free);
        // B A is similar to a symmetric matrix: its eigenvalues say how far B is from the inverse.
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(A, symmetric.inverse());
        EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.1);
        EXPECT_LT(eigen.eigenvalues().maxCoeff(), 1.3);
    }
}

TEST(Multigrid, IterationsDoNotGrowWithTheMesh) {
    std::vector<int> iterations;
    for (const Index n : {5000, 40000}) {
        const Problem problem(shapes::bumpy_sphere(n), 0.0, {1.0}, every(n / 100, n), 500);
        const Multigrid cycle = problem.cycle();
        Block x = Block::Zero(n, 1);
        for (const Index i : problem.held)
            x(i, 0) = static_cast<double>(i % 7);
        const Block b = Block::Zero(n, 1);
        const Vector inverse_diagonal = problem.A.diagonal().cwiseInverse();
        const CgResult result =
            conjugate_gradients(problem.A.product(), inverse_diagonal, problem.held, b, x,
                                {.tolerance = 1e-10, .preconditioner = cycle.preconditioner()});
        EXPECT_EQ(result.reason, StopReason::converged);
        Block r;
        masked_residual(problem.A.product(), problem.held, b, x, r);
        EXPECT_LT(r.norm(), 1e-7);
        iterations.push_back(result.iterations);
    }
    EXPECT_LE(iterations[1], 40);
    EXPECT_LE(iterations[1], 3 * iterations[0] / 2);
}

TEST(Multigrid, ColumnsAndThreadsDoNotMatter) {
    const Mesh mesh = shapes::bumpy_sphere(30000);
    for (const std::vector<double>& gamma : {std::vector{0.01}, std::vector{0.0, 1e-6}}) {
        const Problem problem(mesh, 1.0, gamma, {5, 700}, 500);
        const Block r = Block::Random(problem.A.rows(), 7);
        Block all;
        problem.cycle().apply(r, all);
        for (const int threads : {1, 3}) {
            const testing::Threads limit(threads);
            Block other;
            problem.cycle().apply(r, other);
            EXPECT_EQ(all, other) << threads;
        }
        const Multigrid cycle = problem.cycle();
        for (Index c = 0; c < 7; ++c) {
            Block z;
            cycle.apply(r.col(c), z);
            EXPECT_LT((z - all.col(c)).cwiseAbs().maxCoeff(), 1e-5 * z.cwiseAbs().maxCoeff());
        }
    }
}

TEST(Multigrid, ComponentsThatNothingHoldsAndIsolatedVertices) {
    const Mesh sphere = shapes::bumpy_sphere(2000);
    const Problem problem(shapes::together({sphere, shapes::torus(1.0, 0.4, 40, 20)}), 0.0, {1.0}, {}, 100);
    const Index n = problem.A.rows();
    // A load without a constant part on either piece.
    Block b;
    problem.A.apply(Block::Random(n, 1), b);
    Block x = Block::Zero(n, 1);
    const Multigrid cycle = problem.cycle();
    const CgResult result = conjugate_gradients(
        problem.A.product(), problem.A.diagonal().cwiseInverse(), {}, b, x,
        {.tolerance = 1e-9, .max_iterations = 60, .preconditioner = cycle.preconditioner()});
    EXPECT_EQ(result.reason, StopReason::converged);
}

// What a cycle costs: levels, and entries of their operators.
TEST(Multigrid, LevelsStayThin) {
    const Mesh mesh = shapes::bumpy_sphere(40000);
    for (const std::vector<double>& gamma : {std::vector{1.0}, std::vector{0.0, 1.0}}) {
        const Problem problem(mesh, 0.0, gamma, {0, 77}, 500);
        const Multigrid cycle = problem.cycle();
        ASSERT_EQ(cycle.level_count(), 4);
        EXPECT_EQ(cycle.size(0), 40000);
        EXPECT_NEAR(cycle.entries_per_row(0), 7.0, 0.01) << "K D K is not formed on the finest level";
        double entries = 0.0;
        for (int l = 1; l < cycle.level_count(); ++l) {
            EXPECT_LT(4 * cycle.size(l), cycle.size(l - 1));
            entries += cycle.size(l) * cycle.entries_per_row(l);
        }
        EXPECT_LT(entries, (gamma.size() == 1 ? 0.7 : 2.2) * 7.0 * 40000.0);
    }
}

TEST(Multigrid, EverythingHeld) {
    const Problem problem(shapes::icosphere(2), 1.0, {1.0}, every(1, 162), 30);
    Block z;
    problem.cycle().apply(Block::Ones(162, 2), z);
    EXPECT_EQ(z, Block::Zero(162, 2));
}

TEST(Multigrid, Refuses) {
    const Problem problem(shapes::icosphere(2), 1.0, {1.0}, {}, 30);
    const Problem other(shapes::icosphere(1), 1.0, {1.0}, {}, 30);
    const Problem third(shapes::icosphere(2), 1.0, {1.0, 0.0, 1.0}, {}, 30);
    EXPECT_THROW(third.cycle(), InputError);
    EXPECT_THROW(Multigrid(other.A, problem.hierarchy, {}), InputError);
    Block z;
    EXPECT_THROW(problem.cycle().apply(Block::Ones(7, 1), z), InputError);
}

}  // namespace
}  // namespace beltrami
