#include "beltrami/solvers/tangent_field.hpp"

#include <gtest/gtest.h>

#include <array>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/connection_laplacian.hpp"
#include "beltrami/operators/hermitian_pde_operator.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::random_block;
using testing::relative_difference;

HermitianPdeOperator pde(const Mesh& mesh, double sigma, const std::vector<double>& gamma) {
    const Laplacian laplacian(mesh);
    return {connection_laplacian(mesh, laplacian, tangent_frames(mesh)), laplacian, sigma, gamma};
}

// Both solvers against a dense factor of the real form, with and without K D K and mass.
TEST(TangentField, BothSolversSolveTheRealForm) {
    for (const Mesh& mesh : {shapes::with_noise(shapes::icosphere(2), 0.3), shapes::fins(3, 5)}) {
        for (const auto& [sigma, gamma] :
             {std::pair{0.0, std::vector{1.0}}, {0.0, std::vector{1.0, 0.1}}, {0.5, std::vector{0.0, 1.0}}}) {
            const HermitianPdeOperator A = pde(mesh, sigma, gamma);
            const Eigen::MatrixXd matrix = dense(A.to_sparse());
            const Constraints held{{8, 1.0}, {9, -0.5}, {40, 0.0}, {41, 2.0}};
            std::vector<Index> free;
            for (Index r = 0; r < A.rows(); ++r) {
                if (!held.is_fixed(r)) free.push_back(r);
            }
            const Block b = random_block(A.rows(), 1);
            Block expected = Block::Zero(A.rows(), 1);
            held.impose(expected);
            const Eigen::MatrixXd load = b - matrix * expected;
            const Eigen::MatrixXd A_ff = matrix(free, free);
            const Eigen::MatrixXd b_f = load(free, Eigen::all);
            const Eigen::MatrixXd x_f = A_ff.ldlt().solve(b_f);
            expected(free, Eigen::all) = x_f;
            for (const SolverKind kind : {SolverKind::cg, SolverKind::cholesky}) {
                LinearSolver solver(A, {.kind = kind, .tolerance = 1e-12});
                Block x = Block::Zero(A.rows(), 1);
                const LinearSummary summary = solver.solve(b, held, x);
                EXPECT_TRUE(summary.converged) << summary.full();
                EXPECT_LT(relative_difference(x, expected), 1e-7) << summary.full();
                EXPECT_EQ(summary.unknowns, A.rows() - 4);
            }
        }
    }
}

TEST(TangentField, TheChoiceOfASolverKnowsBothNumbersOfAVertex) {
    const Mesh plate = shapes::grid(60, 60);
    for (const auto& [gamma, expected] :
         {std::pair{std::vector{0.0, 1.0}, "cholesky"}, {std::vector{1e-6}, "cg"}}) {
        LinearSolver solver(pde(plate, gamma.size() == 1 ? 1.0 : 0.0, gamma));
        Block x = Block::Zero(2 * plate.vertex_count(), 1);
        const LinearSummary summary =
            solver.solve(random_block(x.rows(), 1), Constraints{{0, 1.0}, {1, 1.0}}, x);
        EXPECT_EQ(summary.solver, expected) << summary.why;
        EXPECT_TRUE(summary.converged);
    }
}

TEST(TangentField, ProjectsAndTellsHowFar) {
    const Mesh plane = shapes::grid(2, 2);
    const TangentFrames frames = tangent_frames(plane);
    Constraints given(3);
    given.fix(0, std::array{1.0, 2.0, 0.0});
    given.fix(4, std::array{0.0, 3.0, std::sqrt(3.0)});
    given.fix(8, std::array{0.0, 0.0, 0.0});
    const TangentVectors tangent = project(frames, given);
    EXPECT_NEAR(tangent.largest_tilt, 30.0, 1e-12);
    EXPECT_EQ(tangent.most_tilted, 4);
    EXPECT_NEAR(tangent.vectors.value(4)[1], 3.0, 1e-14);
    EXPECT_NEAR(tangent.vectors.value(4)[2], 0.0, 1e-14);
    EXPECT_NEAR(tangent.vectors.value(0)[0], 1.0, 1e-14);
    EXPECT_EQ(tangent.vectors.value(8)[0], 0.0) << "a zero is a vector like others";
    Constraints zero(3);
    zero.fix(3, std::array{0.0, 0.0, 0.0});
    EXPECT_EQ(project(frames, zero).most_tilted, -1);
}

TEST(TangentField, RefusesVectorsThatAreNone) {
    Points points(10, 3);
    points << shapes::grid(2, 2).points(), 7.0, 7.0, 7.0;
    const TangentFrames frames = tangent_frames(Mesh(points, shapes::grid(2, 2).cells()));
    const auto refused = [&](Index v, const std::array<double, 3>& vector) {
        Constraints given(3);
        given.fix(v, vector);
        EXPECT_THROW((void)project(frames, given), InputError);
    };
    refused(4, {0.0, 0.0, 1.0});
    refused(9, {1.0, 0.0, 0.0});
    refused(10, {1.0, 0.0, 0.0});
    EXPECT_THROW((void)project(frames, Constraints{{0, 1.0}}), InputError);
    const Mesh fins = shapes::fins(3, 2);
    Constraints on_line(3);
    on_line.fix(1, std::array{0.0, 0.0, 1.0});
    EXPECT_THROW((void)project(tangent_frames(fins), on_line), InputError);
}

TEST(TangentField, InterpolatedLengthsKeepDirections) {
    const Mesh sphere = shapes::icosphere(3);
    const Laplacian laplacian(sphere);
    const TangentFrames frames = tangent_frames(sphere);
    Constraints given(3);
    given.fix(0, std::array{2.0, 0.0, 0.0});
    given.fix(300, std::array{0.0, 2.0, 1.0});
    const Constraints held = project(frames, given).vectors;
    const TangentField field = solve_by_connection(sphere, laplacian, frames, held, {1.0}, {});
    const TangentField even = with_interpolated_lengths(field, laplacian, held, {1.0}, {});
    const double a = Eigen::Map<const Vector3>(held.value(0).data()).norm();
    const double b = Eigen::Map<const Vector3>(held.value(300).data()).norm();
    for (Index v = 0; v < sphere.vertex_count(); ++v) {
        const Vector3 before = field.vectors.row(v);
        const Vector3 after = even.vectors.row(v);
        EXPECT_NEAR(before.dot(after), before.norm() * after.norm(), 1e-12);
        EXPECT_GE(after.norm(), std::min(a, b) - 1e-9);
        EXPECT_LE(after.norm(), std::max(a, b) + 1e-9);
    }
    EXPECT_LT(field.vectors.rowwise().norm().minCoeff(), 0.5 * std::min(a, b)) << "which were short";
    EXPECT_EQ(even.summary.factorizations, 2 * field.summary.factorizations);
}

}  // namespace
}  // namespace beltrami
