#include "beltrami/solvers/sweep_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "threads.hpp"

namespace beltrami {
namespace {

// Row i of a banded matrix reaches i + width.
std::vector<Index> band(Index n, Index width) {
    std::vector<Index> reach;
    for (Index i = 0; i < n; ++i)
        reach.push_back(std::min(n, i + width + 1));
    return reach;
}

TEST(SweepOrder, EveryRowOnceAndBackwardIsTheReverse) {
    const testing::Threads threads(1);
    for (const Index width : {1, 50, 600, 30000}) {
        const Index n = 50000;
        const SweepOrder order(band(n, width), 1);
        std::vector<Index> position(n, -1);
        Index count = 0;
        order.forward([&](Index i) { position[i] = count++; });
        EXPECT_EQ(count, n);
        EXPECT_EQ(std::count(position.begin(), position.end(), -1), 0);
        std::vector<Index> back(n, -1);
        order.backward([&](Index i) { back[i] = --count; });
        // Rows that an entry joins are met in the reverse order.
        for (Index i = 0; i < n; ++i) {
            for (const Index j : {i + 1, i + width}) {
                if (j >= n) continue;
                EXPECT_EQ(position[i] < position[j], back[i] < back[j])
                    << i << " " << j << " of width " << width;
            }
        }
    }
}

// Between inner rows of different stretches there is no entry, and with two rings no row that both touch.
TEST(SweepOrder, StretchesAreApart) {
    const Index n = 100000;
    const Index width = 300;
    for (const int rings : {1, 2, 4}) {
        const SweepOrder order(band(n, width), rings);
        const std::vector<RowRange>& separators = order.separators();
        ASSERT_GT(separators.size(), 4U);
        for (std::size_t s = 1; s < separators.size(); ++s)
            EXPECT_GE(separators[s].end - separators[s].first, rings * width);
    }
    EXPECT_EQ(SweepOrder(band(n, n), 1).separators().size(), 1U) << "a matrix in no order has one stretch";
    EXPECT_EQ(SweepOrder(band(500, 3), 1).separators().size(), 1U) << "nor are short ones worth it";
    int steps = 0;
    SweepOrder({}, 1).forward([&](Index) { ++steps; });
    EXPECT_EQ(steps, 0);
}

}  // namespace
}  // namespace beltrami
