#include "beltrami/framework/edge_graph.hpp"

#include <boost/graph/breadth_first_search.hpp>
#include <boost/graph/dijkstra_shortest_paths.hpp>
#include <boost/graph/graph_concepts.hpp>
#include <boost/property_map/function_property_map.hpp>
#include <set>

#include "beltrami/framework/boost_graph.hpp"
#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using Pairs = std::vector<std::pair<Index, Index>>;
using testing::graph_of;

BOOST_CONCEPT_ASSERT((boost::VertexListGraphConcept<EdgeGraph>));
BOOST_CONCEPT_ASSERT((boost::EdgeListGraphConcept<EdgeGraph>));
BOOST_CONCEPT_ASSERT((boost::IncidenceGraphConcept<EdgeGraph>));
BOOST_CONCEPT_ASSERT((boost::AdjacencyGraphConcept<EdgeGraph>));

TEST(EdgeGraph, HoldsEveryPairOnceSorted) {
    const EdgeGraph graph(6, Pairs{{4, 1}, {1, 4}, {0, 5}, {2, 2}, {1, 2}, {0, 1}, {5, 0}});
    EXPECT_EQ(graph.edge_count(), 4);
    EXPECT_EQ(graph.offsets(), (std::vector<Index>{0, 2, 4, 4, 4, 4, 4}));
    EXPECT_EQ(graph.upper(), (std::vector<Index>{1, 5, 2, 4}));
    for (Index e = 0; e < 4; ++e) {
        EXPECT_EQ(graph.find_edge(graph.lower(e), graph.upper()[static_cast<std::size_t>(e)]), e);
        EXPECT_EQ(graph.find_edge(graph.upper()[static_cast<std::size_t>(e)], graph.lower(e)), e);
    }
    EXPECT_EQ(graph.find_edge(2, 3), -1);
    EXPECT_EQ(graph.find_edge(3, 3), -1);
    EXPECT_EQ(graph.degree(1), 3);
    EXPECT_EQ(graph.degree(3), 0);
    EXPECT_EQ(graph.bandwidth(), 5);
}

TEST(EdgeGraph, BlocksOfRowsSayWhatTheyTouch) {
    // Three blocks, of which the first reaches into the second and the second reaches nowhere.
    constexpr Index block = EdgeGraph::block_rows;
    const EdgeGraph graph(
        2 * block + 5,
        Pairs{
            {3, block + 7}, {3, 4}, {block + 1, block + 2}, {block - 1, 0}, {2 * block + 1, 2 * block + 4}});
    EXPECT_EQ(graph.reach(), (std::vector<Index>{block + 8, 2 * block, 2 * block + 5}));
    ASSERT_EQ(graph.lower_in_block().size(), 5U);
    for (Index e = 0; e < graph.edge_count(); ++e)
        EXPECT_EQ(graph.lower_in_block()[static_cast<std::size_t>(e)], graph.lower(e) % block);
}

TEST(EdgeGraph, EdgesOfCellsAreThoseOfASet) {
    for (const Mesh& mesh : {shapes::shuffled(shapes::icosphere(2)).mesh, shapes::tetrahedral_cube(3),
                             shapes::fins(4, 3), shapes::circle(9)}) {
        std::set<std::pair<Index, Index>> expected;
        for (Index c = 0; c < mesh.cell_count(); ++c) {
            for (const Index a : mesh.cells().row(c)) {
                for (const Index b : mesh.cells().row(c)) {
                    if (a < b) expected.emplace(a, b);
                }
            }
        }
        const EdgeGraph graph(mesh.vertex_count(), mesh.cells());
        ASSERT_EQ(graph.edge_count(), static_cast<Index>(expected.size()));
        Index e = 0;
        for (const auto& [a, b] : expected) {
            EXPECT_EQ(graph.lower(e), a);
            EXPECT_EQ(graph.upper()[static_cast<std::size_t>(e)], b);
            EXPECT_EQ(graph.require_edge(b, a), e);
            ++e;
        }
        for (Index v = 0; v < graph.vertex_count(); ++v) {
            Index last = -1;
            for (const auto [w, edge] : graph.neighbours(v)) {
                EXPECT_GT(w, last) << "neighbours ascend";
                EXPECT_EQ(graph.find_edge(v, w), edge);
                last = w;
            }
        }
    }
}

TEST(EdgeGraph, ClosedSurfacesObeyEuler) {
    const auto characteristic = [](const Mesh& mesh) {
        return mesh.vertex_count() - EdgeGraph(mesh.vertex_count(), mesh.cells()).edge_count() +
               mesh.cell_count();
    };
    EXPECT_EQ(characteristic(shapes::icosphere(3)), 2);
    EXPECT_EQ(characteristic(shapes::torus(1, 0.4, 20, 10)), 0);
    EXPECT_EQ(characteristic(shapes::genus(3, 2)), -4);
}

TEST(EdgeGraph, RefusesVerticesOutOfRange) {
    EXPECT_THROW(EdgeGraph(3, Pairs{{0, 3}}), InputError);
    EXPECT_THROW(EdgeGraph(3, Pairs{{-1, 2}}), InputError);
    EXPECT_THROW(EdgeGraph(3, Cells{{0, 1, 3}}), InputError);
    const EdgeGraph graph(3, Pairs{{0, 1}});
    EXPECT_THROW((void)graph.require_edge(0, 2), InputError);
    EXPECT_THROW((void)graph.require_edge(0, 3), InputError);
    EXPECT_THROW((void)graph.require_edge(-1, 0), InputError);
}

TEST(ConnectedComponents, AreNumberedByTheirFirstVertices) {
    const Components components = connected_components(EdgeGraph(7, Pairs{{5, 1}, {0, 3}, {3, 6}}));
    EXPECT_EQ(components.count, 4);
    EXPECT_EQ(components.of_vertex, (std::vector<Index>{0, 1, 2, 0, 3, 1, 0}));
    const Mesh two =
        shapes::shuffled(shapes::together({shapes::icosphere(2), shapes::torus(1, 0.4, 12, 8)})).mesh;
    EXPECT_EQ(connected_components(*graph_of(two)).count, 2);
    EXPECT_EQ(connected_components(*graph_of(shapes::pinched_spheres(1))).count, 1);
    EXPECT_EQ(connected_components(EdgeGraph(0, Pairs{})).count, 0);
}

// Boost.Graph's own algorithms on the graph: distances in edges along a path of segments, and in length.
TEST(EdgeGraph, ServesBoostsShortestPaths) {
    const Mesh circle = shapes::circle(20);
    const EdgeGraph graph(20, circle.cells());
    const Vector lengths = edge_lengths(graph, circle.points());
    std::vector<double> distance(20);
    const auto index = get(boost::vertex_index, graph);
    const auto weight =
        boost::make_function_property_map<WalkedEdge>([&](const WalkedEdge& e) { return lengths[e.edge]; });
    std::vector<Index> before(20);
    boost::dijkstra_shortest_paths(
        graph, 0,
        boost::weight_map(weight)
            .distance_map(boost::make_iterator_property_map(distance.begin(), index))
            .predecessor_map(boost::make_iterator_property_map(before.begin(), index))
            .vertex_index_map(index));
    EXPECT_NEAR(distance[10], 10 * lengths[0], 1e-12);
    EXPECT_NEAR(distance[17], 3 * lengths[0], 1e-12);
}

}  // namespace
}  // namespace beltrami
