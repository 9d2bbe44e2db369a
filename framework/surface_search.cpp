// CGAL compiles slowly, so it keeps to this file.
#include "beltrami/framework/surface_search.hpp"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <utility>
#include <vector>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/sides.hpp"

namespace beltrami {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using AabbTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Cells surface_of(const Mesh& mesh) {
    if (mesh.kind() == CellKind::triangle) return non_degenerate_cells(mesh);
    if (mesh.kind() == CellKind::tetrahedron)
        return boundary(Sides(non_degenerate_cells(mesh), mesh.vertex_count()));
    return Cells(0, 3);
}

}  // namespace

struct SurfaceSearch::Tree {
    explicit Tree(const Mesh& mesh) : cells(surface_of(mesh)), points(mesh.points()) {
        const auto corner = [&](Eigen::Index cell, int k) {
            const Vector3 p = points.row(cells(cell, k)).transpose();
            return Kernel::Point_3(p.x(), p.y(), p.z());
        };
        triangles.reserve(static_cast<std::size_t>(cells.rows()));
        for (Eigen::Index c = 0; c < cells.rows(); ++c)
            triangles.emplace_back(corner(c, 0), corner(c, 1), corner(c, 2));
        tree.insert(triangles.begin(), triangles.end());
        tree.build();
        tree.accelerate_distance_queries();
    }

    Cells cells;
    Points points;
    Triangles triangles;
    AabbTree tree;
};

SurfaceSearch::SurfaceSearch(const Mesh& mesh) : tree_(std::make_unique<const Tree>(mesh)) {
    if (tree_->cells.rows() == 0) {
        throw InputError("the mesh has no surface to touch", "use triangles or tetrahedra with an area");
    }
}
SurfaceSearch::SurfaceSearch(SurfaceSearch&&) noexcept = default;
SurfaceSearch& SurfaceSearch::operator=(SurfaceSearch&&) noexcept = default;
SurfaceSearch::~SurfaceSearch() = default;

SurfacePoint SurfaceSearch::closest(const Vector3& point) const {
    if (!point.allFinite()) {
        throw InputError(fmt::format("the point ({}, {}, {}) is nowhere", point.x(), point.y(), point.z()),
                         "give finite coordinates");
    }
    const auto [found, triangle] = tree_->tree.closest_point_and_primitive({point.x(), point.y(), point.z()});
    const auto cell = triangle - tree_->triangles.begin();
    SurfacePoint result;
    Eigen::Matrix3d corner;
    for (int k = 0; k < 3; ++k) {
        result.vertices[static_cast<std::size_t>(k)] = tree_->cells(cell, k);
        corner.row(k) = tree_->points.row(tree_->cells(cell, k));
    }
    // Areas of the parts that the point cuts the triangle into, along its normal.
    const Eigen::RowVector3d at(found.x(), found.y(), found.z());
    const Eigen::RowVector3d normal = (corner.row(1) - corner.row(0)).cross(corner.row(2) - corner.row(0));
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double part = (corner.row((k + 1) % 3) - at).cross(corner.row((k + 2) % 3) - at).dot(normal);
        result.weights[static_cast<std::size_t>(k)] = std::max(0.0, part);
        sum += std::max(0.0, part);
    }
    for (double& weight : result.weights)
        weight /= sum;
    for (int k = 0; k < 3; ++k)
        result.point += result.weights[static_cast<std::size_t>(k)] * corner.row(k).transpose();
    result.distance = (result.point - point).norm();
    return result;
}

}  // namespace beltrami
