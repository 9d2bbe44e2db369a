#include "beltrami/framework/constraints.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <random>
#include <string>

#include "beltrami/framework/error.hpp"

namespace beltrami {
namespace {

TEST(Constraints, HoldWhatWasFixedAndNothingElse) {
    Constraints held{{120, 0.5}, {3, -1.0}};
    EXPECT_EQ(held.size(), 2);
    EXPECT_TRUE(held.is_fixed(120));
    EXPECT_EQ(held.value(120)[0], 0.5);
    for (const Index v : {-1, 0, 4, 119, 121, 100000})
        EXPECT_FALSE(held.is_fixed(v)) << v;
    held.fix(120, 2.0);
    EXPECT_EQ(held.size(), 2);
    EXPECT_EQ(held.value(120)[0], 2.0);
    held.free(120);
    held.free(120);
    held.free(-5);
    held.free(99999);
    EXPECT_EQ(held.vertices(), std::vector<Index>{3});
    EXPECT_THROW((void)held.value(120), InputError);
    EXPECT_THROW((void)held.value(99999), InputError);
}

TEST(Constraints, AgreeWithAMapAfterManyChanges) {
    std::mt19937 random(5);
    Constraints held(2);
    std::map<Index, std::array<double, 2>> expected;
    for (int change = 0; change < 5000; ++change) {
        const auto v = static_cast<Index>(random() % 60);
        if (random() % 3 == 0) {
            held.free(v);
            expected.erase(v);
        } else {
            const std::array<double, 2> value{double(random() % 100), double(random() % 100)};
            held.fix(v, value);
            expected[v] = value;
        }
        ASSERT_EQ(held.size(), static_cast<Index>(expected.size()));
    }
    Block field = Block::Zero(60, 2);
    held.impose(field);
    std::vector<Index> vertices = held.vertices();
    std::sort(vertices.begin(), vertices.end());
    std::size_t at = 0;
    for (const auto& [v, value] : expected) {
        EXPECT_EQ(vertices[at++], v);
        EXPECT_EQ(field(v, 0), value[0]);
        EXPECT_EQ(field(v, 1), value[1]);
    }
    EXPECT_EQ((field.rowwise().sum().array() != 0.0).count() <= held.size(), true);
}

// The value of one held vertex given to another, while the store of values grows.
TEST(Constraints, CanTakeTheValueOfAnotherVertex) {
    Constraints held(3);
    held.fix(0, std::array{1.0, 2.0, 3.0});
    for (Index v = 1; v < 200; ++v)
        held.fix(v, held.value(v - 1));
    EXPECT_EQ(held.value(199)[0], 1.0);
    EXPECT_EQ(held.value(199)[2], 3.0);
}

TEST(Constraints, AddRefusesASecondValueButFixMoves) {
    Constraints held{{7, 1.0}};
    held.add(7, 1.0);
    EXPECT_EQ(held.size(), 1);
    EXPECT_THROW(held.add(7, 2.0), InputError);
    EXPECT_EQ(held.value(7)[0], 1.0);
    EXPECT_THROW((Constraints{{1, 0.0}, {1, 1.0}}), InputError);
    EXPECT_NO_THROW((Constraints{{1, 0.0}, {1, 0.0}}));
}

TEST(Constraints, RefuseWhatIsNoVertexOrNoValue) {
    Constraints held;
    EXPECT_THROW(held.fix(-1, 0.0), InputError);
    EXPECT_THROW(held.add(-1, 0.0), InputError);
    EXPECT_THROW(held.fix(1, std::numeric_limits<double>::quiet_NaN()), InputError);
    EXPECT_THROW(held.fix(1, std::numeric_limits<double>::infinity()), InputError);
    EXPECT_THROW(held.fix(1, std::array{1.0, 2.0}), InputError);
    EXPECT_THROW(Constraints(0), InputError);
    EXPECT_TRUE(held.empty()) << "a refused vertex must not stay half held";
}

TEST(Constraints, OutsideOfAFieldAreRefusedByName) {
    const Constraints held{{5, 1.0}};
    EXPECT_NO_THROW(held.check_range(6));
    try {
        held.check_range(5);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find('5'), std::string::npos);
        EXPECT_FALSE(error.hint().empty());
        EXPECT_EQ(error.exit_status(), 2);
    }
    Block short_field = Block::Zero(5, 1);
    Block wide_field = Block::Zero(6, 2);
    EXPECT_THROW(held.impose(short_field), InputError);
    EXPECT_THROW(held.impose(wide_field), InputError);
    EXPECT_NO_THROW(Constraints(3).impose(wide_field)) << "none held, nothing to write";
}

}  // namespace
}  // namespace beltrami
