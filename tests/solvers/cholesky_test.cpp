#include "beltrami/solvers/cholesky.hpp"

#include <omp.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

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

// Wide fronts are in the last only.
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
            EXPECT_GE(static_cast<double>(factor.memory_bytes()), 8.0 * factor.nonzeros());
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

// x of A_ff x_f = b_f by Eigen; held rows are those of b.
Block by_reduction(const Sparse& A, const std::vector<Index>& held, const Block& b) {
    std::vector<Index> number(static_cast<std::size_t>(A.rows()), 0);
    for (const Index v : held)
        number[static_cast<std::size_t>(v)] = -1;
    std::vector<Index> free;
    for (Index v = 0; v < A.rows(); ++v) {
        if (number[static_cast<std::size_t>(v)] < 0) continue;
        number[static_cast<std::size_t>(v)] = static_cast<Index>(free.size());
        free.push_back(v);
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (const Index col : free) {
        for (Sparse::InnerIterator entry(A, col); entry; ++entry) {
            const Index row = number[static_cast<std::size_t>(entry.row())];
            if (row >= 0) entries.emplace_back(row, number[static_cast<std::size_t>(col)], entry.value());
        }
    }
    Sparse A_ff(std::ssize(free), std::ssize(free));
    A_ff.setFromTriplets(entries.begin(), entries.end());
    Block x = b;
    if (free.empty() || b.cols() == 0) return x;
    const Eigen::SimplicialLDLT<Sparse> eigen(A_ff);
    const Eigen::MatrixXd x_f = eigen.solve(Eigen::MatrixXd(b(free, Eigen::all)));
    x(free, Eigen::all) = x_f;
    return x;
}
Block solved(const Cholesky& factor, const Block& b) {
    Block x;
    factor.solve(b, x);
    return x;
}
std::vector<Index> every(Index step, Index n) {
    std::vector<Index> all;
    for (Index v = 0; v < n; v += step)
        all.push_back(v);
    return all;
}

TEST(CholeskyAnalysis, ServesAllMatricesAndHeldSets) {
    const Mesh mesh = shapes::bumpy_sphere(900);
    const Laplacian laplacian(mesh);
    const Sparse bilaplacian = PdeOperator(laplacian, 0.0, {0.0, 1.0}).to_sparse();
    for (const auto ordering : {Cholesky::Ordering::amd, Cholesky::Ordering::metis}) {
        const long before = CholeskyAnalysis::builds();
        const auto analysis = std::make_shared<const CholeskyAnalysis>(bilaplacian, ordering);
        EXPECT_EQ(analysis->rows(), 900);
        Cholesky factor(bilaplacian, analysis, every(100, 900));
        // K and K + K D K on the pattern of K D K.
        int count = 0;
        for (const auto& gamma : {std::vector<double>{0.0, 1.0}, {1.0}, {1.0, 0.1}}) {
            const Sparse A = PdeOperator(laplacian, 0.0, gamma).to_sparse();
            for (const auto& held :
                 {std::vector<Index>{3}, every(100, 900), every(2, 900), every(1, 899), every(1, 900)}) {
                factor.refactor(A, held);
                EXPECT_EQ(factor.factorizations(), ++count + 1);
                EXPECT_EQ(factor.corrected(), 0);
                const Block b = random_block(900, 2);
                const Block expected = by_reduction(A, held, b);
                EXPECT_LT(relative_difference(solved(factor, b), expected), 1e-7) << held.size();
                EXPECT_EQ(solved(Cholesky(A, analysis, held), b), solved(factor, b));
            }
        }
        EXPECT_EQ(CholeskyAnalysis::builds(), before + 1);
        EXPECT_EQ(factor.analysis(), analysis);
    }
}

TEST(Cholesky, AnalysesOnceByItself) {
    const Sparse A = assembled(shapes::icosphere(2), 0.5, {1.0});
    const long before = CholeskyAnalysis::builds();
    Cholesky factor(A);
    factor.refactor(2.0 * A, std::vector<Index>{5});
    factor.change_held(2.0 * A, every(3, static_cast<Index>(A.rows())));
    EXPECT_EQ(CholeskyAnalysis::builds(), before + 1);
}

TEST(Cholesky, SolvesAnyNumberOfColumns) {
    const Sparse A = assembled(shapes::grid(30, 30), 0.5, {1.0, 1e-3});
    const std::vector<Index> held = every(100, static_cast<Index>(A.rows()));
    const Cholesky factor(A, std::make_shared<const CholeskyAnalysis>(A), held);
    for (const Index columns : {0, 1, 4, 5, 33, 64, 100}) {
        const Block b = random_block(static_cast<Index>(A.rows()), columns);
        const Block x = solved(factor, b);
        EXPECT_EQ(x.cols(), columns);
        EXPECT_LT(relative_difference(x, by_reduction(A, held, b)), 1e-9) << columns;
        Block in_place = b;
        factor.solve(in_place, in_place);
        EXPECT_EQ(in_place, x);
    }
}

// Large enough for threads to share it.
TEST(Cholesky, ThreadsDoNotMatter) {
    const Sparse A = assembled(shapes::grid(70, 70), 0.5, {1.0, 1e-3});
    const std::vector<Index> held = every(1000, static_cast<Index>(A.rows()));
    const auto analysis = std::make_shared<const CholeskyAnalysis>(A);
    const Block b = random_block(static_cast<Index>(A.rows()), 33);
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    const Block x = solved(Cholesky(A, analysis, held), b);
    for (const int count : {2, 3}) {
        omp_set_num_threads(count);
        EXPECT_EQ(solved(Cholesky(A, analysis, held), b), x);
    }
    omp_set_num_threads(threads);
    EXPECT_GT(analysis->nonzeros(), 2e5);
}

// Rows are held and let go, one after the other and many at once, and the factor stays.
TEST(Cholesky, ChangesFewHeldRowsWithoutAFactor) {
    for (const auto& [mesh, gamma] : samples()) {
        const Sparse A = assembled(mesh, 0.0, gamma);
        const auto n = static_cast<Index>(A.rows());
        const Block b = random_block(n, 3);
        Cholesky factor(A, std::make_shared<const CholeskyAnalysis>(A), std::vector<Index>{1, n / 2});
        const std::vector<std::vector<Index>> sets{{1, n / 2, 7},      {1, n / 2, 7, 8}, {1, 8},
                                                   {n / 2, n / 2 + 1}, {n - 1, 0, 2, 1}, {8, 7},
                                                   {n / 2, 1}};
        for (const auto& held : sets) {
            factor.change_held(A, held);
            EXPECT_LT(relative_difference(solved(factor, b), by_reduction(A, held, b)), 1e-8)
                << n << " rows, held " << ::testing::PrintToString(held);
            EXPECT_GT(factor.memory_bytes(), static_cast<std::size_t>(8 * factor.corrected() * n));
        }
        EXPECT_EQ(factor.factorizations(), 1);
        EXPECT_EQ(factor.corrected(), 0);
    }
}

TEST(Cholesky, FactorsWhereManyHeldRowsChange) {
    const Sparse A = assembled(shapes::grid(30, 30), 0.0, {1.0});
    const auto n = static_cast<Index>(A.rows());
    Cholesky factor(A, std::make_shared<const CholeskyAnalysis>(A), std::vector<Index>{0});
    std::vector<Index> held(static_cast<std::size_t>(factor.most_corrected()) + 1);
    std::iota(held.begin(), held.end(), 0);
    factor.change_held(A, held);
    EXPECT_EQ(factor.corrected(), factor.most_corrected());
    EXPECT_EQ(factor.factorizations(), 1);
    held.push_back(500);
    factor.change_held(A, held);
    EXPECT_EQ(factor.corrected(), 0);
    EXPECT_EQ(factor.factorizations(), 2);
    const Block b = random_block(n, 1);
    EXPECT_LT(relative_difference(solved(factor, b), by_reduction(A, held, b)), 1e-10);
}

// A thick factor stays for more of them, if they do not come all at once.
TEST(Cholesky, CorrectsAsManyRowsAsAFactorIsThick) {
    const Sparse A = assembled(shapes::grid(60, 60), 0.0, {1.0, 1.0});
    const auto n = static_cast<Index>(A.rows());
    const auto analysis = std::make_shared<const CholeskyAnalysis>(A);
    Cholesky factor(A, analysis, std::vector<Index>{0});
    const Index most = factor.most_corrected();
    ASSERT_GT(most, 25);
    EXPECT_EQ(most, static_cast<Index>(0.5 * factor.nonzeros() / n));
    const Block b = random_block(n, 2);
    std::vector<Index> held;
    for (Index k = 0; k < most - 1; ++k) {
        held.push_back((37 * k + 11) % n);
        factor.change_held(A, held);
        if (k % 8 == 0) {
            EXPECT_LT(relative_difference(solved(factor, b), by_reduction(A, held, b)), 1e-8) << k;
        }
    }
    EXPECT_EQ(factor.corrected(), most);  // row 0 was let go
    EXPECT_EQ(factor.factorizations(), 1);
    EXPECT_LT(relative_difference(solved(factor, b), by_reduction(A, held, b)), 1e-8);
    factor.change_held(A, std::vector<Index>{0});
    EXPECT_EQ(factor.corrected(), 0);
    EXPECT_EQ(factor.factorizations(), 1);
    held.resize(21);
    factor.change_held(A, held);
    EXPECT_EQ(factor.corrected(), 0);
    EXPECT_EQ(factor.factorizations(), 2);
}

// What the held rows hid.
TEST(Cholesky, RefusesChangesThatLeaveItIndefinite) {
    const Mesh two = shapes::together({shapes::grid(20, 20), shapes::icosphere(2)});
    const Sparse A = assembled(two, 0.0, {1.0});
    Cholesky factor(A, std::make_shared<const CholeskyAnalysis>(A), std::vector<Index>{4, 500});
    Sparse indefinite = A;
    indefinite.coeffRef(30, 30) = -1.0;
    EXPECT_THROW(Cholesky(indefinite, factor.analysis(), std::vector<Index>{4, 500}), SolveError);
    EXPECT_NO_THROW(Cholesky(indefinite, factor.analysis(), std::vector<Index>{4, 30, 500}));
    factor.change_held(indefinite, std::vector<Index>{4, 30, 500});
    EXPECT_EQ(factor.corrected(), 1);

    Sparse negative = A;
    negative.coeffRef(4, 4) = 0.1;
    factor.refactor(negative, std::vector<Index>{4, 500});
    EXPECT_THROW(factor.change_held(negative, std::vector<Index>{500}), SolveError);
    Block x;
    EXPECT_THROW(factor.solve(Block::Zero(A.rows(), 1), x), InputError);
    factor.change_held(negative, std::vector<Index>{4, 500});
    EXPECT_NO_THROW(factor.solve(Block::Zero(A.rows(), 1), x));
}

TEST(Cholesky, RefusesWhatTheAnalysisDoesNotKnow) {
    const Mesh mesh = shapes::grid(8, 8);
    const Sparse K = assembled(mesh, 1.0, {1.0});
    const Sparse KDK = assembled(mesh, 1.0, {1.0, 1.0});
    const auto analysis = std::make_shared<const CholeskyAnalysis>(K);
    EXPECT_THROW(Cholesky(KDK, analysis), InputError);
    EXPECT_THROW(Cholesky(assembled(shapes::grid(8, 7), 1.0, {1.0}), analysis), InputError);
    EXPECT_THROW(Cholesky(K, analysis, std::vector<Index>{81}), InputError);
    EXPECT_THROW(Cholesky(K, analysis, std::vector<Index>{-1}), InputError);
    EXPECT_THROW(CholeskyAnalysis(Sparse(3, 4)), InputError);
    Sparse broken = K;
    broken.coeffRef(5, 5) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(Cholesky(broken, analysis), InputError);
    // What is refused changes nothing.
    Cholesky factor(K, analysis, std::vector<Index>{2});
    const Block b = random_block(81, 2);
    const Block before = solved(factor, b);
    EXPECT_THROW(factor.refactor(KDK), InputError);
    EXPECT_THROW(factor.change_held(K, std::vector<Index>{2, 99}), InputError);
    EXPECT_EQ(solved(factor, b), before);
}

TEST(Cholesky, RecoversFromAMatrixThatIsNotDefinite) {
    const Sparse A = assembled(shapes::grid(20, 20), 1.0, {1.0});
    const Block b = random_block(static_cast<Index>(A.rows()), 2);
    Cholesky factor(A);
    const Block before = solved(factor, b);
    EXPECT_THROW(factor.refactor(-1.0 * A), SolveError);
    Block x;
    EXPECT_THROW(factor.solve(b, x), InputError);
    factor.refactor(A);
    EXPECT_EQ(solved(factor, b), before);
}

}  // namespace
}  // namespace beltrami
