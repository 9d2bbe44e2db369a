#include "beltrami/framework/boundary.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/sides.hpp"

namespace beltrami {

std::vector<Index> boundary_vertices(const Mesh& mesh) {
    if (mesh.kind() == CellKind::point) return {};
    const Cells rim = boundary(Sides(non_degenerate_cells(mesh), mesh.vertex_count()));
    std::vector<Index> vertices(rim.data(), rim.data() + rim.size());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

Cells boundary_triangles(const Mesh& tetrahedra) {
    if (tetrahedra.kind() != CellKind::tetrahedron) {
        throw InputError(fmt::format("{} have no faces on a boundary", plural(tetrahedra.kind())),
                         "give a mesh of tetrahedra");
    }
    const Cells cells = proper_cells(tetrahedra);
    const Sides sides(cells, tetrahedra.vertex_count());
    // Seen from outside where the tetrahedron's volume is positive, opposite to each corner.
    constexpr Index faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    const auto point = [&](Index c, int k) -> Vector3 {
        return tetrahedra.points().row(cells(c, k)).transpose();
    };
    std::vector<Index> places;
    for (Index s = 0; s < sides.count(); ++s) {
        if (sides.places(s).size() == 1) places.push_back(sides.places(s).front());
    }
    Cells triangles(static_cast<Eigen::Index>(places.size()), 3);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Index c = sides.cell(places[i]);
        const Vector3 p = point(c, 0);
        const bool inverted = (point(c, 1) - p).cross(point(c, 2) - p).dot(point(c, 3) - p) < 0.0;
        auto triangle = triangles.row(static_cast<Eigen::Index>(i));
        for (int k = 0; k < 3; ++k)
            triangle[k] = cells(c, faces[sides.corner(places[i])][k]);
        if (inverted) std::swap(triangle[1], triangle[2]);
    }
    return triangles;
}

}  // namespace beltrami
