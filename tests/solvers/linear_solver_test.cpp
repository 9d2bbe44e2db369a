#include "beltrami/solvers/linear_solver.hpp"

#include <limits>
#include <string>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::random_block;
using testing::relative_difference;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// What the solver should find, and the forces that hold the vertices, by dense block elimination.
struct Reference {
    Block x;
    Block reaction;
};
Reference by_schur_complement(const LinearOperator& A, const Block& b, const Constraints& held) {
    const Eigen::MatrixXd matrix = dense(A.to_sparse());
    const std::vector<Index>& c = held.vertices();
    std::vector<Index> f;
    for (Index v = 0; v < A.rows(); ++v) {
        if (!held.is_fixed(v)) f.push_back(v);
    }
    Reference reference{Block::Zero(A.rows(), b.cols()), Block::Zero(A.rows(), b.cols())};
    held.impose(reference.x);
    const Eigen::MatrixXd A_ff = matrix(f, f);
    const Eigen::MatrixXd A_cf = matrix(c, f);
    const Eigen::MatrixXd x_c = reference.x(c, Eigen::all);
    const Eigen::MatrixXd b_f = b(f, Eigen::all);
    const Eigen::MatrixXd b_c = b(c, Eigen::all);
    const Eigen::LDLT<Eigen::MatrixXd> factor(A_ff);
    const Eigen::MatrixXd x_f = factor.solve(b_f - A_cf.transpose() * x_c);
    const Eigen::MatrixXd schur = Eigen::MatrixXd(matrix(c, c)) - A_cf * factor.solve(A_cf.transpose());
    const Eigen::MatrixXd force = schur * x_c + A_cf * factor.solve(b_f) - b_c;
    reference.x(f, Eigen::all) = x_f;
    reference.reaction(c, Eigen::all) = force;
    return reference;
}

Constraints some_held(Index n, Index columns, Index count) {
    Constraints held(columns);
    const Block values = random_block(count, columns, 9);
    for (Index i = 0; i < count; ++i) {
        held.fix((i * 37 + 5) % n, std::span(values.row(i).data(), static_cast<std::size_t>(columns)));
    }
    return held;
}

class EverySolver : public ::testing::TestWithParam<SolverKind> {};

TEST_P(EverySolver, AgreeWithTheSchurComplementAlsoInReactions) {
    const std::vector<PdeOperator> operators{
        {Laplacian(shapes::with_noise(shapes::icosphere(2), 0.2)), 0.0, {1.0}},
        {Laplacian(shapes::fins(3, 5)), 1.0, {0.01}},
        {Laplacian(shapes::jittered(shapes::grid(10, 8), 0.2)), 0.0, {1.0, 0.1}},
        {Laplacian(shapes::grid(8, 8)), 0.0, {0.0, 1.0}},
        {Laplacian(shapes::with_noise(shapes::tetrahedral_cube(4), 0.1)), 0.0, {1.0}},
        {Laplacian(shapes::circle(30)), 0.0, {1.0}}};
    for (const PdeOperator& A : operators) {
        for (const Index k : {1, 3}) {
            const Constraints held = some_held(A.rows(), k, 7);
            const Block b = random_block(A.rows(), k);
            const Reference expected = by_schur_complement(A, b, held);
            LinearSolver solver(A, {.kind = GetParam(), .tolerance = 1e-12});
            Block x = Block::Zero(A.rows(), k);
            const LinearSummary summary = solver.solve(b, held, x);
            EXPECT_TRUE(summary.converged) << summary.full();
            EXPECT_LT(relative_difference(x, expected.x), 1e-7) << summary.full();
            Block reaction;
            solver.reaction(b, x, held, reaction);
            EXPECT_LT(relative_difference(reaction, expected.reaction), 1e-7);
            EXPECT_EQ(summary.unknowns, A.rows() - 7);
            EXPECT_EQ(summary.columns, k);
            for (const Index v : held.vertices())
                EXPECT_EQ(x(v, 0), held.value(v)[0]);
        }
    }
}

TEST_P(EverySolver, ReactionsBalanceTheLoadOnEachComponent) {
    const Mesh two = shapes::together({shapes::icosphere(2), shapes::with_noise(shapes::icosphere(1), 0.2)});
    const Laplacian laplacian(two);
    for (const std::vector<double>& gamma : {std::vector{1.0}, std::vector{0.5, 0.1}}) {
        LinearSolver solver(PdeOperator(laplacian, 0.0, gamma), {.kind = GetParam(), .tolerance = 1e-12});
        Constraints held;
        for (const Index v : {0, 33, 161, 170, 190})
            held.fix(laplacian.order().working(v), 0.1 * v);
        const Block b = random_block(laplacian.vertex_count(), 1);
        Block x = Block::Zero(b.rows(), 1);
        ASSERT_TRUE(solver.solve(b, held, x).converged);
        Block f;
        solver.reaction(b, x, held, f);
        const Components components = connected_components(laplacian.graph());
        Vector sums = Vector::Zero(components.count);
        for (Index v = 0; v < laplacian.vertex_count(); ++v) {
            sums[components.of_vertex[static_cast<std::size_t>(v)]] += f(v, 0) + b(v, 0);
        }
        EXPECT_EQ(components.count, 2);
        EXPECT_LT(sums.cwiseAbs().maxCoeff(), 1e-8 * f.cwiseAbs().maxCoeff());
        EXPECT_EQ((f.array() != 0.0).count(), 5) << "forces act at held vertices alone";
    }
}

TEST_P(EverySolver, SolveColumnsAsIfTheyWereAlone) {
    const Laplacian laplacian(shapes::icosphere(3));
    const Constraints held = some_held(laplacian.vertex_count(), 4, 5);
    const Block b = random_block(laplacian.vertex_count(), 4);
    Block together = Block::Zero(b.rows(), 4);
    LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}), {.kind = GetParam(), .tolerance = 1e-12});
    ASSERT_TRUE(solver.solve(b, held, together).converged);
    for (Index c = 0; c < 4; ++c) {
        Constraints one;
        for (const Index v : held.vertices())
            one.fix(v, held.value(v)[static_cast<std::size_t>(c)]);
        Block x = Block::Zero(b.rows(), 1);
        ASSERT_TRUE(solver.solve(b.col(c), one, x).converged);
        EXPECT_LT(relative_difference(Block(together.col(c)), x), 1e-9);
    }
}

TEST_P(EverySolver, NothingToDoIsDone) {
    const Laplacian laplacian(shapes::icosphere(1));
    const Index n = laplacian.vertex_count();
    LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}), {.kind = GetParam()});
    Constraints all;
    for (Index v = 0; v < n; ++v)
        all.fix(v, 0.5 * v);
    Block x = random_block(n, 1);
    const LinearSummary held_all = solver.solve(random_block(n, 1, 2), all, x);
    EXPECT_TRUE(held_all.converged);
    EXPECT_EQ(held_all.iterations, 0);
    EXPECT_EQ(held_all.unknowns, 0);
    EXPECT_EQ(x(7, 0), 3.5);
    x.setZero();
    const LinearSummary no_load = solver.solve(Block::Zero(n, 1), Constraints{{3, 0.0}}, x);
    EXPECT_TRUE(no_load.converged);
    EXPECT_EQ(no_load.iterations, 0);
    EXPECT_TRUE(x.isZero(0.0));
    x = random_block(n, 1);  // no load, but a start: what nothing pulls falls to zero
    EXPECT_TRUE(solver.solve(Block::Zero(n, 1), Constraints{{3, 0.0}}, x).converged);
    EXPECT_LT(x.cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(EverySolver, LeaveIsolatedVerticesAsTheyAre) {
    Points points(43, 3);
    points << shapes::icosphere(1).points(), 9.0, 9.0, 9.0;
    const Laplacian laplacian(Mesh(points, shapes::icosphere(1).cells()));
    const Index isolated = laplacian.order().working(42);
    for (const double sigma : {0.0, 1.0}) {
        LinearSolver solver(PdeOperator(laplacian, sigma, {1.0}), {.kind = GetParam()});
        Block x = Block::Constant(43, 1, 7.0);
        const Index other = isolated == 0 ? 1 : 0;
        const LinearSummary summary = solver.solve(random_block(43, 1), Constraints{{other, 1.0}}, x);
        EXPECT_TRUE(summary.converged);
        EXPECT_EQ(summary.unknowns, 41);
        EXPECT_EQ(x(isolated, 0), 7.0);
        ASSERT_TRUE(
            solver.solve(random_block(43, 1), Constraints{{other, 1.0}, {isolated, 2.0}}, x).converged);
        EXPECT_EQ(x(isolated, 0), 2.0) << "unless it is held";
    }
}

// No constraint and a load that pulls the sphere away: there is no solution, and none may be claimed.
TEST_P(EverySolver, DoNotClaimToSolveASingularProblem) {
    const Laplacian laplacian(shapes::icosphere(3));
    LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}), {.kind = GetParam(), .max_iterations = 2000});
    Block x = Block::Zero(laplacian.vertex_count(), 1);
    const Block b = Block::Ones(laplacian.vertex_count(), 1);
    EXPECT_THROW(require_converged(solver.solve(b, Constraints(), x)), SolveError);
}

TEST_P(EverySolver, SayWhenAToleranceIsOutOfReach) {
    const Laplacian laplacian(shapes::with_noise(shapes::icosphere(3), 0.2));
    LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}), {.kind = GetParam(), .tolerance = 1e-30});
    Block x = Block::Zero(laplacian.vertex_count(), 1);
    const LinearSummary summary =
        solver.solve(random_block(laplacian.vertex_count(), 1), Constraints{{0, 1.0}}, x);
    EXPECT_FALSE(summary.converged);
    EXPECT_NE(summary.reason, StopReason::converged);
    EXPECT_LT(summary.relative_residual, 1e-12) << "but x is as good as it gets";
    EXPECT_THROW(require_converged(summary), SolveError);
    EXPECT_NE(summary.brief().find("NOT CONVERGED"), std::string::npos);
}

TEST_P(EverySolver, RefuseWrongShapesAndNumbers) {
    const Laplacian laplacian(shapes::icosphere(0));
    LinearSolver solver(PdeOperator(laplacian, 1.0, {1.0}), {.kind = GetParam()});
    const Block b = Block::Ones(12, 2);
    Block x = Block::Zero(12, 2);
    Block narrow = Block::Zero(12, 1);
    Block few = Block::Zero(11, 2);
    EXPECT_THROW((void)solver.solve(few, Constraints(2), x), InputError);
    EXPECT_THROW((void)solver.solve(b, Constraints(2), few), InputError);
    EXPECT_THROW((void)solver.solve(b, Constraints(2), narrow), InputError);
    EXPECT_THROW((void)solver.solve(b, Constraints{{0, 1.0}}, x), InputError);
    EXPECT_THROW((void)solver.solve(Block::Ones(12, 1), Constraints{{12, 1.0}}, narrow), InputError);
    Block broken = b;
    broken(3, 1) = nan;
    EXPECT_THROW((void)solver.solve(broken, Constraints(2), x), InputError);
    broken = Block::Zero(12, 2);
    broken(3, 1) = std::numeric_limits<double>::infinity();
    EXPECT_THROW((void)solver.solve(b, Constraints(2), broken), InputError);
}

TEST_P(EverySolver, CanBeCancelled) {
    const Laplacian laplacian(shapes::icosphere(2));
    Progress* self = nullptr;
    Progress progress([&](const ProgressReport&) { self->cancel(); });
    self = &progress;
    LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}), {.kind = GetParam(), .progress = &progress});
    Block x = Block::Zero(laplacian.vertex_count(), 1);
    EXPECT_THROW((void)solver.solve(random_block(laplacian.vertex_count(), 1), Constraints{{0, 1.0}}, x),
                 Cancelled);
}

INSTANTIATE_TEST_SUITE_P(All, EverySolver,
                         ::testing::Values(SolverKind::cg, SolverKind::multigrid, SolverKind::cholesky),
                         [](const auto& info) { return std::string(name(info.param)); });

// Meshes on which the hierarchy has several levels.
TEST(LinearSolver, MultigridAgreesWithCholesky) {
    const std::vector<Mesh> meshes{shapes::bumpy_sphere(4000), shapes::jittered(shapes::grid(60, 60), 0.3),
                                   shapes::fins(3, 40),
                                   shapes::with_noise(shapes::tetrahedral_cube(12), 0.1)};
    for (const Mesh& mesh : meshes) {
        const Laplacian laplacian(mesh);
        const double h2 = laplacian.mass().sum() / laplacian.vertex_count();
        const auto hierarchy = std::make_shared<const Hierarchy>(
            laplacian.graph(), *laplacian.points(), HierarchyOptions{.radius = 2.3, .coarsest = 60});
        EXPECT_GE(hierarchy->level_count(), 2);
        const std::vector<PdeOperator> operators{{laplacian, 1.0, {100.0 * h2}},
                                                 {laplacian, 0.0, {1.0}},
                                                 {laplacian, 0.0, {1.0, h2}},
                                                 {laplacian, 0.5, {0.0, 1.0}},
                                                 {laplacian, 0.0, {0.0, 1.0}}};
        for (const PdeOperator& A : operators) {
            const Constraints held = some_held(A.rows(), 3, 40);
            const Block b = laplacian.mass().asDiagonal() * random_block(A.rows(), 3);
            Block expected = Block::Zero(A.rows(), 3);
            LinearSolver direct(A, {.kind = SolverKind::cholesky, .tolerance = 1e-12});
            (void)direct.solve(b, held, expected);
            Block x = Block::Zero(A.rows(), 3);
            LinearSolver solver(A, {.kind = SolverKind::multigrid, .hierarchy = hierarchy});
            const LinearSummary summary = solver.solve(b, held, x);
            EXPECT_TRUE(summary.converged) << summary.full();
            EXPECT_EQ(summary.solver, "multigrid");
            EXPECT_EQ(summary.factorizations, 1);
            EXPECT_LE(summary.iterations, 80) << summary.full();
            EXPECT_LT(relative_difference(x, expected), 2e-7) << summary.full();
            EXPECT_EQ(solver.solve(b, held, x).factorizations, 0) << "the cycle is kept";
            EXPECT_EQ(solver.hierarchy(), hierarchy);
        }
    }
}

TEST(LinearSolver, GreensFunctionsAgreeWithCholesky) {
    const Mesh two = shapes::together({shapes::with_noise(shapes::icosphere(3), 0.1), shapes::grid(20, 20)});
    for (const Mesh& mesh : {shapes::bumpy_sphere(2000), two}) {
        const Laplacian laplacian(mesh);
        const Components components = connected_components(laplacian.graph());
        const PdeOperator A(laplacian, 0.0, {0.0, 0.3});
        for (const Index count : {1, 2, 25}) {
            if (count < components.count) continue;
            Constraints held(2);
            // One on each component, then anywhere; also side by side.
            for (Index v = 0, c = 0; c < components.count; ++v) {
                if (components.of_vertex[static_cast<std::size_t>(v)] != c) continue;
                held.fix(v, std::vector<double>{0.5, 1.0 * c++});
            }
            for (Index i = 0; static_cast<Index>(held.vertices().size()) < count; ++i)
                held.fix(i % 3 == 0 ? 200 + i : (i * 37 + 5) % A.rows(), std::vector<double>{0.1 * i, 1.0});
            for (const bool loaded : {false, true}) {
                const Block b = (loaded ? 1.0 : 0.0) * random_block(A.rows(), 2);
                Block expected = Block::Zero(A.rows(), 2);
                LinearSolver direct(A, {.kind = SolverKind::cholesky});
                (void)direct.solve(b, held, expected);
                Block x = Block::Zero(A.rows(), 2);
                LinearSolver green(A, {.kind = SolverKind::green});
                const LinearSummary summary = green.solve(b, held, x);
                EXPECT_TRUE(summary.converged) << summary.full();
                EXPECT_EQ(summary.solver, "green");
                EXPECT_LT(relative_difference(x, expected), 1e-7) << count << " held; " << summary.full();
            }
        }
    }
    LinearSolver mixed(PdeOperator(Laplacian(two), 0.0, {1.0, 1.0}), {.kind = SolverKind::green});
    Block x = Block::Zero(two.vertex_count(), 1);
    EXPECT_THROW((void)mixed.solve(x, Constraints{{0, 1.0}}, x), InputError);
    LinearSolver unheld(PdeOperator(Laplacian(two), 0.0, {0.0, 1.0}), {.kind = SolverKind::green});
    EXPECT_THROW((void)unheld.solve(x, Constraints{{0, 1.0}}, x), SolveError);
}

// A limit that multigrid cannot keep: the factor takes over, and says so.
// With K D K a residual and an energy say little about u: what multigrid stops on is an upper bound, and no large one.
TEST(LinearSolver, MultigridEstimatesTheErrorOfU) {
    const Index n = 5000;
    const Laplacian laplacian(shapes::bumpy_sphere(n));
    const PdeOperator A(laplacian, 0.0, {0.0, 1.0});
    for (const Index count : {2, 30, 500}) {
        Constraints held;
        for (Index c = 0; c < count; ++c)
            held.fix(c * (n / count), static_cast<double>(c * 7919 % 101));
        const Block b = Block::Zero(n, 1);
        Block expected = b;
        LinearSolver direct(A, {.kind = SolverKind::cholesky});
        EXPECT_TRUE(direct.solve(b, held, expected).converged);
        for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
            Block x = b;
            LinearSolver solver(A, {.kind = SolverKind::multigrid, .tolerance = tolerance});
            const LinearSummary summary = solver.solve(b, held, x);
            EXPECT_TRUE(summary.converged) << summary.full();
            EXPECT_EQ(summary.norm, StoppingNorm::refinement);
            const double error = (x - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
            EXPECT_LT(error, summary.error) << count << " held, " << tolerance;
            EXPECT_GT(error, summary.error / 100.0) << count << " held, " << tolerance;
        }
    }
}

TEST(LinearSolver, FallsBackToCholesky) {
    const Laplacian laplacian(shapes::tetrahedral_cube(34));
    const PdeOperator A(laplacian, 0.0, {1.0});
    const Block b = random_block(A.rows(), 1);
    const Constraints held{{0, 1.0}};
    LinearSolver solver(A, {.tolerance = 1e-8});
    Block x = Block::Zero(A.rows(), 1);
    const LinearSummary summary = solver.solve(b, held, x);
    EXPECT_EQ(summary.solver, "multigrid") << summary.full();
    EXPECT_TRUE(summary.converged);
    EXPECT_LE(summary.iterations, 30);
    int cycles = 0;
    const Progress progress(
        [&](const ProgressReport& report) { cycles += report.phase == "conjugate gradients" ? 1 : 0; });
    LinearSolver limited(
        A, {.tolerance = 1e-8, .max_iterations = 2, .hierarchy = solver.hierarchy(), .progress = &progress});
    Block y = Block::Zero(A.rows(), 1);
    const LinearSummary other = limited.solve(b, held, y);
    EXPECT_EQ(other.solver, "cholesky");
    EXPECT_TRUE(other.converged);
    EXPECT_NE(other.why.find("multigrid was tried first"), std::string::npos) << other.why;
    EXPECT_LT(relative_difference(x, y), 1e-6);
    EXPECT_GT(cycles, 0);

    // What has failed is not tried again.
    cycles = 0;
    EXPECT_EQ(limited.solve(2.0 * b, held, y).why, other.why);
    EXPECT_EQ(cycles, 0);
}

TEST(LinearSolver, OneSymbolicAnalysisServesAMesh) {
    const Laplacian laplacian(shapes::icosphere(3));
    const long before = CholeskyAnalysis::builds();
    LinearSolver first(PdeOperator(laplacian, 0.0, {1.0}), {.kind = SolverKind::cholesky});
    Block x = Block::Zero(laplacian.vertex_count(), 1);
    const Block b = random_block(laplacian.vertex_count(), 1);
    ASSERT_TRUE(first.solve(b, Constraints{{0, 1.0}}, x).converged);
    for (const double t : {0.1, 0.2}) {
        LinearSolver other(PdeOperator(laplacian, 1.0, {t}),
                           {.kind = SolverKind::cholesky, .analysis = first.analysis()});
        ASSERT_TRUE(other.solve(b, Constraints(), x).converged);
        ASSERT_TRUE(other.solve(b, some_held(x.rows(), 1, 30), x).converged);
    }
    EXPECT_EQ(CholeskyAnalysis::builds(), before + 1);
}

TEST(LinearSolver, AnalysesAheadWhereItWillFactor) {
    const Laplacian laplacian(shapes::icosphere(3));
    const LinearSolverOptions often{.expected_solves = 1000};
    const long before = CholeskyAnalysis::builds();
    LinearSolver ahead(PdeOperator(laplacian, 0.0, {1.0, 1.0}), often);
    ahead.analyse();
    ahead.analyse();
    ASSERT_NE(ahead.analysis(), nullptr);
    LinearSolverOptions with = often;
    with.analysis = ahead.analysis();
    LinearSolver later(PdeOperator(laplacian, 0.0, {0.0, 0.2}), with);
    const Constraints held{{0, 1.0}, {30, 2.0}};
    const Block b = Block::Zero(laplacian.vertex_count(), 1);
    Block x = b;
    ASSERT_TRUE(later.solve(b, held, x).converged);
    EXPECT_EQ(CholeskyAnalysis::builds(), before + 1);
    EXPECT_LT(relative_difference(x, by_schur_complement(later.op(), b, held).x), 1e-8);

    LinearSolver other(PdeOperator(laplacian, 0.0, {1.0}), {.kind = SolverKind::cg});
    other.analyse();
    EXPECT_EQ(other.analysis(), nullptr);
}

TEST(LinearSolver, MovingAConstraintRebuildsNothing) {
    const long before = EdgeOperator<double>::builds();
    const Laplacian laplacian(shapes::icosphere(3));
    LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}), {.kind = SolverKind::cg});
    const Block b = Block::Zero(laplacian.vertex_count(), 1);
    Block x = b;
    Constraints held{{0, 1.0}};
    for (Index change = 0; change < 100; ++change) {
        held.free(change);
        held.fix(change + 1, 1.0);
        held.fix(400 + change % 7, -1.0);
        const LinearSummary summary = solver.solve(b, held, x);
        ASSERT_TRUE(summary.converged);
        EXPECT_EQ(summary.factorizations, 0);
        EXPECT_EQ(x(change + 1, 0), 1.0);
    }
    EXPECT_EQ(EdgeOperator<double>::builds(), before + 1);
    EXPECT_LT(relative_difference(x, by_schur_complement(solver.op(), b, held).x), 1e-8);
}

TEST(LinearSolver, AFactorIsKeptWhileTheHeldSetStays) {
    const Laplacian laplacian(shapes::icosphere(2));
    LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}), {.kind = SolverKind::cholesky});
    const Block b = random_block(laplacian.vertex_count(), 1);
    Block x = Block::Zero(b.rows(), 1);
    const auto factorizations = [&](const Constraints& held) {
        const LinearSummary summary = solver.solve(b, held, x);
        EXPECT_TRUE(summary.converged);
        EXPECT_LT(relative_difference(x, by_schur_complement(solver.op(), b, held).x), 1e-9);
        return summary.factorizations;
    };
    Constraints held{{5, 1.0}, {80, 2.0}};
    EXPECT_EQ(factorizations(held), 1);
    EXPECT_EQ(factorizations(held), 0);
    held.fix(5, -3.0);
    EXPECT_EQ(factorizations(held), 0) << "only a value changed";
    EXPECT_EQ(factorizations(Constraints{{80, 1.0}, {5, 1.0}}), 0) << "the same set in another order";
    held.fix(6, 0.0);
    EXPECT_EQ(factorizations(held), 0) << "one more is a correction";
    held.free(6);
    held.free(5);
    held.fix(7, 0.0);
    EXPECT_EQ(factorizations(held), 0) << "as many as at first, but others";
    for (Index v = 100; v < 130; ++v)
        held.fix(v, 0.1 * v);
    EXPECT_EQ(factorizations(held), 1) << "most are new, and many";
    EXPECT_EQ(factorizations(Constraints{{5, 1.0}, {80, 2.0}}), 1) << "all rows again";
}

TEST(LinearSolver, AutomaticChoiceFitsTheProblem) {
    const auto choice = [](const Mesh& mesh, double sigma, std::vector<double> gamma, int expected_solves) {
        const Laplacian laplacian(mesh);
        LinearSolver solver(PdeOperator(laplacian, sigma, std::move(gamma)),
                            {.expected_solves = expected_solves});
        Block x = Block::Zero(laplacian.vertex_count(), 1);
        const LinearSummary summary =
            solver.solve(random_block(laplacian.vertex_count(), 1), Constraints{{0, 1.0}}, x);
        EXPECT_TRUE(summary.converged) << summary.full();
        EXPECT_GT(summary.why.size(), 20U) << summary.why;
        return summary.solver;
    };
    const Mesh plate = shapes::grid(80, 80);
    EXPECT_EQ(choice(plate, 1.0, {1e-4}, 1), "cg") << "a short step of heat";
    EXPECT_EQ(choice(plate, 0.0, {0.0, 1.0}, 1), "cholesky") << "bi-Laplacian";
    EXPECT_EQ(choice(plate, 0.0, {1.0, 0.1}, 1), "cholesky") << "mixed";
    EXPECT_EQ(choice(plate, 0.0, {1.0}, 500), "cholesky") << "many solves pay for a factor";
    EXPECT_EQ(choice(shapes::tetrahedral_cube(20), 0.0, {1.0}, 1), "cg") << "factors of solids fill in";
}

TEST(LinearSolver, ObeysWhoChooses) {
    const Laplacian laplacian(shapes::icosphere(1));
    for (const auto kind : {SolverKind::cg, SolverKind::cholesky}) {
        LinearSolver solver(PdeOperator(laplacian, 0.0, {0.0, 1.0}), {.kind = kind, .expected_solves = 1000});
        Block x = Block::Zero(42, 1);
        const LinearSummary summary = solver.solve(random_block(42, 1), Constraints{{0, 1.0}, {9, 0.0}}, x);
        EXPECT_EQ(summary.solver, kind == SolverKind::cg ? "cg" : "cholesky");
        EXPECT_EQ(summary.why, "asked for");
        EXPECT_TRUE(summary.converged) << summary.full();
    }
}

TEST(LinearSolver, KeepsTheHistoryOfTheLastSolve) {
    const Laplacian laplacian(shapes::icosphere(4));
    const Block b = random_block(laplacian.vertex_count(), 2);
    const Constraints held = some_held(laplacian.vertex_count(), 2, 3);
    for (const auto& gamma : {std::vector{1.0}, std::vector{0.0, 1.0}}) {
        for (const auto kind : {SolverKind::cg, SolverKind::multigrid, SolverKind::cholesky}) {
            LinearSolver solver(PdeOperator(laplacian, 0.0, gamma), {.kind = kind});
            Block x = Block::Zero(laplacian.vertex_count(), 2);
            const LinearSummary summary = solver.solve(b, held, x);
            ASSERT_TRUE(summary.converged) << summary.full();
            ASSERT_EQ(summary.history.size(), static_cast<std::size_t>(summary.iterations));
            if (summary.history.empty()) continue;  // a factor was exact at once
            EXPECT_LE(summary.history.back(), summary.tolerance);
            LinearSummary total = summary;
            Block again = Block::Zero(laplacian.vertex_count(), 2);
            const LinearSummary later = solver.solve(2.0 * b, held, again);
            total.add(later);
            EXPECT_EQ(total.history.size(), later.history.size());
        }
    }
}

TEST(LinearSolver, StopsAtTheLimitOfIterations) {
    const Laplacian laplacian(shapes::icosphere(3));
    LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}), {.kind = SolverKind::cg, .max_iterations = 4});
    Block x = Block::Zero(laplacian.vertex_count(), 1);
    const LinearSummary summary =
        solver.solve(random_block(laplacian.vertex_count(), 1), Constraints{{0, 1.0}}, x);
    EXPECT_EQ(summary.reason, StopReason::iteration_limit);
    EXPECT_EQ(summary.iterations, 4);
    EXPECT_FALSE(summary.converged);
    try {
        require_converged(summary);
        FAIL();
    } catch (const SolveError& error) {
        EXPECT_EQ(error.exit_status(), 3);
        EXPECT_NE(std::string(error.what()).find("after 4 iterations"), std::string::npos) << error.what();
        EXPECT_FALSE(error.hint().empty());
    }
}

TEST(LinearSolver, ScalingTheUnitsChangesNoIteration) {
    int iterations = 0;
    for (const double size : {1.0, 1e-4, 1e5}) {
        const Laplacian laplacian(shapes::tetrahedral_ball(6, size));
        LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}), {.kind = SolverKind::cg});
        Block x = Block::Zero(laplacian.vertex_count(), 1);
        const LinearSummary summary =
            solver.solve(Block::Zero(x.rows(), 1), Constraints{{0, 1.0}, {100, 0.0}}, x);
        EXPECT_TRUE(summary.converged);
        if (iterations == 0) iterations = summary.iterations;
        EXPECT_NEAR(summary.iterations, iterations, 1);
    }
}

TEST(LinearSolverOptions, RefuseWhatIsNotPositive) {
    const PdeOperator A(Laplacian(shapes::icosphere(0)), 1.0, {1.0});
    for (const double bad : {0.0, -1e-10, nan, std::numeric_limits<double>::infinity()}) {
        EXPECT_THROW(LinearSolver(A, {.tolerance = bad}), InputError);
    }
    EXPECT_THROW(LinearSolver(A, {.max_iterations = 0}), InputError);
    EXPECT_THROW(LinearSolver(A, {.expected_solves = 0}), InputError);
}

TEST(LinearSummary, AddsCountsAndKeepsTheWorst) {
    LinearSummary sum;
    LinearSummary first;
    first.solver = "cg";
    first.converged = true;
    first.reason = StopReason::converged;
    first.iterations = 3;
    first.error = 1e-11;
    LinearSummary second = first;
    second.solver = "cholesky";
    second.iterations = 4;
    second.factorizations = 1;
    second.error = 1e-3;
    second.converged = false;
    second.reason = StopReason::stagnated;
    sum.add(first);
    sum.add(second);
    sum.add(first);
    EXPECT_EQ(sum.iterations, 10);
    EXPECT_EQ(sum.factorizations, 1);
    EXPECT_EQ(sum.error, 1e-3);
    EXPECT_FALSE(sum.converged) << "one solve that failed is not forgotten";
    EXPECT_EQ(sum.reason, StopReason::stagnated);
}

}  // namespace
}  // namespace beltrami
