#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <utility>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/renumbering.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/framework/shapes/building.hpp"
#include "beltrami/framework/sides.hpp"

namespace beltrami::shapes {

namespace {

double mean_edge(const Mesh& mesh) {
    const EdgeGraph graph(mesh.vertex_count(), mesh.cells());
    if (graph.edge_count() == 0) {
        throw InputError("noise is measured in edge lengths, but the mesh has no edges",
                         "give a mesh of segments, triangles or tetrahedra");
    }
    return edge_lengths(graph, mesh.points()).mean();
}

/// Vertices moved by amount x (mean edge) times what `displacement(v)` gives, a vector of at most length 1.
template <class Displacement>
Mesh moved(const Mesh& mesh, double amount, Displacement displacement) {
    if (!(amount >= 0.0 && std::isfinite(amount))) {
        throw InputError(fmt::format("the amount of noise cannot be {}", amount), "give 0 or more");
    }
    const double length = amount * mean_edge(mesh);
    Points points = mesh.points();
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        points.row(v) += length * displacement(v).transpose();
    return mesh.with_points(std::move(points));
}

/// 0, 1, ..., count - 1 in random order (Fisher & Yates).
std::vector<Index> random_order(Index count, Random& random) {
    std::vector<Index> order(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    for (Index i = count - 1; i > 0; --i) {
        std::swap(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(random.below(i + 1))]);
    }
    return order;
}

}  // namespace

Mesh with_noise(const Mesh& mesh, double amount, std::uint32_t seed) {
    Random random(seed);
    return moved(mesh, amount, [&](Index /*v*/) { return random.in_ball(); });
}

Mesh jittered(const Mesh& flat, double amount, std::uint32_t seed) {
    if (flat.kind() != CellKind::triangle || !flat.points().col(2).isZero(0.0)) {
        throw InputError("only a flat mesh of triangles in the plane z = 0 can be jittered",
                         "use with_noise for any other");
    }
    std::vector<bool> stays(static_cast<std::size_t>(flat.vertex_count()), false);
    const Cells rim = boundary(Sides(proper_cells(flat), flat.vertex_count()));
    for (const Index v : rim.reshaped()) {
        stays[static_cast<std::size_t>(v)] = true;
    }
    Random random(seed);
    return moved(flat, amount, [&](Index v) -> Vector3 {
        const Vector3 step = random.in_disc();
        return stays[static_cast<std::size_t>(v)] ? Vector3::Zero() : step;
    });
}

Shuffled shuffled(const Mesh& mesh, std::uint32_t seed) {
    Random random(seed);
    std::vector<Index> new_number = random_order(mesh.vertex_count(), random);
    const Mesh renumbered = Renumbering(new_number).to_working(mesh);
    if (mesh.kind() == CellKind::point) return {renumbered, std::move(new_number)};
    const std::vector<Index> cell_order = random_order(mesh.cell_count(), random);
    return {Mesh(renumbered.points(), renumbered.cells()(cell_order, Eigen::all), renumbered.fields()),
            std::move(new_number)};
}

Mesh together(const std::vector<Mesh>& meshes) {
    if (meshes.empty()) throw InputError("there are no meshes to put together", "give one or more");
    Eigen::Index vertices = 0;
    Eigen::Index cells = 0;
    for (const Mesh& mesh : meshes) {
        if (mesh.kind() != meshes.front().kind()) {
            throw InputError(fmt::format("{} and {} cannot be one mesh", plural(meshes.front().kind()),
                                         plural(mesh.kind())),
                             "put together meshes of one kind");
        }
        vertices += mesh.vertex_count();
        cells += mesh.cell_count();
    }
    require_size(static_cast<double>(vertices));
    Points points(vertices, 3);
    Cells all(cells, meshes.front().cells().cols());
    Index first = 0;
    Eigen::Index cell = 0;
    for (const Mesh& mesh : meshes) {
        points.middleRows(first, mesh.vertex_count()) = mesh.points();
        all.middleRows(cell, mesh.cell_count()) = mesh.cells().array() + first;
        first += mesh.vertex_count();
        cell += mesh.cell_count();
    }
    if (meshes.front().kind() == CellKind::point) return Mesh(std::move(points));
    return {std::move(points), std::move(all)};
}

}  // namespace beltrami::shapes
