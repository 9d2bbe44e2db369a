#include "beltrami/operators/stiffness.hpp"

#include <Eigen/Eigenvalues>
#include <string>

#include "beltrami/framework/boundary.hpp"
#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/cell_gradients.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::graph_of;
using testing::reference_stiffness;
using testing::relative_difference;
using testing::rigidly_moved;
using testing::scaled;

Eigen::MatrixXd dense_stiffness(const Mesh& mesh) {
    return dense(stiffness(mesh, graph_of(mesh)).to_sparse());
}

struct Sample {
    std::string name;
    Mesh mesh;
};
void PrintTo(const Sample& sample, std::ostream* out) {
    *out << sample.name;
}

std::vector<Sample> samples() {
    return {{"noisy sphere", shapes::with_noise(shapes::icosphere(2), 0.2)},
            {"three fins", shapes::fins(3, 3)},
            {"five noisy fins", shapes::with_noise(shapes::fins(5, 2), 0.2)},
            {"pinched spheres", shapes::pinched_spheres(1)},
            {"jittered grid", shapes::jittered(shapes::grid(6, 5), 0.3)},
            {"shuffled bumps", shapes::shuffled(shapes::bumpy_sphere(300)).mesh},
            {"noisy solid", shapes::with_noise(shapes::tetrahedral_cube(3), 0.1)},
            {"solid ball", shapes::tetrahedral_ball(4)},
            {"noisy circle", shapes::with_noise(shapes::circle(17), 0.2)}};
}

class Stiffness : public ::testing::TestWithParam<Sample> {};

TEST_P(Stiffness, IsTheSumOfDenseElements) {
    const Mesh& mesh = GetParam().mesh;
    EXPECT_LT(relative_difference(dense_stiffness(mesh), reference_stiffness(mesh)), 1e-10);
}

TEST_P(Stiffness, WeightedByMeasureIsTheSumOfWeightedElements) {
    const Mesh& mesh = GetParam().mesh;
    EXPECT_LT(relative_difference(dense(area_weighted_stiffness(mesh, graph_of(mesh)).to_sparse()),
                                  reference_stiffness(mesh, 1)),
              1e-10);
}

TEST_P(Stiffness, IsMadeOfCellGradients) {
    const Mesh& mesh = GetParam().mesh;
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(mesh.vertex_count(), mesh.vertex_count());
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        const CellGradients hats = cell_gradients(mesh, c);
        const Eigen::MatrixXd element = std::abs(signed_measure(mesh, c)) * (hats * hats.transpose());
        for (Eigen::Index a = 0; a < element.rows(); ++a) {
            for (Eigen::Index b = 0; b < element.cols(); ++b) {
                K(mesh.cells()(c, a), mesh.cells()(c, b)) += element(a, b);
            }
        }
    }
    EXPECT_LT(relative_difference(dense_stiffness(mesh), K), 1e-10);
}

TEST_P(Stiffness, IsSymmetricSemidefiniteWithConstantsAsNullSpaceOfEachComponent) {
    const Mesh two = shapes::together({GetParam().mesh, rigidly_moved(GetParam().mesh)});
    const Eigen::MatrixXd K = dense_stiffness(two);
    EXPECT_EQ(K, K.transpose());
    const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
    const double largest = eigenvalues.tail(1)[0];
    EXPECT_GT(eigenvalues[0], -1e-13 * largest);
    EXPECT_LT(eigenvalues[1], 1e-13 * largest);
    EXPECT_GT(eigenvalues[2], 1e-8 * largest) << "more than two zero eigenvalues for two components";
    EXPECT_LT((K * Eigen::VectorXd::Ones(K.cols())).cwiseAbs().maxCoeff(), 1e-13 * largest);
}

TEST_P(Stiffness, DoesNotFeelRigidMotion) {
    const Mesh& mesh = GetParam().mesh;
    EXPECT_LT(relative_difference(dense_stiffness(rigidly_moved(mesh)), dense_stiffness(mesh)), 1e-9);
}

TEST_P(Stiffness, ScalesWithLengthToThePowerOfDimensionMinusTwo) {
    const Mesh& mesh = GetParam().mesh;
    const double power = static_cast<double>(mesh.cells().cols()) - 3.0;
    const Eigen::MatrixXd expected = std::pow(10.0, power) * dense_stiffness(mesh);
    EXPECT_LT(relative_difference(dense_stiffness(scaled(mesh, 10.0)), expected), 1e-10);
}

TEST_P(Stiffness, FollowsARenumbering) {
    const Mesh& mesh = GetParam().mesh;
    const shapes::Shuffled shuffled = shapes::shuffled(mesh, 7);
    const Eigen::MatrixXd K = dense_stiffness(mesh);
    const Eigen::MatrixXd renumbered = dense_stiffness(shuffled.mesh);
    EXPECT_LT(relative_difference(Eigen::MatrixXd(renumbered(shuffled.new_number, shuffled.new_number)), K),
              1e-12);
}

TEST_P(Stiffness, EnergyOfALinearFieldIsItsSquaredGradientTimesMeasure) {
    const Mesh& mesh = GetParam().mesh;
    // x^T K x summed over the coordinates is the squared gradient of the embedding: the dimension, times the
    // measure.
    const Eigen::MatrixXd x = mesh.points();
    const double energy = (x.transpose() * dense_stiffness(mesh) * x).trace();
    const double dimension = static_cast<double>(mesh.cells().cols()) - 1.0;
    EXPECT_NEAR(energy, dimension * cell_measures(mesh).sum(), 1e-10 * energy);
}

INSTANTIATE_TEST_SUITE_P(All, Stiffness, ::testing::ValuesIn(samples()));

// Angles by arc tangent: nothing in common with eq. (4).
double cotangent(const Points& p, Index at, Index b, Index c) {
    const Vector3 to_b = (p.row(b) - p.row(at)).transpose();
    const Vector3 to_c = (p.row(c) - p.row(at)).transpose();
    return 1.0 / std::tan(std::atan2(to_b.cross(to_c).norm(), to_b.dot(to_c)));
}

TEST(CotangentStiffness, IsMinusHalfTheCotangentsAcrossEachEdge) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(2), 0.3);
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(mesh.vertex_count(), mesh.vertex_count());
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        for (int k = 0; k < 3; ++k) {
            const Index at = mesh.cells()(c, k);
            const Index i = mesh.cells()(c, (k + 1) % 3);
            const Index j = mesh.cells()(c, (k + 2) % 3);
            const double half = 0.5 * cotangent(mesh.points(), at, i, j);
            expected(i, j) -= half;
            expected(j, i) -= half;
            expected(i, i) += half;
            expected(j, j) += half;
        }
    }
    EXPECT_LT(relative_difference(dense(cotangent_stiffness(mesh, graph_of(mesh)).to_sparse()), expected),
              1e-11);
}

TEST(TetrahedralStiffness, IsFaceAreaVectorsOverNineVolumes) {
    const Mesh mesh = shapes::with_noise(shapes::tetrahedral_cube(2), 0.1);
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(mesh.vertex_count(), mesh.vertex_count());
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        const auto corner = [&](int k) -> Vector3 {
            return mesh.points().row(mesh.cells()(c, k % 4)).transpose();
        };
        const Vector3 centre = (corner(0) + corner(1) + corner(2) + corner(3)) / 4.0;
        std::vector<Vector3> outward;
        for (int k = 0; k < 4; ++k) {
            Vector3 area = 0.5 * (corner(k + 2) - corner(k + 1)).cross(corner(k + 3) - corner(k + 1));
            if (area.dot(corner(k + 1) - centre) < 0.0) area = -area;
            outward.push_back(area);
        }
        for (int a = 0; a < 4; ++a) {
            for (int b = 0; b < 4; ++b) {
                expected(mesh.cells()(c, a), mesh.cells()(c, b)) +=
                    outward[static_cast<std::size_t>(a)].dot(outward[static_cast<std::size_t>(b)]) /
                    (9.0 * std::abs(signed_measure(mesh, c)));
            }
        }
    }
    EXPECT_LT(relative_difference(dense(tetrahedral_stiffness(mesh, graph_of(mesh)).to_sparse()), expected),
              1e-11);
}

TEST(Stiffness, IsExactForLinearFieldsInsideFlatMeshes) {
    for (const Mesh& mesh :
         {shapes::jittered(shapes::grid(12, 9, 2.0, 1.0), 0.3), shapes::jittered(shapes::disk(7), 0.3),
          shapes::with_noise(shapes::tetrahedral_cube(3), 0.0)}) {
        std::vector<char> inside(static_cast<std::size_t>(mesh.vertex_count()), 1);
        for (const Index v : boundary_vertices(mesh))
            inside[static_cast<std::size_t>(v)] = 0;
        const Vector linear =
            mesh.points() * Vector3(2.0, -3.0, 0.7) + Vector::Constant(mesh.vertex_count(), 5.0);
        Vector y;
        const EdgeOperator<double> K = stiffness(mesh, graph_of(mesh));
        K.apply(linear, y);
        int interior = 0;
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            if (inside[static_cast<std::size_t>(v)] == 0) continue;
            ++interior;
            EXPECT_NEAR(y[v], 0.0, 1e-12) << "vertex " << v;
        }
        EXPECT_GT(interior, 7);
    }
}

TEST(TetrahedralStiffness, DoesNotFeelInvertedCells) {
    const Mesh mesh = shapes::tetrahedral_cube(2);
    Cells cells = mesh.cells();
    for (Eigen::Index c = 0; c < cells.rows(); c += 2)
        std::swap(cells(c, 0), cells(c, 1));
    const Mesh inverted(mesh.points(), cells);
    EXPECT_LT(relative_difference(dense_stiffness(inverted), dense_stiffness(mesh)), 1e-14);
}

TEST(CombinatorialStiffness, CountsNeighbours) {
    const auto graph = graph_of(shapes::latlong_sphere(3));
    const EdgeOperator<double> K = combinatorial_stiffness(graph);
    EXPECT_EQ(K.diagonal()[0], 8.0);  // the north pole
    EXPECT_EQ(K.edges(), Vector::Constant(graph->edge_count(), -1.0));
    EXPECT_EQ(K.diagonal().sum(), 2.0 * graph->edge_count());
}

TEST(Stiffness, LeavesDegenerateCellsOut) {
    const Mesh good = shapes::grid(2, 2);
    Points points(good.vertex_count() + 1, 3);
    points << good.points(), 0.25, 0.0, 0.0;  // on the edge between vertices 0 and 1
    Cells cells(good.cell_count() + 2, 3);
    cells.topRows(good.cell_count()) = good.cells();
    cells.row(good.cell_count()) << 0, 1, 9;      // no area
    cells.row(good.cell_count() + 1) << 4, 4, 8;  // no triangle
    const Mesh mesh(points, cells);
    const Eigen::MatrixXd K = dense_stiffness(mesh);
    EXPECT_TRUE(K.allFinite());
    EXPECT_LT(relative_difference(Eigen::MatrixXd(K.topLeftCorner(9, 9)), dense_stiffness(good)), 1e-15);
    EXPECT_TRUE(K.row(9).isZero(0.0));
    EXPECT_TRUE(dense(area_weighted_stiffness(mesh, graph_of(mesh)).to_sparse()).allFinite());
}

TEST(Stiffness, RefusesOtherCells) {
    const Mesh points(Points::Random(4, 3));
    const Mesh solid = shapes::tetrahedral_cube(1);
    const Mesh surface = shapes::icosphere(0);
    EXPECT_THROW((void)stiffness(points, graph_of(points)), InputError);
    EXPECT_THROW((void)area_weighted_stiffness(points, graph_of(points)), InputError);
    EXPECT_THROW((void)cotangent_stiffness(solid, graph_of(solid)), InputError);
    EXPECT_THROW((void)tetrahedral_stiffness(surface, graph_of(surface)), InputError);
}

// The same vertices, but the graph of other cells: writing through an edge that is not there must not happen.
TEST(Stiffness, RefusesAGraphWithoutTheMeshesEdges) {
    const Mesh surface = shapes::icosphere(1);
    const auto other = graph_of(shapes::shuffled(surface).mesh);
    const auto smaller = graph_of(shapes::icosphere(0));
    EXPECT_THROW((void)stiffness(surface, other), InputError);
    EXPECT_THROW((void)stiffness(surface, smaller), InputError);
}

}  // namespace
}  // namespace beltrami
