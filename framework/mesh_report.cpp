#include "beltrami/framework/mesh_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string_view>
#include <utility>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/orientation.hpp"
#include "beltrami/framework/sides.hpp"

namespace beltrami {

namespace {

constexpr double degree = std::numbers::pi / 180.0;

std::size_t at(Index i) {
    return static_cast<std::size_t>(i);
}

double angle_between(const Vector3& a, const Vector3& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Corner k's angle of a triangle, radians.
double corner_angle(const Mesh& mesh, Index cell, Index k) {
    const auto corner = [&](Index c) -> Vector3 {
        return mesh.points().row(mesh.cells()(cell, c % 3)).transpose();
    };
    return angle_between(corner(k + 1) - corner(k), corner(k + 2) - corner(k));
}

/// The dihedral angle of a tetrahedron at the edge between corners a < b, radians.
double dihedral_angle(const Mesh& mesh, Index cell, Index a, Index b) {
    const auto corner = [&](Index c) -> Vector3 {
        return mesh.points().row(mesh.cells()(cell, c)).transpose();
    };
    const Index c = a > 0 ? 0 : (b > 1 ? 1 : 2);
    const Index d = 6 - a - b - c;
    const Vector3 edge = corner(b) - corner(a);
    return angle_between(edge.cross(corner(c) - corner(a)), edge.cross(corner(d) - corner(a)));
}

/// The corner angles of a triangle, the dihedral angles of a tetrahedron, none of a segment; radians.
void angles_of(const Mesh& mesh, Index cell, std::vector<double>& angles) {
    angles.clear();
    if (mesh.kind() == CellKind::triangle) {
        for (Index k = 0; k < 3; ++k)
            angles.push_back(corner_angle(mesh, cell, k));
    } else if (mesh.kind() == CellKind::tetrahedron) {
        for (Index a = 0; a < 4; ++a) {
            for (Index b = a + 1; b < 4; ++b)
                angles.push_back(dihedral_angle(mesh, cell, a, b));
        }
    }
}

/// Measures, angles and degenerate cells. Returns the angles of all triangles, 3 k to 3 k + 2 those of
/// triangle k (the numbering of Sides' places), 0 in degenerate ones.
std::vector<double> measure_cells(const Mesh& mesh, MeshReport& r) {
    r.measure = cell_measures(mesh).sum();
    std::vector<double> corner_angles;
    std::vector<double> angles;
    double smallest = std::numbers::pi;
    double largest = 0.0;
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        angles_of(mesh, c, angles);
        if (is_degenerate(mesh, c)) {
            ++r.degenerate_cells;
            std::fill(angles.begin(), angles.end(), 0.0);
        } else if (!angles.empty()) {
            const auto [low, high] = std::minmax_element(angles.begin(), angles.end());
            if (*low < 1.0 * degree || *high > 178.0 * degree) ++r.sliver_cells;
            smallest = std::min(smallest, *low);
            largest = std::max(largest, *high);
        }
        if (mesh.kind() == CellKind::triangle) {
            corner_angles.insert(corner_angles.end(), angles.begin(), angles.end());
        } else if (mesh.kind() == CellKind::tetrahedron && signed_measure(mesh, c) < 0.0) {
            ++r.inverted_cells;
        }
    }
    if (largest > 0.0) {
        r.smallest_angle = smallest / degree;
        r.largest_angle = largest / degree;
    }
    return corner_angles;
}

void count_duplicates(const Mesh& mesh, MeshReport& r) {
    Cells sorted = mesh.cells();
    for (auto cell : sorted.rowwise())
        std::sort(cell.begin(), cell.end());
    r.duplicate_cells = mesh.cell_count() - EqualRows(sorted, mesh.vertex_count()).group_count();
}

Index count_repeated(const Points& points) {
    std::vector<std::array<double, 3>> places(static_cast<std::size_t>(points.rows()));
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto p = points.row(static_cast<Eigen::Index>(i));
        places[i] = {p.x(), p.y(), p.z()};
    }
    std::sort(places.begin(), places.end());
    return static_cast<Index>(places.end() - std::unique(places.begin(), places.end()));
}

/// Vertices that lie on no side of three cells or more and whose cells form several fans, not joined by
/// sides.
Index count_pinched(const Mesh& mesh, const Sides& sides, const Cells& crowded) {
    const auto corners = static_cast<Index>(mesh.cells().cols());
    const auto vertex = [&](Index place) { return mesh.cells()(sides.cell(place), sides.corner(place)); };
    // A forest over the corners of all cells; the corners of a fan come to have one root.
    std::vector<Index> parent(static_cast<std::size_t>(mesh.cells().size()));
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](Index i) {
        while (parent[at(i)] != i)
            i = parent[at(i)] = parent[at(parent[at(i)])];
        return i;
    };
    for (Index s = 0; s < sides.count(); ++s) {
        const auto places = sides.places(s);
        const Index first = sides.cell(places[0]) * corners;
        for (const Index place : places.subspan(1)) {
            const Index other = sides.cell(place) * corners;
            for (Index a = 0; a < corners; ++a) {
                for (Index b = 0; b < corners; ++b) {
                    if (first + a != places[0] && other + b != place &&
                        vertex(first + a) == vertex(other + b)) {
                        parent[at(root(first + a))] = root(other + b);
                    }
                }
            }
        }
    }
    std::vector<Index> fans(at(mesh.vertex_count()), 0);
    for (Index corner = 0; corner < static_cast<Index>(parent.size()); ++corner) {
        if (parent[at(corner)] == corner) ++fans[at(vertex(corner))];
    }
    for (const Index v : crowded.reshaped())
        fans[at(v)] = 0;
    return static_cast<Index>(std::count_if(fans.begin(), fans.end(), [](Index n) { return n > 1; }));
}

/// Boundary, manifoldness and components.
void examine_topology(const Mesh& mesh, const EdgeGraph& graph, const Sides& sides, MeshReport& r) {
    const Index n = mesh.vertex_count();
    for (Index v = 0; v < n; ++v)
        r.isolated_vertices += graph.degree(v) == 0 ? 1 : 0;
    r.components = connected_components(graph).count - r.isolated_vertices;
    r.edges = graph.edge_count();

    const Cells rim = boundary(sides);
    const Cells crowded = sides.vertices_where([](std::size_t cells) { return cells > 2; });
    const auto crowded_count = static_cast<Index>(crowded.rows());
    r.euler_characteristic = n - r.isolated_vertices - r.edges;
    if (mesh.kind() == CellKind::segment) {
        r.boundary_vertices = static_cast<Index>(rim.rows());
        r.non_manifold_vertices = crowded_count;
    } else {
        const EdgeGraph rim_graph(n, rim);
        r.boundary_edges = rim_graph.edge_count();
        for (Index v = 0; v < n; ++v)
            r.boundary_vertices += rim_graph.degree(v) > 0 ? 1 : 0;
        r.non_manifold_edges = crowded_count;
        r.non_manifold_vertices = count_pinched(mesh, sides, crowded);
        if (mesh.kind() == CellKind::triangle) {
            r.faces = mesh.cell_count();
            r.boundary_loops = connected_components(rim_graph).count - (n - r.boundary_vertices);
            r.euler_characteristic += r.faces;
        } else {
            r.faces = sides.count();
            r.boundary_faces = static_cast<Index>(rim.rows());
            r.euler_characteristic += r.faces - mesh.cell_count();
        }
    }
    r.manifold = r.non_manifold_edges == 0 && r.non_manifold_vertices == 0;
}

/// What only triangles have: turned and non-Delaunay edges, orientability, genus.
void examine_surface(const Mesh& mesh, const Sides& sides, const std::vector<double>& angles, MeshReport& r) {
    // The triangle's side at a place runs from the corner after it to the one before it.
    const auto start = [&](Index place) {
        return mesh.cells()(sides.cell(place), (sides.corner(place) + 1) % 3);
    };
    const auto turned = [&](Index a, Index b) { return start(a) == start(b); };
    // The diagonal of a split rectangle is no trouble, even with the few digits of a file.
    constexpr double most = 180.0001 * degree;
    for (Index s = 0; s < sides.count(); ++s) {
        const auto places = sides.places(s);
        if (places.size() != 2) continue;
        if (turned(places[0], places[1])) ++r.turned_edges;
        if (angles[at(places[0])] + angles[at(places[1])] > most) ++r.non_delaunay_edges;
    }
    r.orientable = !orientation(mesh.cells(), sides).one_sided;
    if (r.manifold && r.orientable && mesh.cell_count() > 0) {
        r.genus = (2 * r.components - r.boundary_loops - r.euler_characteristic) / 2;
    }
}

/// Everything that cells decide; no cell names a vertex twice.
MeshReport examine_cells(const Mesh& mesh) {
    MeshReport r;
    const EdgeGraph graph(mesh.vertex_count(), mesh.cells());
    const Sides sides(mesh.cells(), mesh.vertex_count());
    examine_topology(mesh, graph, sides, r);
    const std::vector<double> angles = measure_cells(mesh, r);
    if (mesh.kind() == CellKind::triangle) examine_surface(mesh, sides, angles, r);
    count_duplicates(mesh, r);
    if (graph.edge_count() > 0) {
        const Vector lengths = edge_lengths(graph, mesh.points());
        r.shortest_edge = lengths.minCoeff();
        r.mean_edge = lengths.mean();
        r.longest_edge = lengths.maxCoeff();
    }
    return r;
}

MeshReport examine(const Mesh& mesh) {
    if (mesh.kind() == CellKind::point) {
        MeshReport r;
        r.manifold = true;
        r.euler_characteristic = mesh.vertex_count();
        return r;
    }
    Cells proper = proper_cells(mesh);
    const Index collapsed = mesh.cell_count() - static_cast<Index>(proper.rows());
    if (collapsed == 0) return examine_cells(mesh);
    MeshReport r = examine_cells(Mesh(mesh.points(), std::move(proper)));
    r.degenerate_cells += collapsed;
    return r;
}

std::string_view singular(CellKind kind) {
    switch (kind) {
        case CellKind::point:
            return "point";
        case CellKind::segment:
            return "segment";
        case CellKind::triangle:
            return "triangle";
        case CellKind::tetrahedron:
            return "tetrahedron";
    }
    return "cell";
}

std::string counted(Index n, std::string_view one, std::string_view many) {
    return fmt::format("{} {}", n, n == 1 ? one : many);
}
std::string counted(Index n, std::string_view one) {
    return counted(n, one, std::string(one) + "s");
}
std::string counted_vertices(Index n, std::string_view adjective = {}) {
    return counted(n, fmt::format("{}vertex", adjective), fmt::format("{}vertices", adjective));
}
std::string counted_cells(Index n, CellKind kind, std::string_view adjective = {}) {
    return counted(n, fmt::format("{}{}", adjective, singular(kind)),
                   fmt::format("{}{}", adjective, plural(kind)));
}

/// What can make a solver slow or wrong, and what each means; only what there is.
std::vector<std::string> troubles(const MeshReport& r) {
    std::vector<std::string> lines;
    const auto add = [&](Index count, const std::string& what, std::string_view why) {
        if (count > 0) lines.push_back(fmt::format("{}: {}", what, why));
    };
    const bool solid = r.kind == CellKind::tetrahedron;
    add(r.isolated_vertices, counted_vertices(r.isolated_vertices, "isolated "),
        fmt::format("in no {} that has all its corners", singular(r.kind)));
    add(r.non_manifold_edges,
        counted(r.non_manifold_edges, solid ? "non-manifold face" : "non-manifold edge"),
        fmt::format("three {} or more meet there", plural(r.kind)));
    add(r.non_manifold_vertices, counted_vertices(r.non_manifold_vertices, "non-manifold "),
        fmt::format("parts of the mesh meet there that share no {}",
                    r.kind == CellKind::segment ? "way through" : (solid ? "face" : "edge")));
    add(r.turned_edges, counted(r.turned_edges, "turned edge"), "the two triangles face opposite ways");
    add(r.duplicate_cells, counted_cells(r.duplicate_cells, r.kind, "duplicate "),
        "on the vertices of an earlier one, so counted twice");
    add(r.repeated_positions, counted(r.repeated_positions, "repeated position"),
        "vertices at the place of an earlier one, perhaps cracks");
    add(r.degenerate_cells, counted_cells(r.degenerate_cells, r.kind, "degenerate "),
        "without extent, so operators leave them out");
    add(r.sliver_cells, counted(r.sliver_cells, "sliver"), "an angle below 1 or above 178 degrees");
    add(r.inverted_cells, counted_cells(r.inverted_cells, r.kind, "inverted "), "of negative volume");
    add(r.non_delaunay_edges, counted(r.non_delaunay_edges, "non-Delaunay edge"),
        "opposite angles of more than 180 degrees together: negative cotangent weights");
    return lines;
}

std::string boundary_text(const MeshReport& r) {
    switch (r.kind) {
        case CellKind::point:
            return {};
        case CellKind::segment:
            return r.boundary_vertices == 0 ? "closed" : counted(r.boundary_vertices, "end");
        case CellKind::triangle:
            return r.boundary_edges == 0 ? "closed" : counted(r.boundary_loops, "boundary loop");
        case CellKind::tetrahedron:
            return counted(r.boundary_faces, "boundary triangle");
    }
    return {};
}

std::string topology_text(const MeshReport& r) {
    if (!r.manifold) return "not manifold";
    if (r.kind != CellKind::triangle) return "manifold";
    if (!r.orientable) return "not orientable";
    return fmt::format("genus {}", r.genus.value_or(0));
}

}  // namespace

MeshReport report(const Mesh& mesh) {
    MeshReport r = examine(mesh);
    r.kind = mesh.kind();
    r.vertices = mesh.vertex_count();
    r.cells = mesh.cell_count();
    r.repeated_positions = count_repeated(mesh.points());
    if (mesh.vertex_count() > 0) {
        Eigen::Map<Eigen::RowVector3d>(r.lower.data()) = mesh.points().colwise().minCoeff();
        Eigen::Map<Eigen::RowVector3d>(r.upper.data()) = mesh.points().colwise().maxCoeff();
    }
    for (const Field& field : mesh.fields())
        r.field_names.push_back(field.name);
    r.notes = mesh.notes();
    r.memory_bytes = mesh.memory_bytes();
    return r;
}

std::string brief_report(const MeshReport& report) {
    if (report.kind == CellKind::point) return counted(report.vertices, "point");
    std::vector<std::string> parts{counted_vertices(report.vertices),
                                   counted_cells(report.cells, report.kind)};
    if (report.cells > 0) {
        parts.push_back(counted(report.components, "component"));
        parts.push_back(boundary_text(report));
        // Of curves and solids one expects no less than that they are manifold.
        if (report.kind == CellKind::triangle || !report.manifold) parts.push_back(topology_text(report));
    }
    return fmt::format("{}", fmt::join(parts, ", "));
}

std::string full_report(const MeshReport& report) {
    std::string text;
    const auto line = [&](std::string_view name, const std::string& value) {
        text += fmt::format("{:<12}  {}\n", name, value);
    };
    const MeshReport& r = report;
    const bool has_cells = r.kind != CellKind::point && r.cells > 0;
    line("vertices", fmt::format("{}", r.vertices));
    if (r.kind != CellKind::point) line(plural(r.kind), fmt::format("{}", r.cells));
    if (has_cells) {
        if (r.kind == CellKind::tetrahedron) line("faces", fmt::format("{}", r.faces));
        line("edges", fmt::format("{}", r.edges));
        line("components", fmt::format("{}", r.components));
        const bool open_surface = r.kind == CellKind::triangle && r.boundary_edges > 0;
        line("boundary", open_surface ? fmt::format("{}, {}", counted(r.boundary_loops, "loop"),
                                                    counted(r.boundary_edges, "edge"))
                                      : boundary_text(r));
        line("topology",
             fmt::format("{}, Euler characteristic {}", topology_text(r), r.euler_characteristic));
    }
    if (r.vertices > 0) {
        line("box", fmt::format("({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g})", r.lower[0],
                                r.lower[1], r.lower[2], r.upper[0], r.upper[1], r.upper[2]));
    }
    if (has_cells) {
        const std::array<std::string_view, 3> names{"length", "area", "volume"};
        line(names[static_cast<std::size_t>(r.kind) - 2], fmt::format("{:.6g}", r.measure));
        line("edge length",
             fmt::format("{:.4g} to {:.4g}, mean {:.4g}", r.shortest_edge, r.longest_edge, r.mean_edge));
        if (r.largest_angle > 0.0) {
            line(r.kind == CellKind::triangle ? "angles" : "dihedrals",
                 fmt::format("{:.3g} to {:.4g} degrees", r.smallest_angle, r.largest_angle));
        }
    }
    if (!r.field_names.empty()) line("fields", fmt::format("{}", fmt::join(r.field_names, ", ")));
    line("memory", fmt::format("{:.1f} MB", static_cast<double>(r.memory_bytes) / 1e6));
    for (const std::string& trouble : troubles(r))
        line("trouble", trouble);
    for (const std::string& note : r.notes)
        line("note", note);
    return text;
}

}  // namespace beltrami
