#include "beltrami/operators/stiffness.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/operators/cell_gradients.hpp"

namespace beltrami {

namespace {

using ElementMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 4, 4>;

ElementMatrix gradient_element(const Mesh& mesh, Index cell) {
    const CellGradients gradients = cell_gradients(mesh, cell);
    return std::abs(signed_measure(mesh, cell)) * (gradients * gradients.transpose());
}

// Off-diagonal entries are added as the element gives them; the diagonal is minus their sum, so that constants are in
// the null space to the last bit that summation allows.
template <class Element>
EdgeOperator<double> assemble(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph, Element element) {
    Vector diagonal = Vector::Zero(graph->vertex_count());
    Vector edges = Vector::Zero(graph->edge_count());
    const Eigen::Index corners = mesh.cells().cols();
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (is_degenerate(mesh, c)) continue;
        const ElementMatrix local = element(c);
        for (Eigen::Index a = 0; a < corners; ++a) {
            for (Eigen::Index b = a + 1; b < corners; ++b) {
                const Index i = mesh.cells()(c, a);
                const Index j = mesh.cells()(c, b);
                edges[graph->require_edge(i, j)] += local(a, b);
                diagonal[i] -= local(a, b);
                diagonal[j] -= local(a, b);
            }
        }
    }
    return {std::move(graph), std::move(diagonal), std::move(edges)};
}

void require(const Mesh& mesh, CellKind kind, const char* what) {
    if (mesh.kind() != kind) {
        throw InputError(
            fmt::format("{} needs {}, but the mesh has {}", what, plural(kind), plural(mesh.kind())),
            "stiffness() takes cells of any kind");
    }
}

[[noreturn]] void refuse_points() {
    throw InputError("the mesh is points alone: an operator needs segments, triangles or tetrahedra",
                     "triangulate the points first");
}

}  // namespace

// Row k of 2 A B_s is the edge opposite to corner k, so no division by an angle is needed.
Eigen::Matrix3d cotangent_element(const Mesh& mesh, Index cell) {
    Eigen::Matrix3d opposite;
    for (int k = 0; k < 3; ++k) {
        opposite.row(k) = mesh.points().row(mesh.cells()(cell, (k + 1) % 3)) -
                          mesh.points().row(mesh.cells()(cell, (k + 2) % 3));
    }
    return opposite * opposite.transpose() / (4.0 * signed_measure(mesh, cell));
}

EdgeOperator<double> cotangent_stiffness(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph) {
    require(mesh, CellKind::triangle, "the cotangent stiffness");
    return assemble(mesh, std::move(graph), [&](Index c) { return cotangent_element(mesh, c); });
}

EdgeOperator<double> tetrahedral_stiffness(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph) {
    require(mesh, CellKind::tetrahedron, "the tetrahedral stiffness");
    return assemble(mesh, std::move(graph), [&](Index c) { return gradient_element(mesh, c); });
}

EdgeOperator<double> stiffness(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph) {
    switch (mesh.kind()) {
        case CellKind::triangle:
            return cotangent_stiffness(mesh, std::move(graph));
        case CellKind::tetrahedron:
            return tetrahedral_stiffness(mesh, std::move(graph));
        case CellKind::segment:
            return assemble(mesh, std::move(graph), [&](Index c) { return gradient_element(mesh, c); });
        case CellKind::point:
            break;
    }
    refuse_points();
}

EdgeOperator<double> area_weighted_stiffness(const Mesh& mesh, std::shared_ptr<const EdgeGraph> graph) {
    if (mesh.kind() == CellKind::point) refuse_points();
    return assemble(mesh, std::move(graph), [&](Index c) -> ElementMatrix {
        return std::abs(signed_measure(mesh, c)) * gradient_element(mesh, c);
    });
}

EdgeOperator<double> combinatorial_stiffness(std::shared_ptr<const EdgeGraph> graph) {
    Vector diagonal(graph->vertex_count());
    for (Index i = 0; i < graph->vertex_count(); ++i)
        diagonal[i] = graph->degree(i);
    Vector edges = Vector::Constant(graph->edge_count(), -1.0);
    return {std::move(graph), std::move(diagonal), std::move(edges)};
}

}  // namespace beltrami
