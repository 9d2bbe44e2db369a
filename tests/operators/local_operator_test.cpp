// Local products against products over the whole mesh.

#include "beltrami/operators/local_operator.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <tuple>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami::testing {
namespace {

std::vector<Index> patch(const EdgeGraph& graph, Index middle, int rings) {
    ActiveDomain domain(graph, rings);
    domain.activate(std::array{middle});
    std::vector<Index> vertices;
    for (Index s = 1; s < domain.slot_count(); ++s)
        vertices.push_back(domain.vertex(s));
    return vertices;
}

class LocalProduct : public ::testing::TestWithParam<std::tuple<std::string, int, int>> {};

TEST_P(LocalProduct, IsTheGlobalOneWhereItIsDefined) {
    const auto& [shape, terms, columns] = GetParam();
    const Laplacian laplacian(shapes::with_noise(shapes::from_name(shape), 0.1));
    std::vector<double> gamma;
    for (int term = 0; term < terms; ++term)
        gamma.push_back(0.3 + term);
    const PdeOperator stiffness(laplacian, 0.7, gamma);
    ActiveDomain domain(laplacian.graph(), std::max(1, terms));
    LocalOperator local(stiffness);
    SlotField u(columns), y(columns);

    // Grows twice and shrinks once before anything is asked.
    for (const Index v : {laplacian.vertex_count() / 2, Index{3}})
        domain.activate(patch(laplacian.graph(), v, 2));
    domain.deactivate(patch(laplacian.graph(), 3, 1));
    domain.replay(together(local, u, y));

    const Block values = random_block(laplacian.vertex_count(), columns);
    Block field = Block::Zero(laplacian.vertex_count(), columns);
    for (Index s = 1; s < domain.end(0); ++s) {
        field.row(domain.vertex(s)) = values.row(domain.vertex(s));
        for (Index c = 0; c < columns; ++c)
            u[s][c] = values(domain.vertex(s), c);
    }
    // 2 M + 3 (0.7 M + ...)
    for (double& g : gamma)
        g *= 3.0;
    const PdeOperator whole(laplacian, 2.0 + 3.0 * 0.7, gamma);
    Block expected;
    whole.apply(field, expected);
    const double scale = expected.cwiseAbs().maxCoeff();
    for (const int to_level : {0, domain.rings()}) {
        local.apply(domain, {2.0, 3.0}, u, y, to_level);
        double outside = expected.squaredNorm();
        for (Index s = 1; s < domain.end(to_level); ++s) {
            for (Index c = 0; c < columns; ++c)
                ASSERT_NEAR(y[s][c], expected(domain.vertex(s), c), 1e-13 * scale)
                    << "level " << domain.level(s);
            outside -= expected.row(domain.vertex(s)).squaredNorm();
        }
        // Beyond the rings there is nothing.
        if (to_level == domain.rings()) {
            EXPECT_NEAR(outside, 0.0, 1e-10 * expected.squaredNorm());
        }
    }

    // The matrix, and the diagonals.
    const Eigen::MatrixXd matrix = dense(local.to_sparse(domain, {2.0, 3.0}));
    const Eigen::MatrixXd all = dense(whole.to_sparse());
    for (Index s = 1; s < domain.end(0); ++s) {
        for (Index t = 1; t < domain.end(0); ++t)
            ASSERT_NEAR(matrix(s - 1, t - 1), all(domain.vertex(s), domain.vertex(t)),
                        1e-12 * all.cwiseAbs().maxCoeff());
        const auto at = static_cast<std::size_t>(s);
        ASSERT_NEAR(2.0 * local.mass()[at] + 3.0 * local.diagonal()[at],
                    all(domain.vertex(s), domain.vertex(s)), 1e-12 * all.cwiseAbs().maxCoeff());
        ASSERT_DOUBLE_EQ(local.mass()[at] * local.inverse_mass()[at], 1.0);
    }
}

INSTANTIATE_TEST_SUITE_P(Meshes, LocalProduct,
                         ::testing::Combine(::testing::Values("icosphere:2", "fins:3:6", "tetrahedral-ball:4",
                                                              "circle:60"),
                                            ::testing::Values(0, 1, 2, 3, 4), ::testing::Values(1, 2, 3, 5)));

TEST(LocalOperator, CountsProductsAndBytesOfTheDomainAlone) {
    const auto cost = [](int levels) {
        const Laplacian laplacian(shapes::icosphere(levels));
        LocalOperator local(PdeOperator(laplacian, 1.0, {1.0, 1.0}));
        ActiveDomain domain(laplacian.graph(), 2);
        SlotField u(3), y(3);
        Index v = 0;
        while (laplacian.graph().degree(v) != 6)
            ++v;
        domain.activate(std::array{v});
        domain.replay(together(local, u, y));
        local.apply(domain, {1.0, 1.0}, u, y, 2);
        EXPECT_EQ(local.products(), 2);
        return std::pair(local.bytes(), local.memory_bytes());
    };
    EXPECT_EQ(cost(3), cost(6));
}

TEST(LocalOperator, RefusesFieldsThatDidNotFollow) {
    const Laplacian laplacian(shapes::icosphere(2));
    LocalOperator local(PdeOperator(laplacian, 1.0, {1.0, 1.0}));
    SlotField u(1), y(1);
    ActiveDomain domain(laplacian.graph(), 2);
    domain.activate(std::array{Index{0}});
    EXPECT_THROW(local.apply(domain, {}, u, y, 0), InputError);
    ActiveDomain shallow(laplacian.graph(), 1);
    EXPECT_THROW(local.apply(shallow, {}, u, y, 0), InputError);
    EXPECT_THROW(local.apply(shallow, {}, u, u, 0), InputError);
}

}  // namespace
}  // namespace beltrami::testing
