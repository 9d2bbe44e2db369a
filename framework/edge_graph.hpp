// The mesh as a solver sees it: vertices and unique edges.
//
//     EdgeGraph graph(mesh.vertex_count(), mesh.cells());
//     for (const EdgeGraph::Neighbour n : graph.neighbours(v)) use(n.vertex, n.edge);
//
// Edges are stored once, from the lower to the higher vertex number, sorted by lower end and then by upper end: the
// edges of rows 0, 1, 2, ... of the strict upper triangle, one after the other. EdgeGraph models the concepts of
// Boost.Graph (boost_graph.hpp), so Boost.Graph's algorithms run on it directly.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "beltrami/framework/types.hpp"

namespace beltrami {

class EdgeGraph {
  public:
    struct Neighbour {
        Index vertex;
        Index edge;
    };

    /// The edges of cells (m x 1, 2, 3 or 4); a cell that names a vertex twice gives no loop.
    EdgeGraph(Index vertex_count, const Cells& cells);

    /// From pairs of vertices in any order and multiplicity. Throws InputError for a vertex out of range.
    EdgeGraph(Index vertex_count, std::vector<std::pair<Index, Index>> edges);

    [[nodiscard]] Index vertex_count() const { return static_cast<Index>(offsets_.size()) - 1; }
    [[nodiscard]] Index edge_count() const { return static_cast<Index>(upper_.size()); }

    /// Edges offsets()[i] to offsets()[i + 1] - 1 have the lower end i. Size n + 1.
    [[nodiscard]] const std::vector<Index>& offsets() const { return offsets_; }
    /// The upper end of each edge. Size m.
    [[nodiscard]] const std::vector<Index>& upper() const { return upper_; }
    /// The lower end of each edge, by binary search in offsets().
    [[nodiscard]] Index lower(Index edge) const;

    // For products that sweep over the edges, a block of rows at a time.

    static constexpr Index block_rows = 256;
    /// The lower end of each edge, counted from the first row of its block. Size m.
    [[nodiscard]] const std::vector<std::uint8_t>& lower_in_block() const { return lower_in_block_; }
    /// Of each block: 1 + the highest vertex among its rows, earlier ones, and their neighbours.
    [[nodiscard]] const std::vector<Index>& reach() const { return reach_; }

    /// Every vertex at the other end of an edge of v, in ascending order.
    [[nodiscard]] std::span<const Neighbour> neighbours(Index v) const {
        const auto begin = neighbour_offsets_[static_cast<std::size_t>(v)];
        const auto end = neighbour_offsets_[static_cast<std::size_t>(v) + 1];
        return {neighbours_.data() + begin, static_cast<std::size_t>(end - begin)};
    }
    [[nodiscard]] Index degree(Index v) const { return static_cast<Index>(neighbours(v).size()); }

    /// The edge between a and b, or -1.
    [[nodiscard]] Index find_edge(Index a, Index b) const;
    /// The same, but throws InputError where there is no such edge or no such vertex.
    [[nodiscard]] Index require_edge(Index a, Index b) const;

    /// The largest |i - j| over the edges.
    [[nodiscard]] Index bandwidth() const;

    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    void build(std::vector<std::pair<Index, Index>>&& edges, Index vertex_count);
    void build_blocks();

    std::vector<Index> offsets_;
    std::vector<Index> upper_;
    std::vector<std::uint8_t> lower_in_block_;
    std::vector<Index> reach_;
    std::vector<std::int64_t> neighbour_offsets_;
    std::vector<Neighbour> neighbours_;
};

/// The connected components: component[v] from 0, in the order of their first vertices. A vertex without edges is a
/// component of its own.
struct Components {
    std::vector<Index> of_vertex;
    Index count = 0;
};
Components connected_components(const EdgeGraph& graph);

}  // namespace beltrami
