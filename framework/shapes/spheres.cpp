#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/framework/shapes/building.hpp"

namespace beltrami::shapes {

namespace {

using std::numbers::pi;

constexpr Index south_pole = 11;  // of the icosahedron; 0 is its north pole

/// On the unit sphere, with a vertex at each pole of z.
Mesh icosahedron() {
    MeshBuilder builder;
    const double z = 1.0 / std::sqrt(5.0);
    const double r = 2.0 * z;
    builder.vertex({0, 0, 1});
    for (int i = 0; i < 5; ++i) {
        const double u = 2.0 * pi * i / 5.0;
        builder.vertex({r * std::cos(u), r * std::sin(u), z});
    }
    for (int i = 0; i < 5; ++i) {
        const double u = 2.0 * pi * (i + 0.5) / 5.0;
        builder.vertex({r * std::cos(u), r * std::sin(u), -z});
    }
    builder.vertex({0, 0, -1});
    for (Index i = 0; i < 5; ++i) {
        const Index next = (i + 1) % 5;
        builder.cell({0, 1 + i, 1 + next});
        builder.cell({1 + i, 6 + i, 1 + next});
        builder.cell({1 + next, 6 + i, 6 + next});
        builder.cell({south_pole, 6 + next, 6 + i});
    }
    return builder.mesh();
}

Mesh tetrahedron() {
    MeshBuilder builder;
    const double s = 1.0 / std::sqrt(3.0);
    for (const Vector3& corner :
         {Vector3(s, s, s), Vector3(s, -s, -s), Vector3(-s, s, -s), Vector3(-s, -s, s)}) {
        builder.vertex(corner);
    }
    builder.cell({0, 1, 2});
    builder.cell({0, 2, 3});
    builder.cell({0, 3, 1});
    builder.cell({1, 3, 2});
    return builder.mesh();
}

double icosphere_size(int levels) {
    return 10.0 * std::pow(4.0, levels) + 2.0;
}

/// Each triangle in four, by the middles of the edges pushed to the unit sphere.
Mesh split_in_four(const Mesh& sphere) {
    const EdgeGraph graph(sphere.vertex_count(), sphere.cells());
    const Index n = sphere.vertex_count();
    Points points(n + graph.edge_count(), 3);
    points.topRows(n) = sphere.points();
    for (Index i = 0; i < n; ++i) {
        for (const auto [j, edge] : graph.neighbours(i)) {
            if (i < j) points.row(n + edge) = (points.row(i) + points.row(j)).normalized();
        }
    }
    Cells cells(4 * sphere.cell_count(), 3);
    for (Index c = 0; c < sphere.cell_count(); ++c) {
        const auto corner = sphere.cells().row(c);
        const Index ab = n + graph.find_edge(corner[0], corner[1]);
        const Index bc = n + graph.find_edge(corner[1], corner[2]);
        const Index ca = n + graph.find_edge(corner[2], corner[0]);
        cells.middleRows<4>(4 * c) << corner[0], ab, ca, ab, corner[1], bc, ca, bc, corner[2], ab, bc, ca;
    }
    return {std::move(points), std::move(cells)};
}

/// The point at fraction t of the arc from a to b on the unit sphere (Shoemake 1985).
Vector3 along_arc(const Vector3& a, const Vector3& b, double t) {
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    return (std::sin((1.0 - t) * angle) * a + std::sin(t * angle) * b) / std::sin(angle);
}

/// Every face of a polyhedron on the unit sphere cut in frequency^2.
Mesh geodesic(const Mesh& polyhedron, int frequency, double radius) {
    require_at_least("frequency", frequency, 1);
    require_positive("radius", radius);
    require_size(0.5 * polyhedron.cell_count() * frequency * frequency + 2.0);
    const auto corner = [&](Index v) -> Vector3 { return polyhedron.points().row(v).transpose(); };
    const EdgeGraph graph(polyhedron.vertex_count(), polyhedron.cells());
    MeshBuilder builder;
    std::vector<Vector3> unit;
    const auto add = [&](const Vector3& position) {
        unit.push_back(position);
        return builder.vertex(radius * position);
    };
    for (Index v = 0; v < polyhedron.vertex_count(); ++v)
        add(corner(v));
    for (Index v = 0; v < polyhedron.vertex_count(); ++v) {
        for (const auto [w, edge] : graph.neighbours(v)) {
            for (int k = 1; v < w && k < frequency; ++k)
                add(along_arc(corner(v), corner(w), double(k) / frequency));
        }
    }
    // Vertex k steps of the way from v to w.
    const auto on_edge = [&](Index v, Index w, int k) {
        if (k == 0) return v;
        if (k == frequency) return w;
        const Index first = polyhedron.vertex_count() + graph.find_edge(v, w) * (frequency - 1);
        return first + (v < w ? k : frequency - k) - 1;
    };
    for (Index c = 0; c < polyhedron.cell_count(); ++c) {
        const auto face = polyhedron.cells().row(c);
        // Row i, from 0 at the first corner to frequency at the opposite edge, has i + 1 vertices.
        std::vector<Index> above;
        for (int i = 0; i <= frequency; ++i) {
            const Index left = on_edge(face[0], face[1], i);
            const Index right = on_edge(face[0], face[2], i);
            std::vector<Index> row{left};
            for (int j = 1; j < i; ++j) {
                if (i == frequency) {
                    row.push_back(on_edge(face[1], face[2], j));
                } else {
                    row.push_back(add(along_arc(unit[static_cast<std::size_t>(left)],
                                                unit[static_cast<std::size_t>(right)], double(j) / i)));
                }
            }
            if (i > 0) row.push_back(right);
            for (std::size_t j = 0; j + 1 < row.size(); ++j) {
                builder.cell({above[j], row[j], row[j + 1]});
                if (j + 1 < above.size()) builder.cell({above[j], row[j + 1], above[j + 1]});
            }
            above = std::move(row);
        }
    }
    return builder.mesh();
}

}  // namespace

Mesh icosphere(int levels, double radius) {
    require_at_least("levels", levels, 0);
    require_positive("radius", radius);
    require_size(icosphere_size(levels));
    Mesh sphere = icosahedron();
    for (int level = 0; level < levels; ++level)
        sphere = split_in_four(sphere);
    return sphere.with_points(radius * sphere.points());
}

Mesh latlong_sphere(int rings, double radius) {
    require_at_least("rings", rings, 1);
    require_positive("radius", radius);
    require_size(2.0 * rings * (rings + 1.0) + 2.0);
    const int around = 2 * (rings + 1);
    MeshBuilder builder;
    const Index north = builder.vertex({0, 0, radius});
    for (int i = 1; i <= rings; ++i) {
        const double latitude = pi * i / (rings + 1);
        for (int j = 0; j < around; ++j) {
            const double longitude = 2.0 * pi * j / around;
            builder.vertex(radius * Vector3(std::sin(latitude) * std::cos(longitude),
                                            std::sin(latitude) * std::sin(longitude), std::cos(latitude)));
        }
    }
    const Index south = builder.vertex({0, 0, -radius});
    const auto at = [&](int ring, int j) { return 1 + ring * around + j % around; };
    for (int j = 0; j < around; ++j) {
        builder.cell({north, at(0, j), at(0, j + 1)});
        builder.cell({south, at(rings - 1, j + 1), at(rings - 1, j)});
    }
    builder.sheet(rings - 1, around, at);
    return builder.mesh();
}

Mesh geodesic_icosahedron(int frequency, double radius) {
    return geodesic(icosahedron(), frequency, radius);
}

Mesh geodesic_tetrahedron(int frequency, double radius) {
    return geodesic(tetrahedron(), frequency, radius);
}

Mesh pinched_spheres(int levels) {
    require_size(2.0 * icosphere_size(levels) - 1.0);
    const Mesh sphere = icosphere(levels);
    const Index n = sphere.vertex_count();
    // The upper sphere's south pole is the lower one's north pole, vertex 0.
    const auto upper = [&](Index v) { return v == south_pole ? 0 : n + v - (v > south_pole ? 1 : 0); };
    Points points(2 * n - 1, 3);
    points.topRows(n) = sphere.points();
    for (Index v = 0; v < n; ++v) {
        if (v != south_pole) points.row(upper(v)) = sphere.points().row(v) + Eigen::RowVector3d(0, 0, 2);
    }
    Cells cells(2 * sphere.cell_count(), 3);
    cells.topRows(sphere.cell_count()) = sphere.cells();
    cells.bottomRows(sphere.cell_count()) = sphere.cells().unaryExpr(upper);
    return {std::move(points), std::move(cells)};
}

}  // namespace beltrami::shapes
