// Figure 6 of Kim & Rossignac, "Localized bi-Laplacian Solver on a Triangle Mesh and Its Applications": an egg whose
// lower half is fixed. The Laplacian concentrates the triangles of the film; weighting K by area, and evaluating it anew
// at each step, makes them even.
#include <gtest/gtest.h>

#include <cmath>

#include "beltrami/apps/fair/fair.hpp"
#include "beltrami/apps/membrane/membrane.hpp"
#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami {
namespace {

class Figure6 : public ::testing::Test {
  protected:
    Figure6() {
        for (Index v = 0; v < egg_.vertex_count(); ++v) {
            if (egg_.points()(v, 2) > 1e-9) upper_half_.push_back(v);
        }
    }

    // A sphere stretched upwards by a half.
    static Mesh make_egg() {
        const Mesh sphere = shapes::icosphere(4);
        Points points = sphere.points();
        points.col(2) = points.col(2).unaryExpr([](double z) { return z > 0.0 ? 1.5 * z : z; });
        return sphere.with_points(points);
    }

    /// Of the triangles with a corner in the upper half.
    struct Regularity {
        double largest_to_smallest;
        double deviation;  // standard deviation of the areas over their mean
        double area;
    };
    [[nodiscard]] Regularity regularity(const Points& points) const {
        const Vector all = cell_measures(egg_.with_points(points));
        std::vector<double> areas;
        for (Index c = 0; c < egg_.cell_count(); ++c) {
            for (int k = 0; k < 3; ++k) {
                if (egg_.points()(egg_.cells()(c, k), 2) > 1e-9) {
                    areas.push_back(all[c]);
                    break;
                }
            }
        }
        const Eigen::Map<const Eigen::ArrayXd> a(areas.data(), static_cast<Eigen::Index>(areas.size()));
        return {a.maxCoeff() / a.minCoeff(), std::sqrt((a - a.mean()).square().mean()) / a.mean(), a.sum()};
    }

    Mesh egg_ = make_egg();
    std::vector<Index> upper_half_;
    Laplacian laplacian_{egg_};
};

TEST_F(Figure6, TheLaplacianConcentratesTrianglesAndAreaWeightsMakeThemEven) {
    const Regularity start = regularity(egg_.points());
    EXPECT_LT(start.largest_to_smallest, 2.0);
    const Regularity laplacian = regularity(fair(egg_, laplacian_, upper_half_, {.laplacian = 1.0}).points);
    const Regularity cotangent =
        regularity(membrane(egg_, laplacian_, upper_half_, {.flow = {.weights = Weights::cotangent}}).points);
    const Regularity weighted = regularity(membrane(egg_, laplacian_, upper_half_, {}).points);
    EXPECT_GT(laplacian.largest_to_smallest, 10.0) << "top centre";
    EXPECT_GT(laplacian.deviation, 0.6);
    EXPECT_GT(cotangent.largest_to_smallest, 10.0);
    EXPECT_LT(weighted.largest_to_smallest, 1.2) << "top right";
    EXPECT_LT(weighted.deviation, 0.05);
    // All of them the disc that the equator spans.
    for (const Regularity& film : {cotangent, weighted})
        EXPECT_NEAR(film.area, M_PI, 5e-3);
}

// "grown from top center": from the concentrated film as well.
TEST_F(Figure6, AreaWeightsRegularizeAFilmThatTheLaplacianMade) {
    const Mesh film = egg_.with_points(fair(egg_, laplacian_, upper_half_, {.laplacian = 1.0}).points);
    const Regularity after = regularity(membrane(film, Laplacian(film), upper_half_, {}).points);
    EXPECT_LT(after.largest_to_smallest, 1.2);
}

// Bottom centre: the bi-Laplacian closes the egg with a dome, at the price of uneven triangles.
TEST_F(Figure6, TheBilaplacianMakesADome) {
    const Points dome = fair(egg_, laplacian_, upper_half_, {.bilaplacian = 1.0}).points;
    const Points film = fair(egg_, laplacian_, upper_half_, {.laplacian = 1.0}).points;
    EXPECT_LT(film.col(2).maxCoeff(), 0.05);
    EXPECT_GT(dome.col(2).maxCoeff(), 0.4);
    EXPECT_GT(regularity(dome).largest_to_smallest, 2.0 * regularity(egg_.points()).largest_to_smallest);
}

}  // namespace
}  // namespace beltrami
