#include "beltrami/framework/renumbering.hpp"

#include "beltrami/framework/constraints.hpp"
#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::random_block;

TEST(Renumbering, ThereAndBackIsTheSame) {
    const Renumbering order({3, 0, 2, 1});
    const Block field = random_block(4, 3);
    EXPECT_EQ(order.to_user(order.to_working(field)), field);
    for (Index v = 0; v < 4; ++v) {
        EXPECT_EQ(order.user(order.working(v)), v);
        EXPECT_EQ(order.to_working(field).row(order.working(v)), field.row(v));
    }
    EXPECT_EQ(order.working(0), 3);
}

TEST(Renumbering, MovesMeshAndConstraintsTogether) {
    const Mesh mesh(Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, Cells{{0, 1, 2}},
                    {{"heat", Block{{10.0}, {11.0}, {12.0}}}});
    const Renumbering order({2, 0, 1});
    const Mesh moved = order.to_working(mesh);
    EXPECT_EQ(moved.cells(), (Cells{{2, 0, 1}}));
    EXPECT_EQ(moved.points().row(2), mesh.points().row(0));
    EXPECT_EQ(moved.field("heat").values(2, 0), 10.0);
    const Constraints held = order.to_working(Constraints{{0, 7.0}});
    EXPECT_TRUE(held.is_fixed(2));
    EXPECT_EQ(held.value(2)[0], 7.0);
    EXPECT_THROW((void)order.to_working(Constraints{{3, 7.0}}), InputError);
}

TEST(Renumbering, RefusesWhatIsNoPermutation) {
    EXPECT_THROW(Renumbering({0, 0}), InputError);
    EXPECT_THROW(Renumbering({0, 2}), InputError);
    EXPECT_THROW(Renumbering({-1, 0}), InputError);
    EXPECT_EQ(Renumbering({}).vertex_count(), 0);
}

TEST(Renumbering, RefusesFieldsOfOtherLengths) {
    const Renumbering order = Renumbering::identity(4);
    for (const Index rows : {0, 3, 5}) {
        EXPECT_THROW((void)order.to_working(Block(Block::Zero(rows, 1))), InputError);
        EXPECT_THROW((void)order.to_user(Block(Block::Zero(rows, 1))), InputError);
    }
    EXPECT_THROW((void)order.to_working(shapes::icosphere(0)), InputError);
}

TEST(CuthillMckee, NarrowsTheBandOfAShuffledMesh) {
    const Mesh mesh = shapes::shuffled(shapes::together({shapes::grid(40, 10), shapes::grid(30, 10)})).mesh;
    const EdgeGraph graph(mesh.vertex_count(), mesh.cells());
    const Renumbering order = cuthill_mckee(graph);
    const Mesh narrow = order.to_working(mesh);
    EXPECT_GT(graph.bandwidth(), 500);
    EXPECT_LT(EdgeGraph(narrow.vertex_count(), narrow.cells()).bandwidth(), 30);
}

TEST(CuthillMckee, NumbersIsolatedVerticesToo) {
    const EdgeGraph graph(6, std::vector<std::pair<Index, Index>>{{1, 4}});
    const Renumbering order = cuthill_mckee(graph);  // its constructor checks that it is a permutation
    EXPECT_EQ(order.vertex_count(), 6);
    EXPECT_EQ(std::abs(order.working(1) - order.working(4)), 1);
    EXPECT_EQ(cuthill_mckee(EdgeGraph(0, std::vector<std::pair<Index, Index>>{})).vertex_count(), 0);
}

// Work that grew with components x vertices would not end within the test's time: 3e10 steps.
TEST(CuthillMckee, IsLinearInTheNumberOfComponents) {
    const Index n = 300000;
    std::vector<std::pair<Index, Index>> pairs;
    for (Index v = 0; v + 1 < n / 2; v += 2)
        pairs.emplace_back(v, v + 1);
    const EdgeGraph graph(n, pairs);
    const Renumbering order = cuthill_mckee(graph);
    for (const auto& [a, b] : pairs)
        ASSERT_EQ(std::abs(order.working(a) - order.working(b)), 1);
}

}  // namespace
}  // namespace beltrami
