// Meshes that are refined in one part and untouched in another: the same surface with more vertices elsewhere.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami::testing {

/// Triangles with all corners where `there(point)` holds are split in four; their neighbours are cut so that no edge is
/// left with a vertex in its middle. The old vertices keep their numbers, and the surface stays the same.
template <class There>
Mesh refined_where(const Mesh& mesh, There there) {
    std::vector<char> inside(static_cast<std::size_t>(mesh.vertex_count()));
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        inside[static_cast<std::size_t>(v)] = there(Vector3(mesh.points().row(v).transpose())) ? 1 : 0;
    std::map<std::pair<Index, Index>, Index> middles;
    const auto key = [](Index a, Index b) { return std::pair(std::min(a, b), std::max(a, b)); };
    Index count = mesh.vertex_count();
    for (Index t = 0; t < mesh.cell_count(); ++t) {
        bool all = true;
        for (int k = 0; k < 3; ++k)
            all = all && inside[static_cast<std::size_t>(mesh.cells()(t, k))] != 0;
        if (!all) continue;
        for (int k = 0; k < 3; ++k)
            count +=
                middles.emplace(key(mesh.cells()(t, k), mesh.cells()(t, (k + 1) % 3)), count).second ? 1 : 0;
    }
    Points points(count, 3);
    points.topRows(mesh.vertex_count()) = mesh.points();
    for (const auto& [edge, v] : middles)
        points.row(v) = 0.5 * (mesh.points().row(edge.first) + mesh.points().row(edge.second));

    std::vector<std::array<Index, 3>> cells;
    for (Index t = 0; t < mesh.cell_count(); ++t) {
        std::array<Index, 3> corner{};
        std::array<Index, 3> middle{};  // of the edge after each corner, or -1
        int split = 0;
        for (int k = 0; k < 3; ++k) {
            const auto at = static_cast<std::size_t>(k);
            corner[at] = mesh.cells()(t, k);
            const auto found = middles.find(key(mesh.cells()(t, k), mesh.cells()(t, (k + 1) % 3)));
            middle[at] = found == middles.end() ? -1 : found->second;
            split += middle[at] >= 0 ? 1 : 0;
        }
        // Turned so that a lone split edge comes first, a lone whole one last.
        while (split > 0 && split < 3 && !(middle[0] >= 0 && middle[2] < 0)) {
            std::rotate(corner.begin(), corner.begin() + 1, corner.end());
            std::rotate(middle.begin(), middle.begin() + 1, middle.end());
        }
        const auto [a, b, c] = corner;
        if (split == 0) cells.push_back({a, b, c});
        if (split == 1) cells.insert(cells.end(), {{a, middle[0], c}, {middle[0], b, c}});
        if (split == 2) {
            cells.insert(cells.end(),
                         {{middle[0], b, middle[1]}, {a, middle[0], c}, {middle[0], middle[1], c}});
        }
        if (split == 3) {
            cells.insert(cells.end(), {{a, middle[0], middle[2]},
                                       {middle[0], b, middle[1]},
                                       {middle[2], middle[1], c},
                                       {middle[0], middle[1], middle[2]}});
        }
    }
    Cells table(std::ssize(cells), 3);
    for (Eigen::Index t = 0; t < table.rows(); ++t) {
        for (int k = 0; k < 3; ++k)
            table(t, k) = cells[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)];
    }
    return Mesh(std::move(points), std::move(table));
}

/// What a local solve or step took, none of which may depend on what the mesh is like elsewhere.
struct Cost {
    Index active, slots;
    int rounds, iterations;
    long products;
    double bytes;
    bool operator==(const Cost&) const = default;
};
template <class Summary>
Cost cost_of(const Summary& s) {
    return {s.active, s.slots, s.rounds, s.iterations, s.products, s.bytes};
}

}  // namespace beltrami::testing
