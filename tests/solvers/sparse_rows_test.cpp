#include "beltrami/solvers/sparse_rows.hpp"

#include <gtest/gtest.h>

#include <Eigen/SparseCore>

#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "numerics.hpp"
#include "threads.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::random_block;
using testing::relative_difference;
using RowMajor = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// About a tenth of the entries, whole columns and rows without any among them.
RowMajor random_sparse(Index rows, Index columns, std::uint32_t seed) {
    const Block numbers = random_block(rows, columns, seed);
    RowMajor A(rows, columns);
    for (Index i = 0; i < rows; ++i) {
        for (Index j = 0; j < columns; ++j) {
            if (numbers(i, j) > 0.8 && i % 7 != 3 && j % 11 != 5) A.insert(i, j) = numbers(i, j);
        }
    }
    A.makeCompressed();
    return A;
}

TEST(SparseRows, AreTheSameMatrix) {
    const RowMajor A = random_sparse(40, 30, 1);
    const SparseRows rows = rows_of(A);
    EXPECT_EQ(rows.rows(), 40);
    EXPECT_EQ(dense(to_sparse(rows)), Eigen::MatrixXd(A));
    EXPECT_EQ(dense(to_sparse(transpose(rows))), Eigen::MatrixXd(A).transpose());
}

TEST(SparseRows, ProductsAndSums) {
    const RowMajor A = random_sparse(60, 50, 1);
    const RowMajor B = random_sparse(50, 20, 2);
    const RowMajor C = random_sparse(60, 20, 3);
    const Eigen::MatrixXd expected = Eigen::MatrixXd(A) * Eigen::MatrixXd(B);
    const SparseRows AB = product(rows_of(A), rows_of(B));
    EXPECT_LT(relative_difference(dense(to_sparse(AB)), expected), 1e-14);
    EXPECT_LT(relative_difference(dense(to_sparse(sum(AB, rows_of(C)))), expected + Eigen::MatrixXd(C)),
              1e-14);
    SparseRows scaled = rows_of(B);
    const Vector scale = Vector::LinSpaced(20, -1.0, 3.0);
    scale_columns(scale, scaled);
    EXPECT_EQ(dense(to_sparse(scaled)), Eigen::MatrixXd(B) * scale.asDiagonal());
}

TEST(SparseRows, NothingAtAll) {
    const SparseRows none = rows_of(RowMajor(0, 5));
    EXPECT_EQ(product(none, rows_of(RowMajor(5, 3))).rows(), 0);
    EXPECT_EQ(product(rows_of(RowMajor(4, 5)), rows_of(RowMajor(5, 3))).column.size(), 0U);
    EXPECT_EQ(transpose(none).rows(), 5);
}

TEST(SparseRows, StiffnessIsReadWhereItStands) {
    const Laplacian laplacian(shapes::fins(3, 12));
    const Index n = laplacian.vertex_count();
    const StiffnessRows rows{laplacian.stiffness(), 0.5, 2.0, &laplacian.mass()};
    const SparseRows P = rows_of(random_sparse(n, 9, 4));
    const Eigen::MatrixXd A =
        0.5 * dense(laplacian.stiffness().to_sparse()) + 2.0 * Eigen::MatrixXd(laplacian.mass().asDiagonal());
    EXPECT_LT(relative_difference(dense(to_sparse(product(n, rows, P))), A * dense(to_sparse(P))), 1e-14);
}

TEST(SparseRows, ThreadsDoNotMatter) {
    const Laplacian laplacian(shapes::grid(120, 120));
    const Index n = laplacian.vertex_count();
    const StiffnessRows K{laplacian.stiffness()};
    RowMajor every(n, n / 5 + 1);
    for (Index i = 0; i < n; ++i)
        every.insert(i, i / 5) = 1.0 + i % 3;
    const SparseRows P = rows_of(every);
    const auto made_by = [&](int count) {
        const testing::Threads threads(count);
        return product(n, K, P);
    };
    const SparseRows one = made_by(1);
    const SparseRows three = made_by(3);
    EXPECT_EQ(one.begin, three.begin);
    EXPECT_EQ(one.column, three.column);
    EXPECT_EQ(one.value, three.value);
}

}  // namespace
}  // namespace beltrami
