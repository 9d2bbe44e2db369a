#include "beltrami/operators/connection_laplacian.hpp"

#include <gtest/gtest.h>

#include <Spectra/MatOp/SparseSymShiftSolve.h>
#include <Spectra/SymEigsShiftSolver.h>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/mesh_report.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/hermitian_pde_operator.hpp"
#include "numerics.hpp"
#include "turned_meshes.hpp"

namespace beltrami {
namespace {

using Complex = std::complex<double>;
using testing::dense;
using testing::moebius_strip;
using testing::partly_turned;
using testing::random_vector;
using testing::relative_difference;

EdgeOperator<Complex> connection_of(const Mesh& mesh, bool renumber = true) {
    return connection_laplacian(mesh, Laplacian(mesh, {.renumber = renumber}), tangent_frames(mesh));
}

Vector eigenvalues(const Mesh& mesh) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd>(dense(connection_of(mesh).to_sparse()),
                                                           Eigen::EigenvaluesOnly)
        .eigenvalues();
}

// y = K z for a field of vectors in space, in the mesh's order; the vectors that come out.
Block apply_to_vectors(const Mesh& mesh, const Block& field) {
    const Laplacian laplacian(mesh);
    const TangentFrames frames = tangent_frames(mesh);
    EdgeOperator<Complex>::Array z(mesh.vertex_count());
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        z[laplacian.order().working(v)] = frames.to_number(v, field.row(v).transpose());
    EdgeOperator<Complex>::Array y;
    connection_laplacian(mesh, laplacian, frames).apply(z, y);
    Block result(mesh.vertex_count(), 3);
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        result.row(v) = frames.to_vector(v, y[laplacian.order().working(v)]);
    return result;
}

// Meshes with negative cotangents, boundaries, edges of three triangles, triangles turned over.
std::vector<Mesh> difficult_meshes() {
    return {shapes::with_noise(shapes::icosphere(2), 0.4),
            shapes::bumpy_sphere(150),
            shapes::fins(3, 3),
            shapes::genus(2, 2),
            partly_turned(shapes::cylinder(1.0, 2.0, 9, 5)),
            shapes::pinched_spheres(1)};
}

TEST(ConnectionLaplacian, IsPositiveSemidefiniteOnEveryMesh) {
    Index not_delaunay = 0;
    for (const Mesh& mesh : difficult_meshes()) {
        not_delaunay += report(mesh).non_delaunay_edges;
        const Vector lambda = eigenvalues(mesh);
        ASSERT_TRUE(lambda.allFinite());
        EXPECT_GT(lambda.minCoeff(), -1e-13 * lambda.maxCoeff());
    }
    EXPECT_GT(not_delaunay, 10) << "or the meshes do not ask for much";
}

TEST(ConnectionLaplacian, HasTheDiagonalOfTheStiffness) {
    for (const Mesh& mesh : difficult_meshes()) {
        const Laplacian laplacian(mesh);
        const auto K = connection_laplacian(mesh, laplacian, tangent_frames(mesh));
        EXPECT_EQ(&K.graph(), &laplacian.graph());
        EXPECT_LT(relative_difference(Vector(K.diagonal().real()), laplacian.stiffness().diagonal()), 1e-13);
        EXPECT_TRUE(K.diagonal().imag().isZero(0.0));
    }
}

// In a plane the field of complex numbers is two fields of real ones.
TEST(ConnectionLaplacian, IsTheScalarLaplacianInAPlane) {
    const Mesh flat = shapes::shuffled(shapes::jittered(shapes::grid(9, 7), 0.3)).mesh;
    const Mesh tilted = testing::rigidly_moved(flat);
    for (const Mesh& mesh : {flat, tilted, partly_turned(tilted)}) {
        const Laplacian laplacian(mesh);
        const auto K = connection_laplacian(mesh, laplacian, tangent_frames(mesh));
        const auto expected = dense(laplacian.stiffness().to_sparse());
        EXPECT_LT(
            relative_difference(Eigen::MatrixXcd(K.to_sparse()), Eigen::MatrixXcd(expected.cast<Complex>())),
            1e-13);
    }
}

// Along a cylinder, and around it, a field is parallel.
TEST(ConnectionLaplacian, ParallelFieldsOfACylinderAreInTheNullSpace) {
    const Mesh cylinder = partly_turned(shapes::cylinder(0.7, 2.0, 17, 9));
    Block along = Block::Zero(cylinder.vertex_count(), 3);
    along.col(2).setOnes();
    Block around = Block::Zero(cylinder.vertex_count(), 3);
    const TangentFrames frames = tangent_frames(cylinder);
    for (Index v = 0; v < cylinder.vertex_count(); ++v)
        around.row(v) = Vector3::UnitZ().cross(Vector3(frames.normal.row(v)));
    EXPECT_LT(apply_to_vectors(cylinder, along).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_LT(apply_to_vectors(cylinder, around).cwiseAbs().maxCoeff(), 1e-13);
    const Vector lambda = eigenvalues(cylinder);
    EXPECT_LT(lambda[0], 1e-13);
    EXPECT_GT(lambda[1], 1e-3) << "and nothing else is";
}

TEST(ConnectionLaplacian, AnotherChoiceOfAxesIsTheSameOperator) {
    for (const Mesh& mesh : difficult_meshes()) {
        const Laplacian laplacian(mesh);
        const TangentFrames frames = tangent_frames(mesh);
        TangentFrames other = frames;
        const Vector angle = 3.0 * random_vector(mesh.vertex_count());
        Eigen::VectorXcd gauge(mesh.vertex_count());
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            other.axis.row(v) = frames.to_vector(v, std::polar(1.0, angle[v]));
            gauge[laplacian.order().working(v)] = std::polar(1.0, angle[v]);
        }
        const Eigen::MatrixXcd A = dense(connection_laplacian(mesh, laplacian, frames).to_sparse());
        const Eigen::MatrixXcd B = dense(connection_laplacian(mesh, laplacian, other).to_sparse());
        const Eigen::MatrixXcd expected = gauge.conjugate().asDiagonal() * A * gauge.asDiagonal();
        EXPECT_LT(relative_difference(B, expected), 1e-13);
    }
}

TEST(ConnectionLaplacian, SpectrumIgnoresNumberingPositionAndSize) {
    for (const Mesh& mesh :
         {shapes::with_noise(shapes::icosphere(1), 0.3), shapes::cylinder(1.0, 1.0, 7, 4)}) {
        const Vector lambda = eigenvalues(mesh);
        EXPECT_LT(relative_difference(eigenvalues(shapes::shuffled(mesh).mesh), lambda), 1e-12);
        EXPECT_LT(relative_difference(eigenvalues(testing::rigidly_moved(mesh)), lambda), 1e-12);
        EXPECT_LT(relative_difference(eigenvalues(testing::scaled(mesh, 1e4)), lambda), 1e-12);
        EXPECT_LT(relative_difference(eigenvalues(partly_turned(mesh)), lambda), 1e-12);
    }
}

// The smallest eigenvalue of -(covariant derivative)^2 on vector fields of the unit sphere is 1, six times: the
// gradients of x, y and z and their quarter turns. The next is 5. Spectra finds them, nothing of our own solvers.
Vector smallest_of_sphere(const Mesh& mesh) {
    const Laplacian laplacian(mesh);
    const HermitianPdeOperator K(connection_laplacian(mesh, laplacian, tangent_frames(mesh)), laplacian, 0.0,
                                 {1.0});
    Vector scale(K.rows());
    for (Index v = 0; v < laplacian.vertex_count(); ++v)
        scale[2 * v] = scale[2 * v + 1] = 1.0 / std::sqrt(laplacian.mass()[v]);
    const Eigen::SparseMatrix<double> A = scale.asDiagonal() * K.to_sparse() * scale.asDiagonal();
    Spectra::SparseSymShiftSolve<double> op(A);
    Spectra::SymEigsShiftSolver<Spectra::SparseSymShiftSolve<double>> solver(op, 8, 40, -0.5);
    solver.init();
    solver.compute(Spectra::SortRule::LargestMagn, 1000, 1e-11, Spectra::SortRule::SmallestAlge);
    EXPECT_EQ(solver.info(), Spectra::CompInfo::Successful);
    return solver.eigenvalues();
}

TEST(ConnectionLaplacian, EigenvaluesOfTheSphereConverge) {
    const auto on_sphere = [](const Mesh& mesh) {
        Points points = mesh.points();
        points.rowwise().normalize();
        return mesh.with_points(points);
    };
    for (const bool irregular : {false, true}) {
        std::vector<double> widths;
        std::vector<double> errors;
        for (const int level : {2, 3, 4}) {
            const Mesh regular = shapes::icosphere(level);
            const Vector lambda = smallest_of_sphere(
                irregular ? on_sphere(shapes::bumpy_sphere(regular.vertex_count())) : regular);
            EXPECT_GT(lambda[0], 1.0);
            EXPECT_GT(lambda[6], 4.0) << "six fields and no more";
            widths.push_back(std::pow(0.5, level));
            errors.push_back(lambda.head(6).maxCoeff() - 1.0);
        }
        const double order = testing::fitted_order(widths, errors);
        EXPECT_NEAR(order, 2.0, irregular ? 0.4 : 0.1) << errors.front() << " to " << errors.back();
        EXPECT_LT(errors.back(), irregular ? 8e-3 : 3e-4);
        RecordProperty(irregular ? "order_irregular" : "order", std::to_string(order));
    }
}

TEST(ConnectionLaplacian, RefusesWhatHasNoConsistentNormalAndOtherMeshes) {
    EXPECT_THROW((void)connection_of(moebius_strip(20)), InputError);
    EXPECT_THROW((void)connection_of(shapes::tetrahedral_cube(2)), InputError);
    const Mesh small = shapes::icosphere(1);
    const Mesh large = shapes::icosphere(2);
    EXPECT_THROW((void)connection_laplacian(large, Laplacian(small), tangent_frames(large)), InputError);
    EXPECT_THROW((void)connection_laplacian(large, Laplacian(large), tangent_frames(small)), InputError);
}

}  // namespace
}  // namespace beltrami
