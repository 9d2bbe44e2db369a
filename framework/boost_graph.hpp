// EdgeGraph as a model of Boost.Graph's VertexListGraph, EdgeListGraph, IncidenceGraph and AdjacencyGraph, undirected.
//
//     std::vector<Index> component(graph.vertex_count());
//     boost::connected_components(graph, component.data());
#pragma once

#include <boost/graph/graph_traits.hpp>
#include <boost/graph/properties.hpp>
#include <boost/iterator/counting_iterator.hpp>
#include <boost/iterator/transform_iterator.hpp>
#include <boost/property_map/property_map.hpp>
#include <utility>

#include "beltrami/framework/edge_graph.hpp"

namespace beltrami {

/// An edge as it is walked: from source to target; `edge` is its number in the EdgeGraph.
struct WalkedEdge {
    Index source;
    Index target;
    Index edge;
    friend bool operator==(const WalkedEdge& a, const WalkedEdge& b) { return a.edge == b.edge; }
};

struct NeighbourVertex {
    Index operator()(const EdgeGraph::Neighbour& n) const { return n.vertex; }
};
struct OutEdge {
    Index source = 0;
    WalkedEdge operator()(const EdgeGraph::Neighbour& n) const { return {source, n.vertex, n.edge}; }
};
struct NumberedEdge {
    const EdgeGraph* graph = nullptr;
    WalkedEdge operator()(Index e) const {
        return {graph->lower(e), graph->upper()[static_cast<std::size_t>(e)], e};
    }
};

}  // namespace beltrami

namespace boost {

template <>
struct graph_traits<beltrami::EdgeGraph> {
    using vertex_descriptor = beltrami::Index;
    using edge_descriptor = beltrami::WalkedEdge;
    using directed_category = undirected_tag;
    using edge_parallel_category = disallow_parallel_edge_tag;
    // NOLINTNEXTLINE(readability-identifier-naming): the name is Boost.Graph's
    struct traversal_category : incidence_graph_tag,
                                adjacency_graph_tag,
                                vertex_list_graph_tag,
                                edge_list_graph_tag {};

    using vertices_size_type = beltrami::Index;
    using edges_size_type = beltrami::Index;
    using degree_size_type = beltrami::Index;

    using vertex_iterator = counting_iterator<beltrami::Index>;
    using adjacency_iterator =
        transform_iterator<beltrami::NeighbourVertex, const beltrami::EdgeGraph::Neighbour*>;
    using out_edge_iterator = transform_iterator<beltrami::OutEdge, const beltrami::EdgeGraph::Neighbour*>;
    using edge_iterator = transform_iterator<beltrami::NumberedEdge, counting_iterator<beltrami::Index>>;

    static vertex_descriptor null_vertex() { return -1; }
};

template <>
struct property_map<beltrami::EdgeGraph, vertex_index_t> {
    using type = typed_identity_property_map<beltrami::Index>;
    using const_type = type;
};

}  // namespace boost

namespace beltrami {

using GraphTraits = boost::graph_traits<EdgeGraph>;

inline Index num_vertices(const EdgeGraph& g) {
    return g.vertex_count();
}
inline Index num_edges(const EdgeGraph& g) {
    return g.edge_count();
}
inline std::pair<GraphTraits::vertex_iterator, GraphTraits::vertex_iterator> vertices(const EdgeGraph& g) {
    return {GraphTraits::vertex_iterator(0), GraphTraits::vertex_iterator(g.vertex_count())};
}
inline std::pair<GraphTraits::edge_iterator, GraphTraits::edge_iterator> edges(const EdgeGraph& g) {
    const auto at = [&](Index e) {
        return GraphTraits::edge_iterator(boost::counting_iterator<Index>(e), NumberedEdge{&g});
    };
    return {at(0), at(g.edge_count())};
}
inline std::pair<GraphTraits::adjacency_iterator, GraphTraits::adjacency_iterator> adjacent_vertices(
    Index v, const EdgeGraph& g) {
    const auto n = g.neighbours(v);
    return {GraphTraits::adjacency_iterator(n.data()), GraphTraits::adjacency_iterator(n.data() + n.size())};
}
inline std::pair<GraphTraits::out_edge_iterator, GraphTraits::out_edge_iterator> out_edges(
    Index v, const EdgeGraph& g) {
    const auto n = g.neighbours(v);
    return {GraphTraits::out_edge_iterator(n.data(), OutEdge{v}),
            GraphTraits::out_edge_iterator(n.data() + n.size(), OutEdge{v})};
}
inline Index out_degree(Index v, const EdgeGraph& g) {
    return g.degree(v);
}
inline Index degree(Index v, const EdgeGraph& g) {
    return g.degree(v);
}
inline Index source(const WalkedEdge& e, const EdgeGraph& /*g*/) {
    return e.source;
}
inline Index target(const WalkedEdge& e, const EdgeGraph& /*g*/) {
    return e.target;
}
inline boost::typed_identity_property_map<Index> get(boost::vertex_index_t /*tag*/, const EdgeGraph& /*g*/) {
    return {};
}

}  // namespace beltrami
