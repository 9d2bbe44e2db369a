#include "beltrami/framework/isolines.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

constexpr double pi = std::numbers::pi;

/// Every segment is in exactly one line, between points that follow each other there.
void expect_complete(const Isolines& found) {
    std::size_t segments = 0;
    for (const Polyline& line : found.lines)
        segments += line.points.size() - (line.closed ? 0 : 1);
    EXPECT_EQ(segments, static_cast<std::size_t>(found.segments.cell_count()));
    double length = 0.0;
    const Points& points = found.segments.points();
    for (const Polyline& line : found.lines) {
        for (std::size_t i = line.closed ? 0 : 1; i < line.points.size(); ++i) {
            const Index before = i == 0 ? line.points.back() : line.points[i - 1];
            length += (points.row(line.points[i]) - points.row(before)).norm();
        }
    }
    EXPECT_NEAR(length, found.length, 1e-12 * (1.0 + found.length));
}

TEST(Isolines, ACircleOnADiskInSecondOrder) {
    std::vector<double> widths;
    std::vector<double> errors;
    for (const int rings : {8, 16, 32, 64}) {
        const Mesh disk = shapes::disk(rings);
        const Vector squared = disk.points().rowwise().squaredNorm();
        const Isolines found = isolines(disk, squared, 0.3);
        ASSERT_EQ(found.lines.size(), 1u);
        EXPECT_TRUE(found.lines[0].closed);
        expect_complete(found);
        widths.push_back(1.0 / rings);
        errors.push_back(std::abs(found.length / (2.0 * pi * std::sqrt(0.3)) - 1.0));
    }
    EXPECT_GE(testing::fitted_order(widths, errors), 1.8);
    EXPECT_LT(errors.back(), 1e-3);
}

TEST(Isolines, AVertexOnTheLevelIsAbove) {
    const Mesh grid = shapes::grid(8, 8);
    const Vector x = grid.points().col(0);
    for (const double level : {0.5, 1.0, 0.125, 0.3}) {  // all but the last pass through a column of vertices
        const Isolines found = isolines(grid, x, level);
        ASSERT_EQ(found.lines.size(), 1u) << level;
        EXPECT_FALSE(found.lines[0].closed);
        EXPECT_NEAR(found.length, 1.0, 1e-14);
        EXPECT_LT((found.segments.points().col(0).array() - level).abs().maxCoeff(), 1e-15);
        expect_complete(found);
    }
    EXPECT_TRUE(isolines(grid, x, 0.0).lines.empty()) << "all are above";
    EXPECT_TRUE(isolines(grid, x, 1.5).lines.empty()) << "all are below";
    EXPECT_TRUE(isolines(grid, Vector::Zero(81), 0.0).lines.empty());
    // A single vertex on the level: a line around it, of no length.
    Vector peak = Vector::Constant(81, -1.0);
    peak[40] = 0.0;
    const Isolines around = isolines(grid, peak, 0.0);
    ASSERT_EQ(around.lines.size(), 1u);
    EXPECT_TRUE(around.lines[0].closed);
    EXPECT_EQ(around.length, 0.0);
}

TEST(Isolines, SeveralLines) {
    const Mesh torus = shapes::torus(1.0, 0.4, 120, 48);
    const Isolines found = isolines(torus, torus.points().col(2), 0.0123);
    ASSERT_EQ(found.lines.size(), 2u);
    EXPECT_TRUE(found.lines[0].closed && found.lines[1].closed);
    EXPECT_NEAR(found.length, 2.0 * pi * 1.4 + 2.0 * pi * 0.6, 0.01);
    expect_complete(found);

    const Mesh grid = shapes::grid(20, 10);
    const Vector x = grid.points().col(0);
    const Isolines two = isolines(grid, ((x.array() - 0.26) * (x.array() - 0.73)).matrix(), 0.0);
    ASSERT_EQ(two.lines.size(), 2u);
    EXPECT_FALSE(two.lines[0].closed || two.lines[1].closed);
    EXPECT_NEAR(two.length, 2.0, 1e-12);
}

// On a closed manifold all lines are closed, and joined points have two segments each.
TEST(Isolines, ClosedOnClosedSurfaces) {
    const Mesh mesh = shapes::bumpy_sphere(2000);
    for (const std::uint32_t seed : {1u, 2u, 3u}) {
        const Isolines found = isolines(mesh, testing::random_vector(mesh.vertex_count(), seed), 0.1);
        EXPECT_GT(found.lines.size(), 20u);
        for (const Polyline& line : found.lines)
            EXPECT_TRUE(line.closed);
        EXPECT_EQ(found.segments.vertex_count(), found.segments.cell_count());
        expect_complete(found);
    }
}

TEST(Isolines, MeetOnNonManifoldEdges) {
    const Mesh fins = shapes::fins(3, 4);
    const Isolines found = isolines(fins, fins.points().col(2), 0.4);
    ASSERT_EQ(found.lines.size(), 3u);
    for (const Polyline& line : found.lines)
        EXPECT_FALSE(line.closed);
    EXPECT_NEAR(found.length, 3.0, 1e-12);
    expect_complete(found);
}

TEST(Isolines, RefusesWhatHasNone) {
    const Mesh grid = shapes::grid(2, 2);
    EXPECT_THROW(isolines(shapes::circle(5), Vector::Zero(5), 0.0), InputError);
    EXPECT_THROW(isolines(shapes::tetrahedral_cube(1), Vector::Zero(8), 0.0), InputError);
    EXPECT_THROW(isolines(grid, Vector::Zero(8), 0.0), InputError);
    EXPECT_THROW(isolines(grid, Vector::Constant(9, NAN), 0.0), InputError);
    EXPECT_THROW(isolines(grid, Vector::Zero(9), INFINITY), InputError);
}

}  // namespace
}  // namespace beltrami
