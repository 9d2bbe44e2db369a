#include "scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>

#include "beltrami/framework/boundary.hpp"
#include "beltrami/framework/sides.hpp"
#include "beltrami/framework/vertex_clustering.hpp"
#include "parcel.hpp"

namespace beltrami::view {

namespace {

bool is_surface(CellKind drawn) {
    return drawn == CellKind::triangle;
}

/// Edges between the vertices that are sent: those that collapse are dropped, of equal ones all but one.
Cells edges_at(Cells edges, const std::vector<Index>& shown_at) {
    if (shown_at.empty()) return edges;
    Cells kept(edges.rows(), 2);
    Eigen::Index count = 0;
    for (const auto& edge : edges.rowwise()) {
        const Index a = shown_at[static_cast<std::size_t>(edge[0])];
        const Index b = shown_at[static_cast<std::size_t>(edge[1])];
        if (a == b || a < 0 || b < 0) continue;
        kept.row(count++) << std::min(a, b), std::max(a, b);
    }
    kept.conservativeResize(count, Eigen::NoChange);
    const auto vertices = static_cast<Index>(shown_at.size());
    const EqualRows groups(kept, vertices);
    std::vector<Index> first;
    first.reserve(static_cast<std::size_t>(groups.group_count()));
    for (Index g = 0; g < groups.group_count(); ++g)
        first.push_back(groups.group(g).front());
    return kept(first, Eigen::all);
}

/// Which edges mark where a surface ends or branches.
void find_marked_edges(const Mesh& surface, Shown& shown) {
    const Sides sides(proper_cells(surface), surface.vertex_count());
    shown.boundary = edges_at(boundary(sides), shown.shown_at);
    shown.non_manifold =
        edges_at(sides.vertices_where([](std::size_t cells) { return cells > 2; }), shown.shown_at);
}

nlohmann::json number(double value, double above = -std::numeric_limits<double>::infinity()) {
    if (!std::isfinite(value) || !(value > above)) return nullptr;
    return value;
}

/// Numbers of the points of the lines, which have as many each, that are left of many.
std::vector<Eigen::Index> points_to_keep(const std::vector<ChartLine>& lines) {
    constexpr Eigen::Index most = 4000;
    const Eigen::Index n = lines.front().x.size();
    std::vector<Eigen::Index> kept;
    if (n <= most) {
        kept.resize(static_cast<std::size_t>(n));
        std::iota(kept.begin(), kept.end(), 0);
        return kept;
    }
    const Eigen::Index parts = most / (2 * static_cast<Eigen::Index>(lines.size()));
    kept = {0, n - 1};
    for (Eigen::Index p = 0; p < parts; ++p) {
        const Eigen::Index begin = p * n / parts;
        const Eigen::Index size = (p + 1) * n / parts - begin;
        for (const ChartLine& line : lines) {
            Eigen::Index least = 0;
            Eigen::Index greatest = 0;
            line.y.segment(begin, size).minCoeff<Eigen::PropagateNumbers>(&least);
            line.y.segment(begin, size).maxCoeff<Eigen::PropagateNumbers>(&greatest);
            kept.push_back(begin + std::max<Eigen::Index>(least, 0));
            kept.push_back(begin + std::max<Eigen::Index>(greatest, 0));
        }
    }
    std::sort(kept.begin(), kept.end());
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    return kept;
}

}  // namespace

Shown shown(const Mesh& mesh, Index most_vertices) {
    const bool solid = mesh.kind() == CellKind::tetrahedron;
    const Mesh bare = mesh.kind() == CellKind::point
                          ? Mesh(mesh.points())
                          : Mesh(mesh.points(), solid ? boundary_triangles(mesh) : mesh.cells());
    Shown result{bare, {}, {}, {}};
    if (mesh.vertex_count() > most_vertices) {
        VertexClustering clusters = cluster_vertices(bare, most_vertices);
        result.mesh = std::move(clusters.mesh);
        result.vertex_of = std::move(clusters.vertex_of);
        result.shown_at = std::move(clusters.cluster_of);
        result.decimation =
            fmt::format("{} of {} vertices are drawn, {}", result.mesh.vertex_count(), mesh.vertex_count(),
                        clusters.box > 0.0 ? fmt::format("one for each box of side {:.3g}", clusters.box)
                                           : "those that can be seen");
    }
    if (is_surface(bare.kind())) find_marked_edges(bare, result);
    return result;
}

Shown moved(Shown shown, const Points& points) {
    shown.mesh = shown.mesh.with_points(
        shown.vertex_of.empty() ? points : Points(points(shown.vertex_of, Eigen::all)));
    return shown;
}

Shown with_lines(const Shown& shown, const Mesh& lines, Index vertex_count) {
    const Index before = shown.mesh.vertex_count();
    Points points(before + lines.vertex_count(), 3);
    points << shown.mesh.points(), lines.points();
    Shown both{Mesh(points, shown.mesh.cells()),
               shown.vertex_of,
               shown.shown_at,
               shown.decimation,
               shown.boundary,
               shown.non_manifold,
               lines.cells().array() + before};
    if (!both.vertex_of.empty()) {
        for (Index i = 0; i < lines.vertex_count(); ++i)
            both.vertex_of.push_back(vertex_count + i);
    }
    return both;
}

Block at_shown(const Block& values, const Shown& shown) {
    if (shown.vertex_of.empty()) return values;
    return values(shown.vertex_of, Eigen::all);
}

std::string name_of_mesh(const std::string& argument) {
    return argument.starts_with("shape:") ? argument : std::filesystem::path(argument).filename().string();
}

std::string mesh_parcel(const Shown& shown, const std::string& name, const Mesh& original,
                        const MeshReport& report) {
    nlohmann::json fields = nlohmann::json::array();
    for (const Field& field : original.fields())
        fields.push_back({{"name", field.name}, {"columns", field.values.cols()}});
    Parcel parcel({{"kind", "mesh"},
                   {"name", name},
                   {"cells", plural(original.kind())},
                   {"vertices", shown.mesh.vertex_count()},
                   {"decimated", !shown.vertex_of.empty()},
                   {"decimation", shown.decimation},
                   {"brief", brief_report(report)},
                   {"full", full_report(report)},
                   {"report", to_json(report)},
                   {"fields", fields},
                   {"mean_edge", report.mean_edge}});
    const Cells none(0, 1);
    const CellKind drawn = shown.mesh.kind();
    std::vector<Index> points;
    if (drawn == CellKind::point) {
        points.resize(static_cast<std::size_t>(shown.mesh.vertex_count()));
        std::iota(points.begin(), points.end(), 0);
    }
    parcel.add("positions", shown.mesh.points());
    parcel.add("triangles", drawn == CellKind::triangle ? shown.mesh.cells() : none);
    parcel.add("segments", drawn == CellKind::segment ? shown.mesh.cells() : shown.lines);
    parcel.add("points", points);
    parcel.add("boundary", shown.boundary);
    parcel.add("non_manifold", shown.non_manifold);
    if (!shown.vertex_of.empty()) parcel.add("vertex_of", shown.vertex_of);
    return parcel.bytes();
}

std::string field_parcel(const Field& field, const Shown& shown, const char* as) {
    Parcel parcel({{"kind", "field"}, {"name", field.name}, {"columns", field.values.cols()}, {"as", as}});
    parcel.add("values", at_shown(field.values, shown));
    return parcel.bytes();
}

const char* meaning_of(const Field& field) {
    if (field.values.cols() != 3) return "scalar";
    return field.name == "color" ? "colors" : "vectors";
}

std::string moment_parcel(const std::string& name, double time, Index columns, std::span<const float> values,
                          bool displaced) {
    Parcel parcel({{"kind", "moment"}, {"name", name}, {"time", time}, {"columns", columns}});
    parcel.add(displaced ? "displacement" : "values", values);
    return parcel.bytes();
}

nlohmann::json to_json(const Chart& chart) {
    nlohmann::json lines = nlohmann::json::array();
    const bool alike = std::all_of(chart.lines.begin(), chart.lines.end(), [&](const ChartLine& line) {
        return line.x.size() == chart.lines.front().x.size();
    });
    for (const ChartLine& line : chart.lines) {
        nlohmann::json x = nlohmann::json::array();
        nlohmann::json y = nlohmann::json::array();
        // Lines over the same numbers keep the same points.
        for (const Eigen::Index i : points_to_keep(alike ? chart.lines : std::vector<ChartLine>{line})) {
            x.push_back(number(line.x[i]));
            // A logarithm of 0 is a gap.
            y.push_back(chart.logarithmic ? number(line.y[i], 0.0) : number(line.y[i]));
        }
        lines.push_back({{"name", line.name}, {"x", x}, {"y", y}});
    }
    return {{"title", chart.title},
            {"across", chart.across},
            {"up", chart.up},
            {"logarithmic", chart.logarithmic},
            {"lines", lines}};
}

nlohmann::json to_json(const MeshReport& report) {
    nlohmann::json json = {{"kind", plural(report.kind)},
                           {"vertices", report.vertices},
                           {"edges", report.edges},
                           {"faces", report.faces},
                           {"cells", report.cells},
                           {"components", report.components},
                           {"isolated_vertices", report.isolated_vertices},
                           {"boundary_edges", report.boundary_edges},
                           {"boundary_loops", report.boundary_loops},
                           {"boundary_faces", report.boundary_faces},
                           {"boundary_vertices", report.boundary_vertices},
                           {"non_manifold_edges", report.non_manifold_edges},
                           {"non_manifold_vertices", report.non_manifold_vertices},
                           {"turned_edges", report.turned_edges},
                           {"duplicate_cells", report.duplicate_cells},
                           {"repeated_positions", report.repeated_positions},
                           {"degenerate_cells", report.degenerate_cells},
                           {"sliver_cells", report.sliver_cells},
                           {"inverted_cells", report.inverted_cells},
                           {"non_delaunay_edges", report.non_delaunay_edges},
                           {"manifold", report.manifold},
                           {"orientable", report.orientable},
                           {"euler_characteristic", report.euler_characteristic},
                           {"genus", nullptr},
                           {"smallest_angle", report.smallest_angle},
                           {"largest_angle", report.largest_angle},
                           {"shortest_edge", report.shortest_edge},
                           {"mean_edge", report.mean_edge},
                           {"longest_edge", report.longest_edge},
                           {"measure", report.measure},
                           {"lower", report.lower},
                           {"upper", report.upper},
                           {"fields", report.field_names},
                           {"notes", report.notes},
                           {"memory_bytes", report.memory_bytes}};
    if (report.genus) json["genus"] = *report.genus;
    return json;
}

}  // namespace beltrami::view
