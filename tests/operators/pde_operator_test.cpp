#include "beltrami/operators/pde_operator.hpp"

#include <limits>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::random_block;
using testing::relative_difference;

// sigma M + sum of gamma_i K (D K)^(i-1) from dense products.
Eigen::MatrixXd reference(const Laplacian& laplacian, double sigma, const std::vector<double>& gamma) {
    const Eigen::MatrixXd K = dense(laplacian.stiffness().to_sparse());
    Eigen::MatrixXd power = K;
    Eigen::MatrixXd sum = sigma * Eigen::MatrixXd(laplacian.mass().asDiagonal());
    for (const double g : gamma) {
        sum += g * power;
        power = K * laplacian.inverse_mass().asDiagonal() * power;
    }
    return sum;
}

// One to five terms; with zeros at the start, in the middle and at the end.
const std::vector<std::vector<double>> coefficients{{},
                                                    {2.0},
                                                    {1.0},
                                                    {0.0, 1.0},
                                                    {1.0, 0.1},
                                                    {0.0, 0.0, 0.3},
                                                    {1.0, 0.0, 0.2},
                                                    {0.5, 0.2, 0.1, 0.05},
                                                    {1.0, 0.0, 0.0, 0.1},
                                                    {0.5, 0.2, 0.1, 0.05, 0.02},
                                                    {0.0, 0.0, 0.0, 0.0, 1.0},
                                                    {1.0, 0.0, 0.0}};

std::vector<Laplacian> laplacians() {
    Points with_isolated(43, 3);
    with_isolated << shapes::icosphere(1).points(), 9.0, 9.0, 9.0;
    return {Laplacian(shapes::with_noise(shapes::icosphere(1), 0.2)),
            Laplacian(shapes::fins(3, 3)),
            Laplacian(shapes::tetrahedral_cube(3)),
            Laplacian(shapes::circle(12)),
            Laplacian(shapes::grid(5, 5), {.mass = Mass::voronoi, .weights = Weights::combinatorial}),
            Laplacian(Mesh(with_isolated, shapes::icosphere(1).cells()))};
}

TEST(PdeOperator, AgreesWithTheAssembledProducts) {
    for (const Laplacian& laplacian : laplacians()) {
        for (const double sigma : {0.0, 0.7}) {
            for (const auto& gamma : coefficients) {
                const PdeOperator A(laplacian, sigma, gamma);
                const Eigen::MatrixXd expected = reference(laplacian, sigma, gamma);
                EXPECT_LT(relative_difference(dense(A.to_sparse()), expected), 1e-12);
                EXPECT_LT(relative_difference(A.diagonal(), Vector(expected.diagonal())), 1e-12);
                for (const Index k : {1, 3}) {
                    const Block u = random_block(A.rows(), k);
                    Block y = Block::Constant(A.rows(), k, std::numeric_limits<double>::quiet_NaN());
                    A.apply(u, y);
                    EXPECT_LT(relative_difference(y, Block(expected * u)), 1e-12)
                        << gamma.size() << " terms, sigma " << sigma << ", " << k << " columns";
                }
            }
        }
    }
}

TEST(PdeOperator, IsSymmetric) {
    const PdeOperator A(Laplacian(shapes::bumpy_sphere(200)), 0.3, {1.0, 0.2, 0.1});
    const Eigen::MatrixXd matrix = dense(A.to_sparse());
    EXPECT_LT(relative_difference(matrix, Eigen::MatrixXd(matrix.transpose())), 1e-12);
    const Block u = random_block(A.rows(), 1, 1);
    const Block v = random_block(A.rows(), 1, 2);
    Block Au;
    Block Av;
    A.apply(u, Au);
    A.apply(v, Av);
    EXPECT_NEAR(v.col(0).dot(Au.col(0)), u.col(0).dot(Av.col(0)), 1e-12 * Au.norm() * v.norm());
}

TEST(PdeOperator, AWorkspaceServesAnyWidth) {
    const PdeOperator A(Laplacian(shapes::icosphere(1)), 0.3, {1.0, 0.2, 0.1});
    PdeOperator::Workspace workspace;
    for (const Index k : {3, 1, 5}) {
        const Block u = random_block(A.rows(), k);
        Block with;
        Block without;
        A.apply(u, with, workspace);
        A.apply(u, without);
        EXPECT_EQ(with, without);
    }
}

TEST(PdeOperator, LargeFieldsOnThreads) {
    const PdeOperator A(Laplacian(shapes::shuffled(shapes::grid(150, 150)).mesh), 0.3, {1.0, 1e-4});
    const Eigen::SparseMatrix<double> matrix = A.to_sparse();
    const Block u = random_block(A.rows(), 3);
    Block y;
    A.apply(u, y);
    EXPECT_LT(relative_difference(y, Block(matrix * u)), 1e-12);
}

TEST(PdeOperator, OrderCountsProductsThatAreNeeded) {
    const Laplacian laplacian(shapes::icosphere(0));
    EXPECT_EQ(PdeOperator(laplacian, 1.0, {}).order(), 0);
    EXPECT_EQ(PdeOperator(laplacian, 1.0, {1.0, 0.0}).order(), 1);
    EXPECT_EQ(PdeOperator(laplacian, 1.0, {0.0, 1.0}).order(), 2);
}

// On the sphere D K has the eigenvalue l (l + 1), so each further term multiplies by about that. Not from the
// third on: D K z is off by a constant at the twelve vertices of five neighbours, and the energy of such
// spikes does not vanish with the mesh width.
TEST(PdeOperator, PowersActAsPowersOfTheLaplacian) {
    const Mesh sphere = shapes::icosphere(4);
    const Laplacian laplacian(sphere, {.renumber = false});
    const Block z = sphere.points().col(2);
    for (std::size_t terms = 1; terms <= 2; ++terms) {
        std::vector<double> gamma(terms, 0.0);
        gamma.back() = 1.0;
        Block y;
        PdeOperator(laplacian, 0.0, gamma).apply(z, y);
        const double expected = std::pow(2.0, static_cast<double>(terms));
        EXPECT_NEAR(z.col(0).dot(y.col(0)) / z.col(0).dot(laplacian.mass().asDiagonal() * z.col(0)), expected,
                    0.01 * expected);
    }
}

TEST(PdeOperator, RefusesCoefficientsThatMakeItIndefinite) {
    const Laplacian laplacian(shapes::icosphere(0));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double bad : {-1.0, -1e-300, nan, infinity}) {
        EXPECT_THROW(PdeOperator(laplacian, bad, {1.0}), InputError);
        EXPECT_THROW(PdeOperator(laplacian, 1.0, {1.0, bad}), InputError);
    }
    Block y;
    EXPECT_THROW(PdeOperator(laplacian, 1.0, {1.0}).apply(Block(Block::Zero(11, 1)), y), InputError);
}

}  // namespace
}  // namespace beltrami
