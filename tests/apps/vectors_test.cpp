#include "beltrami/apps/vectors/vectors.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "beltrami/apps/interpolate/interpolate.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/solvers/tangent_field.hpp"
#include "numerics.hpp"
#include "turned_meshes.hpp"

namespace beltrami {
namespace {

using testing::partly_turned;
using testing::relative_difference;

using Given = std::vector<std::pair<Index, Vector3>>;

Constraints constraints(const Given& given) {
    Constraints fixed(3);
    for (const auto& [v, vector] : given)
        fixed.fix(v, std::array{vector.x(), vector.y(), vector.z()});
    return fixed;
}

VectorsResult solve(const Mesh& mesh, const Given& given, const VectorsOptions& options = {}) {
    return vectors(mesh, Laplacian(mesh), constraints(given), options);
}

const std::vector<VectorsOptions> ways = {
    {.method = VectorMethod::connection, .lengths = VectorLengths::solved},
    {.method = VectorMethod::connection,
     .lengths = VectorLengths::solved,
     .laplacian = 1.0,
     .bilaplacian = 0.05},
    {.method = VectorMethod::connection},
    {.method = VectorMethod::coordinates},
    {.method = VectorMethod::coordinates, .laplacian = 0.0, .bilaplacian = 1.0}};

const Given some = {{3, {1.0, 0.3, 0.2}}, {100, {0.0, 2.0, -1.0}}, {141, {0.5, 0.0, 0.1}}};

TEST(Vectors, AreTangentAndTakeTheGivenOnes) {
    const Mesh sphere = shapes::with_noise(shapes::icosphere(2), 0.1);
    const TangentFrames frames = tangent_frames(sphere);
    const TangentVectors given = project(frames, constraints(some));
    for (const VectorsOptions& options : ways) {
        const VectorsResult result = solve(sphere, some, options);
        EXPECT_TRUE(result.summary.converged);
        for (Index v = 0; v < sphere.vertex_count(); ++v)
            EXPECT_NEAR(result.vectors.row(v).dot(frames.normal.row(v)), 0.0, 1e-12);
        for (const auto& [v, vector] : some) {
            const Vector3 expected = Eigen::Map<const Vector3>(given.vectors.value(v).data());
            EXPECT_LT((Vector3(result.vectors.row(v)) - expected).norm(), 1e-12);
        }
        EXPECT_EQ(result.singularities.index_sum, 2);
        EXPECT_GT(result.largest_tilt, 5.0);
        EXPECT_EQ(result.without_plane, 0);
    }
}

TEST(Vectors, InAPlaneAreTwoInterpolations) {
    const Mesh plane = testing::rigidly_moved(shapes::jittered(shapes::grid(14, 12), 0.3));
    const TangentFrames frames = tangent_frames(plane);
    const Given given = {{0, frames.to_vector(0, {1.0, 2.0})},
                         {80, frames.to_vector(80, {0.0, -1.0})},
                         {194, frames.to_vector(194, {3.0, 0.5})}};
    for (const double bilaplacian : {0.0, 0.02}) {
        const Block expected =
            interpolate(Laplacian(plane), constraints(given), {.bilaplacian = bilaplacian}).value;
        for (const VectorMethod method : {VectorMethod::connection, VectorMethod::coordinates}) {
            const VectorsResult result =
                solve(plane, given,
                      {.method = method, .lengths = VectorLengths::solved, .bilaplacian = bilaplacian});
            EXPECT_LT(relative_difference(result.vectors, expected), 1e-8);
            EXPECT_LT(result.largest_tilt, 1e-6);
        }
    }
}

// Numbering, position, size and the sense of the triangles are no part of the question.
TEST(Vectors, DoNotDependOnNumberingPositionSizeOrTurnedTriangles) {
    const Mesh sphere = shapes::with_noise(shapes::icosphere(2), 0.1);
    const Mesh moved = testing::rigidly_moved(sphere);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.7, Vector3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
    const shapes::Shuffled shuffled = shapes::shuffled(sphere, 3);
    Given turned_given;
    Given shuffled_given;
    for (const auto& [v, vector] : some) {
        turned_given.emplace_back(v, turn * vector);
        shuffled_given.emplace_back(shuffled.new_number[static_cast<std::size_t>(v)], vector);
    }
    for (const VectorsOptions& options : ways) {
        const Block expected = solve(sphere, some, options).vectors;
        const Block after_turn = solve(moved, turned_given, options).vectors * turn;
        EXPECT_LT(relative_difference(after_turn, expected), 1e-7);
        const Block mixed = solve(shuffled.mesh, shuffled_given, options).vectors;
        EXPECT_LT(relative_difference(Block(mixed(shuffled.new_number, Eigen::all)), expected), 1e-7);
        EXPECT_LT(relative_difference(solve(partly_turned(sphere), some, options).vectors, expected), 1e-7);
        VectorsOptions larger = options;
        larger.bilaplacian *= 100.0 * 100.0;
        EXPECT_LT(relative_difference(solve(testing::scaled(sphere, 100.0), some, larger).vectors, expected),
                  1e-7);
    }
}

// Lengths of the given vectors are kept by default, but not by the published way.
TEST(Vectors, LengthsAreInterpolatedUnlessCoordinatesAreAskedFor) {
    const Mesh sphere = shapes::icosphere(2);
    const Laplacian laplacian(sphere);
    const Given given = {{3, sphere.points().row(3).cross(Eigen::RowVector3d(1, 2, 3)).normalized()}};
    const auto shortest = [&](const VectorsOptions& options) {
        return solve(sphere, given, options).vectors.rowwise().norm().minCoeff();
    };
    EXPECT_NEAR(shortest({}), 1.0, 1e-9);
    EXPECT_LT(shortest({.lengths = VectorLengths::solved}), 0.2);
    EXPECT_LT(shortest({.method = VectorMethod::coordinates}), 0.2);
    EXPECT_NEAR(shortest({.method = VectorMethod::coordinates, .lengths = VectorLengths::interpolated}), 1.0,
                1e-9);
}

TEST(Vectors, BothSolversAgree) {
    const Mesh torus = shapes::torus(1.0, 0.4, 30, 14);
    VectorsOptions options{.laplacian = 1.0, .bilaplacian = 0.01};
    options.linear.kind = SolverKind::cg;
    const VectorsResult cg = solve(torus, some, options);
    options.linear.kind = SolverKind::cholesky;
    const VectorsResult cholesky = solve(torus, some, options);
    EXPECT_EQ(cg.summary.solver, "cg");
    EXPECT_EQ(cholesky.summary.solver, "cholesky");
    EXPECT_LT(relative_difference(cg.vectors, cholesky.vectors), 1e-6);
    EXPECT_EQ(cg.singularities.index_sum, 0);
}

TEST(Vectors, FreeComponentsAreRefusedOrLeftAtZero) {
    const Mesh two = shapes::together({shapes::icosphere(1), shapes::icosphere(1)});
    const Given given = {{3, {1.0, 2.0, 0.0}}};
    EXPECT_THROW((void)solve(two, given), InputError);
    for (VectorsOptions options : ways) {
        options.free_components = FreeComponents::keep_at_zero;
        const VectorsResult result = solve(two, given, options);
        EXPECT_TRUE(result.vectors.bottomRows(42).isZero(0.0));
        EXPECT_FALSE(result.vectors.topRows(42).isZero(0.1));
        EXPECT_EQ(result.singularities.undefined_triangles, 80);
    }
}

TEST(Vectors, AreFiniteWhereNormalsCancel) {
    const Mesh fins = shapes::fins(3, 4);
    for (const VectorsOptions& options : ways) {
        const VectorsResult result = solve(fins, {{10, {0.0, 0.0, 1.0}}, {40, {0.0, 0.0, 2.0}}}, options);
        EXPECT_TRUE(result.vectors.allFinite());
        EXPECT_EQ(result.without_plane, 5);
        for (Index v = 0; v < 5; ++v)
            EXPECT_TRUE(result.vectors.row(v).isZero(0.0));
        EXPECT_GT(result.vectors.row(60).norm(), 0.5) << "but the field goes across to the third fin";
    }
}

TEST(Vectors, OnAOneSidedSurfaceOnlyCoordinatesWork) {
    const Mesh strip = testing::moebius_strip(30);
    const Given given = {{1, {0.0, 1.0, 0.0}}};
    EXPECT_THROW((void)solve(strip, given), InputError);
    const VectorsResult result = solve(strip, given, {.method = VectorMethod::coordinates});
    EXPECT_TRUE(result.vectors.allFinite());
    EXPECT_EQ(result.singularities.undefined_triangles, strip.cell_count());
}

TEST(Vectors, RefuseWhatHasNoAnswer) {
    const Mesh sphere = shapes::icosphere(1);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Given fine = {{0, {1.0, 1.0, 1.0}}};
    EXPECT_NO_THROW((void)solve(sphere, fine));
    EXPECT_THROW((void)solve(sphere, {}), InputError);
    EXPECT_THROW((void)vectors(sphere, Laplacian(sphere), Constraints{{0, 1.0}}), InputError);
    EXPECT_THROW((void)solve(sphere, {{0, sphere.points().row(0)}}), InputError) << "along the normal";
    EXPECT_THROW((void)solve(sphere, {{42, {1.0, 0.0, 0.0}}}), InputError);
    EXPECT_THROW((void)solve(sphere, fine, {.laplacian = 0.0}), InputError);
    EXPECT_THROW((void)solve(sphere, fine, {.laplacian = -1.0}), InputError);
    EXPECT_THROW((void)solve(sphere, fine, {.bilaplacian = nan}), InputError);
    EXPECT_THROW((void)solve(shapes::tetrahedral_cube(2), fine), InputError);
    VectorsOptions hopeless;
    hopeless.linear.kind = SolverKind::cg;
    hopeless.linear.max_iterations = 1;
    EXPECT_THROW((void)solve(sphere, fine, hopeless), SolveError);
}

}  // namespace
}  // namespace beltrami
