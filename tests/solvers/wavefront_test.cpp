#include "beltrami/solvers/wavefront.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>
#include <vector>

#include "threads.hpp"

namespace beltrami {
namespace {

// Which blocks a block reaches, first and last.
using Reach = std::vector<std::pair<Index, Index>>;

Reach banded(Index blocks, Index width) {
    Reach reach;
    for (Index b = 0; b < blocks; ++b)
        reach.emplace_back(std::max<Index>(0, b - width), std::min(blocks - 1, b + width));
    return reach;
}

// What the passes over the blocks of a matrix must keep to, whatever the order.
void expect_in_order(const Reach& reach, int passes, int threads) {
    const testing::Threads limit(threads);
    const auto blocks = static_cast<Index>(reach.size());
    const Wavefront front(blocks, [&](Index b) { return reach[static_cast<std::size_t>(b)]; });
    EXPECT_EQ(front.blocks(), blocks);
    std::vector<int> done(reach.size(), 0);
    std::mutex mutex;
    int wrong = 0;
    front.run(passes, true, [&](int pass, Index b) {
        const std::lock_guard lock(mutex);
        if (done[static_cast<std::size_t>(b)]++ != pass) ++wrong;
        const auto [first, last] = reach[static_cast<std::size_t>(b)];
        for (Index other = first; other <= last; ++other) {
            const int there = done[static_cast<std::size_t>(other)];
            // It has had the passes before, and at most this one and the next.
            if (there < pass || (pass > 0 && there > pass + 2)) ++wrong;
        }
    });
    EXPECT_EQ(wrong, 0) << passes << " passes, " << threads << " threads";
    for (const int passes_of_block : done)
        EXPECT_EQ(passes_of_block, passes);
}

TEST(Wavefront, EveryPassFollowsTheOneBefore) {
    for (const int threads : {1, 2, 5}) {
        for (const int passes : {1, 2, 7}) {
            expect_in_order(banded(40, 1), passes, threads);
            expect_in_order(banded(40, 3), passes, threads);
            expect_in_order(banded(7, 6), passes, threads);
            expect_in_order(banded(1, 0), passes, threads);
            expect_in_order(banded(40, 0), passes, threads);
        }
    }
}

TEST(Wavefront, ABlockMayReachFar) {
    Reach reach = banded(50, 1);
    reach[3].second = 40;
    reach[40].first = 3;
    for (const int threads : {1, 3}) {
        for (const int passes : {2, 5})
            expect_in_order(reach, passes, threads);
    }
}

// The cache finds what was used last: a pass is no farther behind than what it waits for.
TEST(Wavefront, PassesFollowClosely) {
    const Reach reach = banded(100, 2);
    const Wavefront front(100, [&](Index b) { return reach[static_cast<std::size_t>(b)]; });
    std::vector<Index> at(4, -1);
    front.run(4, false, [&](int pass, Index b) {
        at[static_cast<std::size_t>(pass)] = b;
        if (pass == 3) {
            EXPECT_LE(at[0] - b, 6);
        }
    });
    EXPECT_EQ(at, std::vector<Index>(4, 99));
}

TEST(Wavefront, NoBlocks) {
    const Wavefront front(0, [](Index) { return std::pair<Index, Index>(0, 0); });
    front.run(3, true, [](int, Index) { FAIL(); });
}

}  // namespace
}  // namespace beltrami
