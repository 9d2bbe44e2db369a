#include "beltrami/solvers/membrane_flow.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "beltrami/framework/boundary.hpp"
#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/stiffness.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::relative_difference;

Constraints hold(std::span<const Index> vertices) {
    Constraints held(3);
    for (const Index v : vertices)
        held.fix(v, std::array{0.0, 0.0, 0.0});
    return held;
}

Constraints hold_below(const Mesh& mesh, double height) {
    Constraints held(3);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.points()(v, 2) <= height) held.fix(v, std::array{0.0, 0.0, 0.0});
    }
    return held;
}

double spread(const Mesh& mesh) {
    const Vector areas = cell_measures(mesh);
    return std::sqrt((areas.array() - areas.mean()).square().mean()) / areas.mean();
}

// What the flow goes down: K x is the slope of the area, and with area weights that of half the sum of squares.
TEST(MembraneFlow, TheOperatorTimesThePositionsIsTheSlopeOfTheEnergy) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(1), 0.3);
    const auto graph = testing::graph_of(mesh);
    const auto area = [&](const Points& points) { return cell_measures(mesh.with_points(points)).sum(); };
    const auto squares = [&](const Points& points) {
        return 0.5 * cell_measures(mesh.with_points(points)).squaredNorm();
    };
    const auto slope = [&](const auto& energy) {
        constexpr double h = 1e-5;
        Block g(mesh.vertex_count(), 3);
        for (Eigen::Index i = 0; i < g.size(); ++i) {
            Points plus = mesh.points();
            Points minus = mesh.points();
            plus.data()[i] += h;
            minus.data()[i] -= h;
            g.data()[i] = (energy(plus) - energy(minus)) / (2.0 * h);
        }
        return g;
    };
    Block product;
    stiffness(mesh, graph).apply(Block(mesh.points()), product);
    EXPECT_LT(relative_difference(product, slope(area)), 1e-8);
    area_weighted_stiffness(mesh, graph).apply(Block(mesh.points()), product);
    EXPECT_LT(relative_difference(product, slope(squares)), 1e-8);
}

TEST(MembraneFlow, OneStepIsTheDenseSolution) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(2), 0.1);
    const Constraints held = hold_below(mesh, 0.1);
    std::vector<Index> free;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (!held.is_fixed(v)) free.push_back(v);
    }
    const Vector areas = cell_measures(mesh);
    double moving_area = 0.0;
    int moving_triangles = 0;
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        const auto corners = mesh.cells().row(c);
        if (std::all_of(corners.begin(), corners.end(), [&](Index v) { return held.is_fixed(v); })) continue;
        moving_area += areas[c];
        ++moving_triangles;
    }
    for (const Weights weights : {Weights::area_weighted, Weights::cotangent}) {
        const bool by_area = weights == Weights::area_weighted;
        const Eigen::MatrixXd W = testing::reference_stiffness(mesh, by_area ? 1 : 0);
        const double dt = 0.02 * (by_area ? moving_triangles : moving_area);
        const Eigen::MatrixXd A = Eigen::MatrixXd(lumped_mass(mesh).asDiagonal()) + dt * W;
        const Eigen::MatrixXd load = -dt * W * mesh.points();
        const Eigen::MatrixXd A_ff = A(free, free);
        const Eigen::MatrixXd load_f = load(free, Eigen::all);
        const Eigen::MatrixXd moved = A_ff.partialPivLu().solve(load_f);
        Points expected = mesh.points();
        for (std::size_t i = 0; i < free.size(); ++i)
            expected.row(free[i]) += moved.row(static_cast<Eigen::Index>(i));

        MembraneFlow flow(mesh, held, {.weights = weights, .step = 0.02});
        EXPECT_NEAR(flow.area(), moving_area, 1e-12);
        flow.advance();
        EXPECT_LT(relative_difference(flow.points(), expected), 1e-7);
        EXPECT_EQ(flow.step_count(), 1);
        EXPECT_DOUBLE_EQ(flow.time(), 0.02);
    }
}

// For any step: large ones are halved where they would not.
TEST(MembraneFlow, EveryStepLowersWhatItSays) {
    for (const Weights weights : {Weights::area_weighted, Weights::cotangent}) {
        for (const double step : {0.01, 1.0, 1e4}) {
            for (const Mesh& mesh :
                 {shapes::with_noise(shapes::icosphere(3), 0.4), shapes::bumpy_sphere(2000)}) {
                MembraneFlow flow(mesh, hold_below(mesh, 0.0), {.weights = weights, .step = step});
                double energy = flow.energy();
                for (int s = 0; s < 12 && !flow.at_rest(); ++s) {
                    flow.advance();
                    EXPECT_LE(flow.energy(), energy);
                    EXPECT_TRUE(flow.points().allFinite());
                    energy = flow.energy();
                }
                EXPECT_LT(flow.area(), 0.9 * MembraneFlow(mesh, hold_below(mesh, 0.0)).area());
            }
        }
    }
}

// Tangentially the flow spreads triangles evenly; the area of a flat sheet cannot change while none turns over.
TEST(MembraneFlow, AFlatSheetStaysFlatAndItsTrianglesBecomeEqual) {
    const Mesh sheet = shapes::jittered(shapes::grid(16, 16), 0.2);
    MembraneFlow flow(sheet, hold(boundary_vertices(sheet)));
    const double before = spread(sheet);
    const double area = flow.area();
    while (!flow.at_rest()) {
        flow.advance();
        EXPECT_NEAR(flow.area(), area, 1e-12);
    }
    EXPECT_EQ(flow.points().col(2).cwiseAbs().maxCoeff(), 0.0);
    EXPECT_LT(spread(sheet.with_points(flow.points())), 0.1 * before);
}

TEST(MembraneFlow, KnowsNoUnitsAndNoPlace) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(3), 0.2);
    for (const Weights weights : {Weights::area_weighted, Weights::cotangent}) {
        const auto after_three = [&](const Mesh& start) {
            MembraneFlow flow(start, hold_below(mesh, 0.0), {.weights = weights, .step = 0.1});
            for (int s = 0; s < 3; ++s)
                flow.advance();
            return mesh.with_points(flow.points());
        };
        const Mesh end = after_three(mesh);
        EXPECT_LT(relative_difference(after_three(testing::scaled(mesh, 1e5)).points(),
                                      testing::scaled(end, 1e5).points()),
                  1e-6);
        EXPECT_LT(relative_difference(after_three(testing::rigidly_moved(mesh)).points(),
                                      testing::rigidly_moved(end).points()),
                  1e-6);
    }
}

// The tip of a pyramid whose triangles are all degenerate but one, an isolated vertex, and a cell that names a vertex
// twice.
TEST(MembraneFlow, DegenerateTrianglesAndIsolatedVerticesDoNotDisturbIt) {
    Points points(7, 3);
    points << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.3, 0.4, 1, 5, 5, 5, 0.5, 0, 0;
    Cells cells(6, 3);
    cells << 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 0, 1, 6, 4, 4, 1;
    MembraneFlow flow(Mesh(points, cells), hold(std::array<Index, 4>{0, 1, 2, 3}), {.rest = 1e-12});
    while (!flow.at_rest())
        flow.advance();
    EXPECT_TRUE(flow.points().allFinite());
    EXPECT_LT((flow.points().row(4) - Eigen::RowVector3d(0.5, 0.5, 0.0)).norm(), 1e-3)
        << "four equal triangles";
    EXPECT_EQ(flow.points().bottomRows(2), points.bottomRows(2));
}

// A free rim retracts: the sheet vanishes into the line that is held, and the flow ends.
TEST(MembraneFlow, ASheetThatIsHeldOnOneSideVanishesAndComesToRest) {
    const Mesh sheet = shapes::jittered(shapes::grid(10, 10), 0.2);
    std::vector<Index> side;
    for (Index v = 0; v < sheet.vertex_count(); ++v) {
        if (sheet.points()(v, 0) == 0.0) side.push_back(v);
    }
    for (const Weights weights : {Weights::area_weighted, Weights::cotangent}) {
        MembraneFlow flow(sheet, hold(side), {.weights = weights});
        for (int s = 0; s < 500 && !flow.at_rest(); ++s)
            flow.advance();
        EXPECT_TRUE(flow.at_rest());
        EXPECT_TRUE(flow.points().allFinite());
        EXPECT_LT(flow.area(), 0.05);
    }
}

TEST(MembraneFlow, RefusesWhatIsNoMembrane) {
    const Mesh mesh = shapes::icosphere(1);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(MembraneFlow(mesh, Constraints(3)), InputError);
    EXPECT_THROW(MembraneFlow(mesh, hold(std::array<Index, 1>{42})), InputError);
    EXPECT_THROW(MembraneFlow(shapes::tetrahedral_cube(1), hold(std::array<Index, 1>{0})), InputError);
    EXPECT_THROW(MembraneFlow(mesh, hold(std::array<Index, 1>{0}), {.weights = Weights::combinatorial}),
                 InputError);
    for (const double bad : {0.0, -1.0, nan}) {
        EXPECT_THROW(MembraneFlow(mesh, hold(std::array<Index, 1>{0}), {.step = bad}), InputError);
        EXPECT_THROW(MembraneFlow(mesh, hold(std::array<Index, 1>{0}), {.rest = bad}), InputError);
    }
}

}  // namespace
}  // namespace beltrami
