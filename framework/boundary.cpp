#include "beltrami/framework/boundary.hpp"

#include <algorithm>

#include "beltrami/framework/cell_geometry.hpp"
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

}  // namespace beltrami
