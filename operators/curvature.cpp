#include "beltrami/operators/curvature.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// Vertices of edges that only one non-degenerate triangle has.
std::vector<char> on_boundary(const Mesh& mesh) {
    const EdgeGraph graph(mesh.vertex_count(), mesh.cells());
    std::vector<Index> triangles(static_cast<std::size_t>(graph.edge_count()), 0);
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (is_degenerate(mesh, c)) continue;
        for (int k = 0; k < 3; ++k) {
            const Index e = graph.find_edge(mesh.cells()(c, k), mesh.cells()(c, (k + 1) % 3));
            ++triangles[static_cast<std::size_t>(e)];
        }
    }
    std::vector<char> boundary(static_cast<std::size_t>(mesh.vertex_count()), 0);
    for (Index e = 0; e < graph.edge_count(); ++e) {
        if (triangles[static_cast<std::size_t>(e)] != 1) continue;
        boundary[static_cast<std::size_t>(graph.lower(e))] = 1;
        boundary[static_cast<std::size_t>(graph.upper()[static_cast<std::size_t>(e)])] = 1;
    }
    return boundary;
}

}  // namespace

MeanCurvature mean_curvature(const Mesh& mesh, const Laplacian& laplacian, CurvatureCorrection correction) {
    if (mesh.kind() != CellKind::triangle) {
        throw InputError(fmt::format("mean curvature needs triangles, but the mesh has {}", plural(mesh.kind())));
    }
    Vector area = Vector::Zero(mesh.vertex_count());
    Points normal = Points::Zero(mesh.vertex_count(), 3);
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (is_degenerate(mesh, c)) continue;
        const Eigen::RowVector3d p = mesh.points().row(mesh.cells()(c, 0));
        const Eigen::RowVector3d a = mesh.points().row(mesh.cells()(c, 1)) - p;
        const Eigen::RowVector3d b = mesh.points().row(mesh.cells()(c, 2)) - p;
        const Eigen::RowVector3d doubled = a.cross(b);
        for (int k = 0; k < 3; ++k) {
            area[mesh.cells()(c, k)] += 0.5 * doubled.norm();
            normal.row(mesh.cells()(c, k)) += doubled;
        }
    }
    Block working;
    laplacian.stiffness().apply(laplacian.order().to_working(Block(mesh.points())), working);
    const Block stretched = laplacian.order().to_user(working);
    const std::vector<char> boundary = on_boundary(mesh);

    MeanCurvature result{Points::Zero(mesh.vertex_count(), 3), Vector::Zero(mesh.vertex_count()), 0};
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (boundary[static_cast<std::size_t>(v)] != 0) {
            ++result.boundary_vertices;
            continue;
        }
        if (area[v] <= 0.0) continue;
        const Index valence = laplacian.graph().degree(laplacian.order().working(v));
        const double cosine = std::cos(std::numbers::pi / valence);
        const double factor = correction == CurvatureCorrection::c1 ? 4.0 * cosine * cosine / area[v] : 3.0 / area[v];
        result.normal.row(v) = -factor * stretched.row(v);
        const double convex = result.normal.row(v).dot(normal.row(v)) > 0.0 ? -1.0 : 1.0;
        result.mean[v] = convex * 0.5 * result.normal.row(v).norm();
    }
    return result;
}

}  // namespace beltrami
