#include "beltrami/framework/cell_geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "beltrami/framework/edge_graph.hpp"

namespace beltrami {

double signed_measure(const Mesh& mesh, Index cell) {
    const auto corner = [&](int k) -> Vector3 {
        return mesh.points().row(mesh.cells()(cell, k)).transpose();
    };
    switch (mesh.kind()) {
        case CellKind::point:
            return 0.0;
        case CellKind::segment:
            return (corner(1) - corner(0)).norm();
        case CellKind::triangle:
            return 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
        case CellKind::tetrahedron:
            return (corner(1) - corner(0)).cross(corner(2) - corner(0)).dot(corner(3) - corner(0)) / 6.0;
    }
    return 0.0;
}

Vector cell_measures(const Mesh& mesh) {
    Vector measures(mesh.cell_count());
    for (Index c = 0; c < mesh.cell_count(); ++c)
        measures[c] = std::abs(signed_measure(mesh, c));
    return measures;
}

double longest_edge(const Mesh& mesh, Index cell) {
    double longest = 0.0;
    const Eigen::Index corners = mesh.cells().cols();
    for (Eigen::Index a = 0; a < corners; ++a) {
        for (Eigen::Index b = a + 1; b < corners; ++b) {
            const auto edge =
                mesh.points().row(mesh.cells()(cell, a)) - mesh.points().row(mesh.cells()(cell, b));
            longest = std::max(longest, edge.norm());
        }
    }
    return longest;
}

bool names_a_vertex_twice(const Mesh& mesh, Index cell) {
    const Eigen::Index corners = mesh.cells().cols();
    for (Eigen::Index a = 0; a < corners; ++a) {
        for (Eigen::Index b = a + 1; b < corners; ++b) {
            if (mesh.cells()(cell, a) == mesh.cells()(cell, b)) return true;
        }
    }
    return false;
}

bool is_degenerate(const Mesh& mesh, Index cell) {
    if (names_a_vertex_twice(mesh, cell)) return true;
    const double length = longest_edge(mesh, cell);
    return std::abs(signed_measure(mesh, cell)) <=
           1e-12 * std::pow(length, static_cast<double>(mesh.cells().cols() - 1));
}

Vector edge_lengths(const EdgeGraph& graph, const Points& points) {
    Vector lengths(graph.edge_count());
    for (Index i = 0; i < graph.vertex_count(); ++i) {
        for (const auto [j, edge] : graph.neighbours(i)) {
            if (i < j) lengths[edge] = (points.row(i) - points.row(j)).norm();
        }
    }
    return lengths;
}

Cells non_degenerate_cells(const Mesh& mesh) {
    std::vector<Index> kept;
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (!is_degenerate(mesh, c)) kept.push_back(c);
    }
    Cells cells(static_cast<Eigen::Index>(kept.size()), mesh.cells().cols());
    for (std::size_t c = 0; c < kept.size(); ++c)
        cells.row(static_cast<Eigen::Index>(c)) = mesh.cells().row(kept[c]);
    return cells;
}

}  // namespace beltrami
