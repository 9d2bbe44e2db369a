#include "beltrami/solvers/chebyshev.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <vector>

#include "beltrami/framework/shapes.hpp"
#include "beltrami/solvers/sparse_rows.hpp"
#include "threads.hpp"

namespace beltrami {
namespace {

// D^(-1/2) A D^(-1/2) in the order of the places, without what is held.
Eigen::MatrixXd in_places(const Eigen::MatrixXd& A, const ScaledRows& scaled) {
    Eigen::MatrixXd result(A.rows(), A.cols());
    for (Index p = 0; p < A.rows(); ++p) {
        for (Index q = 0; q < A.cols(); ++q) {
            const Index i = scaled.order[static_cast<std::size_t>(p)];
            const Index j = scaled.order[static_cast<std::size_t>(q)];
            result(p, q) = scaled.scale[static_cast<std::size_t>(i)] * A(i, j) *
                           scaled.scale[static_cast<std::size_t>(j)];
        }
    }
    return result;
}

struct Case {
    PdeOperator A;
    ScaledRows scaled;
    Chebyshev smoother;
};

Case make(const Laplacian& laplacian, double sigma, const std::vector<double>& gamma,
          const std::vector<Index>& fixed) {
    PdeOperator A(laplacian, sigma, gamma);
    std::vector<char> held(static_cast<std::size_t>(A.rows()), 0);
    for (const Index i : fixed)
        held[static_cast<std::size_t>(i)] = 1;
    const SparseRows rows = rows_of(A.to_sparse());
    ScaledRows scaled = scaled_rows(A.rows(), rows, held);
    Chebyshev smoother = A.order() == 2 ? Chebyshev(A, scaled) : Chebyshev(rows, scaled);
    return {std::move(A), std::move(scaled), std::move(smoother)};
}

std::vector<Case> cases() {
    static const Laplacian sphere(shapes::bumpy_sphere(1500));
    static const Laplacian ball(shapes::tetrahedral_ball(6));
    std::vector<Case> result;
    result.push_back(make(sphere, 0.0, {1.0}, {3, 500}));
    result.push_back(make(sphere, 1.0, {0.01}, {}));
    result.push_back(make(sphere, 0.0, {0.0, 1.0}, {3, 500, 501}));
    result.push_back(make(sphere, 2.0, {1.0, 0.01}, {3}));
    result.push_back(make(ball, 0.0, {1.0}, {7}));
    result.push_back(make(ball, 0.0, {0.5, 1.0}, {7}));
    return result;
}

TEST(Chebyshev, TheResidualIsThatOfTheSolution) {
    for (const Case& c : cases()) {
        const Eigen::MatrixXd A = in_places(Eigen::MatrixXd(c.A.to_sparse()), c.scaled);
        for (const int k : {1, 3, 4}) {
            SmootherFields fields;
            c.smoother.resize(k, fields);
            Eigen::MatrixXd b = Eigen::MatrixXd::Random(A.rows(), k);
            for (Index p = 0; p < A.rows(); ++p) {
                if (c.scaled.is_held(c.scaled.order[static_cast<std::size_t>(p)])) b.row(p).setZero();
                for (int column = 0; column < k; ++column)
                    fields.d[0][static_cast<std::size_t>(k * p + column)] = static_cast<float>(b(p, column));
            }
            c.smoother.descend(k, fields);
            using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
            const auto of = [&](const std::vector<float>& field) -> Eigen::MatrixXd {
                return Eigen::Map<const Rows>(field.data(), A.rows(), k).cast<double>();
            };
            EXPECT_LT((b - A * of(fields.x) - of(fields.r)).cwiseAbs().maxCoeff(), 1e-4);
            EXPECT_LT(of(fields.r).norm(), b.norm());

            // A correction that is zero leaves the same smoothing.
            const SlicedRows nothing(c.scaled.size(), [](Index, auto) {});
            const Eigen::MatrixXd before = of(fields.r);
            const float none[4] = {};
            c.smoother.ascend(k, nothing, none, fields);
            EXPECT_LT((b - A * of(fields.x)).norm(), before.norm());
        }
    }
}

TEST(Chebyshev, BoundsTheLargestEigenvalueClosely) {
    for (const Case& c : cases()) {
        const Eigen::MatrixXd A = in_places(Eigen::MatrixXd(c.A.to_sparse()), c.scaled);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(A, Eigen::EigenvaluesOnly);
        const double largest = eigen.eigenvalues().maxCoeff();
        EXPECT_GT(c.smoother.largest_eigenvalue(), largest);
        EXPECT_LT(c.smoother.largest_eigenvalue(), 1.15 * largest);
    }
}

TEST(Chebyshev, RowsThatAreHeldStayAtZero) {
    for (const Case& c : cases()) {
        SmootherFields fields;
        c.smoother.resize(1, fields);
        for (Index p = 0; p < c.scaled.size(); ++p) {
            const bool held = c.scaled.is_held(c.scaled.order[static_cast<std::size_t>(p)]);
            fields.d[0][static_cast<std::size_t>(p)] = held ? 0.0F : 1.0F;
        }
        c.smoother.descend(1, fields);
        for (Index p = 0; p < c.scaled.size(); ++p) {
            if (!c.scaled.is_held(c.scaled.order[static_cast<std::size_t>(p)])) continue;
            EXPECT_EQ(fields.x[static_cast<std::size_t>(p)], 0.0F);
            EXPECT_EQ(fields.r[static_cast<std::size_t>(p)], 0.0F);
        }
    }
}

// K D K is applied by its factors.
TEST(Chebyshev, StoresNoSquareOfK) {
    for (const Case& c : cases()) {
        EXPECT_NEAR(c.smoother.entries_per_row(),
                    1.0 + 2.0 * c.A.graph().edge_count() / static_cast<double>(c.A.rows()), 0.1);
    }
}

TEST(Chebyshev, AMatrixWithoutRowsOrWithAllOfThemHeld) {
    const SparseRows none;
    const Chebyshev empty(none, scaled_rows(0, none, {}));
    SmootherFields fields;
    empty.resize(2, fields);
    empty.descend(2, fields);
    const Laplacian laplacian(shapes::icosphere(1));
    const PdeOperator A(laplacian, 1.0, {1.0});
    const SparseRows rows = rows_of(A.to_sparse());
    const std::vector<char> all(static_cast<std::size_t>(A.rows()), 1);
    const Chebyshev held(rows, scaled_rows(A.rows(), rows, all));
    held.resize(1, fields);
    held.descend(1, fields);
    for (const float x : fields.x)
        EXPECT_EQ(x, 0.0F);
}

}  // namespace
}  // namespace beltrami
