// Several passes over the rows of a banded matrix in one: a pass follows the one before it at the distance of a bandwidth, and
// finds the matrix in the cache.
//
//     const Wavefront front(blocks, [&](Index b) { return reach_of_block(b); });
//     front.run(3, n > 20000, [&](int pass, Index block) { ... });
//
// On several threads each has a stretch of blocks, of which every pass does what depends on the stretch alone; what is left
// around the ends follows pass by pass.
#pragma once

#include <omp.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "beltrami/framework/types.hpp"
#include "beltrami/solvers/flush_to_zero.hpp"
#include "beltrami/solvers/row_range.hpp"

namespace beltrami {

class Wavefront {
  public:
    Wavefront() = default;
    /// reach(b): the first and the last block that have an entry in the rows of block b. The pattern is symmetric.
    template <class Reach>
    Wavefront(Index blocks, Reach reach);

    /// process(pass, b), b a block, for every pass and block: after the pass before has done all blocks that b reaches, and before
    /// the pass after next does any of them. So passes may write to two fields by turns.
    template <class Process>
    void run(int passes, bool on_threads, Process process) const;

    [[nodiscard]] Index blocks() const { return static_cast<Index>(last_.size()); }

  private:
    static std::size_t at(Index i) { return static_cast<std::size_t>(i); }
    // What the pass after one that did `done` can do without any other blocks.
    [[nodiscard]] RowRange inner(RowRange done) const {
        const auto begin = std::lower_bound(first_.begin(), first_.end(), done.first) - first_.begin();
        const auto end = std::lower_bound(last_.begin(), last_.end(), done.end) - last_.begin();
        return {static_cast<Index>(begin), static_cast<Index>(std::max(begin, end))};
    }
    // All passes on the blocks that `own` lets each of them do.
    template <class Process>
    void run_stretch(int passes, RowRange own, std::vector<RowRange>& done, Process process) const;

    std::vector<Index> first_;  // the first block that this one or a later one reaches
    std::vector<Index> last_;   // the last one that this one or an earlier one reaches
};

template <class Reach>
Wavefront::Wavefront(Index blocks, Reach reach) : first_(at(blocks)), last_(at(blocks)) {
    for (Index b = 0; b < blocks; ++b) {
        const std::pair<Index, Index> reached = reach(b);
        first_[at(b)] = std::min(b, reached.first);
        last_[at(b)] = std::max({b, reached.second, b > 0 ? last_[at(b) - 1] : 0});
    }
    for (Index b = blocks - 1; b-- > 0;)
        first_[at(b)] = std::min(first_[at(b)], first_[at(b) + 1]);
}

template <class Process>
void Wavefront::run_stretch(int passes, RowRange own, std::vector<RowRange>& done, Process process) const {
    done.assign(static_cast<std::size_t>(passes), own);
    for (std::size_t pass = 1; pass < done.size(); ++pass)
        done[pass] = inner(done[pass - 1]);
    std::vector<Index> next(static_cast<std::size_t>(passes));
    for (std::size_t pass = 0; pass < next.size(); ++pass)
        next[pass] = done[pass].first;
    const auto ready = [&](std::size_t pass) {
        return next[pass] < done[pass].end && last_[at(next[pass])] < next[pass - 1];
    };
    while (next[0] < own.end) {
        process(0, next[0]++);
        for (std::size_t pass = 1; pass < next.size(); ++pass) {
            while (ready(pass))
                process(static_cast<int>(pass), next[pass]++);
        }
    }
}

template <class Process>
void Wavefront::run(int passes, bool on_threads, Process process) const {
    const Index count = blocks();
    if (count == 0) return;
    const int threads = on_threads ? std::min<int>(omp_get_max_threads(), count) : 1;
    std::vector<std::vector<RowRange>> done(static_cast<std::size_t>(threads));
    if (threads == 1) {
        const FlushToZero flush;
        return run_stretch(passes, {0, count}, done.front(), process);
    }
#pragma omp parallel num_threads(threads)
    {
        const FlushToZero flush;
#pragma omp for schedule(static, 1)
        for (int t = 0; t < threads; ++t)
            run_stretch(passes, even_part(count, t, threads), done[static_cast<std::size_t>(t)], process);
        for (int pass = 1; pass < passes; ++pass) {
            // Between the stretches; the loop's end is where threads wait for each other.
#pragma omp for schedule(dynamic, 1)
            for (int t = 0; t <= threads; ++t) {
                const auto of = [&](int s) {
                    return done[static_cast<std::size_t>(s)][static_cast<std::size_t>(pass)];
                };
                const Index end = t < threads ? of(t).first : count;
                for (Index b = t > 0 ? of(t - 1).end : 0; b < end; ++b)
                    process(pass, b);
            }
        }
    }
}

}  // namespace beltrami
