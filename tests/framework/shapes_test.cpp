#include "beltrami/framework/shapes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/mesh_report.hpp"

namespace beltrami {
namespace {

using std::numbers::pi;

/// The volume that a closed surface encloses; positive when its triangles face outward.
double enclosed_volume(const Mesh& mesh) {
    double volume = 0.0;
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        const auto corner = [&](int k) -> Vector3 {
            return mesh.points().row(mesh.cells()(c, k)).transpose();
        };
        volume += corner(0).cross(corner(1)).dot(corner(2)) / 6.0;
    }
    return volume;
}

void expect_closed(const Mesh& mesh, Index genus) {
    const MeshReport r = report(mesh);
    EXPECT_TRUE(r.manifold);
    EXPECT_TRUE(r.orientable);
    EXPECT_EQ(r.turned_edges, 0);
    EXPECT_EQ(r.boundary_edges, 0);
    EXPECT_EQ(r.degenerate_cells, 0);
    EXPECT_EQ(r.components, 1);
    EXPECT_EQ(r.euler_characteristic, 2 - 2 * genus);
    EXPECT_EQ(r.genus, genus);
    EXPECT_GT(enclosed_volume(mesh), 0.0);
}

void expect_on_sphere(const Mesh& mesh, double radius) {
    expect_closed(mesh, 0);
    EXPECT_LT((mesh.points().rowwise().norm().array() - radius).abs().maxCoeff(), 1e-13 * radius);
}

TEST(Shapes, IcospheresAreSpheres) {
    for (int levels = 0; levels <= 4; ++levels) {
        const Mesh mesh = shapes::icosphere(levels, 2.5);
        EXPECT_EQ(mesh.vertex_count(), 10 * (1 << (2 * levels)) + 2);
        expect_on_sphere(mesh, 2.5);
    }
    EXPECT_NEAR(enclosed_volume(shapes::icosphere(5)), 4.0 / 3.0 * pi, 0.01);
}

struct TableRow {
    Mesh mesh;
    double radius;
    Index vertices;
    double mean_1, range_1, mean_2, range_2;
    double unit_1, unit_2;  // of the last printed digit: means, ranges
};

/// Smallest, mean and largest 2 / |Delta x| with Delta x = -factor(valence) / (area of the incident
/// triangles) K x.
template <class Factor>
std::array<double, 3> curvature_radii(const Mesh& mesh, Factor factor) {
    Points stiffness = Points::Zero(mesh.vertex_count(), 3);
    Vector area = Vector::Zero(mesh.vertex_count());
    Vector valence = Vector::Zero(mesh.vertex_count());
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        for (int k = 0; k < 3; ++k) {
            const Index i = mesh.cells()(c, k);
            const Index j = mesh.cells()(c, (k + 1) % 3);
            const Index o = mesh.cells()(c, (k + 2) % 3);
            const Vector3 u = mesh.points().row(i) - mesh.points().row(o);
            const Vector3 v = mesh.points().row(j) - mesh.points().row(o);
            const double cotangent = u.dot(v) / u.cross(v).norm();
            const Eigen::RowVector3d flow = 0.5 * cotangent * (mesh.points().row(i) - mesh.points().row(j));
            stiffness.row(i) += flow;
            stiffness.row(j) -= flow;
            area[i] += signed_measure(mesh, c);
            valence[i] += 1.0;
        }
    }
    Vector radii(mesh.vertex_count());
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        radii[v] = 2.0 * area[v] / (factor(valence[v]) * stiffness.row(v).norm());
    }
    return {radii.minCoeff(), radii.mean(), radii.maxCoeff()};
}

TEST(Shapes, CurvatureRadiiOfKimAndRossignacTable1) {
    using namespace shapes;
    const TableRow rows[] = {
        {latlong_sphere(1, 100), 100, 6, 150.0, 0, 100, 0, 0.1, 0.1},
        {latlong_sphere(2, 100), 100, 14, 112.1, 4.4, 99.8, 9.9, 0.1, 0.1},
        {latlong_sphere(3, 100), 100, 26, 106.7, 6.3, 99.3, 21.6, 0.1, 0.1},
        {latlong_sphere(4, 100), 100, 42, 104.7, 7.4, 99.2, 27.2, 0.1, 0.1},
        {latlong_sphere(14, 100), 100, 422, 101.7, 14.2, 99.8, 33.1, 0.1, 0.1},
        {geodesic_icosahedron(1, 5), 5, 12, 5.73, 0, 5.00, 0, 0.01, 0.01},
        {geodesic_icosahedron(3, 5), 5, 92, 5.08, 0.045, 4.99, 0.65, 0.01, 0.01},
        {geodesic_icosahedron(5, 5), 5, 252, 5.03, 0.047, 5.00, 0.67, 0.01, 0.01},
        {geodesic_tetrahedron(1, 5), 5, 4, 15.00, 0, 5.00, 0, 0.01, 0.01},
        {geodesic_tetrahedron(2, 5), 5, 10, 7.04, 1.88, 4.86, 3.56, 0.01, 0.01},
        {geodesic_tetrahedron(4, 5), 5, 34, 5.39, 0.84, 4.93, 3.96, 0.01, 0.01},
        {geodesic_tetrahedron(10, 5), 5, 202, 5.06, 0.49, 4.99, 3.67, 0.01, 0.01},
        {geodesic_tetrahedron(20, 5), 5, 802, 5.02, 0.27, 5.00, 3.55, 0.01, 0.01},
    };
    for (const TableRow& row : rows) {
        SCOPED_TRACE(row.vertices);
        ASSERT_EQ(row.mesh.vertex_count(), row.vertices);
        expect_on_sphere(row.mesh, row.radius);
        const auto by_valence = [](double n) { return 4.0 * std::pow(std::cos(pi / n), 2); };
        const auto [low_1, mean_1, high_1] = curvature_radii(row.mesh, by_valence);
        const auto [low_2, mean_2, high_2] = curvature_radii(row.mesh, [](double /*n*/) { return 3.0; });
        EXPECT_NEAR(mean_1, row.mean_1, 0.5 * row.unit_1);
        EXPECT_NEAR(mean_2, row.mean_2, 0.5 * row.unit_1);
        // Two ranges of the latitude-longitude spheres are printed cut off, not rounded (6.392 as 6.3, 9.955
        // as 9.9).
        EXPECT_NEAR(high_1 - low_1, row.range_1, row.unit_2);
        EXPECT_NEAR(high_2 - low_2, row.range_2, row.unit_2);
    }
}

TEST(Shapes, TheRowsOfGeodesicFacesStartAtTheCornerThatTable1Wants) {
    const auto by_valence = [](double n) { return 4.0 * std::pow(std::cos(pi / n), 2); };
    const auto three = curvature_radii(shapes::geodesic_icosahedron(3, 5), by_valence);
    const auto five = curvature_radii(shapes::geodesic_icosahedron(5, 5), by_valence);
    EXPECT_NEAR(three[2] - three[0], 0.045, 0.0005);
    EXPECT_NEAR(five[2] - five[0], 0.047, 0.0005);
}

TEST(Shapes, GridsAreRectangles) {
    const Mesh mesh = shapes::grid(6, 4, 3.0, 1.0);
    EXPECT_EQ(mesh.vertex_count(), 35);
    EXPECT_EQ(mesh.cell_count(), 48);
    const MeshReport r = report(mesh);
    EXPECT_EQ(r.boundary_edges, 20);
    EXPECT_EQ(r.boundary_loops, 1);
    EXPECT_EQ(r.turned_edges, 0);
    EXPECT_NEAR(r.measure, 3.0, 1e-14);
    EXPECT_EQ(r.lower, (std::array<double, 3>{0, 0, 0}));
    EXPECT_EQ(r.upper, (std::array<double, 3>{3, 1, 0}));

    const MeshReport alternating = report(shapes::grid(6, 4, 3.0, 1.0, true));
    EXPECT_EQ(alternating.turned_edges, 0);
    EXPECT_EQ(alternating.edges, r.edges);
    EXPECT_NE(shapes::grid(6, 4, 3.0, 1.0, true).cells(), mesh.cells());
}

TEST(Shapes, DisksAreDiscs) {
    const Mesh mesh = shapes::disk(20, 2.0);
    EXPECT_EQ(mesh.vertex_count(), 1261);
    const MeshReport r = report(mesh);
    EXPECT_EQ(r.boundary_edges, 120);
    EXPECT_EQ(r.euler_characteristic, 1);
    EXPECT_EQ(r.turned_edges, 0);
    EXPECT_EQ(r.components, 1);
    EXPECT_GT(r.smallest_angle, 40.0);
    EXPECT_NEAR(r.measure, 0.5 * 120 * 4.0 * std::sin(2.0 * pi / 120), 1e-10);
}

TEST(Shapes, TorusAndGenusSurfacesHaveTheirGenus) {
    const Mesh torus = shapes::torus(1.0, 0.4, 60, 24);
    EXPECT_EQ(torus.vertex_count(), 1440);
    expect_closed(torus, 1);
    EXPECT_NEAR(enclosed_volume(torus), 2.0 * pi * pi * 0.16, 0.05);
    for (int holes = 0; holes <= 4; ++holes) {
        for (const int subdivisions : {1, 3})
            expect_closed(shapes::genus(holes, subdivisions), holes);
        EXPECT_NEAR(enclosed_volume(shapes::genus(holes, 2)), 3.0 * (2 * holes + 1) - holes, 1e-12);
    }
}

TEST(Shapes, CylindersAreOpen) {
    const Mesh mesh = shapes::cylinder(1.0, 2.0, 64, 32);
    EXPECT_EQ(mesh.vertex_count(), 64 * 33);
    const MeshReport r = report(mesh);
    EXPECT_EQ(r.boundary_edges, 128);
    EXPECT_EQ(r.boundary_loops, 2);
    EXPECT_EQ(r.genus, 0);
    EXPECT_EQ(r.turned_edges, 0);
    EXPECT_GT(enclosed_volume(mesh), 0.0);
    EXPECT_NEAR(r.measure, 64 * 2.0 * std::sin(pi / 64) * 2.0, 1e-10);
}

TEST(Shapes, CirclesAreClosed) {
    const MeshReport r = report(shapes::circle(100, 3.0));
    EXPECT_EQ(r.kind, CellKind::segment);
    EXPECT_EQ(r.cells, 100);
    EXPECT_EQ(r.boundary_vertices, 0);
    EXPECT_EQ(r.euler_characteristic, 0);
    EXPECT_NEAR(r.measure, 600.0 * std::sin(pi / 100), 1e-11);
}

TEST(Shapes, FinsMeetAlongALine) {
    const Mesh mesh = shapes::fins(5, 4);
    EXPECT_EQ(mesh.vertex_count(), 5 + 5 * 4 * 5);
    const MeshReport r = report(mesh);
    EXPECT_EQ(r.non_manifold_edges, 4);
    EXPECT_EQ(r.non_manifold_vertices, 0);
    EXPECT_EQ(r.boundary_edges, 5 * 12);
    EXPECT_EQ(r.components, 1);
    EXPECT_NEAR(r.measure, 5.0, 1e-13);
}

TEST(Shapes, PinchedSpheresShareAVertex) {
    const Mesh mesh = shapes::pinched_spheres(2);
    EXPECT_EQ(mesh.vertex_count(), 2 * 162 - 1);
    const MeshReport r = report(mesh);
    EXPECT_EQ(r.non_manifold_vertices, 1);
    EXPECT_EQ(r.non_manifold_edges, 0);
    EXPECT_EQ(r.repeated_positions, 0);
    EXPECT_EQ(r.components, 1);
    EXPECT_EQ(r.euler_characteristic, 3);
    EXPECT_NEAR(r.upper[2] - r.lower[2], 4.0, 1e-14);
}

void expect_solid(const Mesh& mesh, double volume, double tolerance) {
    for (Index c = 0; c < mesh.cell_count(); ++c)
        ASSERT_GT(signed_measure(mesh, c), 0.0) << c;
    const MeshReport r = report(mesh);
    EXPECT_EQ(r.euler_characteristic, 1);
    EXPECT_TRUE(r.manifold);
    EXPECT_EQ(r.sliver_cells, 0);
    EXPECT_NEAR(r.measure, volume, tolerance);
}

TEST(Shapes, TetrahedraFillTheCube) {
    const Mesh mesh = shapes::tetrahedral_cube(7);
    EXPECT_EQ(mesh.vertex_count(), 512);
    EXPECT_EQ(mesh.cell_count(), 6 * 343);
    expect_solid(mesh, 1.0, 1e-13);
    EXPECT_EQ(report(mesh).boundary_faces, 12 * 49);
}

TEST(Shapes, TetrahedraFillTheBall) {
    for (const int n : {1, 2, 3, 8, 9}) {
        const Mesh mesh = shapes::tetrahedral_ball(n, 2.0);
        expect_solid(mesh, 4.0 / 3.0 * pi * 8.0, 55.0 / (n * n));
        EXPECT_EQ(report(mesh).boundary_faces, 12 * n * n);
        EXPECT_NEAR(mesh.points().rowwise().norm().maxCoeff(), 2.0, 1e-14);
    }
}

TEST(Shapes, BumpySpheresAreClosedAndHaveSlivers) {
    const Mesh mesh = shapes::bumpy_sphere(20000);
    EXPECT_EQ(mesh.vertex_count(), 20000);
    expect_closed(mesh, 0);
    const MeshReport r = report(mesh);
    EXPECT_GT(r.sliver_cells, 20);
    EXPECT_LT(r.sliver_cells, 400);
    EXPECT_GT(r.non_delaunay_edges, 100);
    EXPECT_EQ(r.repeated_positions, 0);
    // Star-shaped about the origin: every triangle is seen from outside.
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        Eigen::Matrix3d corners;
        for (int k = 0; k < 3; ++k)
            corners.col(k) = mesh.points().row(mesh.cells()(c, k)).transpose();
        ASSERT_GT(corners.determinant(), 0.0) << c;
    }
    // Numbered for locality.
    const EdgeGraph graph(mesh.vertex_count(), mesh.cells());
    double apart = 0.0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        for (const auto n : graph.neighbours(v))
            apart += std::abs(n.vertex - v);
    }
    EXPECT_LT(apart / (2.0 * graph.edge_count()), 1000.0);
}

TEST(Shapes, RandomShapesDependOnTheirSeedAlone) {
    EXPECT_EQ(shapes::bumpy_sphere(500, 7).points(), shapes::bumpy_sphere(500, 7).points());
    EXPECT_NE(shapes::bumpy_sphere(500, 7).points(), shapes::bumpy_sphere(500, 8).points());
    EXPECT_EQ(shapes::shuffled(shapes::grid(5, 5), 3).new_number,
              shapes::shuffled(shapes::grid(5, 5), 3).new_number);
    EXPECT_NE(shapes::shuffled(shapes::grid(5, 5), 3).new_number,
              shapes::shuffled(shapes::grid(5, 5), 4).new_number);
    // These numbers must be the same on every machine.
    EXPECT_EQ(shapes::shuffled(shapes::circle(8), 1).new_number,
              (std::vector<Index>{1, 2, 7, 0, 5, 4, 6, 3}));
}

TEST(Shapes, NoiseIsBoundedByTheMeanEdge) {
    const Mesh sphere = shapes::icosphere(3);
    const double length = report(sphere).mean_edge;
    const Mesh noisy = shapes::with_noise(sphere, 0.3);
    const auto moved = (noisy.points() - sphere.points()).rowwise().norm();
    EXPECT_LE(moved.maxCoeff(), 0.3 * length);
    EXPECT_GT(moved.maxCoeff(), 0.25 * length);
    EXPECT_EQ(noisy.cells(), sphere.cells());
    EXPECT_EQ(shapes::with_noise(sphere, 0.0).points(), sphere.points());
    EXPECT_THROW((void)shapes::with_noise(sphere, -1.0), InputError);
    EXPECT_THROW((void)shapes::with_noise(sphere, std::nan("")), InputError);
    EXPECT_THROW((void)shapes::with_noise(Mesh(Points::Zero(3, 3)), 0.1), InputError);
}

TEST(Shapes, JitterKeepsTheBoundaryAndThePlane) {
    const Mesh flat = shapes::grid(10, 10);
    const Mesh jittered = shapes::jittered(flat, 0.24);
    EXPECT_TRUE(jittered.points().col(2).isZero(0.0));
    const auto moved = (jittered.points() - flat.points()).rowwise().norm();
    for (int j = 0; j <= 10; ++j) {
        for (int i = 0; i <= 10; ++i) {
            const bool inside = i % 10 != 0 && j % 10 != 0;
            EXPECT_EQ(moved[j * 11 + i] > 0.0, inside);
        }
    }
    for (Index c = 0; c < jittered.cell_count(); ++c) {
        const auto corner = [&](int k) -> Vector3 {
            return jittered.points().row(jittered.cells()(c, k)).transpose();
        };
        EXPECT_GT((corner(1) - corner(0)).cross(corner(2) - corner(0)).z(), 0.0);
    }
    EXPECT_NEAR(report(jittered).measure, 1.0, 1e-13);
    EXPECT_THROW((void)shapes::jittered(shapes::icosphere(1), 0.1), InputError);
    EXPECT_THROW((void)shapes::jittered(shapes::circle(5), 0.1), InputError);
}

TEST(Shapes, ShufflingIsAPermutation) {
    const Mesh grid = shapes::grid(8, 5);
    const Block height = grid.points().rowwise().sum();
    const Mesh mesh(grid.points(), grid.cells(), {{"height", height}});
    const auto [shuffled, new_number] = shapes::shuffled(mesh);
    ASSERT_EQ(new_number.size(), 54U);
    std::vector<Index> sorted = new_number;
    std::sort(sorted.begin(), sorted.end());
    for (Index v = 0; v < 54; ++v)
        EXPECT_EQ(sorted[static_cast<std::size_t>(v)], v);
    for (Index v = 0; v < 54; ++v) {
        const Index moved = new_number[static_cast<std::size_t>(v)];
        EXPECT_EQ(shuffled.points().row(moved), mesh.points().row(v));
        EXPECT_EQ(shuffled.field("height").values(moved, 0), height(v, 0));
    }
    const MeshReport before = report(mesh);
    const MeshReport after = report(shuffled);
    EXPECT_EQ(after.edges, before.edges);
    EXPECT_EQ(after.boundary_edges, before.boundary_edges);
    EXPECT_EQ(after.turned_edges, 0);
    EXPECT_NEAR(after.measure, before.measure, 1e-14);
    EXPECT_EQ(shapes::shuffled(Mesh(Points::Random(9, 3))).mesh.vertex_count(), 9);
}

TEST(Shapes, TogetherPutsMeshesSideBySide) {
    const Mesh mesh =
        shapes::together({shapes::icosphere(1), shapes::torus(1, 0.4, 8, 6), shapes::icosphere(0)});
    const MeshReport r = report(mesh);
    EXPECT_EQ(r.vertices, 42 + 48 + 12);
    EXPECT_EQ(r.components, 3);
    EXPECT_EQ(r.genus, 1);
    EXPECT_EQ(r.euler_characteristic, 4);
    EXPECT_EQ(shapes::together({Mesh(Points::Zero(2, 3)), Mesh(Points::Zero(3, 3))}).vertex_count(), 5);
    EXPECT_THROW((void)shapes::together({}), InputError);
    EXPECT_THROW((void)shapes::together({shapes::circle(3), shapes::icosphere(0)}), InputError);
}

TEST(ShapeNames, EveryFormWorks) {
    const auto count = [](std::string_view name) { return shapes::from_name(name).vertex_count(); };
    EXPECT_EQ(count("icosphere:3"), 642);
    EXPECT_EQ(count("latlong:14"), 422);
    EXPECT_EQ(count("geodesic-icosahedron:5"), 252);
    EXPECT_EQ(count("geodesic-tetrahedron:4"), 34);
    EXPECT_EQ(count("grid:20x10"), 231);
    EXPECT_EQ(count("disk:20"), 1261);
    EXPECT_EQ(count("torus:1:0.4:20x8"), 160);
    EXPECT_EQ(count("genus:3:1"), 2 * 18 + 20 + 12 - 4);
    EXPECT_EQ(count("cylinder:1:2:64x32"), 64 * 33);
    EXPECT_EQ(count("tetrahedral-cube:4"), 125);
    EXPECT_EQ(count("tetrahedral-ball:4:3"), 125);
    EXPECT_EQ(count("circle:100"), 100);
    EXPECT_EQ(count("fins:3:10"), 11 + 330);
    EXPECT_EQ(count("pinched-spheres:2"), 323);
    EXPECT_EQ(count("bumpy-sphere:150"), 150);
    EXPECT_EQ(shapes::from_name("icosphere:2:2.5").points(), shapes::icosphere(2, 2.5).points());
    EXPECT_EQ(shapes::from_name("bumpy-sphere:150:7").points(), shapes::bumpy_sphere(150, 7).points());
    EXPECT_EQ(shapes::from_name("grid:20x10:2").points(), shapes::grid(20, 10, 2.0, 1.0).points());
    EXPECT_EQ(shapes::from_name("grid:20x10:2:3e-1").points(), shapes::grid(20, 10, 2.0, 0.3).points());
}

TEST(ShapeNames, TheListShowsEveryForm) {
    const std::string list = shapes::list();
    EXPECT_EQ(std::count(list.begin(), list.end(), '\n'), 15);
    EXPECT_NE(list.find("grid:NXxNY[:WIDTH[:HEIGHT]] "), std::string::npos);
    EXPECT_NE(list.find("torus:MAJOR:MINOR:NUxNV "), std::string::npos);
}

void expect_refused(std::string_view name, std::string_view sentence, std::string_view hint) {
    SCOPED_TRACE(name);
    try {
        (void)shapes::from_name(name);
        ADD_FAILURE() << "was accepted";
    } catch (const InputError& error) {
        EXPECT_EQ(std::string_view(error.what()), sentence);
        EXPECT_NE(error.hint().find(hint), std::string::npos) << error.hint();
    }
}

TEST(ShapeNames, MistakesAreExplained) {
    expect_refused("sphere:3", "there is no shape 'sphere'", "icosphere:LEVELS[:RADIUS], latlong:RINGS");
    expect_refused("", "there is no shape ''", "torus:MAJOR:MINOR:NUxNV");
    expect_refused("grid", "shape 'grid' lacks NXxNY, two whole numbers like 20x10",
                   "for example grid:200x100");
    for (const auto* bad : {"20", "20x", "x10", "20x10x5", "20X10", "2.5x3", " 20x10", "20x10 "}) {
        expect_refused(std::string("grid:") + bad,
                       std::string("shape 'grid:") + bad + "' has '" + bad +
                           "' where NXxNY belongs, two whole numbers like 20x10",
                       "write grid:NXxNY[:WIDTH[:HEIGHT]]");
    }
    expect_refused("icosphere:five", "shape 'icosphere:five' has 'five' where LEVELS belongs, a whole number",
                   "write icosphere:LEVELS[:RADIUS], for example icosphere:5");
    expect_refused("icosphere:99999999999",
                   "shape 'icosphere:99999999999' has '99999999999' where LEVELS belongs, a whole number",
                   "for example");
    expect_refused("icosphere:3:", "shape 'icosphere:3:' has '' where RADIUS belongs, a number", "icosphere");
    expect_refused("icosphere:3:1:2",
                   "shape 'icosphere:3:1:2' has 3 arguments, but icosphere takes at most 2", "");
    expect_refused("icosphere:-1", "the levels of a shape cannot be -1", "0 or more");
    expect_refused("icosphere:3:inf", "the radius of a shape cannot be inf", "positive");
    expect_refused("icosphere:3:nan", "the radius of a shape cannot be nan", "positive");
    expect_refused("icosphere:12", "a shape of 1.68e+08 vertices is too large", "50 million");
}

TEST(Shapes, AbsurdArgumentsAreRefused) {
    using namespace shapes;
    constexpr int many = 2147483647;
    EXPECT_THROW((void)icosphere(many), InputError);
    EXPECT_THROW((void)latlong_sphere(0), InputError);
    EXPECT_THROW((void)latlong_sphere(many), InputError);
    EXPECT_THROW((void)geodesic_icosahedron(0), InputError);
    EXPECT_THROW((void)geodesic_tetrahedron(many), InputError);
    EXPECT_THROW((void)grid(0, 5), InputError);
    EXPECT_THROW((void)grid(5, -1), InputError);
    EXPECT_THROW((void)grid(many, many), InputError);
    EXPECT_THROW((void)grid(5, 5, 0.0, 1.0), InputError);
    EXPECT_THROW((void)disk(0), InputError);
    EXPECT_THROW((void)disk(many), InputError);
    EXPECT_THROW((void)disk(3, -1.0), InputError);
    EXPECT_THROW((void)torus(1.0, 1.0, 10, 10), InputError);
    EXPECT_THROW((void)torus(0.4, 1.0, 10, 10), InputError);
    EXPECT_THROW((void)torus(1.0, 0.4, 2, 10), InputError);
    EXPECT_THROW((void)torus(1.0, 0.4, many, many), InputError);
    EXPECT_THROW((void)genus(-1, 1), InputError);
    EXPECT_THROW((void)genus(1, 0), InputError);
    EXPECT_THROW((void)genus(many, many), InputError);
    EXPECT_THROW((void)cylinder(1.0, 0.0, 8, 8), InputError);
    EXPECT_THROW((void)cylinder(1.0, 1.0, 8, many), InputError);
    EXPECT_THROW((void)circle(2), InputError);
    EXPECT_THROW((void)circle(many), InputError);
    EXPECT_THROW((void)fins(2, 5), InputError);
    EXPECT_THROW((void)fins(many, many), InputError);
    EXPECT_THROW((void)pinched_spheres(-1), InputError);
    EXPECT_THROW((void)pinched_spheres(11), InputError);
    EXPECT_THROW((void)tetrahedral_cube(0), InputError);
    EXPECT_THROW((void)tetrahedral_cube(many), InputError);
    EXPECT_THROW((void)tetrahedral_ball(3, 0.0), InputError);
    EXPECT_THROW((void)bumpy_sphere(99), InputError);
    EXPECT_THROW((void)bumpy_sphere(many), InputError);
}

}  // namespace
}  // namespace beltrami
