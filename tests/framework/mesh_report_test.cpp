#include "beltrami/framework/mesh_report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "beltrami/framework/shapes.hpp"

namespace beltrami {
namespace {

Points points_of(std::initializer_list<Vector3> places) {
    Points points(static_cast<Eigen::Index>(places.size()), 3);
    Eigen::Index row = 0;
    for (const Vector3& p : places)
        points.row(row++) = p.transpose();
    return points;
}

Cells cells_of(std::initializer_list<std::initializer_list<Index>> rows) {
    Cells cells(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.begin()->size()));
    Eigen::Index r = 0;
    for (const auto& row : rows) {
        Eigen::Index k = 0;
        for (const Index v : row)
            cells(r, k++) = v;
        ++r;
    }
    return cells;
}

/// The unit square of two triangles in z = 0, with vertex 4 above it and free for other uses.
const Points square_and_one = points_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}});

/// A strip of n squares around a ring whose ends meet after a half turn.
Mesh moebius_strip(Index n) {
    Points points(2 * n, 3);
    Cells cells(2 * n, 3);
    for (Index i = 0; i < n; ++i) {
        const double u = 2.0 * std::numbers::pi * i / n;
        for (Index side = 0; side < 2; ++side) {
            const double w = side == 0 ? -0.4 : 0.4;
            const double r = 1.0 + w * std::cos(u / 2.0);
            points.row(2 * i + side) << r * std::cos(u), r * std::sin(u), w * std::sin(u / 2.0);
        }
        const bool last = i == n - 1;
        const Index a = 2 * i;
        const Index b = 2 * i + 1;
        const Index c = last ? 1 : 2 * i + 2;
        const Index d = last ? 0 : 2 * i + 3;
        cells.row(2 * i) << a, c, d;
        cells.row(2 * i + 1) << a, d, b;
    }
    return {points, cells};
}

TEST(MeshReport, Sphere) {
    const MeshReport r = report(shapes::icosphere(3, 2.0));
    EXPECT_EQ(r.kind, CellKind::triangle);
    EXPECT_EQ(r.vertices, 642);
    EXPECT_EQ(r.edges, 1920);
    EXPECT_EQ(r.faces, 1280);
    EXPECT_EQ(r.cells, 1280);
    EXPECT_EQ(r.components, 1);
    EXPECT_EQ(r.isolated_vertices, 0);
    EXPECT_EQ(r.boundary_edges, 0);
    EXPECT_EQ(r.boundary_loops, 0);
    EXPECT_EQ(r.boundary_vertices, 0);
    EXPECT_EQ(r.duplicate_cells, 0);
    EXPECT_EQ(r.repeated_positions, 0);
    EXPECT_EQ(r.degenerate_cells, 0);
    EXPECT_EQ(r.sliver_cells, 0);
    EXPECT_EQ(r.non_delaunay_edges, 0);
    EXPECT_TRUE(r.manifold);
    EXPECT_TRUE(r.orientable);
    EXPECT_EQ(r.euler_characteristic, 2);
    EXPECT_EQ(r.genus, 0);
    EXPECT_NEAR(r.measure, 16.0 * std::numbers::pi, 0.5);
    EXPECT_NEAR(r.upper[2], 2.0, 1e-14);
    EXPECT_GT(r.memory_bytes, 642U * 24U);
    EXPECT_EQ(brief_report(r), "642 vertices, 1280 triangles, 1 component, closed, genus 0");
}

TEST(MeshReport, GenusIsSummedOverComponents) {
    const MeshReport r = report(
        shapes::together({shapes::genus(3, 2), shapes::cylinder(1, 1, 8, 2), shapes::torus(1, 0.3, 9, 7)}));
    EXPECT_EQ(r.components, 3);
    EXPECT_EQ(r.boundary_loops, 2);
    EXPECT_EQ(r.euler_characteristic, -4 + 0 + 0);
    EXPECT_EQ(r.genus, 4);
}

TEST(MeshReport, OpenCylinder) {
    const MeshReport r = report(shapes::cylinder(1.0, 2.0, 16, 4));
    EXPECT_EQ(r.boundary_edges, 32);
    EXPECT_EQ(r.boundary_vertices, 32);
    EXPECT_EQ(r.boundary_loops, 2);
    EXPECT_EQ(r.euler_characteristic, 0);
    EXPECT_EQ(r.genus, 0);
    EXPECT_EQ(brief_report(r), "80 vertices, 128 triangles, 1 component, 2 boundary loops, genus 0");
}

TEST(MeshReport, MoebiusStripIsNotOrientable) {
    const MeshReport r = report(moebius_strip(20));
    EXPECT_TRUE(r.manifold);
    EXPECT_FALSE(r.orientable);
    EXPECT_FALSE(r.genus.has_value());
    EXPECT_EQ(r.turned_edges, 1);
    EXPECT_EQ(r.boundary_edges, 40);
    EXPECT_EQ(r.boundary_loops, 1);
    EXPECT_EQ(r.euler_characteristic, 0);
    EXPECT_EQ(brief_report(r), "40 vertices, 40 triangles, 1 component, 1 boundary loop, not orientable");
}

TEST(MeshReport, TurnedFacesAreStillOrientable) {
    const Mesh sphere = shapes::icosphere(1);
    Cells cells = sphere.cells();
    std::swap(cells(0, 0), cells(0, 1));
    const MeshReport r = report(Mesh(sphere.points(), cells));
    EXPECT_EQ(r.turned_edges, 3);
    EXPECT_TRUE(r.orientable);
    EXPECT_EQ(r.genus, 0);
}

TEST(MeshReport, FinsAndPinchedSpheresAreNotManifold) {
    const MeshReport fins = report(shapes::fins(3, 10));
    EXPECT_EQ(fins.non_manifold_edges, 10);
    EXPECT_EQ(fins.non_manifold_vertices, 0);
    EXPECT_EQ(fins.boundary_edges, 90);
    EXPECT_EQ(fins.boundary_loops, 1);
    EXPECT_FALSE(fins.manifold);
    EXPECT_FALSE(fins.genus.has_value());
    EXPECT_EQ(brief_report(fins), "341 vertices, 600 triangles, 1 component, 1 boundary loop, not manifold");

    const MeshReport pinched = report(shapes::pinched_spheres(1));
    EXPECT_EQ(pinched.non_manifold_edges, 0);
    EXPECT_EQ(pinched.non_manifold_vertices, 1);
    EXPECT_FALSE(pinched.manifold);
    EXPECT_EQ(brief_report(pinched), "83 vertices, 160 triangles, 1 component, closed, not manifold");
}

TEST(MeshReport, TrianglesThatTouchInAVertexOfTheBoundary) {
    const MeshReport r = report(Mesh(square_and_one, cells_of({{0, 1, 4}, {2, 3, 4}})));
    EXPECT_EQ(r.non_manifold_vertices, 1);
    EXPECT_EQ(r.components, 1);
    EXPECT_EQ(r.boundary_loops, 1);
    EXPECT_EQ(r.boundary_edges, 6);
    EXPECT_EQ(r.boundary_vertices, 5);
}

TEST(MeshReport, IsolatedVerticesAndRepeatedPositions) {
    Points points = square_and_one;
    points.row(4) = points.row(1);
    const MeshReport r = report(Mesh(points, cells_of({{0, 1, 2}, {0, 2, 3}})));
    EXPECT_EQ(r.vertices, 5);
    EXPECT_EQ(r.isolated_vertices, 1);
    EXPECT_EQ(r.repeated_positions, 1);
    EXPECT_EQ(r.components, 1);
    EXPECT_EQ(r.euler_characteristic, 1);
    EXPECT_EQ(r.genus, 0);
    // -0 and 0 are one place.
    EXPECT_EQ(report(Mesh(points_of({{0, 0, 0}, {-0.0, 0, 0}, {0, 0, 0}}))).repeated_positions, 2);
}

TEST(MeshReport, DuplicateCellsCountInAnyOrderOfCorners) {
    const MeshReport r = report(Mesh(square_and_one, cells_of({{0, 1, 2}, {0, 2, 3}, {2, 1, 0}, {1, 2, 0}})));
    EXPECT_EQ(r.duplicate_cells, 2);
    EXPECT_EQ(r.edges, 5);
    EXPECT_EQ(r.faces, 4);
    EXPECT_EQ(r.non_manifold_edges, 3);
}

TEST(MeshReport, DegenerateCells) {
    // One without area, one that names a vertex twice; the second is in no edge count.
    const Points points = points_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0, 0}, {5, 5, 5}});
    const MeshReport r = report(Mesh(points, cells_of({{0, 1, 2}, {0, 2, 3}, {0, 4, 1}, {5, 5, 0}})));
    EXPECT_EQ(r.cells, 4);
    EXPECT_EQ(r.faces, 3);
    EXPECT_EQ(r.degenerate_cells, 2);
    EXPECT_EQ(r.sliver_cells, 0);
    EXPECT_EQ(r.edges, 7);
    EXPECT_EQ(r.isolated_vertices, 1);
    EXPECT_EQ(r.euler_characteristic, 1);
    EXPECT_NEAR(r.smallest_angle, 45.0, 1e-12);
    EXPECT_NEAR(r.largest_angle, 90.0, 1e-12);
    EXPECT_NEAR(r.measure, 1.0, 1e-15);

    const MeshReport nothing = report(Mesh(points, cells_of({{0, 0, 0}})));
    EXPECT_EQ(nothing.degenerate_cells, 1);
    EXPECT_EQ(nothing.components, 0);
    EXPECT_EQ(nothing.edges, 0);
    EXPECT_EQ(nothing.smallest_angle, 0.0);
    EXPECT_FALSE(nothing.genus.has_value());
    EXPECT_FALSE(full_report(nothing).empty());
}

TEST(MeshReport, SliversAndNonDelaunayEdges) {
    const MeshReport needle =
        report(Mesh(points_of({{0, 0, 0}, {1, 0, 0}, {0, 0.01, 0}}), cells_of({{0, 1, 2}})));
    EXPECT_EQ(needle.sliver_cells, 1);
    const MeshReport flat = report(Mesh(points_of({{-1, 0, 0}, {1, 0, 0}, {0, 0.5, 0}, {0, -0.5, 0}}),
                                        cells_of({{0, 1, 2}, {1, 0, 3}})));
    EXPECT_EQ(flat.non_delaunay_edges, 1);
    EXPECT_EQ(flat.sliver_cells, 0);
    EXPECT_EQ(report(shapes::grid(20, 20, 1.0, 0.3)).non_delaunay_edges, 0);
}

TEST(MeshReport, AnglesEdgesAndBox) {
    const MeshReport r = report(Mesh(points_of({{0, 0, 0}, {2, 0, 0}, {0, 2, -1}}), cells_of({{0, 1, 2}})));
    EXPECT_NEAR(r.largest_angle, 90.0, 1e-12);
    EXPECT_NEAR(r.smallest_angle, std::atan2(2.0, std::sqrt(5.0)) * 180.0 / std::numbers::pi, 1e-12);
    EXPECT_DOUBLE_EQ(r.shortest_edge, 2.0);
    EXPECT_DOUBLE_EQ(r.longest_edge, 3.0);
    EXPECT_DOUBLE_EQ(r.mean_edge, (5.0 + std::sqrt(5.0)) / 3.0);
    EXPECT_DOUBLE_EQ(r.measure, std::sqrt(5.0));
    EXPECT_EQ(r.lower, (std::array<double, 3>{0, 0, -1}));
    EXPECT_EQ(r.upper, (std::array<double, 3>{2, 2, 0}));
}

TEST(MeshReport, CubeOfTetrahedra) {
    const MeshReport r = report(shapes::tetrahedral_cube(2));
    EXPECT_EQ(r.vertices, 27);
    EXPECT_EQ(r.cells, 48);
    EXPECT_EQ(r.faces, 120);
    EXPECT_EQ(r.edges, 98);
    EXPECT_EQ(r.boundary_faces, 48);
    EXPECT_EQ(r.boundary_edges, 72);
    EXPECT_EQ(r.boundary_vertices, 26);
    EXPECT_EQ(r.boundary_loops, 0);
    EXPECT_EQ(r.euler_characteristic, 1);
    EXPECT_TRUE(r.manifold);
    EXPECT_FALSE(r.genus.has_value());
    EXPECT_EQ(r.inverted_cells, 0);
    EXPECT_NEAR(r.smallest_angle, 45.0, 1e-12);
    EXPECT_NEAR(r.largest_angle, 90.0, 1e-12);
    EXPECT_NEAR(r.measure, 1.0, 1e-14);
    EXPECT_EQ(brief_report(r), "27 vertices, 48 tetrahedra, 1 component, 48 boundary triangles");
}

TEST(MeshReport, TroubledTetrahedra) {
    const Points points =
        points_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}, {0.3, 0.3, 0.001}, {0, 0, -1}});
    // Inverted, a duplicate and a sliver.
    const MeshReport r = report(Mesh(points, cells_of({{0, 2, 1, 3}, {0, 1, 2, 5}, {3, 1, 2, 0}})));
    EXPECT_EQ(r.inverted_cells, 1 + 1);
    EXPECT_EQ(r.duplicate_cells, 1);
    EXPECT_EQ(r.sliver_cells, 1);
    EXPECT_EQ(r.non_manifold_edges, 1);
    EXPECT_FALSE(r.manifold);
    EXPECT_GT(r.largest_angle, 178.0);

    // Two that share an edge alone: both ends have two fans.
    const MeshReport hinge =
        report(Mesh(points_of({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}),
                    cells_of({{0, 2, 3, 1}, {0, 4, 5, 1}})));
    EXPECT_EQ(hinge.non_manifold_vertices, 2);
    EXPECT_EQ(hinge.inverted_cells, 0);
    EXPECT_EQ(hinge.components, 1);
    EXPECT_EQ(hinge.boundary_edges, 11);
    EXPECT_EQ(brief_report(hinge),
              "6 vertices, 2 tetrahedra, 1 component, 8 boundary triangles, not manifold");
}

TEST(MeshReport, RegularTetrahedronHasDihedralAnglesOfAcosOneThird) {
    const Mesh mesh(points_of({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}), cells_of({{0, 1, 2, 3}}));
    const MeshReport r = report(mesh);
    EXPECT_NEAR(r.smallest_angle, std::acos(1.0 / 3.0) * 180.0 / std::numbers::pi, 1e-12);
    EXPECT_NEAR(r.largest_angle, r.smallest_angle, 1e-12);
}

TEST(MeshReport, Segments) {
    // A path of three edges and a star of three that touches nothing else.
    const Mesh mesh(Points::Random(8, 3), cells_of({{0, 1}, {1, 2}, {2, 3}, {4, 5}, {4, 6}, {4, 7}}));
    const MeshReport r = report(mesh);
    EXPECT_EQ(r.edges, 6);
    EXPECT_EQ(r.faces, 0);
    EXPECT_EQ(r.components, 2);
    EXPECT_EQ(r.boundary_vertices, 5);
    EXPECT_EQ(r.non_manifold_vertices, 1);
    EXPECT_EQ(r.euler_characteristic, 2);
    EXPECT_EQ(r.largest_angle, 0.0);
    EXPECT_EQ(brief_report(r), "8 vertices, 6 segments, 2 components, 5 ends, not manifold");
    EXPECT_EQ(brief_report(report(shapes::circle(7))), "7 vertices, 7 segments, 1 component, closed");
    EXPECT_EQ(brief_report(report(Mesh(Points::Random(2, 3), cells_of({{0, 1}})))),
              "2 vertices, 1 segment, 1 component, 2 ends");
}

TEST(MeshReport, PointsAlone) {
    const MeshReport r = report(Mesh(Points::Random(10, 3)));
    EXPECT_EQ(r.kind, CellKind::point);
    EXPECT_EQ(r.isolated_vertices, 0);
    EXPECT_EQ(r.edges, 0);
    EXPECT_EQ(brief_report(r), "10 points");
    EXPECT_EQ(brief_report(report(Mesh(Points::Random(1, 3)))), "1 point");
    EXPECT_FALSE(full_report(report(Mesh(Points(0, 3)))).empty());
}

TEST(MeshReport, FullReportOfAGoodMeshNamesNoTrouble) {
    const Mesh grid = shapes::grid(2, 1, 2.0, 1.0);
    const Mesh mesh =
        Mesh(grid.points(), grid.cells(), {{"heat", Block::Zero(6, 1)}, {"color", Block::Zero(6, 3)}})
            .with_notes({"2 squares were split"});
    EXPECT_EQ(full_report(report(mesh)),
              "vertices      6\n"
              "triangles     4\n"
              "edges         9\n"
              "components    1\n"
              "boundary      1 loop, 6 edges\n"
              "topology      genus 0, Euler characteristic 1\n"
              "box           (0, 0, 0) to (2, 1, 0)\n"
              "area          2\n"
              "edge length   1 to 1.414, mean 1.092\n"
              "angles        45 to 90 degrees\n"
              "fields        heat, color\n"
              "memory        0.0 MB\n"
              "note          2 squares were split\n");
}

TEST(MeshReport, FullReportNamesTroubles) {
    const Points points = points_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 1, 0}});
    const std::string text =
        full_report(report(Mesh(points, cells_of({{0, 1, 2}, {2, 0, 3}, {3, 2, 0}, {1, 1, 2}}))));
    EXPECT_NE(text.find("trouble       1 isolated vertex:"), std::string::npos) << text;
    EXPECT_NE(text.find("trouble       1 non-manifold edge:"), std::string::npos) << text;
    EXPECT_NE(text.find("trouble       1 duplicate triangle:"), std::string::npos) << text;
    EXPECT_NE(text.find("trouble       1 repeated position:"), std::string::npos) << text;
    EXPECT_NE(text.find("trouble       1 degenerate triangle:"), std::string::npos) << text;
    EXPECT_EQ(text.find("sliver"), std::string::npos) << text;
    EXPECT_EQ(text.find("inverted"), std::string::npos) << text;
}

}  // namespace
}  // namespace beltrami
