#include "beltrami/solvers/hierarchy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <queue>
#include <utility>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

/// A level that is not smaller than the one above by this factor is not worth having.
constexpr double least_shrinkage = 1.5;

std::size_t at(Index i) {
    return static_cast<std::size_t>(i);
}

/// Single precision, summed in double: sums of a few are exact, so ways of the same length stay so wherever the mesh
/// lies.
using Lengths = Eigen::VectorXf;

/// Every vertex belongs to the nearest of the centres that cover it.
struct VoronoiCells {
    std::vector<Index> centres;    ///< ascending
    std::vector<Index> of_vertex;  ///< from 0 in the order of the centres; -1 for a vertex that is left out
};

/// In the order of the vertices: one that no earlier centre covers becomes a centre itself.
VoronoiCells voronoi_cells(const EdgeGraph& graph, const Lengths& lengths, double radius,
                           bool leave_out_isolated) {
    const Index n = graph.vertex_count();
    std::vector<double> scale(at(n), 0.0);  // the mean length of a vertex's edges
    for (Index v = 0; v < n; ++v) {
        for (const EdgeGraph::Neighbour& neighbour : graph.neighbours(v))
            scale[at(v)] += lengths[neighbour.edge];
        scale[at(v)] /= std::max(graph.degree(v), Index{1});
    }
    VoronoiCells cells{{}, std::vector<Index>(at(n), -1)};
    std::vector<double> distance(at(n), std::numeric_limits<double>::infinity());

    // Dijkstra's algorithm by hand: Boost.Graph's makes an array of n for every call, and there is a call a centre.
    // A centre goes no farther than it covers, and enters only where it is nearer than all earlier ones: the whole
    // takes time in proportion to the mesh.
    using Reached = std::pair<double, Index>;
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> front;
    const auto reach = [&](Index v, double d, Index cell) {
        if (d >= distance[at(v)]) return;
        distance[at(v)] = d;
        cells.of_vertex[at(v)] = cell;
        front.emplace(d, v);
    };
    for (Index centre = 0; centre < n; ++centre) {
        if (cells.of_vertex[at(centre)] >= 0 || (graph.degree(centre) == 0 && leave_out_isolated)) continue;
        const auto cell = static_cast<Index>(cells.centres.size());
        cells.centres.push_back(centre);
        reach(centre, 0.0, cell);
        while (!front.empty()) {
            const auto [from_centre, v] = front.top();
            front.pop();
            if (from_centre > distance[at(v)]) continue;
            for (const auto& [w, edge] : graph.neighbours(v)) {
                const double d = from_centre + lengths[edge];
                if (d <= radius * std::min(scale[at(centre)], scale[at(w)])) reach(w, d, cell);
            }
        }
    }
    return cells;
}

/// Cells are adjacent where an edge leads from one to the other.
EdgeGraph adjacency(const EdgeGraph& graph, const VoronoiCells& cells) {
    std::vector<std::pair<Index, Index>> edges;
    for (Index i = 0; i < graph.vertex_count(); ++i) {
        for (Index e = graph.offsets()[at(i)]; e < graph.offsets()[at(i) + 1]; ++e) {
            const Index a = cells.of_vertex[at(i)];
            const Index b = cells.of_vertex[at(graph.upper()[at(e)])];
            if (a != b) edges.emplace_back(a, b);
        }
    }
    return {static_cast<Index>(cells.centres.size()), std::move(edges)};
}

/// The point s a + t b of a triangle whose corners are the origin, a and b, closest to another.
struct Closest {
    double s = 0.0;
    double t = 0.0;
    double squared_distance = std::numeric_limits<double>::infinity();
};

struct Foot {
    Closest closest;
    bool inside;
};

/// The triangle of a cell's centre, which is the origin, and of two others; a segment where these are the same.
class Triangle {
  public:
    Triangle(Index cell_a, Index cell_b, Vector3 a, Vector3 b)
        : cell_a(cell_a), cell_b(cell_b), a_(std::move(a)), b_(std::move(b)) {
        // Of a sliver only the sides are looked at.
        const double determinant = aa_ * bb_ - ab_ * ab_;
        if (determinant > 1e-12 * aa_ * bb_) {
            inverse_ = 1.0 / determinant;
            heights_ = {determinant / bb_, determinant / aa_, determinant / (aa_ - 2.0 * ab_ + bb_)};
        }
    }
    Index cell_a;
    Index cell_b;

    /// The foot of p in the triangle's plane where that lies in the triangle; otherwise a bound from below of its distance
    /// alone, and nothing where there is no plane.
    [[nodiscard]] Foot foot(const Vector3& p) const {
        if (inverse_ == 0.0) return {{0.0, 0.0, 0.0}, false};
        const double pa = p.dot(a_);
        const double pb = p.dot(b_);
        const double s = (bb_ * pa - ab_ * pb) * inverse_;
        const double t = (aa_ * pb - ab_ * pa) * inverse_;
        Foot result{point(p, s, t), s >= 0.0 && t >= 0.0 && s + t <= 1.0};
        if (!result.inside) {
            // Beyond a side p is farther from the triangle than from that side's line.
            const auto beyond = [](double x) { return std::min(x, 0.0) * std::min(x, 0.0); };
            result.closest.squared_distance += std::max(
                {beyond(s) * heights_[0], beyond(t) * heights_[1], beyond(1.0 - s - t) * heights_[2]});
        }
        return result;
    }
    [[nodiscard]] Closest closest_on_sides(const Vector3& p) const {
        const double pa = p.dot(a_);
        const double pb = p.dot(b_);
        const auto part = [](double some, double all) {
            return all > 0.0 ? std::clamp(some / all, 0.0, 1.0) : 0.0;
        };
        const double along = part(pb - pa - ab_ + aa_, aa_ - 2.0 * ab_ + bb_);
        return std::min(
            {point(p, part(pa, aa_), 0.0), point(p, 0.0, part(pb, bb_)), point(p, 1.0 - along, along)},
            [](const Closest& x, const Closest& y) { return x.squared_distance < y.squared_distance; });
    }

  private:
    [[nodiscard]] Closest point(const Vector3& p, double s, double t) const {
        return {s, t, (p - s * a_ - t * b_).squaredNorm()};
    }

    Vector3 a_;
    Vector3 b_;
    double aa_ = a_.squaredNorm();
    double ab_ = a_.dot(b_);
    double bb_ = b_.squaredNorm();
    double inverse_ = 0.0;  // of the determinant
    // Squared, over the sides where s, t and 1 - s - t are zero.
    std::array<double, 3> heights_{};
};

/// The triangles of a cell and two that are adjacent to it and to each other, and the segments to adjacent cells that
/// are in no triangle. seen_from: a number a cell, kept between calls, -1 at first.
void triangles_around(Index cell, const EdgeGraph& cells, const Points& centres,
                      std::vector<Index>& seen_from, std::vector<Triangle>& triangles) {
    triangles.clear();
    for (const EdgeGraph::Neighbour& a : cells.neighbours(cell))
        seen_from[at(a.vertex)] = cell;
    const Vector3 origin = centres.row(cell);
    const auto add = [&](Index a, Index b) {
        triangles.emplace_back(a, b, centres.row(a).transpose() - origin,
                               centres.row(b).transpose() - origin);
    };
    for (const EdgeGraph::Neighbour& a : cells.neighbours(cell)) {
        bool in_triangle = false;
        for (const EdgeGraph::Neighbour& b : cells.neighbours(a.vertex)) {
            if (seen_from[at(b.vertex)] != cell) continue;
            in_triangle = true;
            if (a.vertex < b.vertex) add(a.vertex, b.vertex);
        }
        if (!in_triangle) add(a.vertex, a.vertex);
    }
}

Hierarchy::Prolongation interpolation(const Points& points, const VoronoiCells& cells,
                                      const EdgeGraph& adjacent, const Points& centres) {
    const auto cell_count = static_cast<Index>(cells.centres.size());
    std::vector<Index> begin(at(cell_count) + 1, 0);
    for (const Index cell : cells.of_vertex) {
        if (cell >= 0) ++begin[at(cell) + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Index> members(at(begin.back()));
    std::vector<Index> next = begin;
    for (Index v = 0; v < static_cast<Index>(cells.of_vertex.size()); ++v) {
        const Index cell = cells.of_vertex[at(v)];
        if (cell >= 0) members[at(next[at(cell)]++)] = v;
    }

    struct Entry {
        Index column = 0;
        double weight = 0.0;
    };
    std::vector<std::array<Entry, 3>> rows(cells.of_vertex.size());
#pragma omp parallel if (cell_count > 5000)
    {
        std::vector<Triangle> triangles;
        std::vector<Foot> feet;
        std::vector<Index> seen_from(at(cell_count), -1);
#pragma omp for schedule(static)
        for (Index cell = 0; cell < cell_count; ++cell) {
            triangles_around(cell, adjacent, centres, seen_from, triangles);
            const Vector3 centre = centres.row(cell);
            for (Index m = begin[at(cell)]; m < begin[at(cell) + 1]; ++m) {
                const Index v = members[at(m)];
                std::array<Entry, 3>& row = rows[at(v)];
                row[0] = {cell, 1.0};
                if (v == cells.centres[at(cell)]) continue;
                const Vector3 p = points.row(v).transpose() - centre;
                Closest best;
                const auto take = [&](const Triangle& triangle, const Closest& here) {
                    // Among equally close points, as in a plane, rounding does not decide.
                    if (here.squared_distance >= best.squared_distance - 1e-12 * p.squaredNorm()) return;
                    best = here;
                    row = {Entry{cell, 1.0 - here.s - here.t},
                           {triangle.cell_a, here.s},
                           {triangle.cell_b, here.t}};
                };
                feet.clear();
                for (const Triangle& triangle : triangles) {
                    feet.push_back(triangle.foot(p));
                    if (feet.back().inside) take(triangle, feet.back().closest);
                }
                for (std::size_t t = 0; t < triangles.size(); ++t) {
                    if (!feet[t].inside && feet[t].closest.squared_distance < best.squared_distance)
                        take(triangles[t], triangles[t].closest_on_sides(p));
                }
                std::sort(row.begin(), row.end(),
                          [](const Entry& x, const Entry& y) { return x.column < y.column; });
            }
        }
    }

    Hierarchy::Prolongation P(points.rows(), cell_count);
    P.reserve(3 * points.rows());
    for (std::size_t v = 0; v < rows.size(); ++v) {
        P.startVec(static_cast<Eigen::Index>(v));
        for (const Entry& entry : rows[v]) {
            if (entry.weight > 0.0) P.insertBack(static_cast<Eigen::Index>(v), entry.column) = entry.weight;
        }
    }
    P.finalize();
    P.data().squeeze();
    return P;
}

/// The mean edge length is one, so that neither underflow nor overflow depends on the unit; points that all lie in one
/// place stay there.
Points in_mean_edges(const EdgeGraph& graph, const Points& points) {
    const auto divided = [](const Points& p, double by) -> Points { return by > 0.0 ? Points(p / by) : p; };
    const Points within_one = divided(points, points.cwiseAbs().maxCoeff());
    return divided(within_one, edge_lengths(graph, within_one).mean());
}

void check(const EdgeGraph& graph, const Points& points, const HierarchyOptions& options) {
    if (points.rows() != graph.vertex_count()) {
        throw InputError(
            fmt::format("{} points for a graph of {} vertices", points.rows(), graph.vertex_count()),
            "give one point a vertex, in the order of the graph");
    }
    if (!points.allFinite()) throw InputError("a coordinate is not finite", "look for NaN among the points");
    if (!(options.radius > 0.0) || !std::isfinite(options.radius)) {
        throw InputError(fmt::format("a hierarchy's radius is {}", options.radius), "2 suits most meshes");
    }
    if (options.coarsest < 1) {
        throw InputError(fmt::format("a coarsest level of {} vertices", options.coarsest),
                         "give at least one");
    }
}

}  // namespace

Hierarchy::Hierarchy(const EdgeGraph& graph, const Points& points, const HierarchyOptions& options) {
    check(graph, points, options);
    vertices_.emplace_back(at(graph.vertex_count()));
    std::iota(vertices_[0].begin(), vertices_[0].end(), Index{0});
    if (graph.edge_count() == 0) return;

    const EdgeGraph* fine = &graph;
    std::optional<EdgeGraph> last;
    Points positions = in_mean_edges(graph, points);
    const auto tell = [&](double vertices_left) {
        report(options.progress, "hierarchy", 1.0 - vertices_left / graph.vertex_count());
    };
    while (fine->vertex_count() > options.coarsest) {
        tell(fine->vertex_count());
        // On a coarser level a vertex without an edge is all that is left of its component.
        const bool leave_out_isolated = fine == &graph;
        const VoronoiCells cells = voronoi_cells(*fine, edge_lengths(*fine, positions).cast<float>(),
                                                 options.radius, leave_out_isolated);
        const auto left_out = std::count(cells.of_vertex.begin(), cells.of_vertex.end(), -1);
        const auto cell_count = static_cast<double>(cells.centres.size());
        if (least_shrinkage * cell_count > static_cast<double>(fine->vertex_count() - left_out)) break;
        tell(0.5 * (fine->vertex_count() + cell_count));

        EdgeGraph coarse = adjacency(*fine, cells);
        Points centres = positions(cells.centres, Eigen::all);
        prolongations_.push_back(interpolation(positions, cells, coarse, centres));
        std::vector<Index> vertices;
        vertices.reserve(cells.centres.size());
        for (const Index centre : cells.centres)
            vertices.push_back(vertices_.back()[at(centre)]);
        vertices_.push_back(std::move(vertices));
        positions = std::move(centres);
        last = std::move(coarse);
        fine = &*last;
    }
    tell(0.0);
}

const std::vector<Index>& Hierarchy::vertices(int level) const {
    if (level < 0 || level >= level_count()) {
        throw InputError(fmt::format("a hierarchy of {} levels has no level {}", level_count(), level),
                         "level 0 is the mesh");
    }
    return vertices_[static_cast<std::size_t>(level)];
}

const Hierarchy::Prolongation& Hierarchy::prolongation(int level) const {
    if (level < 0 || level + 1 >= level_count()) {
        throw InputError(
            fmt::format("a hierarchy of {} levels has no prolongation to level {}", level_count(), level),
            "the coarsest level has none below it");
    }
    return prolongations_[static_cast<std::size_t>(level)];
}

std::size_t Hierarchy::memory_bytes() const {
    std::size_t bytes = 0;
    for (const std::vector<Index>& level : vertices_)
        bytes += sizeof(Index) * level.size();
    for (const Prolongation& P : prolongations_) {
        bytes += static_cast<std::size_t>(P.nonZeros()) * (sizeof(double) + sizeof(Index)) +
                 sizeof(Index) * (static_cast<std::size_t>(P.rows()) + 1);
    }
    return bytes;
}

Eigen::SparseMatrix<double> galerkin_product(const Eigen::SparseMatrix<double>& A,
                                             const Hierarchy::Prolongation& P) {
    const Eigen::SparseMatrix<double> columns = P;
    const Eigen::SparseMatrix<double> AP = A * columns;
    return columns.transpose() * AP;
}

}  // namespace beltrami
