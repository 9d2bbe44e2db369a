#include "beltrami/solvers/conjugate_gradients.hpp"

#include <limits>

#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/pde_operator.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::random_block;
using testing::relative_difference;

struct Problem {
    PdeOperator A;
    std::vector<Index> held;
    Product product = [op = A](const Block& u, Block& y) { op.apply(u, y); };
    Vector inverse_diagonal = A.diagonal().cwiseInverse();

    Problem(const Mesh& mesh, double sigma, std::vector<double> gamma, std::vector<Index> held_vertices)
        : A(Laplacian(mesh), sigma, std::move(gamma)), held(std::move(held_vertices)) {}

    CgResult solve(const Block& b, Block& x, const CgOptions& options = {}) const {
        return conjugate_gradients(product, inverse_diagonal, held, b, x, options);
    }
    // By dense elimination of the held rows.
    [[nodiscard]] Block exact(const Block& b, const Block& x) const {
        const Eigen::MatrixXd matrix = dense(A.to_sparse());
        std::vector<char> is_held(static_cast<std::size_t>(A.rows()), 0);
        for (const Index v : held)
            is_held[static_cast<std::size_t>(v)] = 1;
        std::vector<Index> free;
        for (Index v = 0; v < A.rows(); ++v) {
            if (is_held[static_cast<std::size_t>(v)] == 0) free.push_back(v);
        }
        Block solution = x;
        const Eigen::MatrixXd load = b(free, Eigen::all) - matrix(free, held) * x(held, Eigen::all);
        const Eigen::MatrixXd A_ff = matrix(free, free);
        const Eigen::MatrixXd values = A_ff.ldlt().solve(load);
        solution(free, Eigen::all) = values;
        return solution;
    }
    // |x - y|_A / |y - (y with free values at zero)|_A, the largest of the columns.
    [[nodiscard]] double energy_error(const Block& x, const Block& y) const {
        Block zero = Block::Zero(y.rows(), y.cols());
        for (const Index v : held)
            zero.row(v) = y.row(v);
        const auto square = [&](const Block& e) -> Eigen::RowVectorXd {
            Block Ae;
            A.apply(e, Ae);
            return e.cwiseProduct(Ae).colwise().sum();
        };
        return std::sqrt((square(x - y).array() / square(y - zero).array()).maxCoeff());
    }
};

TEST(ConjugateGradients, AgreeWithDenseElimination) {
    const std::vector<Problem> problems{{shapes::with_noise(shapes::icosphere(2), 0.2), 0.0, {1.0}, {3, 77}},
                                        {shapes::fins(3, 5), 0.1, {1.0}, {}},
                                        {shapes::grid(9, 9), 0.0, {1.0, 0.1}, {0, 50, 99}},
                                        {shapes::tetrahedral_cube(4), 0.0, {1.0}, {0, 124}}};
    for (const Problem& problem : problems) {
        for (const Index k : {1, 3}) {
            const Block b = random_block(problem.A.rows(), k);
            Block x = random_block(problem.A.rows(), k, 2);
            const Block held_before = x(problem.held, Eigen::all);
            const Block expected = problem.exact(b, x);
            const CgResult result = problem.solve(b, x, {.tolerance = 1e-13});
            EXPECT_EQ(result.reason, StopReason::converged);
            EXPECT_LT(relative_difference(x, expected), 1e-9);
            EXPECT_EQ(Block(x(problem.held, Eigen::all)), held_before)
                << "held rows are read and never changed";
            EXPECT_LT(result.relative_residual, 1e-11);
            EXPECT_GE(result.products, result.iterations);
        }
    }
}

TEST(ConjugateGradients, SolveEveryColumnOnItsOwn) {
    const Problem problem(shapes::icosphere(3), 0.0, {1.0}, {0, 300});
    // Columns of very different size and difficulty, one of them without any load.
    Block b = random_block(problem.A.rows(), 5);
    b.col(1) *= 1e9;
    b.col(2) *= 1e-9;
    b.col(3).setZero();
    Block x = Block::Zero(problem.A.rows(), 5);
    const CgResult all = problem.solve(b, x);
    EXPECT_EQ(all.reason, StopReason::converged);
    int most = 0;
    for (Index c = 0; c < 5; ++c) {
        Block one = Block::Zero(problem.A.rows(), 1);
        most = std::max(most, problem.solve(b.col(c), one).iterations);
        EXPECT_LT(relative_difference(Block(x.col(c)), one), 1e-8) << "column " << c;
    }
    EXPECT_TRUE(x.col(3).isZero(0.0));
    EXPECT_NEAR(all.iterations, most, 2);
}

TEST(ConjugateGradients, TakeNoIterationFromTheSolution) {
    const Problem problem(shapes::icosphere(2), 0.0, {1.0}, {0});
    const Block b = random_block(problem.A.rows(), 2);
    Block x = problem.exact(b, Block::Zero(problem.A.rows(), 2));
    const Block before = x;
    EXPECT_EQ(problem.solve(b, x).iterations, 0);
    EXPECT_EQ(x, before);
}

TEST(ConjugateGradients, GiveZeroForNoLoadFromAnyStart) {
    const Problem problem(shapes::icosphere(2), 0.0, {1.0}, {0});
    for (const StoppingNorm norm :
         {StoppingNorm::scaled_residual, StoppingNorm::residual, StoppingNorm::energy_error}) {
        Block x = random_block(problem.A.rows(), 2);
        x.row(0).setZero();
        const CgResult result = problem.solve(Block::Zero(x.rows(), 2), x, {.norm = norm});
        EXPECT_EQ(result.reason, StopReason::converged);
        EXPECT_EQ(result.iterations, 0);
        EXPECT_TRUE(x.isZero(0.0));
    }
}

TEST(ConjugateGradients, ReportIndefiniteOperators) {
    const Vector diagonal = Vector::LinSpaced(10, -1.0, 8.0);
    const Product product = [&](const Block& u, Block& y) { y = diagonal.asDiagonal() * u; };
    Block x = Block::Zero(10, 2);
    const CgResult result =
        conjugate_gradients(product, Vector::Ones(10), {}, Block::Ones(10, 2), x, {.max_iterations = 100});
    EXPECT_EQ(result.reason, StopReason::not_definite);
    EXPECT_TRUE(x.allFinite());
}

TEST(ConjugateGradients, DoNotTakeNaNForConvergence) {
    const Problem problem(shapes::icosphere(1), 1.0, {1.0}, {});
    Block b = random_block(problem.A.rows(), 1);
    b(3, 0) = std::numeric_limits<double>::quiet_NaN();
    for (const StoppingNorm norm :
         {StoppingNorm::scaled_residual, StoppingNorm::residual, StoppingNorm::energy_error}) {
        Block x = Block::Zero(problem.A.rows(), 1);
        EXPECT_NE(problem.solve(b, x, {.norm = norm}).reason, StopReason::converged);
    }
}

TEST(ConjugateGradients, StopAtTheLimitWithTheLastIterate) {
    const Problem problem(shapes::icosphere(3), 0.0, {1.0}, {0});
    const Block b = random_block(problem.A.rows(), 1);
    Block x = Block::Zero(problem.A.rows(), 1);
    const CgResult result = problem.solve(b, x, {.max_iterations = 5});
    EXPECT_EQ(result.reason, StopReason::iteration_limit);
    EXPECT_EQ(result.iterations, 5);
    EXPECT_GT(result.error, 1e-10);
    EXPECT_TRUE(x.allFinite());
    EXPECT_FALSE(x.isZero());
}

TEST(ConjugateGradients, StopInTheNormThatWasAskedFor) {
    const Problem problem(shapes::with_noise(shapes::icosphere(3), 0.3), 0.0, {1.0}, {0});
    const Block b = random_block(problem.A.rows(), 1);
    const Vector ones = Vector::Ones(problem.A.rows());
    for (const StoppingNorm norm : {StoppingNorm::scaled_residual, StoppingNorm::residual}) {
        const Vector& weight = norm == StoppingNorm::residual ? ones : problem.inverse_diagonal;
        for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
            Block x = Block::Zero(problem.A.rows(), 1);
            const CgResult result = problem.solve(b, x, {.tolerance = tolerance, .norm = norm});
            Block r;
            Block r_0;
            masked_residual(problem.product, problem.held, b, x, r);
            masked_residual(problem.product, problem.held, b, Block::Zero(x.rows(), 1), r_0);
            const double reached = column_norms(r, weight)[0] / column_norms(r_0, weight)[0];
            EXPECT_LE(reached, 1.01 * tolerance);
            EXPECT_GT(reached, 0.1 * tolerance) << "no more iterations than were asked for";
            EXPECT_NEAR(result.error, reached, 0.01 * tolerance);
        }
    }
}

// The estimate sums terms that span the square of the tolerance: rounding of the first ones must not decide
// the end.
TEST(ConjugateGradients, EnergyErrorIsWhatTheEstimateSays) {
    const Problem problem(shapes::jittered(shapes::grid(14, 14), 0.2), 0.0, {0.0, 1.0},
                          {0, 14, 112, 210, 224});
    Block x = Block::Zero(problem.A.rows(), 2);
    x(0, 0) = 1.0;
    x(112, 1) = -3.0;
    const Block b = Block::Zero(problem.A.rows(), 2);
    const Block expected = problem.exact(b, x);
    for (const double tolerance : {1e-4, 1e-7, 1e-10}) {
        Block y = x;
        const CgResult result =
            problem.solve(b, y, {.tolerance = tolerance, .norm = StoppingNorm::energy_error});
        EXPECT_EQ(result.reason, StopReason::converged);
        EXPECT_LT(problem.energy_error(y, expected), 3.0 * tolerance) << tolerance;
        EXPECT_LT(result.iterations, 2000);
    }
}

// Convergence is steady here, so digits cost iterations in proportion; waiting for the estimate's own
// rounding does not.
TEST(ConjugateGradients, EnergyErrorStopsWhenItIsReached) {
    const Problem problem(shapes::grid(14, 14), 1.0, {0.1, 1e-3}, {0});
    const Block b = random_block(problem.A.rows(), 1);
    const Block expected = problem.exact(b, Block::Zero(b.rows(), 1));
    std::vector<double> iterations;
    for (const double tolerance : {1e-5, 1e-10}) {
        Block x = Block::Zero(b.rows(), 1);
        const CgResult result =
            problem.solve(b, x, {.tolerance = tolerance, .norm = StoppingNorm::energy_error});
        iterations.push_back(result.iterations);
        EXPECT_LT(problem.energy_error(x, expected), 1.5 * tolerance);
        EXPECT_LT(result.error, tolerance);
    }
    EXPECT_LT(iterations[1], 2.0 * iterations[0]);
}

TEST(ConjugateGradients, EnergyErrorIsRelativeToTheSolutionAlsoFromAGoodStart) {
    const Problem problem(shapes::grid(14, 14), 0.0, {0.0, 1.0}, {0, 14, 112, 210, 224});
    Block x = Block::Zero(problem.A.rows(), 1);
    x(112, 0) = 1.0;
    const Block b = Block::Zero(problem.A.rows(), 1);
    const CgOptions options{.tolerance = 1e-8, .norm = StoppingNorm::energy_error};
    Block y = x;
    const int cold = problem.solve(b, y, options).iterations;
    const Block solution = problem.exact(b, x);
    Block warm = solution;
    const CgResult again = problem.solve(b, warm, options);
    EXPECT_EQ(again.reason, StopReason::converged);
    EXPECT_LE(again.iterations, 25) << "the delay of the estimate; cold it took " << cold;
    EXPECT_LT(problem.energy_error(warm, solution), 1e-8);
    // And a start that is far away does not make the answer worse.
    Block far = 1e4 * random_block(problem.A.rows(), 1);
    for (const Index v : problem.held)
        far.row(v) = x.row(v);
    EXPECT_EQ(problem.solve(b, far, options).reason, StopReason::converged);
    EXPECT_LT(problem.energy_error(far, solution), 1e-6);
}

TEST(ConjugateGradients, CanBeCancelledBetweenIterations) {
    const Problem problem(shapes::icosphere(3), 0.0, {1.0}, {0});
    int reports = 0;
    Progress* self = nullptr;
    Progress progress([&](const ProgressReport&) {
        if (++reports == 4) self->cancel();
    });
    self = &progress;
    Block x = Block::Zero(problem.A.rows(), 1);
    EXPECT_THROW((void)problem.solve(random_block(problem.A.rows(), 1), x, {.progress = &progress}),
                 Cancelled);
    EXPECT_EQ(reports, 4);
}

TEST(ConjugateGradients, HandleNoColumnsAndNoFreeRows) {
    const Problem all_held(shapes::icosphere(0), 0.0, {1.0}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
    Block x = random_block(12, 2);
    const Block before = x;
    const CgResult result = all_held.solve(random_block(12, 2, 3), x);
    EXPECT_EQ(result.reason, StopReason::converged);
    EXPECT_EQ(result.iterations, 0);
    EXPECT_EQ(x, before);
    const Problem none(shapes::icosphere(0), 1.0, {1.0}, {});
    Block empty(12, 0);
    EXPECT_EQ(none.solve(Block(12, 0), empty).iterations, 0);
}

TEST(ColumnNorms, AreWeighted) {
    const Block r{{1.0, 2.0}, {3.0, 0.0}};
    const Vector norms = column_norms(r, Vector{{1.0, 4.0}});
    EXPECT_DOUBLE_EQ(norms[0], std::sqrt(1.0 + 36.0));
    EXPECT_DOUBLE_EQ(norms[1], 2.0);
}

}  // namespace
}  // namespace beltrami
