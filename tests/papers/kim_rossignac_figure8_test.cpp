// Figure 8 of Kim & Rossignac, "Localized bi-Laplacian Solver on a Triangle Mesh and Its Applications": a plate is
// displaced at points. The Laplacian makes a spike around each, the bi-Laplacian is smooth there with a bump between
// them, which falls when the two are mixed.
#include <gtest/gtest.h>

#include <cmath>

#include "beltrami/apps/interpolate/interpolate.hpp"
#include "beltrami/framework/boundary.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami {
namespace {

constexpr double width = 4.0;
const InterpolateOptions laplacian_only{.laplacian = 1.0, .bilaplacian = 0.0};
const InterpolateOptions bilaplacian_only{.laplacian = 0.0, .bilaplacian = 1.0};

// The plate of docs/interpolate.md: the rim at 0, vertices at these places at 1.
Block lifted(int cells, const std::vector<std::pair<double, double>>& places,
             const InterpolateOptions& options) {
    const Mesh plate = shapes::grid(cells, cells, width, width, true);
    Constraints fixed;
    for (const Index v : boundary_vertices(plate))
        fixed.fix(v, 0.0);
    for (const auto& [x, y] : places) {
        Index nearest = 0;
        (plate.points().rowwise() - Eigen::RowVector3d(x, y, 0.0)).rowwise().squaredNorm().minCoeff(&nearest);
        fixed.fix(nearest, 1.0);
    }
    return interpolate(Laplacian(plate), fixed, options).value;
}

// The slope between the lifted vertex in the middle and the vertex beside it.
double slope_at_the_point(int cells, const InterpolateOptions& options) {
    const Block height = lifted(cells, {{width / 2, width / 2}}, options);
    const Index middle = (cells / 2) * (cells + 1) + cells / 2;
    EXPECT_EQ(height(middle, 0), 1.0);
    return (height(middle, 0) - height(middle + 1, 0)) / (width / cells);
}

// A harmonic function with a point held behaves as log r: the slope one width h away grows as 1 / (h log 1/h). A
// biharmonic one behaves as r^2 log r: the slope there falls with h.
TEST(Figure8, TheLaplacianSpikeSharpensUnderRefinementAndTheBilaplacianFlattens) {
    double spike = slope_at_the_point(20, laplacian_only);
    double bump = slope_at_the_point(20, bilaplacian_only);
    EXPECT_NEAR(spike, 1.9, 0.4);
    for (const int cells : {40, 80, 160}) {
        const double next_spike = slope_at_the_point(cells, laplacian_only);
        const double next_bump = slope_at_the_point(cells, bilaplacian_only);
        EXPECT_GT(next_spike, 1.5 * spike);
        EXPECT_LT(next_bump, 0.75 * bump);
        spike = next_spike;
        bump = next_bump;
    }
    EXPECT_GT(spike, 8.0);
    EXPECT_LT(bump, 0.12);
}

// In the limit a single point weighs nothing to the Laplacian, and its full weight to the bi-Laplacian.
TEST(Figure8, APointHoldsAPlateButNoFilm) {
    const auto half_way = [](int cells, const InterpolateOptions& options) {
        return lifted(cells, {{width / 2, width / 2}}, options)((cells / 2) * (cells + 1) + cells / 4, 0);
    };
    const double film = half_way(20, laplacian_only);
    const double plate = half_way(20, bilaplacian_only);
    EXPECT_LT(half_way(160, laplacian_only), 0.75 * film);
    EXPECT_NEAR(half_way(160, bilaplacian_only), plate, 0.02);
}

// The numbers that docs/interpolate.md shows.
TEST(Figure8, TheBumpBetweenTwoPointsFallsWhenMixed) {
    const std::vector<std::pair<double, double>> points = {{1.5, 2.0}, {2.5, 2.0}};
    EXPECT_EQ(lifted(80, points, laplacian_only).maxCoeff(), 1.0);
    EXPECT_NEAR(lifted(80, points, bilaplacian_only).maxCoeff(), 1.098, 5e-4);
    EXPECT_NEAR(lifted(80, points, {.laplacian = 1.0, .bilaplacian = 0.1}).maxCoeff(), 1.012, 5e-4);
    InterpolateOptions bounded = bilaplacian_only;
    bounded.bounds = Bounds{Vector::Zero(1), Vector::Ones(1)};
    const Block height = lifted(80, points, bounded);
    EXPECT_EQ(height.maxCoeff(), 1.0);
    EXPECT_NEAR(height(40 * 81 + 40, 0), 1.0, 0.01) << "a bridge between the two points instead of a bump";
}

}  // namespace
}  // namespace beltrami
