#include "beltrami/operators/curvature.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "beltrami/framework/boundary.hpp"
#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

MeanCurvature mean_curvature(const Mesh& mesh, const Laplacian& laplacian, CurvatureCorrection correction) {
    if (mesh.kind() != CellKind::triangle) {
        throw InputError(
            fmt::format("mean curvature needs triangles, but the mesh has {}", plural(mesh.kind())),
            "give the surface of the solid as triangles");
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
    // On the boundary K x is the pull of the rim, not curvature.
    const std::vector<Index> boundary = boundary_vertices(mesh);
    for (const Index v : boundary)
        area[v] = 0.0;

    MeanCurvature result{Points::Zero(mesh.vertex_count(), 3), Vector::Zero(mesh.vertex_count()),
                         static_cast<Index>(boundary.size())};
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (area[v] <= 0.0) continue;
        const Index valence = laplacian.graph().degree(laplacian.order().working(v));
        const double cosine = std::cos(std::numbers::pi / valence);
        const double factor =
            correction == CurvatureCorrection::c1 ? 4.0 * cosine * cosine / area[v] : 3.0 / area[v];
        result.normal.row(v) = -factor * stretched.row(v);
        const double convex = result.normal.row(v).dot(normal.row(v)) > 0.0 ? -1.0 : 1.0;
        result.mean[v] = convex * 0.5 * result.normal.row(v).norm();
    }
    return result;
}

}  // namespace beltrami
