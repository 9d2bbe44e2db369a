// ActiveDomain against its definition: levels are distances to the nearest active vertex, rows are the graph's.

#include "beltrami/framework/active_domain.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami::testing {
namespace {

EdgeGraph graph_of_mesh(const Mesh& mesh) {
    return EdgeGraph(mesh.vertex_count(), mesh.cells());
}

// The level of every vertex by breadth-first search, -1 beyond the rings.
std::vector<int> levels_of(const EdgeGraph& graph, const std::set<Index>& active, int rings) {
    std::vector<int> level(static_cast<std::size_t>(graph.vertex_count()), -1);
    std::deque<Index> queue;
    for (const Index v : active) {
        level[static_cast<std::size_t>(v)] = 0;
        queue.push_back(v);
    }
    for (; !queue.empty(); queue.pop_front()) {
        const int next = level[static_cast<std::size_t>(queue.front())] + 1;
        if (next > rings) continue;
        for (const auto& n : graph.neighbours(queue.front())) {
            if (level[static_cast<std::size_t>(n.vertex)] >= 0) continue;
            level[static_cast<std::size_t>(n.vertex)] = next;
            queue.push_back(n.vertex);
        }
    }
    return level;
}

void expect_consistent(const ActiveDomain& domain, const std::set<Index>& active) {
    const EdgeGraph& graph = domain.graph();
    const std::vector<int> level = levels_of(graph, active, domain.rings());
    ASSERT_EQ(domain.active_count(), std::ssize(active));
    ASSERT_EQ(domain.slot_count() - 1,
              std::count_if(level.begin(), level.end(), [](int l) { return l >= 0; }));
    std::set<Index> rows;
    for (Index s = 1; s < domain.slot_count(); ++s) {
        const Index v = domain.vertex(s);
        ASSERT_EQ(domain.slot(v), s);
        ASSERT_EQ(domain.level(s), level[static_cast<std::size_t>(v)]) << "vertex " << v;
        const auto row = domain.row(s);
        const auto neighbours = graph.neighbours(v);
        ASSERT_EQ(row.size(), neighbours.size());
        for (std::size_t k = 0; k < row.size(); ++k) {
            ASSERT_EQ(row[k], domain.slot(neighbours[k].vertex));
            ASSERT_TRUE(rows.insert(domain.row_begin(s) + static_cast<Index>(k)).second) << "rows overlap";
        }
    }
}

// A follower that only remembers which vertex lies in which slot.
struct Vertices {
    std::vector<Index> of_slot = {-1};
    void push(Index slot, Index vertex, Index) {
        ASSERT_EQ(slot, std::ssize(of_slot));
        of_slot.push_back(vertex);
    }
    void swap(Index a, Index b) {
        std::swap(of_slot[static_cast<std::size_t>(a)], of_slot[static_cast<std::size_t>(b)]);
    }
    void pop() { of_slot.pop_back(); }
};

class ActiveDomainOn : public ::testing::TestWithParam<std::tuple<std::string, int>> {};

TEST_P(ActiveDomainOn, StaysTrueToItsDefinitionOverRandomChanges) {
    const Mesh mesh = shapes::from_name(std::get<0>(GetParam()));
    const EdgeGraph graph = graph_of_mesh(mesh);
    ActiveDomain domain(graph, std::get<1>(GetParam()));
    std::mt19937 engine(7);
    std::set<Index> active;
    Vertices follower;
    for (int change = 0; change < 60; ++change) {
        std::vector<Index> chosen;
        if (engine() % 2 == 0 || active.empty()) {
            // A patch: some vertex and vertices near it.
            const auto v = static_cast<Index>(engine() % static_cast<unsigned>(graph.vertex_count()));
            chosen.push_back(v);
            for (const auto& n : graph.neighbours(v)) {
                if (engine() % 3 != 0) chosen.push_back(n.vertex);
            }
            domain.activate(chosen);
            active.insert(chosen.begin(), chosen.end());
        } else {
            for (const Index v : active) {
                if (engine() % 2 == 0) chosen.push_back(v);
            }
            chosen.push_back(static_cast<Index>(engine() % static_cast<unsigned>(graph.vertex_count())));
            domain.deactivate(chosen);
            for (const Index v : chosen)
                active.erase(v);
        }
        expect_consistent(domain, active);
        if (change % 3 == 0) domain.replay(follower);
    }
    domain.replay(follower);
    ASSERT_EQ(std::ssize(follower.of_slot), domain.slot_count());
    for (Index s = 1; s < domain.slot_count(); ++s)
        EXPECT_EQ(follower.of_slot[static_cast<std::size_t>(s)], domain.vertex(s));
    domain.clear();
    expect_consistent(domain, {});
    EXPECT_TRUE(domain.empty());
    domain.activate(std::array{Index{0}});
    expect_consistent(domain, {0});
}

INSTANTIATE_TEST_SUITE_P(Graphs, ActiveDomainOn,
                         ::testing::Combine(::testing::Values("icosphere:2", "fins:4:5", "tetrahedral-cube:4",
                                                              "circle:30", "pinched-spheres:1", "latlong:5"),
                                            ::testing::Values(0, 1, 2, 4)));

TEST(ActiveDomain, StorageDoesNotGrowWithTheMesh) {
    const auto bytes = [](int levels) {
        const Mesh sphere = shapes::icosphere(levels);
        const EdgeGraph graph = graph_of_mesh(sphere);
        ActiveDomain domain(graph, 2);
        // The neighbourhood of a vertex in the middle of an edge: regular at every refinement.
        Index v = 0;
        while (graph.degree(v) != 6)
            ++v;
        domain.activate(std::array{v});
        for (int ring = 0; ring < 3; ++ring) {
            std::vector<Index> rim;
            for (Index s = domain.end(0); s < domain.end(1); ++s)
                rim.push_back(domain.vertex(s));
            domain.activate(rim);
        }
        return std::pair(domain.slot_count(), domain.memory_bytes());
    };
    EXPECT_EQ(bytes(4), bytes(6));
}

TEST(ActiveDomain, RefusesVerticesThatAreNotThere) {
    const EdgeGraph graph = graph_of_mesh(shapes::icosphere(0));
    ActiveDomain domain(graph, 1);
    EXPECT_THROW(domain.activate(std::array{Index{12}}), InputError);
    EXPECT_THROW(domain.activate(std::array{Index{-1}}), InputError);
    EXPECT_TRUE(domain.empty());
    EXPECT_THROW(ActiveDomain(graph, -1), InputError);
    domain.deactivate(std::array{Index{3}});
    EXPECT_TRUE(domain.empty());
}

}  // namespace
}  // namespace beltrami::testing
