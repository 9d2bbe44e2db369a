#include "beltrami/operators/hermitian_pde_operator.hpp"

#include <gtest/gtest.h>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/connection_laplacian.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using Complex = std::complex<double>;
using testing::dense;
using testing::random_block;
using testing::relative_difference;

HermitianPdeOperator pde(const Mesh& mesh, double sigma, const std::vector<double>& gamma) {
    const Laplacian laplacian(mesh);
    return {connection_laplacian(mesh, laplacian, tangent_frames(mesh)), laplacian, sigma, gamma};
}

// sigma M + sum of gamma_i K (D K)^(i-1) from dense complex products.
Eigen::MatrixXcd reference(const Mesh& mesh, double sigma, const std::vector<double>& gamma) {
    const Laplacian laplacian(mesh);
    const Eigen::MatrixXcd K = dense(connection_laplacian(mesh, laplacian, tangent_frames(mesh)).to_sparse());
    Eigen::MatrixXcd power = K;
    Eigen::MatrixXcd sum = sigma * Eigen::MatrixXcd(laplacian.mass().cast<Complex>().asDiagonal());
    for (const double g : gamma) {
        sum += g * power;
        power = K * laplacian.inverse_mass().cast<Complex>().asDiagonal() * power;
    }
    return sum;
}

TEST(HermitianPdeOperator, IsTheRealFormOfTheComplexProducts) {
    for (const Mesh& mesh : {shapes::with_noise(shapes::icosphere(1), 0.2), shapes::fins(3, 3)}) {
        for (const double sigma : {0.0, 0.7}) {
            for (const std::vector<double>& gamma : {std::vector<double>{},
                                                     {2.0},
                                                     {0.0, 1.0},
                                                     {1.0, 0.1},
                                                     {0.5, 0.0, 0.2},
                                                     {0.5, 0.2, 0.1, 0.05}}) {
                const HermitianPdeOperator A = pde(mesh, sigma, gamma);
                const Eigen::MatrixXcd expected = reference(mesh, sigma, gamma);
                ASSERT_EQ(A.rows(), 2 * mesh.vertex_count());
                const Eigen::MatrixXd matrix = dense(A.to_sparse());
                EXPECT_LT(relative_difference(matrix, Eigen::MatrixXd(matrix.transpose())), 1e-14);
                EXPECT_LT(relative_difference(A.diagonal(), Vector(matrix.diagonal())), 1e-12);
                const Product product = A.product();
                for (const Index k : {1, 3}) {
                    const Block u = random_block(A.rows(), k);
                    const BlockOf<Complex> z = HermitianPdeOperator::to_complex(u);
                    const Block y = HermitianPdeOperator::to_real(expected * z);
                    Block got;
                    A.apply(u, got);
                    EXPECT_LT(relative_difference(got, y), 1e-12) << gamma.size() << " terms";
                    EXPECT_LT(relative_difference(Block(matrix * u), y), 1e-12);
                    Block again;
                    product(u, again);
                    EXPECT_EQ(again, got);
                }
            }
        }
    }
}

TEST(HermitianPdeOperator, SaysWhatSolversGoBy) {
    const Mesh mesh = shapes::icosphere(2);
    const HermitianPdeOperator A = pde(mesh, 0.5, {1.0, 0.1, 0.0});
    EXPECT_EQ(A.order(), 2);
    EXPECT_EQ(A.graph().vertex_count(), mesh.vertex_count());
    EXPECT_NEAR(A.total_mass(), lumped_mass(mesh).sum(), 1e-12) << "half of it, for each of two parts";
}

TEST(HermitianPdeOperator, RefusesWhatDoesNotFit) {
    const Mesh small = shapes::icosphere(0);
    const Laplacian laplacian(small);
    const auto K = connection_laplacian(small, laplacian, tangent_frames(small));
    EXPECT_THROW(HermitianPdeOperator(K, Laplacian(shapes::icosphere(1)), 0.0, {1.0}), InputError);
    EXPECT_THROW(HermitianPdeOperator(K, laplacian, -1.0, {1.0}), InputError);
    EXPECT_THROW(HermitianPdeOperator(K, laplacian, 0.0, {1.0, -1.0}), InputError);
    const HermitianPdeOperator A(K, laplacian, 0.0, {1.0});
    Block y;
    EXPECT_THROW(A.apply(Block::Zero(23, 1), y), InputError);
    EXPECT_THROW(A.apply(Block::Zero(26, 1), y), InputError);
}

}  // namespace
}  // namespace beltrami
