#include "beltrami/operators/edge_operator.hpp"

#include <complex>
#include <limits>
#include <tuple>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/stiffness.hpp"
#include "numerics.hpp"
#include "threads.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::graph_of;
using testing::random_block;
using testing::random_vector;
using testing::relative_difference;
using testing::Threads;
using Complex = std::complex<double>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Numbers with nothing special about them: row sums are not zero and signs are mixed.
EdgeOperator<double> arbitrary(const std::shared_ptr<const EdgeGraph>& graph) {
    return {graph, random_vector(graph->vertex_count(), 1), random_vector(graph->edge_count(), 2)};
}
EdgeOperator<Complex> arbitrary_hermitian(const std::shared_ptr<const EdgeGraph>& graph) {
    Eigen::VectorXcd edges(graph->edge_count());
    edges.real() = random_vector(graph->edge_count(), 2);
    edges.imag() = random_vector(graph->edge_count(), 3);
    return {graph, random_vector(graph->vertex_count(), 1).cast<Complex>(), edges};
}

// Both ends of the numbering joined to everything, so that every thread writes into the rows of every other.
std::shared_ptr<const EdgeGraph> double_star(Index n) {
    std::vector<std::pair<Index, Index>> edges;
    for (Index v = 0; v < n; ++v) {
        edges.emplace_back(0, v);
        edges.emplace_back(n - 1, v);
    }
    return std::make_shared<const EdgeGraph>(n, std::move(edges));
}

TEST(EdgeOperator, HoldsNumbersWhereTheGraphSays) {
    const auto graph = graph_of(shapes::icosphere(1));
    const EdgeOperator<double> A = arbitrary(graph);
    const Eigen::MatrixXd matrix = dense(A.to_sparse());
    EXPECT_EQ(matrix, matrix.transpose());
    EXPECT_EQ(A.to_sparse().nonZeros(), graph->vertex_count() + 2 * graph->edge_count());
    for (Index i = 0; i < A.rows(); ++i) {
        EXPECT_EQ(matrix(i, i), A.diagonal()[i]);
        for (const auto [j, edge] : graph->neighbours(i))
            EXPECT_EQ(matrix(i, j), A.edges()[edge]);
    }
}

TEST(EdgeOperator, HermitianHoldsTheConjugateBelowTheDiagonal) {
    const auto graph = graph_of(shapes::icosphere(1));
    const EdgeOperator<Complex> A = arbitrary_hermitian(graph);
    const Eigen::MatrixXcd matrix = dense(A.to_sparse());
    EXPECT_EQ(matrix, matrix.adjoint());
    for (Index e = 0; e < graph->edge_count(); ++e) {
        EXPECT_EQ(matrix(graph->lower(e), graph->upper()[static_cast<std::size_t>(e)]), A.edges()[e]);
    }
}

TEST(EdgeOperator, ProductsOfEveryWidthAgreeWithDense) {
    const auto graph = graph_of(shapes::fins(3, 4));
    const EdgeOperator<double> A = arbitrary(graph);
    const Eigen::MatrixXd matrix = dense(A.to_sparse());
    for (Index k = 0; k <= 6; ++k) {
        const Block u = random_block(A.rows(), k);
        Block y = Block::Constant(A.rows(), k, nan);  // what y held before must not matter
        A.apply(u, y);
        EXPECT_LT(relative_difference(y, Block(matrix * u)), 1e-14) << k << " columns";
    }
    Vector y = Vector::Constant(2, nan);
    const Vector u = random_vector(A.rows());
    A.apply(u, y);
    EXPECT_LT(relative_difference(y, Vector(matrix * u)), 1e-14);
}

TEST(EdgeOperator, HermitianProductsAgreeWithDense) {
    const auto graph = graph_of(shapes::icosphere(2));
    const EdgeOperator<Complex> A = arbitrary_hermitian(graph);
    const Eigen::MatrixXcd matrix = dense(A.to_sparse());
    for (Index k = 1; k <= 6; ++k) {
        BlockOf<Complex> u(A.rows(), k);
        u.real() = random_block(A.rows(), k, 4);
        u.imag() = random_block(A.rows(), k, 5);
        BlockOf<Complex> y = BlockOf<Complex>::Constant(A.rows(), k, nan);
        A.apply(u, y);
        EXPECT_LT(relative_difference(y, BlockOf<Complex>(matrix * u)), 1e-14) << k << " columns";
        EXPECT_NEAR(u.col(0).dot(y.col(0)).imag(), 0.0, 1e-12) << "u* A u of a Hermitian A is real";
    }
}

// Ordered meshes give threads short overlaps, shuffled ones and stars overlaps with all others; 74 x 74
// squares are 11 blocks of rows, which 7 threads cannot share evenly.
class EdgeOperatorThreads : public ::testing::TestWithParam<std::tuple<const char*, int>> {
  protected:
    static std::shared_ptr<const EdgeGraph> graph(const std::string& name) {
        if (name == "ordered") return graph_of(shapes::grid(190, 190));
        if (name == "shuffled") return graph_of(shapes::shuffled(shapes::grid(190, 190)).mesh);
        if (name == "few blocks") return graph_of(shapes::grid(74, 74));
        return double_star(40000);
    }
};

TEST_P(EdgeOperatorThreads, DoNotChangeProducts) {
    const auto [name, threads] = GetParam();
    const Threads scope(threads);
    const EdgeOperator<double> A = arbitrary(graph(name));
    const Eigen::SparseMatrix<double> matrix = A.to_sparse();
    for (const Index k : {1, 2, 3, 4, 5, 6}) {
        const Block u = random_block(A.rows(), k);
        Block y = Block::Constant(A.rows(), k, nan);
        A.apply(u, y);
        EXPECT_LT(relative_difference(y, Block(matrix * u)), 1e-12) << k << " columns";
    }
}

TEST_P(EdgeOperatorThreads, DoNotChangeHermitianProducts) {
    const auto [name, threads] = GetParam();
    const Threads scope(threads);
    const EdgeOperator<Complex> A = arbitrary_hermitian(graph(name));
    const Eigen::SparseMatrix<Complex> matrix = A.to_sparse();
    for (const Index k : {1, 5}) {
        BlockOf<Complex> u(A.rows(), k);
        u.real() = random_block(A.rows(), k, 4);
        u.imag() = random_block(A.rows(), k, 5);
        BlockOf<Complex> y = BlockOf<Complex>::Constant(A.rows(), k, nan);
        A.apply(u, y);
        EXPECT_LT(relative_difference(y, BlockOf<Complex>(matrix * u)), 1e-12) << k << " columns";
    }
}

INSTANTIATE_TEST_SUITE_P(All, EdgeOperatorThreads,
                         ::testing::Combine(::testing::Values("ordered", "shuffled", "few blocks",
                                                              "double star"),
                                            ::testing::Values(1, 2, 7)));

TEST(EdgeOperator, VerticesWithoutEdgesAreOnlyScaled) {
    const auto graph = std::make_shared<const EdgeGraph>(5, std::vector<std::pair<Index, Index>>{{1, 3}});
    const EdgeOperator<double> A(graph, Vector::LinSpaced(5, 1.0, 5.0), Vector::Constant(1, -1.0));
    Vector y;
    A.apply(Vector::Ones(5), y);
    EXPECT_EQ(y, (Vector(5) << 1, 1, 3, 3, 5).finished());
}

TEST(EdgeOperator, OfNothingIsNothing) {
    const auto graph = std::make_shared<const EdgeGraph>(0, std::vector<std::pair<Index, Index>>{});
    const EdgeOperator<double> A(graph, Vector(), Vector());
    Block y;
    A.apply(Block(0, 3), y);
    EXPECT_EQ(y.rows(), 0);
    EXPECT_EQ(y.cols(), 3);
    EXPECT_EQ(A.to_sparse().rows(), 0);
}

TEST(EdgeOperator, RefusesWrongShapes) {
    const auto graph = graph_of(shapes::icosphere(0));
    EXPECT_THROW(EdgeOperator<double>(graph, Vector::Ones(11), Vector::Ones(30)), InputError);
    EXPECT_THROW(EdgeOperator<double>(graph, Vector::Ones(12), Vector::Ones(31)), InputError);
    const EdgeOperator<double> A(graph, Vector::Ones(12), Vector::Ones(30));
    Block block;
    Vector vector;
    EXPECT_THROW(A.apply(Block(Block::Ones(11, 1)), block), InputError);
    EXPECT_THROW(A.apply(Vector(Vector::Ones(13)), vector), InputError);
}

TEST(EdgeOperator, CountsBuildsButNotCopies) {
    const auto graph = graph_of(shapes::icosphere(0));
    const long before = EdgeOperator<double>::builds();
    const EdgeOperator<double> A = combinatorial_stiffness(graph);
    EXPECT_EQ(EdgeOperator<double>::builds(), before + 1);
    const EdgeOperator<double> copy = A;  // NOLINT(performance-unnecessary-copy-initialization)
    EXPECT_EQ(EdgeOperator<double>::builds(), before + 1);
    EXPECT_EQ(copy.edges(), A.edges());
}

}  // namespace
}  // namespace beltrami
