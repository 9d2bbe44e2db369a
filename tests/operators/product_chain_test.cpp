#include "beltrami/operators/product_chain.hpp"

#include <complex>
#include <limits>
#include <string>
#include <tuple>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/pde_terms.hpp"
#include "numerics.hpp"
#include "threads.hpp"

namespace beltrami {
namespace {

using testing::graph_of;
using testing::random_block;
using testing::random_vector;
using testing::relative_difference;
using testing::Threads;
using Complex = std::complex<double>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr Index block = EdgeGraph::block_rows;

// Hubs of 1 to 700 spokes, some within their block of rows and some far past it, with vertices between them, before
// them and after them that have no edge.
std::shared_ptr<const EdgeGraph> fans(Index n) {
    std::vector<std::pair<Index, Index>> edges;
    Index spokes = 1;
    for (Index hub = 100; hub + spokes + 100 < n; hub += 150) {
        for (Index s = 1; s <= spokes; ++s)
            edges.emplace_back(hub, hub + s);
        spokes = spokes % 700 + 9;
    }
    return std::make_shared<const EdgeGraph>(n, std::move(edges));
}

std::shared_ptr<const EdgeGraph> isolated(Index n) {
    return std::make_shared<const EdgeGraph>(n, std::vector<std::pair<Index, Index>>{});
}

std::shared_ptr<const EdgeGraph> graph(const std::string& name) {
    if (name == "grid") return graph_of(shapes::grid(190, 190));
    if (name == "shuffled grid") return graph_of(shapes::shuffled(shapes::grid(190, 190)).mesh);
    if (name == "solid") return graph_of(shapes::tetrahedral_cube(32));
    if (name == "fans") return fans(40000);
    return isolated(40000);
}

// sigma M + gamma_1 K + ... with arbitrary numbers; D and M are positive.
template <class Scalar>
struct Terms {
    Terms(const std::shared_ptr<const EdgeGraph>& graph, double sigma_, std::vector<double> gamma_)
        : K(graph, random_vector(graph->vertex_count(), 1).cast<Scalar>(), edges(graph->edge_count())),
          M(random_vector(graph->vertex_count(), 4).array() + 1.5),
          D(random_vector(graph->vertex_count(), 5).array() + 1.5),
          sigma(sigma_),
          gamma(std::move(gamma_)) {}

    static typename EdgeOperator<Scalar>::Array edges(Index count) {
        if constexpr (std::is_same_v<Scalar, Complex>) {
            Eigen::VectorXcd values(count);
            values.real() = random_vector(count, 2);
            values.imag() = random_vector(count, 3);
            return values;
        } else {
            return random_vector(count, 2);
        }
    }

    [[nodiscard]] PdeTerms<Scalar> terms() const { return {K, M, D, sigma, gamma}; }

    BlockOf<Scalar> apply(const BlockOf<Scalar>& u, int threads, PdeWorkspace<Scalar>& workspace) const {
        const Threads scope(threads);
        BlockOf<Scalar> y = BlockOf<Scalar>::Constant(u.rows(), u.cols(), nan);
        terms().apply(u, y, workspace);
        return y;
    }

    EdgeOperator<Scalar> K;
    Vector M;
    Vector D;
    double sigma;
    std::vector<double> gamma;
};

// The same from the assembled K.
template <class Scalar>
BlockOf<Scalar> reference(const Terms<Scalar>& A, const BlockOf<Scalar>& u) {
    const Eigen::SparseMatrix<Scalar> K = A.K.to_sparse();
    BlockOf<Scalar> sum = A.gamma.back() * (K * u);
    for (std::size_t i = A.gamma.size() - 1; i-- > 0;)
        sum = K * BlockOf<Scalar>(A.gamma[i] * u + A.D.asDiagonal() * sum);
    return sum + A.sigma * (A.M.asDiagonal() * u);
}

class ProductChain : public ::testing::TestWithParam<std::tuple<const char*, std::vector<double>>> {};

TEST_P(ProductChain, AgreesWithTheAssembledOperatorOnAnyThreads) {
    const auto [name, gamma] = GetParam();
    const Terms<double> A(graph(name), 0.7, gamma);
    PdeWorkspace<double> workspace;
    for (const Index k : {1, 2, 3, 4, 5}) {
        const Block u = random_block(A.K.rows(), k);
        const Block y = A.apply(u, 1, workspace);
        EXPECT_LT(relative_difference(y, reference(A, u)), 1e-14) << k << " columns";
        for (const int threads : {2, 3})
            EXPECT_EQ(A.apply(u, threads, workspace), y) << k << " columns, " << threads << " threads";
    }
}

INSTANTIATE_TEST_SUITE_P(
    All, ProductChain,
    ::testing::Combine(::testing::Values("grid", "shuffled grid", "solid", "fans", "isolated"),
                       ::testing::Values(std::vector{1.0}, std::vector{0.3}, std::vector{0.0, 1.0},
                                         std::vector{0.5, 0.2}, std::vector{0.5, 0.0, 0.1, 0.2})));

TEST(ProductChain, OfAHermitianOperator) {
    for (const char* name : {"grid", "shuffled grid", "fans"}) {
        const Terms<Complex> A(graph(name), 0.7, {0.5, 0.2});
        PdeWorkspace<Complex> workspace;
        for (const Index k : {1, 3, 5}) {
            BlockOf<Complex> u(A.K.rows(), k);
            u.real() = random_block(A.K.rows(), k, 6);
            u.imag() = random_block(A.K.rows(), k, 7);
            const BlockOf<Complex> y = A.apply(u, 1, workspace);
            EXPECT_LT(relative_difference(y, reference(A, u)), 1e-14) << name;
            EXPECT_EQ(A.apply(u, 3, workspace), y) << name;
        }
    }
}

TEST(ProductChain, OfFewRows) {
    for (const Index n : {1, 2, block - 1, block, block + 1}) {
        const Terms<double> A(fans(n), 0.7, {0.5, 0.2});
        PdeWorkspace<double> workspace;
        const Block u = random_block(n, 3);
        EXPECT_LT(relative_difference(A.apply(u, 2, workspace), reference(A, u)), 1e-14) << n;
    }
}

// Threads repeat what their neighbours do only as far as the bandwidth reaches.
TEST(ProductChain, ThreadsRepeatABandwidthOfEachOthersRows) {
    const auto narrow = graph("grid");
    const Terms<double> A(narrow, 0.0, {0.5, 0.2});
    const Block u = random_block(A.K.rows(), 3);
    for (const int threads : {1, 2, 3}) {
        PdeWorkspace<double> workspace;
        A.apply(u, threads, workspace);
        ASSERT_EQ(workspace.between.size(), static_cast<std::size_t>(threads));
        Eigen::Index rows = 0;
        for (const Block& part : workspace.between)
            rows += part.rows();
        EXPECT_GE(rows, A.K.rows());
        EXPECT_LE(rows, A.K.rows() + 2 * (threads - 1) * (narrow->bandwidth() + 2 * block));
    }
}

TEST(ProductChain, OneProductNeedsNoRoom) {
    const Terms<double> A(graph("grid"), 0.7, {0.5});
    PdeWorkspace<double> workspace;
    A.apply(random_block(A.K.rows(), 3), 2, workspace);
    EXPECT_TRUE(workspace.between.empty());
}

TEST(ProductChain, DoesNotWriteOverWhatItReads) {
    const Terms<double> A(fans(1000), 0.0, {0.0, 1.0});
    Block u = random_block(1000, 2);
    PdeWorkspace<double> workspace;
    EXPECT_THROW(A.terms().apply(u, u, workspace), InputError);
}

}  // namespace
}  // namespace beltrami
