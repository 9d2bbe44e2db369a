#include "beltrami/operators/curvature.hpp"

#include <numbers>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::relative_difference;

MeanCurvature curvature_of(const Mesh& mesh, CurvatureCorrection correction = CurvatureCorrection::c2) {
    return mean_curvature(mesh, Laplacian(mesh), correction);
}

TEST(MeanCurvature, OfASphereIsOneOverItsRadius) {
    const Mesh sphere = shapes::icosphere(4, 2.5);
    const MeanCurvature curvature = curvature_of(sphere);
    EXPECT_NEAR(curvature.mean.mean(), 1.0 / 2.5, 1e-3);
    EXPECT_EQ(curvature.boundary_vertices, 0);
    // The Laplacian of the position points to the centre, with length 2 H.
    for (Index v = 0; v < sphere.vertex_count(); v += 100) {
        const Vector3 inward = -sphere.points().row(v).transpose().normalized();
        EXPECT_LT((curvature.normal.row(v).transpose().normalized() - inward).norm(), 0.01);
        EXPECT_NEAR(curvature.normal.row(v).norm(), 2.0 * curvature.mean[v], 1e-12);
    }
}

TEST(MeanCurvature, ChangesSignWithTheOrientation) {
    const Mesh sphere = shapes::icosphere(2);
    Cells turned = sphere.cells();
    turned.col(0).swap(turned.col(1));
    const MeanCurvature outside = curvature_of(sphere);
    const MeanCurvature inside = curvature_of(Mesh(sphere.points(), turned));
    EXPECT_GT(outside.mean.minCoeff(), 0.0);
    EXPECT_LT(relative_difference(inside.mean, Vector(-outside.mean)), 1e-13);
    EXPECT_LT(relative_difference(inside.normal, outside.normal), 1e-13);
}

// H = (R + 2 r cos v) / (2 r (R + r cos v)): positive outside, negative inside where R < 2 r.
TEST(MeanCurvature, OfATorus) {
    const double R = 1.0;
    const double r = 0.6;
    const Mesh torus = shapes::torus(R, r, 120, 72);
    const MeanCurvature curvature = curvature_of(torus);
    for (Index v = 0; v < torus.vertex_count(); v += 37) {
        const double cosine = (torus.points().row(v).head<2>().norm() - R) / r;
        const double expected = (R + 2.0 * r * cosine) / (2.0 * r * (R + r * cosine));
        EXPECT_NEAR(curvature.mean[v], expected, 0.01);
    }
    EXPECT_LT(curvature.mean.minCoeff(), -0.2);
}

TEST(MeanCurvature, IsZeroInAPlaneAndLeavesTheBoundaryOut) {
    const Mesh grid = shapes::jittered(shapes::grid(8, 6), 0.3);
    const MeanCurvature curvature = curvature_of(grid);
    EXPECT_EQ(curvature.boundary_vertices, 28);
    EXPECT_LT(curvature.mean.cwiseAbs().maxCoeff(), 1e-11);
    const Mesh cylinder = shapes::cylinder(2.0, 3.0, 60, 10);
    const MeanCurvature round = curvature_of(cylinder);
    EXPECT_EQ(round.boundary_vertices, 120);
    EXPECT_EQ(round.mean[0], 0.0);
    EXPECT_NEAR(round.mean[5 * 60], 0.25, 1e-3);
}

TEST(MeanCurvature, CorrectionsAgreeAtSixNeighboursOnly) {
    const Mesh sphere = shapes::icosphere(2);
    const MeanCurvature c1 = curvature_of(sphere, CurvatureCorrection::c1);
    const MeanCurvature c2 = curvature_of(sphere, CurvatureCorrection::c2);
    const EdgeGraph graph(sphere.vertex_count(), sphere.cells());
    const double cosine = std::cos(std::numbers::pi / 5.0);
    for (Index v = 0; v < sphere.vertex_count(); ++v) {
        const double factor = graph.degree(v) == 6 ? 1.0 : 4.0 / 3.0 * cosine * cosine;
        EXPECT_NEAR(c1.mean[v], factor * c2.mean[v], 1e-12);
    }
}

TEST(MeanCurvature, DoesNotFeelRenumbering) {
    const shapes::Shuffled shuffled = shapes::shuffled(shapes::with_noise(shapes::icosphere(2), 0.1));
    const MeanCurvature plain = curvature_of(shapes::with_noise(shapes::icosphere(2), 0.1));
    const MeanCurvature moved = curvature_of(shuffled.mesh);
    EXPECT_LT(relative_difference(Vector(moved.mean(shuffled.new_number)), plain.mean), 1e-10);
}

TEST(MeanCurvature, RefusesWhatIsNotASurface) {
    const Mesh solid = shapes::tetrahedral_cube(1);
    EXPECT_THROW((void)curvature_of(solid), InputError);
    const Laplacian other(shapes::icosphere(0));
    EXPECT_THROW((void)mean_curvature(shapes::icosphere(1), other, CurvatureCorrection::c2), InputError);
}

TEST(MeanCurvature, LeavesIsolatedVerticesAtZero) {
    Points points(13, 3);
    points << shapes::icosphere(0).points(), 9.0, 9.0, 9.0;
    const MeanCurvature curvature = curvature_of(Mesh(points, shapes::icosphere(0).cells()));
    EXPECT_EQ(curvature.mean[12], 0.0);
    EXPECT_TRUE(curvature.normal.allFinite());
}

}  // namespace
}  // namespace beltrami
