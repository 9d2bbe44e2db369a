#include "beltrami/framework/surface_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami::testing {
namespace {

// The smallest distance to any triangle, by projected gradient on each: slow and simple.
double distance_by_sampling(const Mesh& mesh, const Vector3& p) {
    double best = INFINITY;
    constexpr int cuts = 60;
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        for (int i = 0; i <= cuts; ++i) {
            for (int j = 0; i + j <= cuts; ++j) {
                const Vector3 q =
                    (mesh.points().row(mesh.cells()(c, 0)) * i + mesh.points().row(mesh.cells()(c, 1)) * j +
                     mesh.points().row(mesh.cells()(c, 2)) * (cuts - i - j))
                        .transpose() /
                    cuts;
                best = std::min(best, (p - q).norm());
            }
        }
    }
    return best;
}

TEST(SurfaceSearch, FindsTheClosestPoint) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(1), 0.1);
    const SurfaceSearch search(mesh);
    std::mt19937 engine(5);
    for (int trial = 0; trial < 20; ++trial) {
        Vector3 p;
        for (int k = 0; k < 3; ++k)
            p[k] = 3.0 * (engine() / 4294967295.0) - 1.5;
        const SurfacePoint hit = search.closest(p);
        Vector3 by_weights = Vector3::Zero();
        double sum = 0.0;
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_GE(hit.weights[k], 0.0);
            sum += hit.weights[k];
            by_weights += hit.weights[k] * mesh.points().row(hit.vertices[k]).transpose();
        }
        EXPECT_NEAR(sum, 1.0, 1e-14);
        EXPECT_LT((by_weights - hit.point).norm(), 1e-14);
        EXPECT_NEAR(hit.distance, (hit.point - p).norm(), 1e-14);
        const double sampled = distance_by_sampling(mesh, p);
        EXPECT_LE(hit.distance, sampled + 1e-12);
        EXPECT_GE(hit.distance, sampled - 0.02);
    }
}

TEST(SurfaceSearch, KnowsVerticesEdgesAndTheBoundaryOfSolids) {
    const Mesh grid = shapes::grid(4, 4);
    const SurfaceSearch search(grid);
    const SurfacePoint corner = search.closest({-1.0, -1.0, 0.5});
    double largest = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        if (corner.weights[k] > 0.5) {
            EXPECT_EQ(corner.vertices[k], 0);
        }
        largest = std::max(largest, corner.weights[k]);
    }
    EXPECT_DOUBLE_EQ(largest, 1.0);
    EXPECT_NEAR(search.closest({0.3, 0.6, 2.0}).distance, 2.0, 1e-14);

    const SurfaceSearch solid(shapes::tetrahedral_cube(3));
    EXPECT_NEAR(solid.closest({0.5, 0.5, 0.4}).distance, 0.4, 1e-14) << "inside, to the surface";
}

TEST(SurfaceSearch, PassesOverCellsWithoutAreaAndRefusesWhatHasNone) {
    Points points(5, 3);
    points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 5, 5, 6, 6, 6;
    Cells cells(2, 3);
    cells << 0, 1, 2, 3, 4, 3;
    EXPECT_GT(SurfaceSearch(Mesh(points, cells)).closest({5, 5, 5}).distance, 5.0);
    EXPECT_THROW(SurfaceSearch(shapes::circle(5)), InputError);
    EXPECT_THROW((void)SurfaceSearch(shapes::grid(1, 1)).closest({NAN, 0, 0}), InputError);
}

}  // namespace
}  // namespace beltrami::testing
