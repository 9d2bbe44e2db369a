#include "beltrami/operators/mass.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// The share of each corner in a triangle's area.
std::array<double, 3> voronoi_shares(const Mesh& mesh, Index cell) {
    const double area = signed_measure(mesh, cell);
    std::array<double, 3> squared{};  // length of the edge opposite to the corner
    for (int k = 0; k < 3; ++k) {
        squared[k] = (mesh.points().row(mesh.cells()(cell, (k + 1) % 3)) -
                      mesh.points().row(mesh.cells()(cell, (k + 2) % 3)))
                         .squaredNorm();
    }
    for (int k = 0; k < 3; ++k) {
        if (squared[k] > squared[(k + 1) % 3] + squared[(k + 2) % 3]) {
            std::array<double, 3> obtuse = {area / 4.0, area / 4.0, area / 4.0};
            obtuse[k] = area / 2.0;
            return obtuse;
        }
    }
    const auto cotangent = [&](int k) {
        return (squared[(k + 1) % 3] + squared[(k + 2) % 3] - squared[k]) / (4.0 * area);
    };
    std::array<double, 3> shares{};
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3;
        const int b = (k + 2) % 3;
        shares[k] = (squared[a] * cotangent(a) + squared[b] * cotangent(b)) / 8.0;
    }
    return shares;
}

void require_cells(const Mesh& mesh) {
    if (mesh.kind() == CellKind::point) {
        throw InputError("the mesh is points alone: mass needs segments, triangles or tetrahedra",
                         "triangulate the points first");
    }
}

}  // namespace

Vector lumped_mass(const Mesh& mesh, Mass kind) {
    require_cells(mesh);
    if (kind == Mass::voronoi && mesh.kind() == CellKind::tetrahedron) {
        throw InputError("Voronoi mass is not offered for tetrahedra: it can be negative",
                         "use barycentric mass");
    }
    const Eigen::Index corners = mesh.cells().cols();
    Vector mass = Vector::Zero(mesh.vertex_count());
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (is_degenerate(mesh, c)) continue;
        if (kind == Mass::voronoi && mesh.kind() == CellKind::triangle) {
            const auto shares = voronoi_shares(mesh, c);
            for (int k = 0; k < 3; ++k)
                mass[mesh.cells()(c, k)] += shares[k];
        } else {
            const double share = std::abs(signed_measure(mesh, c)) / static_cast<double>(corners);
            for (Eigen::Index k = 0; k < corners; ++k)
                mass[mesh.cells()(c, k)] += share;
        }
    }
    return mass;
}

EdgeOperator<double> consistent_mass(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph) {
    require_cells(mesh);
    Vector diagonal = Vector::Zero(graph->vertex_count());
    Vector edges = Vector::Zero(graph->edge_count());
    const Eigen::Index corners = mesh.cells().cols();
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (is_degenerate(mesh, c)) continue;
        const double entry = std::abs(signed_measure(mesh, c)) /
                             (static_cast<double>(corners) * static_cast<double>(corners + 1));
        for (Eigen::Index a = 0; a < corners; ++a) {
            for (Eigen::Index b = a + 1; b < corners; ++b) {
                edges[graph->require_edge(mesh.cells()(c, a), mesh.cells()(c, b))] += entry;
            }
        }
        for (Eigen::Index a = 0; a < corners; ++a)
            diagonal[mesh.cells()(c, a)] += 2.0 * entry;
    }
    return {std::move(graph), std::move(diagonal), std::move(edges)};
}

}  // namespace beltrami
