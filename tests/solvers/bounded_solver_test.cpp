#include "beltrami/solvers/bounded_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::relative_difference;

constexpr double infinity = std::numeric_limits<double>::infinity();

Bounds between(double low, double high) {
    return {Vector::Constant(1, low), Vector::Constant(1, high)};
}

// Optimality (Karush, Kuhn and Tucker): within the bounds, no slope inside, and at a bound a slope that pushes outward.
void expect_optimal(const PdeOperator& A, const Block& b, const Constraints& held, const Bounds& bounds,
                    const Block& u, double tolerance) {
    Block slope;
    A.apply(u, slope);
    slope -= b;
    const Vector diagonal = A.diagonal();
    for (Eigen::Index c = 0; c < u.cols(); ++c) {
        for (Index v = 0; v < u.rows(); ++v) {
            EXPECT_GE(u(v, c), bounds.low[c]);
            EXPECT_LE(u(v, c), bounds.high[c]);
            if (held.is_fixed(v)) {
                EXPECT_EQ(u(v, c), held.value(v)[static_cast<std::size_t>(c)]);
                continue;
            }
            const double force = slope(v, c) / diagonal[v];
            const bool above = u(v, c) > bounds.low[c] + 1e-9;
            const bool below = u(v, c) < bounds.high[c] - 1e-9;
            EXPECT_TRUE(!above || force < tolerance) << v << " " << force;
            EXPECT_TRUE(!below || force > -tolerance) << v << " " << force;
        }
    }
}

Constraints handles(const Mesh& mesh, int count, std::uint32_t seed) {
    const Vector places = testing::random_vector(count, seed);
    const Vector values = testing::random_vector(count, seed + 1);
    Constraints held;
    for (int i = 0; i < count; ++i)
        held.fix(static_cast<Index>(0.5 * (places[i] + 1.0) * (mesh.vertex_count() - 1)), values[i]);
    return held;
}

TEST(BoundedSolver, MeetsTheConditionsOfOptimalityForEveryOperator) {
    for (const Mesh& mesh : {shapes::grid(25, 25), shapes::bumpy_sphere(1500), shapes::fins(3, 12)}) {
        const Laplacian laplacian(mesh);
        for (const std::vector<double>& gamma : {std::vector{1.0}, {0.0, 1.0}, {1.0, 0.01}}) {
            const PdeOperator A(laplacian, 0.0, gamma);
            LinearSolver solver(A);
            const Constraints held = handles(mesh, 40, 3);
            Block u = Block::Zero(mesh.vertex_count(), 1);
            const Block b = u;
            const BoundedSummary summary = solve_bounded(solver, b, held, between(-1.0, 1.0), u);
            expect_optimal(A, b, held, between(-1.0, 1.0), u, 1e-9);
            EXPECT_TRUE(summary.linear.converged);
            EXPECT_EQ(summary.projected, 0);
        }
    }
}

// Every choice of inside, low and high for nine free vertices.
TEST(BoundedSolver, IsTheBestOfAllActiveSetsOfASmallMesh) {
    const Mesh mesh = shapes::grid(3, 2);
    const Laplacian laplacian(mesh, {.renumber = false});
    const Constraints held{{0, 1.0}, {6, -1.0}, {11, 0.8}};
    const Block b = 2.0 * testing::random_block(12, 1, 5);
    std::vector<Index> free;
    for (Index v = 0; v < 12; ++v) {
        if (!held.is_fixed(v)) free.push_back(v);
    }
    for (const std::vector<double>& gamma : {std::vector{1.0}, {0.0, 0.2}}) {
        LinearSolver solver(PdeOperator(laplacian, 0.0, gamma));
        const Eigen::MatrixXd A = testing::dense(solver.op().to_sparse());
        Eigen::VectorXd best;
        double least = infinity;
        for (int code = 0; code < 19683; ++code) {
            Eigen::VectorXd u(12);
            for (const Index v : held.vertices())
                u[v] = held.value(v)[0];
            std::vector<Index> inside;
            std::vector<Index> fixed = held.vertices();
            int digits = code;
            for (const Index v : free) {
                if (digits % 3 == 0) {
                    inside.push_back(v);
                } else {
                    u[v] = digits % 3 == 1 ? -1.0 : 1.0;
                    fixed.push_back(v);
                }
                digits /= 3;
            }
            const Eigen::MatrixXd A_ii = A(inside, inside);
            const Eigen::MatrixXd A_if = A(inside, fixed);
            const Eigen::VectorXd u_f = u(fixed);
            const Eigen::VectorXd b_i = b.col(0)(inside);
            const Eigen::VectorXd right = b_i - A_if * u_f;
            const Eigen::VectorXd solved = A_ii.partialPivLu().solve(right);
            for (std::size_t i = 0; i < inside.size(); ++i)
                u[inside[i]] = solved[static_cast<Eigen::Index>(i)];
            const double energy = 0.5 * u.dot(A * u) - b.col(0).dot(u);
            if (u.cwiseAbs().maxCoeff() > 1.0 + 1e-12 || energy >= least) continue;
            least = energy;
            best = u;
        }
        for (const int active_sets : {100, 1}) {
            Block u = Block::Zero(12, 1);
            const BoundedSummary summary =
                solve_bounded(solver, b, held, between(-1.0, 1.0), u, {.active_sets = active_sets});
            EXPECT_GT(summary.at_bounds, 0) << "the bounds do something here";
            EXPECT_LT(relative_difference(u.col(0), best), 1e-10);
        }
    }
}

// The fallback, made to do all of the work.
TEST(BoundedSolver, TheProjectedNewtonMethodFindsTheSame) {
    for (const Mesh& mesh : {shapes::grid(25, 25), shapes::bumpy_sphere(1500)}) {
        const PdeOperator A(Laplacian(mesh), 0.0, {0.0, 1.0});
        LinearSolver solver(A);
        const Constraints held = handles(mesh, 15, 11);
        const Block b = Block::Zero(mesh.vertex_count(), 1);
        Block by_sets = b;
        const BoundedSummary sets = solve_bounded(solver, b, held, between(-1.0, 1.0), by_sets);
        Block by_newton = b;
        const BoundedSummary newton =
            solve_bounded(solver, b, held, between(-1.0, 1.0), by_newton, {.active_sets = 1});
        EXPECT_EQ(sets.projected, 0);
        EXPECT_GT(sets.at_bounds, 0);
        EXPECT_EQ(newton.sets, newton.projected + 1);
        EXPECT_LT(relative_difference(by_newton, by_sets), 1e-8);
        expect_optimal(A, b, held, between(-1.0, 1.0), by_newton, 1e-9);
    }
}

TEST(BoundedSolver, WhatDoesNotOvershootIsTheLinearSolution) {
    const Mesh mesh = shapes::icosphere(3);
    LinearSolver solver(PdeOperator(Laplacian(mesh), 0.0, {1.0}));
    const Constraints held{{0, 0.0}, {100, 1.0}};
    const Block b = Block::Zero(mesh.vertex_count(), 1);
    Block free = b;
    ASSERT_TRUE(solver.solve(b, held, free).converged);
    for (const Bounds& bounds : {between(0.0, 1.0), between(-infinity, infinity)}) {
        Block u = b;
        const BoundedSummary summary = solve_bounded(solver, b, held, bounds, u);
        EXPECT_EQ(summary.sets, 1);
        EXPECT_EQ(summary.at_bounds, 0);
        EXPECT_LT(relative_difference(u, free), 1e-9);
    }
}

TEST(BoundedSolver, ColumnsHaveBoundsAndSetsOfTheirOwn) {
    const Mesh mesh = shapes::grid(20, 20);
    LinearSolver solver(PdeOperator(Laplacian(mesh), 0.0, {0.0, 1.0}));
    Constraints both(2);
    Constraints first;
    Constraints second;
    for (const auto& [v, x, y] :
         {std::tuple{30, 0.0, 5.0}, {200, 1.0, -5.0}, {205, 0.2, 4.0}, {400, 0.9, 0.0}}) {
        both.fix(v, std::array{x, y});
        first.fix(v, x);
        second.fix(v, y);
    }
    const Block zero = Block::Zero(mesh.vertex_count(), 1);
    Block u = Block::Zero(mesh.vertex_count(), 2);
    (void)solve_bounded(solver, Block::Zero(mesh.vertex_count(), 2), both,
                        {Eigen::Vector2d(0.0, -5.0), Eigen::Vector2d(1.0, infinity)}, u);
    Block a = zero;
    (void)solve_bounded(solver, zero, first, between(0.0, 1.0), a);
    Block b = zero;
    (void)solve_bounded(solver, zero, second, between(-5.0, infinity), b);
    EXPECT_LT(relative_difference(u.col(0), a.col(0)), 1e-12);
    EXPECT_LT(relative_difference(u.col(1), b.col(0)), 1e-12);
    EXPECT_GT(u.col(1).maxCoeff(), 5.0) << "no bound above there";
}

// An obstacle: a string under load that touches the floor between 0.5 - s and 0.5 + s, in closed form.
TEST(BoundedSolver, AMembraneUnderLoadRestsOnTheFloorWhereItShould) {
    // u'' = 8 on (0, 1/2 - s) with u = 1 at 0 and u = u' = 0 at 1/2 - s: (1/2 - s)^2 = 1/4 for load 8, so s = 0;
    // for load 32 the string touches from 1/4 to 3/4.
    constexpr int n = 400;
    Points points = Points::Zero(n + 1, 3);
    Cells cells(n, 2);
    for (int i = 0; i <= n; ++i) {
        points(i, 0) = static_cast<double>(i) / n;
        if (i < n) cells.row(i) << i, i + 1;
    }
    const Mesh string(points, cells);
    const Laplacian laplacian(string, {.renumber = false});
    LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}));
    const Block b = -32.0 * laplacian.mass();
    Block u = Block::Zero(n + 1, 1);
    const BoundedSummary summary = solve_bounded(solver, b, {{0, 1.0}, {n, 1.0}}, between(0.0, infinity), u);
    for (int i = 0; i <= n; ++i) {
        const double away = std::max(0.0, std::abs(points(i, 0) - 0.5) - 0.25);
        EXPECT_NEAR(u(i, 0), 16.0 * away * away, 1e-10);
    }
    EXPECT_NEAR(summary.at_bounds, n / 2, 2);
}

TEST(BoundedSolver, RefusesBoundsThatHoldNothing) {
    const Mesh mesh = shapes::icosphere(1);
    LinearSolver solver(PdeOperator(Laplacian(mesh), 0.0, {1.0}));
    const Constraints held{{0, 0.0}, {3, 1.0}};
    const Block b = Block::Zero(42, 1);
    Block u = b;
    EXPECT_THROW((void)solve_bounded(solver, b, held, between(1.0, 0.0), u), InputError);
    EXPECT_THROW((void)solve_bounded(solver, b, held, between(std::nan(""), 1.0), u), InputError);
    EXPECT_THROW((void)solve_bounded(solver, b, held, {Vector::Zero(2), Vector::Ones(2)}, u), InputError);
    EXPECT_THROW((void)solve_bounded(solver, b, {{42, 0.5}}, between(0.0, 1.0), u), InputError);
    Block wrong = Block::Zero(41, 1);
    EXPECT_THROW((void)solve_bounded(solver, b, held, between(0.0, 1.0), wrong), InputError);
}

}  // namespace
}  // namespace beltrami
