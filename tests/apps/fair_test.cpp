#include "beltrami/apps/fair/fair.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::relative_difference;

std::vector<Index> everything(const Mesh& mesh) {
    std::vector<Index> vertices(static_cast<std::size_t>(mesh.vertex_count()));
    std::iota(vertices.begin(), vertices.end(), 0);
    return vertices;
}

std::vector<Index> above(const Mesh& mesh, double height) {
    std::vector<Index> vertices = everything(mesh);
    std::erase_if(vertices, [&](Index v) { return mesh.points()(v, 2) <= height; });
    return vertices;
}

// gamma_1 K + gamma_2 K D K from the Gram matrices of the triangles.
Eigen::MatrixXd dense_operator(const Mesh& mesh, double laplacian, double bilaplacian) {
    const Eigen::MatrixXd K = testing::reference_stiffness(mesh);
    return laplacian * K + bilaplacian * K * lumped_mass(mesh).cwiseInverse().asDiagonal() * K;
}

// A x = load on the region, with the held rows of x as they are.
Points dense_rest(const Eigen::MatrixXd& A, const std::vector<Index>& region, const std::vector<Index>& held,
                  const Eigen::MatrixXd& load, const Points& x) {
    const Eigen::MatrixXd A_rr = A(region, region);
    const Eigen::MatrixXd x_held = x(held, Eigen::all);
    const Eigen::MatrixXd right = load(region, Eigen::all) - A(region, held) * x_held;
    const Eigen::MatrixXd solved = A_rr.partialPivLu().solve(right);
    Points result = x;
    result(region, Eigen::all) = solved;
    return result;
}

TEST(Fair, RestIsTheDenseSolutionForAnyMixture) {
    for (const Mesh& mesh : {shapes::with_noise(shapes::icosphere(2), 0.2), shapes::fins(3, 5)}) {
        const std::vector<Index> region = above(mesh, 0.3);
        std::vector<Index> held = everything(mesh);
        std::erase_if(held, [&](Index v) { return std::ranges::count(region, v) > 0; });
        for (const auto& [laplacian, bilaplacian] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {1.0, 0.05}}) {
            const Eigen::MatrixXd A = dense_operator(mesh, laplacian, bilaplacian);
            const Points rest_of_it = mesh.points()(held, Eigen::all);
            const Points expected =
                dense_rest(A, region, held, Eigen::MatrixXd::Zero(A.rows(), 3), mesh.points());
            const FairResult result =
                fair(mesh, Laplacian(mesh), region, {.laplacian = laplacian, .bilaplacian = bilaplacian});
            EXPECT_LT(relative_difference(result.points, expected), 1e-9) << laplacian << " " << bilaplacian;
            EXPECT_EQ(Points(result.points(held, Eigen::all)), rest_of_it) << "held to the last bit";
            EXPECT_TRUE(result.summary.converged);
        }
    }
}

TEST(Fair, AFlowKeepsKOverItsSteps) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(2), 0.2);
    const std::vector<Index> region = above(mesh, 0.0);
    std::vector<Index> held = everything(mesh);
    std::erase_if(held, [&](Index v) { return mesh.points()(v, 2) > 0.0; });
    const Vector mass = lumped_mass(mesh);
    const double dt = 0.05 / 3;
    const Eigen::MatrixXd A = Eigen::MatrixXd(mass.asDiagonal()) + dt * dense_operator(mesh, 1.0, 0.02);
    Points expected = mesh.points();
    for (int step = 0; step < 3; ++step)
        expected = dense_rest(A, region, held, mass.asDiagonal() * expected, expected);
    std::vector<double> times;
    const long before = EdgeOperator<double>::builds();
    const Laplacian laplacian(mesh);
    const FairResult result = fair(
        mesh, laplacian, region,
        {.laplacian = 1.0, .bilaplacian = 0.02, .time = 0.05, .steps = 3, .on_frame = [&](const Frame& f) {
             times.push_back(f.time);
         }});
    EXPECT_EQ(EdgeOperator<double>::builds(), before + 1);
    EXPECT_LT(relative_difference(result.points, expected), 1e-9);
    ASSERT_EQ(times.size(), 4U);
    EXPECT_DOUBLE_EQ(times.back(), 0.05);
}

// The coordinates of a sphere are eigenfunctions of its Laplacian for 2 / R^2: a step of time t divides the radius by
// 1 + t (2 gamma_1 + 4 gamma_2).
TEST(Fair, AStepShrinksASphereAsTheSpectrumSays) {
    for (const auto& [laplacian, bilaplacian] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {1.0, 1.0}}) {
        std::vector<double> widths;
        std::vector<double> errors;
        for (const int level : {2, 3, 4, 5}) {
            const Mesh mesh = shapes::icosphere(level);
            const FairResult result = fair(mesh, Laplacian(mesh), everything(mesh),
                                           {.laplacian = laplacian, .bilaplacian = bilaplacian, .time = 0.2});
            const double expected = 1.0 / (1.0 + 0.2 * (2.0 * laplacian + 4.0 * bilaplacian));
            const Vector radius = result.points.rowwise().norm();
            widths.push_back(std::pow(0.5, level));
            errors.push_back(testing::l2_norm(lumped_mass(mesh), Vector(radius.array() - expected)));
        }
        EXPECT_GT(testing::fitted_order(widths, errors), 1.8) << laplacian << " " << bilaplacian;
        EXPECT_LT(errors.back(), 2e-3);
    }
}

// Figure 6, left: the upper half of an egg. The Laplacian flattens it; the bi-Laplacian goes on over the rim.
TEST(Fair, TheBilaplacianMeetsTheRestWithoutACrease) {
    const Mesh sphere = shapes::icosphere(4);
    Points tall = sphere.points();
    tall.col(2) *= 1.5;
    const Mesh egg = sphere.with_points(tall);
    const Laplacian laplacian(egg);
    const std::vector<Index> region = above(egg, 0.0);
    const Points film = fair(egg, laplacian, region, {.laplacian = 1.0}).points;
    const Points plate = fair(egg, laplacian, region, {.bilaplacian = 1.0}).points;
    EXPECT_LT(film.col(2).maxCoeff(), 0.05);
    EXPECT_GT(plate.col(2).maxCoeff(), 0.4);
    EXPECT_LT(plate.col(2).maxCoeff(), 1.5);
    // The sharpest turn between normals of triangles that share an edge, in degrees.
    const auto crease = [&](const Points& points) {
        double sharpest = 0.0;
        const Cells& cells = egg.cells();
        std::map<std::pair<Index, Index>, Vector3> normal_of_edge;
        for (Index c = 0; c < egg.cell_count(); ++c) {
            const auto corner = [&](int k) -> Vector3 { return points.row(cells(c, k)).transpose(); };
            const Vector3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
            for (int k = 0; k < 3; ++k) {
                const std::pair<Index, Index> edge =
                    std::minmax(Index{cells(c, k)}, Index{cells(c, (k + 1) % 3)});
                const auto [other, is_new] = normal_of_edge.try_emplace(edge, normal);
                if (is_new) continue;
                sharpest = std::max(sharpest, std::acos(std::clamp(normal.dot(other->second), -1.0, 1.0)));
            }
        }
        return sharpest * 180.0 / M_PI;
    };
    EXPECT_GT(crease(film), 60.0);
    EXPECT_LT(crease(plate), 30.0);
}

TEST(Fair, ANoisyPlateBecomesFlatWithinItsRim) {
    const Mesh plate = shapes::grid(20, 20);
    Points bumpy = plate.points();
    std::vector<Index> region;
    for (Index v = 0; v < plate.vertex_count(); ++v) {
        const auto p = plate.points().row(v).head<2>().array();
        if ((p > 0.11).all() && (p < 0.89).all()) region.push_back(v);
    }
    bumpy(region, 2) += 0.03 * testing::random_vector(static_cast<Index>(region.size()));
    const Mesh mesh = plate.with_points(bumpy);
    for (const FairOptions& options : {FairOptions{.laplacian = 1.0}, FairOptions{.bilaplacian = 1.0}}) {
        const Points rest = fair(mesh, Laplacian(mesh), region, options).points;
        EXPECT_LT(rest.col(2).cwiseAbs().maxCoeff(), 1e-10);
        EXPECT_EQ(rest.row(0), mesh.points().row(0));
    }
}

TEST(Fair, MovesScalesAndRenumbersWithTheMesh) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(3), 0.2);
    const std::vector<Index> region = above(mesh, 0.2);
    const FairOptions options{.laplacian = 1.0, .bilaplacian = 0.1};
    const Points rest = fair(mesh, Laplacian(mesh), region, options).points;

    const Mesh moved = testing::rigidly_moved(mesh);
    EXPECT_LT(relative_difference(fair(moved, Laplacian(moved), region, options).points,
                                  testing::rigidly_moved(mesh.with_points(rest)).points()),
              1e-9);
    const Mesh large = testing::scaled(mesh, 1000.0);
    EXPECT_LT(relative_difference(
                  fair(large, Laplacian(large), region, {.laplacian = 1.0, .bilaplacian = 0.1e6}).points,
                  Points(1000.0 * rest)),
              1e-9);
    const auto [shuffled, new_number] = shapes::shuffled(mesh, 5);
    std::vector<Index> renumbered;
    for (const Index v : region)
        renumbered.push_back(new_number[static_cast<std::size_t>(v)]);
    EXPECT_LT(
        relative_difference(
            Points(fair(shuffled, Laplacian(shuffled), renumbered, options).points(new_number, Eigen::all)),
            rest),
        1e-9);
}

// Coordinates of a national grid: 10^6 times the size of the mesh away.
TEST(Fair, LosesNoDigitsFarFromTheOrigin) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(3), 0.2);
    const Eigen::RowVector3d away(4.0e6, -5.0e6, 1.0e6);
    const Mesh far = mesh.with_points(mesh.points().rowwise() + away);
    const std::vector<Index> region = above(mesh, 0.2);
    for (const FairOptions& options : {FairOptions{.laplacian = 1.0}, FairOptions{.bilaplacian = 1.0}}) {
        const Points near_rest = fair(mesh, Laplacian(mesh), region, options).points;
        const Points far_rest = fair(far, Laplacian(far), region, options).points;
        EXPECT_LT((far_rest.rowwise() - away - near_rest).cwiseAbs().maxCoeff(), 1e-6)
            << "positions there have a spacing of 1e-9";
    }
}

TEST(Fair, IsolatedVerticesOfTheRegionStayAndAreCounted) {
    Points points(43, 3);
    points << shapes::icosphere(1).points(), 9.0, 9.0, 9.0;
    const Mesh mesh(points, shapes::icosphere(1).cells());
    std::vector<Index> region = above(mesh, 0.3);
    ASSERT_EQ(region.back(), 42);
    for (const FairOptions& options :
         {FairOptions{.laplacian = 1.0}, FairOptions{.laplacian = 1.0, .time = 1.0}}) {
        const FairResult result = fair(mesh, Laplacian(mesh), region, options);
        EXPECT_EQ(result.stayed, 1);
        EXPECT_EQ(result.points.row(42), points.row(42));
    }
    region.pop_back();
    EXPECT_EQ(fair(mesh, Laplacian(mesh), region, {.laplacian = 1.0}).stayed, 0);
}

TEST(Fair, ComponentsThatNothingHoldsAreRefusedOrStay) {
    const Mesh two = shapes::together({shapes::icosphere(1), shapes::icosphere(1)});
    std::vector<Index> region(42 + 20);
    std::iota(region.begin(), region.end(), 0);
    EXPECT_THROW((void)fair(two, Laplacian(two), region, {.laplacian = 1.0}), InputError);
    const FairResult result = fair(two, Laplacian(two), region,
                                   {.laplacian = 1.0, .free_components = FreeComponents::keep_at_zero});
    EXPECT_EQ(result.points.topRows(42), two.points().topRows(42));
    EXPECT_GT((result.points - two.points()).bottomRows(42).cwiseAbs().maxCoeff(), 0.1);
}

TEST(Fair, RefusesWhatHasNoAnswer) {
    const Mesh mesh = shapes::icosphere(1);
    const Laplacian laplacian(mesh);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Index> region = {1, 2, 3};
    const std::vector<Index> outside = {1, 42};
    const std::vector<Index> negative = {-1};
    EXPECT_THROW((void)fair(mesh, laplacian, {}, {.laplacian = 1.0}), InputError);
    EXPECT_THROW((void)fair(mesh, laplacian, outside, {.laplacian = 1.0}), InputError);
    EXPECT_THROW((void)fair(mesh, laplacian, negative, {.laplacian = 1.0}), InputError);
    EXPECT_THROW((void)fair(mesh, laplacian, everything(mesh), {.laplacian = 1.0}), InputError);
    EXPECT_THROW((void)fair(mesh, laplacian, region, {}), InputError);
    EXPECT_THROW((void)fair(mesh, laplacian, region, {.laplacian = -1.0}), InputError);
    EXPECT_THROW((void)fair(mesh, laplacian, region, {.bilaplacian = nan}), InputError);
    for (const double time : {0.0, -1.0, nan})
        EXPECT_THROW((void)fair(mesh, laplacian, region, {.laplacian = 1.0, .time = time}), InputError);
    EXPECT_THROW((void)fair(mesh, laplacian, region, {.laplacian = 1.0, .time = 1.0, .steps = 0}),
                 InputError);
}

}  // namespace
}  // namespace beltrami
