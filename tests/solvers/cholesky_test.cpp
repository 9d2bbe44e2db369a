#include "beltrami/solvers/cholesky.hpp"

#include <Eigen/SparseCholesky>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/pde_operator.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::random_block;
using testing::relative_difference;
using Sparse = Eigen::SparseMatrix<double>;

Sparse assembled(const Mesh& mesh, double sigma, std::vector<double> gamma) {
    return PdeOperator(Laplacian(mesh), sigma, std::move(gamma)).to_sparse();
}

// CHOLMOD works column by column on the first two and in dense blocks on the last.
const std::vector<std::pair<Mesh, std::vector<double>>>& samples() {
    static const std::vector<std::pair<Mesh, std::vector<double>>> all{
        {shapes::circle(40), {1.0}}, {shapes::icosphere(2), {1.0}}, {shapes::grid(60, 60), {1.0, 1e-3}}};
    return all;
}

TEST(Cholesky, AgreesWithEigen) {
    for (const auto& [mesh, gamma] : samples()) {
        const Sparse A = assembled(mesh, 0.5, gamma);
        const Block b = random_block(static_cast<Index>(A.rows()), 3);
        const Eigen::SimplicialLDLT<Sparse> eigen(A);
        const Block expected = eigen.solve(Eigen::MatrixXd(b));
        for (const auto ordering : {Cholesky::Ordering::amd, Cholesky::Ordering::metis}) {
            const Cholesky factor(A, ordering);
            Block x;
            factor.solve(b, x);
            EXPECT_LT(relative_difference(x, expected), 1e-9);
            EXPECT_EQ(factor.rows(), A.rows());
            EXPECT_GE(factor.nonzeros(), static_cast<double>(A.rows() + (A.nonZeros() - A.rows()) / 2));
            EXPECT_GE(factor.memory_bytes(), 8 * static_cast<std::size_t>(A.rows()));
        }
    }
}

TEST(Cholesky, ReadsTheUpperTriangleOnly) {
    const Sparse A = assembled(shapes::icosphere(1), 0.5, {1.0});
    const Sparse upper = A.triangularView<Eigen::Upper>();
    const Block b = random_block(42, 1);
    Block x;
    Block y;
    Cholesky(A).solve(b, x);
    Cholesky(upper).solve(b, y);
    EXPECT_EQ(x, y);
}

// One diagonal entry turned negative: one negative eigenvalue among many positive ones, wherever it comes in
// the order.
TEST(Cholesky, RefusesIndefiniteMatricesOfAnySize) {
    for (const auto& [mesh, gamma] : samples()) {
        Sparse A = assembled(mesh, 0.5, gamma);
        for (const Eigen::Index v : {Eigen::Index{0}, A.rows() / 2, A.rows() - 1}) {
            const double before = A.coeff(v, v);
            A.coeffRef(v, v) = -before;
            EXPECT_THROW(Cholesky{A}, SolveError) << A.rows() << " rows";
            A.coeffRef(v, v) = before;
        }
        EXPECT_NO_THROW(Cholesky{A});
    }
}

// A shift into the spectrum, as somebody looking for eigenvalues would make it.
TEST(Cholesky, RefusesAShiftedStiffness) {
    for (const int n : {4, 60}) {
        const Laplacian laplacian(shapes::grid(n, n));
        Sparse A = laplacian.stiffness().to_sparse();
        A.diagonal() -= 1.0 * laplacian.mass();  // 0 < 1 < pi^2: one negative eigenvalue
        EXPECT_THROW(Cholesky{A}, SolveError) << n;
    }
}

TEST(Cholesky, RefusesZeroRows) {
    Sparse A(3, 3);
    A.insert(0, 0) = 1.0;
    A.insert(2, 2) = 1.0;
    EXPECT_THROW(Cholesky{A}, SolveError);
}

TEST(Cholesky, SolvesOneUnknownAndManyTimes) {
    Sparse A(1, 1);
    A.insert(0, 0) = 4.0;
    Cholesky factor(A);
    const Cholesky moved = std::move(factor);
    for (int i = 1; i <= 3; ++i) {
        Block x;
        moved.solve(Block::Constant(1, i, 8.0), x);
        EXPECT_EQ(x, Block::Constant(1, i, 2.0));
    }
}

TEST(Cholesky, RefusesLoadsOfOtherLengths) {
    const Cholesky factor(assembled(shapes::icosphere(0), 1.0, {1.0}));
    Block x;
    EXPECT_THROW(factor.solve(Block::Zero(11, 1), x), InputError);
}

}  // namespace
}  // namespace beltrami
