#include "beltrami/framework/active_domain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

ActiveDomain::ActiveDomain(const EdgeGraph& graph, int rings)
    : graph_(&graph), ends_(static_cast<std::size_t>(std::max(rings, 0)) + 1, 1), slots_{{-1, 0, 0}} {
    if (rings < 0) throw InputError(fmt::format("a domain of {} rings", rings), "ask for none or more");
}

int ActiveDomain::level(Index slot) const {
    int level = 0;
    while (slot >= end(level))
        ++level;
    return level;
}

void ActiveDomain::exchange(Index a, Index b) {
    if (a == b) return;
    Slot& at_a = slots_[static_cast<std::size_t>(a)];
    Slot& at_b = slots_[static_cast<std::size_t>(b)];
    // By way of the twins, which do not move, this is right for slots that are neighbours too.
    const auto point_at = [&](const Slot& from, Index to) {
        for (auto e = static_cast<std::size_t>(from.begin);
             e < static_cast<std::size_t>(from.begin) + static_cast<std::size_t>(from.size); ++e) {
            if (neighbours_[e] != 0) neighbours_[static_cast<std::size_t>(twins_[e])] = to;
        }
    };
    point_at(at_a, b);
    point_at(at_b, a);
    std::swap(at_a, at_b);
    slot_of_vertex_[at_a.vertex] = a;
    slot_of_vertex_[at_b.vertex] = b;
    changes_.push_back({a, b, -1});
}

// From one level to another: each step exchanges the slot with the border of its level and moves the border over it.
Index ActiveDomain::set_level(Index slot, int from, int to) {
    for (; from > to; --from) {
        Index& border = ends_[static_cast<std::size_t>(from) - 1];
        exchange(slot, border);
        slot = border++;
    }
    for (; from < to; ++from) {
        Index& border = ends_[static_cast<std::size_t>(from)];
        exchange(slot, --border);
        slot = border;
    }
    return slot;
}

// At the outermost level.
Index ActiveDomain::insert(Index vertex) {
    const auto neighbours = graph_->neighbours(vertex);
    const auto size = static_cast<Index>(neighbours.size());
    if (free_rows_.size() <= neighbours.size()) free_rows_.resize(neighbours.size() + 1);
    auto& free = free_rows_[neighbours.size()];
    Index begin = static_cast<Index>(neighbours_.size());
    if (free.empty()) {
        neighbours_.resize(neighbours_.size() + neighbours.size());
        twins_.resize(neighbours_.size());
    } else {
        begin = free.back();
        free.pop_back();
    }
    const Index slot = ends_.back()++;
    slots_.push_back({vertex, begin, size});
    slot_of_vertex_.emplace(vertex, slot);
    for (Index k = 0; k < size; ++k) {
        const auto entry = static_cast<std::size_t>(begin) + static_cast<std::size_t>(k);
        const Index other = neighbours[static_cast<std::size_t>(k)].vertex;
        const Index q = this->slot(other);
        neighbours_[entry] = q;
        if (q == 0) continue;
        const auto theirs = graph_->neighbours(other);
        const auto back =
            std::lower_bound(theirs.begin(), theirs.end(), vertex,
                             [](const EdgeGraph::Neighbour& n, Index v) { return n.vertex < v; });
        const Index twin = row_begin(q) + static_cast<Index>(back - theirs.begin());
        twins_[entry] = twin;
        neighbours_[static_cast<std::size_t>(twin)] = slot;
        twins_[static_cast<std::size_t>(twin)] = begin + k;
    }
    changes_.push_back({slot, vertex, begin});
    return slot;
}

// From the outermost level.
void ActiveDomain::remove(Index slot) {
    exchange(slot, slot_count() - 1);
    const Slot last = slots_.back();
    for (auto e = static_cast<std::size_t>(last.begin);
         e < static_cast<std::size_t>(last.begin) + static_cast<std::size_t>(last.size); ++e) {
        if (neighbours_[e] != 0) neighbours_[static_cast<std::size_t>(twins_[e])] = 0;
    }
    free_rows_[static_cast<std::size_t>(last.size)].push_back(last.begin);
    slot_of_vertex_.erase(last.vertex);
    slots_.pop_back();
    --ends_.back();
    changes_.push_back({-1, -1, -1});
}

void ActiveDomain::activate(std::span<const Index> vertices) {
    for (const Index v : vertices) {
        if (v < 0 || v >= graph_->vertex_count()) {
            throw InputError(fmt::format("vertex {} cannot be active: the vertices are 0 to {}", v,
                                         graph_->vertex_count() - 1),
                             "activate vertices of the mesh");
        }
    }
    std::vector<Index> frontier;
    const auto lower = [&](Index v, int to) {
        Index s = slot(v);
        const int from = s == 0 ? rings() : level(s);
        if (s != 0 && from <= to) return;
        if (s == 0) s = insert(v);
        set_level(s, from, to);
        frontier.push_back(v);
    };
    for (const Index v : vertices)
        lower(v, 0);
    for (int ring = 1; ring <= rings(); ++ring) {
        const std::vector<Index> inner = std::exchange(frontier, {});
        for (const Index v : inner) {
            for (const auto& n : graph_->neighbours(v))
                lower(n.vertex, ring);
        }
    }
}

void ActiveDomain::deactivate(std::span<const Index> vertices) {
    // Levels can change within `rings` edges of what was let go, along paths that meet no vertex that stays active.
    constexpr int unknown = -1;
    std::unordered_map<Index, int> levels;  // of what may change
    std::vector<Index> affected;
    for (const Index v : vertices) {
        if (is_active(v) && levels.emplace(v, unknown).second) affected.push_back(v);
    }
    std::size_t begin = 0;
    for (int ring = 1; ring <= rings(); ++ring) {
        const std::size_t ring_end = affected.size();
        for (; begin < ring_end; ++begin) {
            for (const Index q : row(slot(affected[begin]))) {
                if (q >= end(0) && levels.emplace(vertex(q), unknown).second) affected.push_back(vertex(q));
            }
        }
    }
    for (int inner = 0; inner < rings(); ++inner) {
        for (const Index v : affected) {
            int& own = levels[v];
            if (own != unknown) continue;
            for (const Index q : row(slot(v))) {
                if (q == 0) continue;
                const auto found = levels.find(vertex(q));
                if ((found == levels.end() ? level(q) : found->second) == inner) {
                    own = inner + 1;
                    break;
                }
            }
        }
    }
    for (const Index v : affected) {
        const int to = levels[v];
        const Index s = slot(v);
        const Index moved = set_level(s, level(s), to == unknown ? rings() : to);
        if (to == unknown) remove(moved);
    }
}

void ActiveDomain::clear() {
    while (!empty())
        remove(slot_count() - 1);
    std::fill(ends_.begin(), ends_.end(), 1);
}

std::size_t ActiveDomain::memory_bytes() const {
    std::size_t rows = 0;
    for (const auto& list : free_rows_)
        rows += list.capacity();
    return slots_.capacity() * sizeof(Slot) +
           (neighbours_.capacity() + twins_.capacity() + rows) * sizeof(Index) +
           slot_of_vertex_.size() * 4 * sizeof(void*) + changes_.capacity() * sizeof(Change);
}

}  // namespace beltrami
