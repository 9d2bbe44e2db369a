#include "beltrami/framework/renumbering.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/graph/cuthill_mckee_ordering.hpp>
#include <boost/property_map/function_property_map.hpp>
#include <deque>
#include <numeric>
#include <utility>

#include "beltrami/framework/boost_graph.hpp"
#include "beltrami/framework/constraints.hpp"
#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// Row i of the result is row source[i] of the block.
Block gather_rows(const Block& block, const std::vector<Index>& source) {
    if (block.rows() != static_cast<Eigen::Index>(source.size())) {
        throw InputError(fmt::format("a field of {} rows for {} vertices", block.rows(), source.size()),
                         "give one row a vertex");
    }
    Block gathered(block.rows(), block.cols());
    for (std::size_t i = 0; i < source.size(); ++i) {
        gathered.row(static_cast<Eigen::Index>(i)) = block.row(source[i]);
    }
    return gathered;
}

}  // namespace

Renumbering Renumbering::identity(Index vertex_count) {
    std::vector<Index> same(static_cast<std::size_t>(vertex_count));
    std::iota(same.begin(), same.end(), Index{0});
    return Renumbering(std::move(same));
}

Renumbering::Renumbering(std::vector<Index> working)
    : working_(std::move(working)), user_(working_.size(), -1) {
    for (std::size_t v = 0; v < working_.size(); ++v) {
        const Index w = working_[v];
        if (w < 0 || w >= vertex_count() || user_[static_cast<std::size_t>(w)] >= 0) {
            throw InputError(fmt::format("the new number {} of vertex {} is out of range or taken", w, v),
                             "a renumbering must be a permutation");
        }
        user_[static_cast<std::size_t>(w)] = static_cast<Index>(v);
    }
}

Block Renumbering::to_working(const Block& user_values) const {
    return gather_rows(user_values, user_);
}

Block Renumbering::to_user(const Block& working_values) const {
    return gather_rows(working_values, working_);
}

Mesh Renumbering::to_working(const Mesh& mesh) const {
    const Points points = to_working(Block(mesh.points()));
    Fields fields;
    for (const Field& field : mesh.fields())
        fields.push_back({field.name, to_working(field.values)});
    if (mesh.kind() == CellKind::point) return Mesh(points, std::move(fields));
    const Cells cells = mesh.cells().unaryExpr([&](Index v) { return working(v); });
    return Mesh(points, cells, std::move(fields));
}

Constraints Renumbering::to_working(const Constraints& constraints) const {
    constraints.check_range(vertex_count());
    Constraints renumbered(constraints.columns());
    for (const Index v : constraints.vertices())
        renumbered.fix(working(v), constraints.value(v));
    return renumbered;
}

namespace {

// A vertex at an end of its component (George & Liu 1979): walk to the farthest vertex of least degree until that no
// longer leads farther. `seen` holds for each vertex the last walk that met it. Boost.Graph's own search clears a mark on
// every vertex for every component, which is quadratic where there are many.
class EndOfComponent {
  public:
    explicit EndOfComponent(const EdgeGraph& graph)
        : graph_(graph), seen_(static_cast<std::size_t>(graph.vertex_count()), 0) {}

    Index from(Index start) {
        Farthest best = walk(start);
        for (Farthest next = walk(best.vertex); next.distance > best.distance; next = walk(best.vertex))
            best = next;
        return best.vertex;
    }

  private:
    struct Farthest {
        Index vertex;
        Index distance;
    };

    Farthest walk(Index start) {
        ++walks_;
        std::vector<Index> level = {start};
        seen_[static_cast<std::size_t>(start)] = walks_;
        for (Index distance = 0;; ++distance) {
            std::vector<Index> next;
            for (const Index v : level) {
                for (const EdgeGraph::Neighbour& n : graph_.neighbours(v)) {
                    Index& seen = seen_[static_cast<std::size_t>(n.vertex)];
                    if (seen == walks_) continue;
                    seen = walks_;
                    next.push_back(n.vertex);
                }
            }
            if (next.empty()) {
                const auto less = [&](Index a, Index b) { return graph_.degree(a) < graph_.degree(b); };
                return {*std::min_element(level.begin(), level.end(), less), distance};
            }
            level = std::move(next);
        }
    }

    const EdgeGraph& graph_;
    std::vector<Index> seen_;
    Index walks_ = 0;
};

}  // namespace

Renumbering cuthill_mckee(const EdgeGraph& graph) {
    const auto n = static_cast<std::size_t>(graph.vertex_count());
    EndOfComponent end(graph);
    const Components components = connected_components(graph);
    std::vector<char> started(static_cast<std::size_t>(components.count), 0);
    std::deque<Index> starts;
    for (Index v = 0; v < graph.vertex_count(); ++v) {
        char& known = started[static_cast<std::size_t>(components.of_vertex[static_cast<std::size_t>(v)])];
        if (known == 0) starts.push_back(graph.degree(v) == 0 ? v : end.from(v));
        known = 1;
    }
    std::vector<Index> user_of_working(n);
    std::vector<boost::default_color_type> colour(n, boost::white_color);
    const auto index = get(boost::vertex_index, graph);
    const auto degree_map =
        boost::make_function_property_map<Index>([&](Index v) { return graph.degree(v); });
    boost::cuthill_mckee_ordering(graph, starts, user_of_working.begin(),
                                  boost::make_iterator_property_map(colour.begin(), index), degree_map);
    std::vector<Index> working(n);
    for (std::size_t w = 0; w < n; ++w)
        working[static_cast<std::size_t>(user_of_working[w])] = static_cast<Index>(w);
    return Renumbering(std::move(working));
}

}  // namespace beltrami
