#include "beltrami/operators/mass.hpp"

#include <numbers>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using std::numbers::pi;
using testing::dense;
using testing::fitted_order;
using testing::graph_of;
using testing::relative_difference;
using testing::rigidly_moved;
using testing::scaled;

std::vector<Mesh> meshes_of_every_kind() {
    return {shapes::with_noise(shapes::icosphere(2), 0.3),
            shapes::fins(3, 4),
            shapes::jittered(shapes::grid(9, 7), 0.4),
            shapes::with_noise(shapes::tetrahedral_cube(3), 0.1),
            shapes::tetrahedral_ball(4),
            shapes::with_noise(shapes::circle(20), 0.2)};
}

TEST(LumpedMass, SumsToClosedForms) {
    EXPECT_NEAR(lumped_mass(shapes::grid(7, 5, 2.0, 3.0)).sum(), 6.0, 1e-13);
    EXPECT_NEAR(lumped_mass(shapes::jittered(shapes::grid(7, 5, 2.0, 3.0), 0.3)).sum(), 6.0, 1e-13);
    EXPECT_NEAR(lumped_mass(shapes::tetrahedral_cube(4)).sum(), 1.0, 1e-13);
    EXPECT_NEAR(lumped_mass(shapes::circle(12, 3.0)).sum(), 12 * 2 * 3.0 * std::sin(pi / 12), 1e-12);
    EXPECT_NEAR(lumped_mass(shapes::fins(5, 3)).sum(), 5.0, 1e-13);
}

TEST(LumpedMass, ApproachesSphereAndTorusInSecondOrder) {
    std::vector<double> widths;
    std::vector<double> sphere;
    std::vector<double> torus;
    for (const int level : {2, 3, 4, 5}) {
        const int n = 1 << level;
        widths.push_back(1.0 / n);
        sphere.push_back(std::abs(lumped_mass(shapes::icosphere(level)).sum() - 4.0 * pi));
        torus.push_back(
            std::abs(lumped_mass(shapes::torus(1.0, 0.4, 5 * n, 2 * n)).sum() - 4.0 * pi * pi * 0.4));
    }
    EXPECT_NEAR(fitted_order(widths, sphere), 2.0, 0.05);
    EXPECT_NEAR(fitted_order(widths, torus), 2.0, 0.05);
}

TEST(LumpedMass, IsTheRowSumOfTheConsistentMass) {
    for (const Mesh& mesh : meshes_of_every_kind()) {
        Vector rows;
        consistent_mass(mesh, graph_of(mesh)).apply(Vector(Vector::Ones(mesh.vertex_count())), rows);
        EXPECT_LT(relative_difference(rows, lumped_mass(mesh)), 1e-13) << plural(mesh.kind());
    }
}

TEST(LumpedMass, IsAnEqualShareOfEveryCell) {
    for (const Mesh& mesh : meshes_of_every_kind()) {
        Vector expected = Vector::Zero(mesh.vertex_count());
        for (Index c = 0; c < mesh.cell_count(); ++c) {
            for (const Index v : mesh.cells().row(c)) {
                expected[v] +=
                    testing::reference_element(mesh, c).measure / static_cast<double>(mesh.cells().cols());
            }
        }
        EXPECT_LT(relative_difference(lumped_mass(mesh), expected), 1e-12) << plural(mesh.kind());
    }
}

// On one cell the integrals of hat_i hat_j are known: d! (1 + delta_ij) / (d + 2)! times the measure.
TEST(ConsistentMass, IntegratesProductsOfHats) {
    const Mesh solid = shapes::tetrahedral_cube(1);
    const Eigen::MatrixXd M = dense(consistent_mass(solid, graph_of(solid)).to_sparse());
    // 1, x, y and z are in the space, so the integrals of their products over the unit cube are exact.
    const Vector x = solid.points().col(0);
    const Vector y = solid.points().col(1);
    EXPECT_NEAR(x.dot(M * x), 1.0 / 3.0, 1e-14);
    EXPECT_NEAR(x.dot(M * y), 1.0 / 4.0, 1e-14);
    const Mesh square = shapes::jittered(shapes::grid(5, 5), 0.3);
    const Eigen::MatrixXd N = dense(consistent_mass(square, graph_of(square)).to_sparse());
    EXPECT_NEAR(square.points().col(0).dot(N * square.points().col(0)), 1.0 / 3.0, 1e-14);
    EXPECT_NEAR(square.points().col(0).dot(N * square.points().col(1)), 1.0 / 4.0, 1e-14);
    const Mesh edge(Points{{0, 0, 0}, {3, 0, 0}}, Cells{{0, 1}});
    EXPECT_LT(relative_difference(dense(consistent_mass(edge, graph_of(edge)).to_sparse()),
                                  Eigen::MatrixXd{{1.0, 0.5}, {0.5, 1.0}}),
              1e-15);
}

TEST(VoronoiMass, SumsToTheAreaAlsoWithObtuseTriangles) {
    for (const Mesh& mesh :
         {shapes::jittered(shapes::grid(9, 7), 0.45), shapes::with_noise(shapes::icosphere(3), 0.4),
          shapes::bumpy_sphere(500), shapes::fins(4, 3)}) {
        const Vector mass = lumped_mass(mesh, Mass::voronoi);
        EXPECT_NEAR(mass.sum(), cell_measures(mesh).sum(), 1e-12 * mass.sum());
        EXPECT_GT(mass.minCoeff(), 0.0);
    }
}

TEST(VoronoiMass, OfSingleTriangles) {
    const auto mass = [](const Points& corners) {
        return lumped_mass(Mesh(corners, Cells{{0, 1, 2}}), Mass::voronoi);
    };
    const double third = std::sqrt(3.0) / 4.0 / 3.0;
    EXPECT_LT(relative_difference(mass(Points{{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}}),
                                  Vector(Vector::Constant(3, third))),
              1e-14);
    // Right angle at the first corner: the circumcentre is the middle of the hypotenuse.
    EXPECT_LT(relative_difference(mass(Points{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}}), Vector{{0.5, 0.25, 0.25}}),
              1e-14);
    // Obtuse at the first corner: half and quarters of the area 1/2.
    EXPECT_LT(
        relative_difference(mass(Points{{0, 0, 0}, {1, 0, 0}, {-1, 1, 0}}), Vector{{0.25, 0.125, 0.125}}),
        1e-14);
    // Acute with three different angles: the kites between edge middles and circumcentre (2, 3/2).
    const Points acute{{0, 0, 0}, {4, 0, 0}, {1.5, 4, 0}};
    const Vector3 centre(2.0, 1.53125, 0.0);
    Vector expected(3);
    for (int k = 0; k < 3; ++k) {
        const Vector3 p = acute.row(k).transpose();
        const Vector3 q = acute.row((k + 1) % 3).transpose();
        const Vector3 r = acute.row((k + 2) % 3).transpose();
        ASSERT_NEAR((p - centre).norm(), (q - centre).norm(), 1e-12);
        expected[k] = 0.5 * (0.5 * (p + q) - p).cross(centre - p).norm() +
                      0.5 * (0.5 * (p + r) - p).cross(centre - p).norm();
    }
    EXPECT_LT(relative_difference(mass(acute), expected), 1e-14);
}

TEST(LumpedMass, ScalesWithTheDimensionAndIgnoresMotion) {
    for (const Mesh& mesh : meshes_of_every_kind()) {
        const double power = static_cast<double>(mesh.cells().cols()) - 1.0;
        const Vector expected = std::pow(10.0, power) * lumped_mass(mesh);
        EXPECT_LT(relative_difference(lumped_mass(scaled(mesh, 10.0)), expected), 1e-12);
        EXPECT_LT(relative_difference(lumped_mass(rigidly_moved(mesh)), lumped_mass(mesh)), 1e-10);
    }
}

TEST(Mass, OfVerticesWithoutAreaIsZero) {
    Points points(5, 3);
    points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0.5, 0, 0, 9, 9, 9;
    const Mesh mesh(points, Cells{{0, 1, 2}, {0, 1, 3}});  // the second has no area; vertex 4 is in no cell
    for (const Mass kind : {Mass::barycentric, Mass::voronoi}) {
        const Vector mass = lumped_mass(mesh, kind);
        EXPECT_NEAR(mass.sum(), 0.5, 1e-15);
        EXPECT_EQ(mass[3], 0.0);
        EXPECT_EQ(mass[4], 0.0);
    }
    EXPECT_EQ(consistent_mass(mesh, graph_of(mesh)).diagonal()[3], 0.0);
}

TEST(Mass, RefusesWhatItCannotDo) {
    const Mesh points(Points::Random(4, 3));
    const Mesh solid = shapes::tetrahedral_cube(1);
    EXPECT_THROW((void)lumped_mass(points), InputError);
    EXPECT_THROW((void)consistent_mass(points, graph_of(points)), InputError);
    EXPECT_THROW((void)lumped_mass(solid, Mass::voronoi), InputError);
    EXPECT_THROW((void)consistent_mass(solid, graph_of(shapes::icosphere(0))), InputError);
}

}  // namespace
}  // namespace beltrami
