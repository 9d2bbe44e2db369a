#include "beltrami/framework/edge_graph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/graph/connected_components.hpp>
#include <limits>

#include "beltrami/framework/boost_graph.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

std::size_t at(Index i) {
    return static_cast<std::size_t>(i);
}

}  // namespace

EdgeGraph::EdgeGraph(Index vertex_count, const Cells& cells) {
    std::vector<std::pair<Index, Index>> edges;
    const Eigen::Index corners = cells.cols();
    edges.reserve(static_cast<std::size_t>(cells.rows() * corners * (corners - 1) / 2));
    for (Eigen::Index c = 0; c < cells.rows(); ++c) {
        for (Eigen::Index a = 0; a < corners; ++a) {
            for (Eigen::Index b = a + 1; b < corners; ++b)
                edges.emplace_back(cells(c, a), cells(c, b));
        }
    }
    build(std::move(edges), vertex_count);
}

EdgeGraph::EdgeGraph(Index vertex_count, std::vector<std::pair<Index, Index>> edges) {
    build(std::move(edges), vertex_count);
}

void EdgeGraph::build(std::vector<std::pair<Index, Index>>&& edges, Index vertex_count) {
    // Bucket the upper ends by lower end, then sort and unique each short row: linear in the number of edges.
    offsets_.assign(at(vertex_count) + 1, 0);
    std::vector<std::int64_t> begin(at(vertex_count) + 1, 0);
    for (auto& [i, j] : edges) {
        if (i > j) std::swap(i, j);
        if (i < 0 || j >= vertex_count) {
            throw InputError(fmt::format("an edge joins vertices {} and {}, but the vertices are 0 to {}", i,
                                         j, vertex_count - 1),
                             "count the vertices that the edges name");
        }
        if (i != j) ++begin[at(i) + 1];
    }
    for (std::size_t i = 0; i < at(vertex_count); ++i)
        begin[i + 1] += begin[i];
    std::vector<Index> ends(static_cast<std::size_t>(begin.back()));
    std::vector<std::int64_t> fill(begin.begin(), begin.end() - 1);
    for (const auto& [i, j] : edges) {
        if (i != j) ends[static_cast<std::size_t>(fill[at(i)]++)] = j;
    }
    edges = {};
    upper_.reserve(ends.size() / 2);
    for (Index i = 0; i < vertex_count; ++i) {
        const auto first = ends.begin() + begin[at(i)];
        const auto last = ends.begin() + begin[at(i) + 1];
        std::sort(first, last);
        upper_.insert(upper_.end(), first, std::unique(first, last));
        offsets_[at(i) + 1] = static_cast<Index>(upper_.size());
    }
    if (upper_.size() > static_cast<std::size_t>(std::numeric_limits<Index>::max())) {
        throw InputError("the mesh has more than 2^31 - 1 edges", "split it into parts");
    }
    upper_.shrink_to_fit();
    build_blocks();

    neighbour_offsets_.assign(at(vertex_count) + 1, 0);
    for (Index i = 0; i < vertex_count; ++i) {
        neighbour_offsets_[at(i) + 1] += offsets_[at(i) + 1] - offsets_[at(i)];
    }
    for (const Index j : upper_)
        ++neighbour_offsets_[at(j) + 1];
    for (std::size_t i = 0; i < at(vertex_count); ++i)
        neighbour_offsets_[i + 1] += neighbour_offsets_[i];
    neighbours_.resize(2 * upper_.size());
    std::vector<std::int64_t> next(neighbour_offsets_.begin(), neighbour_offsets_.end() - 1);
    // Ascending i writes the lower neighbours of every vertex in order; its upper ones follow when its row comes.
    for (Index i = 0; i < vertex_count; ++i) {
        for (Index e = offsets_[at(i)]; e < offsets_[at(i) + 1]; ++e) {
            const Index j = upper_[at(e)];
            neighbours_[static_cast<std::size_t>(next[at(i)]++)] = {j, e};
            neighbours_[static_cast<std::size_t>(next[at(j)]++)] = {i, e};
        }
    }
}

void EdgeGraph::build_blocks() {
    static_assert(block_rows - 1 <= std::numeric_limits<std::uint8_t>::max());
    lower_in_block_.reserve(upper_.size());
    Index highest = 0;
    for (Index first = 0; first < vertex_count(); first += block_rows) {
        const Index end = std::min(vertex_count(), first + block_rows);
        highest = std::max(highest, end);
        for (Index i = first; i < end; ++i) {
            const Index degree = offsets_[at(i) + 1] - offsets_[at(i)];
            if (degree == 0) continue;
            lower_in_block_.insert(lower_in_block_.end(), at(degree), static_cast<std::uint8_t>(i - first));
            highest = std::max(highest, upper_[at(offsets_[at(i) + 1]) - 1] + 1);
        }
        reach_.push_back(highest);
    }
}

Index EdgeGraph::lower(Index edge) const {
    const auto row = std::upper_bound(offsets_.begin(), offsets_.end(), edge);
    return static_cast<Index>(row - offsets_.begin()) - 1;
}

Index EdgeGraph::find_edge(Index a, Index b) const {
    if (a > b) std::swap(a, b);
    const auto first = upper_.begin() + offsets_[at(a)];
    const auto last = upper_.begin() + offsets_[at(a) + 1];
    const auto found = std::lower_bound(first, last, b);
    return found != last && *found == b ? static_cast<Index>(found - upper_.begin()) : Index{-1};
}

Index EdgeGraph::require_edge(Index a, Index b) const {
    const bool in_range = std::min(a, b) >= 0 && std::max(a, b) < vertex_count();
    const Index edge = in_range ? find_edge(a, b) : -1;
    if (edge < 0) {
        throw InputError(
            fmt::format("a graph of {} vertices has no edge between {} and {}", vertex_count(), a, b),
            "make the graph of the mesh that it is used with");
    }
    return edge;
}

Index EdgeGraph::bandwidth() const {
    Index widest = 0;
    for (Index i = 0; i < vertex_count(); ++i) {
        if (offsets_[at(i)] < offsets_[at(i) + 1])
            widest = std::max(widest, upper_[at(offsets_[at(i) + 1]) - 1] - i);
    }
    return widest;
}

std::size_t EdgeGraph::memory_bytes() const {
    return sizeof(Index) * (offsets_.size() + upper_.size() + reach_.size()) + lower_in_block_.size() +
           sizeof(std::int64_t) * neighbour_offsets_.size() + sizeof(Neighbour) * neighbours_.size();
}

Components connected_components(const EdgeGraph& graph) {
    Components components;
    components.of_vertex.assign(at(graph.vertex_count()), 0);
    components.count = boost::connected_components(
        graph,
        boost::make_iterator_property_map(components.of_vertex.begin(), get(boost::vertex_index, graph)));
    return components;
}

}  // namespace beltrami
