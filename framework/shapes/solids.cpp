#include <algorithm>
#include <array>

#include "beltrami/framework/shapes.hpp"
#include "beltrami/framework/shapes/building.hpp"

namespace beltrami::shapes {

namespace {

/// The unit cube as n^3 little cubes, each cut in six tetrahedra around one of its diagonals (Kuhn 1960). That diagonal
/// rises along every axis; where `from_centre`, it points away from the middle of the whole cube, so that every
/// tetrahedron has a vertex inside. Neighbours meet either way, for they differ in one axis alone.
Mesh kuhn_cube(int n, bool from_centre) {
    require_at_least("cubes along an edge", n, 1);
    require_size((n + 1.0) * (n + 1.0) * (n + 1.0));
    MeshBuilder builder(CellKind::tetrahedron);
    for (int k = 0; k <= n; ++k) {
        for (int j = 0; j <= n; ++j) {
            for (int i = 0; i <= n; ++i)
                builder.vertex(Vector3(i, j, k) / n);
        }
    }
    const std::array<Index, 3> stride{1, n + 1, (n + 1) * (n + 1)};
    // The orders in which a path from one end of the diagonal to the other can take the axes; even ones first.
    constexpr std::array<std::array<std::size_t, 3>, 6> orders{
        {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
    for (int k = 0; k < n; ++k) {
        for (int j = 0; j < n; ++j) {
            for (int i = 0; i < n; ++i) {
                const std::array<int, 3> cube{i, j, k};
                Index start = 0;
                std::array<Index, 3> step{};
                bool mirrored = false;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const bool falls = from_centre && 2 * cube[axis] + 1 < n;
                    start += stride[axis] * (cube[axis] + (falls ? 1 : 0));
                    step[axis] = falls ? -stride[axis] : stride[axis];
                    mirrored ^= falls;
                }
                for (std::size_t o = 0; o < orders.size(); ++o) {
                    const auto& [first, second, third] = orders[o];
                    Index a = start + step[first];
                    Index b = a + step[second];
                    const Index end = b + step[third];
                    if (mirrored != (o >= 3)) std::swap(a, b);
                    builder.cell({start, a, b, end});
                }
            }
        }
    }
    return builder.mesh();
}

}  // namespace

Mesh tetrahedral_cube(int n) {
    return kuhn_cube(n, false);
}

Mesh tetrahedral_ball(int n, double radius) {
    require_positive("radius", radius);
    const Mesh cube = kuhn_cube(n, true);
    Points points = 2.0 * cube.points().array() - 1.0;
    for (auto p : points.rowwise()) {
        // Cubes around the centre become spheres.
        const double size = p.norm();
        if (size > 0.0) p *= radius * p.lpNorm<Eigen::Infinity>() / size;
    }
    return cube.with_points(std::move(points));
}

}  // namespace beltrami::shapes
