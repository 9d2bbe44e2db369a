#include "beltrami/operators/gradient.hpp"

#include <Eigen/Geometry>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/cell_gradients.hpp"
#include "beltrami/operators/stiffness.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::graph_of;
using testing::random_vector;
using testing::relative_difference;

std::vector<Mesh> meshes_of_every_kind() {
    return {shapes::with_noise(shapes::icosphere(2), 0.2), shapes::fins(3, 4),
            shapes::with_noise(shapes::tetrahedral_cube(3), 0.1),
            shapes::with_noise(shapes::circle(20), 0.2)};
}

TEST(CellGradients, AreOneAtTheirCornerAndZeroAtOthers) {
    for (const Mesh& mesh : meshes_of_every_kind()) {
        for (Index c = 0; c < mesh.cell_count(); ++c) {
            const CellGradients hats = cell_gradients(mesh, c);
            EXPECT_LT(hats.colwise().sum().cwiseAbs().maxCoeff(), 1e-12 * hats.cwiseAbs().maxCoeff());
            for (Eigen::Index a = 0; a < hats.rows(); ++a) {
                for (Eigen::Index b = 0; b < hats.rows(); ++b) {
                    if (a == b) continue;
                    const Eigen::RowVector3d from_b =
                        mesh.points().row(mesh.cells()(c, a)) - mesh.points().row(mesh.cells()(c, b));
                    EXPECT_NEAR(hats.row(a).dot(from_b), 1.0, 1e-12);
                    EXPECT_NEAR(hats.row(b).dot(from_b), -1.0, 1e-12);
                }
            }
        }
    }
}

TEST(Gradient, IsExactForLinearFields) {
    const Vector3 slope(2.0, -3.0, 0.5);
    const Mesh solid = shapes::with_noise(shapes::tetrahedral_cube(3), 0.1);
    const Points in_solid = gradient(solid, solid.points() * slope);
    EXPECT_LT((in_solid.rowwise() - slope.transpose()).cwiseAbs().maxCoeff(), 1e-12);
    // On a surface the part along the normal is lost.
    const Mesh surface = shapes::icosphere(2);
    const Points on_surface = gradient(surface, surface.points() * slope);
    for (Index c = 0; c < surface.cell_count(); ++c) {
        const Vector3 p = surface.points().row(surface.cells()(c, 0)).transpose();
        const Vector3 a = surface.points().row(surface.cells()(c, 1)).transpose() - p;
        const Vector3 b = surface.points().row(surface.cells()(c, 2)).transpose() - p;
        const Vector3 normal = a.cross(b).normalized();
        const Vector3 tangent = slope - normal * normal.dot(slope);
        EXPECT_LT((on_surface.row(c).transpose() - tangent).norm(), 1e-12);
    }
}

TEST(Divergence, OfTheGradientIsMinusTheStiffness) {
    for (const Mesh& mesh : meshes_of_every_kind()) {
        const Vector u = random_vector(mesh.vertex_count());
        Vector y;
        stiffness(mesh, graph_of(mesh)).apply(u, y);
        EXPECT_LT(relative_difference(Vector(-divergence(mesh, gradient(mesh, u))), y), 1e-12)
            << plural(mesh.kind());
    }
}

TEST(Divergence, IsMinusTheAdjointOfTheGradient) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(2), 0.2);
    const Vector u = random_vector(mesh.vertex_count(), 3);
    const Points X = testing::random_block(mesh.cell_count(), 3, 4);
    double product = 0.0;
    const Points g = gradient(mesh, u);
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        product += testing::reference_element(mesh, c).measure * g.row(c).dot(X.row(c));
    }
    EXPECT_NEAR(u.dot(divergence(mesh, X)), -product, 1e-12 * std::abs(product) + 1e-12);
    EXPECT_NEAR(divergence(mesh, X).sum(), 0.0, 1e-11) << "nothing flows through the boundary";
}

TEST(Divergence, OfTheFieldXInTheBallIsTheDimension) {
    const Mesh ball = shapes::tetrahedral_ball(4);
    const Points X = cell_average(ball, ball.points());
    // Over the hats of interior vertices; here the centre, whose hat is far from the boundary. Its integral
    // is V / 4 summed over its cells, and div x = 3; cell averages make X piecewise constant, exact on
    // average only.
    const Points uniform = Points::Constant(ball.cell_count(), 3, 1.0);
    const Vector none = divergence(ball, uniform);
    const Index centre = 2 * 25 + 2 * 5 + 2;
    ASSERT_LT(ball.points().row(centre).norm(), 1e-12);
    EXPECT_NEAR(none[centre], 0.0, 1e-13);
    EXPECT_GT(divergence(ball, X)[centre], 0.0) << "a source has positive divergence";
}

TEST(CellAverage, IsTheMeanOfTheCorners) {
    const Mesh mesh = shapes::grid(1, 1);
    Points vectors = Points::Zero(4, 3);
    vectors.row(mesh.cells()(0, 0)) << 3.0, 6.0, 9.0;
    EXPECT_LT((cell_average(mesh, vectors).row(0) - Eigen::RowVector3d(1.0, 2.0, 3.0)).norm(), 1e-15);
}

TEST(Gradient, IsZeroInDegenerateCells) {
    const Mesh mesh(Points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}},
                    Cells{{0, 1, 2}, {0, 1, 3}, {1, 1, 3}});
    const Points g = gradient(mesh, Vector{{0.0, 1.0, 5.0, 0.0}});
    EXPECT_TRUE(g.row(0).isZero(0.0));
    EXPECT_LT((g.row(1) - Eigen::RowVector3d(1, 0, 0)).norm(), 1e-15);
    EXPECT_TRUE(g.row(2).isZero(0.0));
    EXPECT_TRUE(divergence(mesh, g).allFinite());
}

TEST(Gradient, RefusesWrongLengths) {
    const Mesh mesh = shapes::icosphere(0);
    EXPECT_THROW((void)gradient(mesh, Vector::Zero(11)), InputError);
    EXPECT_THROW((void)divergence(mesh, Points::Zero(12, 3)), InputError);
    EXPECT_THROW((void)cell_average(mesh, Points::Zero(20, 3)), InputError);
}

}  // namespace
}  // namespace beltrami
