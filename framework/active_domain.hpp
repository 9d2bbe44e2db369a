// The part of a mesh that is alive: active vertices and the rings around them, in storage that knows nothing of the rest.
//
//     ActiveDomain domain(graph, 2);                  // two rings around whatever is active
//     domain.activate(std::array{120, 121});          // time proportional to what changes
//     for (Index s = 1; s < domain.end(0); ++s)       // the active vertices: slots 1 to end(0) - 1
//         for (const Index q : domain.row(s)) ...     // slots of their neighbours, 0 for those that are not in the domain
//     domain.replay(follow);                          // values that lie in slots follow
//
// Vertices of the domain sit in slots 1, 2, ..., sorted by level: the number of edges to the nearest active vertex
// (D, D_1, D_2 of section 4.2 of Kim & Rossignac). Slot 0 stands for everything outside; fields over slots are zero
// there. A walk over slots touches memory in proportion to the domain, however large the graph. Works on any graph:
// surfaces, non-manifold surfaces, solids.
#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/types.hpp"

namespace beltrami {

class ActiveDomain {
  public:
    /// Nothing is active yet. The graph must outlive the domain. Throws InputError for a negative number of rings.
    ActiveDomain(const EdgeGraph& graph, int rings);

    /// Makes vertices active; those that are already stay so. Throws InputError for a vertex out of range.
    void activate(std::span<const Index> vertices);
    /// Lets active vertices go: they fall to the ring where they belong now, or out. Others are passed over.
    void deactivate(std::span<const Index> vertices);
    void clear();

    [[nodiscard]] int rings() const { return static_cast<int>(ends_.size()) - 1; }
    /// Slots 1 to end(level) - 1 hold the vertices of that level and below; end(rings()) is the number of slots.
    [[nodiscard]] Index end(int level) const { return ends_[static_cast<std::size_t>(level)]; }
    [[nodiscard]] Index slot_count() const { return ends_.back(); }
    [[nodiscard]] Index active_count() const { return ends_.front() - 1; }
    [[nodiscard]] bool empty() const { return ends_.back() == 1; }

    [[nodiscard]] Index vertex(Index slot) const { return slots_[static_cast<std::size_t>(slot)].vertex; }
    /// The slot of a vertex, or 0.
    [[nodiscard]] Index slot(Index vertex) const {
        const auto found = slot_of_vertex_.find(vertex);
        return found == slot_of_vertex_.end() ? 0 : found->second;
    }
    [[nodiscard]] int level(Index slot) const;
    [[nodiscard]] bool is_active(Index vertex) const {
        const Index s = slot(vertex);
        return s != 0 && s < end(0);
    }

    /// The slots of the neighbours, in the order of EdgeGraph::neighbours; 0 for one outside.
    [[nodiscard]] std::span<const Index> row(Index slot) const {
        const Slot& s = slots_[static_cast<std::size_t>(slot)];
        return {neighbours_.data() + s.begin, static_cast<std::size_t>(s.size)};
    }
    /// Where that row begins in the array of all rows: numbers on row entries lie in an array parallel to it.
    [[nodiscard]] Index row_begin(Index slot) const { return slots_[static_cast<std::size_t>(slot)].begin; }
    [[nodiscard]] Index row_size(Index slot) const { return slots_[static_cast<std::size_t>(slot)].size; }
    [[nodiscard]] const Index* entries() const { return neighbours_.data(); }

    [[nodiscard]] const EdgeGraph& graph() const { return *graph_; }
    /// Of the storage, which follows the largest domains so far and not the graph.
    [[nodiscard]] std::size_t memory_bytes() const;

    /// What happened to the slots since the last call, in order: push(slot, vertex, row_begin) appended one, swap(a, b)
    /// exchanged two, pop() dropped the last.
    template <class Follower>
    void replay(Follower&& follower) {
        for (const Change& change : changes_) {
            if (change.a < 0) {
                follower.pop();
            } else if (change.row_begin >= 0) {
                follower.push(change.a, change.b, change.row_begin);
            } else {
                follower.swap(change.a, change.b);
            }
        }
        changes_.clear();
    }

  private:
    struct Slot {
        Index vertex;
        Index begin;
        Index size;
    };
    // a < 0: pop. row_begin >= 0: push of vertex b to slot a. Else a swap of slots a and b.
    struct Change {
        Index a;
        Index b;
        Index row_begin;
    };

    Index insert(Index vertex);
    void remove(Index slot);
    Index set_level(Index slot, int from, int to);
    void exchange(Index a, Index b);

    const EdgeGraph* graph_;
    std::vector<Index> ends_;
    std::vector<Slot> slots_;
    std::unordered_map<Index, Index> slot_of_vertex_;
    std::vector<Index> neighbours_;
    std::vector<Index> twins_;  // of an entry: where the same edge lies in the neighbour's row
    std::vector<std::vector<Index>> free_rows_;  // by their number of entries
    std::vector<Change> changes_;
};

}  // namespace beltrami
