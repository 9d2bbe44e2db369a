#include "beltrami/framework/boundary.hpp"

#include <algorithm>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/mesh_report.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami {
namespace {

TEST(BoundaryVertices, OfClosedMeshesAreNone) {
    EXPECT_TRUE(boundary_vertices(shapes::icosphere(2)).empty());
    EXPECT_TRUE(boundary_vertices(shapes::genus(2, 2)).empty());
    EXPECT_TRUE(boundary_vertices(shapes::circle(5)).empty());
    EXPECT_TRUE(boundary_vertices(shapes::pinched_spheres(1)).empty());
    EXPECT_TRUE(boundary_vertices(Mesh(Points::Random(3, 3))).empty());
}

TEST(BoundaryVertices, OfAGridAreItsRimInOrder) {
    EXPECT_EQ(boundary_vertices(shapes::grid(2, 3)), (std::vector<Index>{0, 1, 2, 3, 5, 6, 8, 9, 10, 11}));
}

TEST(BoundaryVertices, OfASolidAreItsSkin) {
    const Mesh cube = shapes::tetrahedral_cube(4);
    const std::vector<Index> skin = boundary_vertices(cube);
    EXPECT_EQ(skin.size(), 125U - 27U);
    for (const Index v : skin) {
        const auto p = cube.points().row(v).array();
        EXPECT_EQ((p * (1.0 - p)).prod(), 0.0);
    }
}

TEST(BoundaryVertices, OfAPathAreItsEnds) {
    const Mesh path(Points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, Cells{{1, 2}, {0, 1}});
    EXPECT_EQ(boundary_vertices(path), (std::vector<Index>{0, 2}));
}

// Three fins: the seam belongs to three triangles and is inside, its two ends are on the rim.
TEST(BoundaryVertices, TheSeamOfFinsIsInside) {
    const Mesh fins = shapes::fins(3, 4);
    std::vector<Index> rim = boundary_vertices(fins);
    const std::vector<Index> seam_on_rim(rim.begin(), std::lower_bound(rim.begin(), rim.end(), 5));
    EXPECT_EQ(seam_on_rim, (std::vector<Index>{0, 4}));
}

TEST(BoundaryVertices, DegenerateCellsDoNotCloseAGap) {
    // Vertex 4 lies on the edge 0 - 1; the flat triangle would make that edge look like an inner one.
    const Points points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0, 0}};
    const Mesh mesh(points, Cells{{0, 1, 2}, {0, 2, 3}, {0, 4, 1}});
    EXPECT_EQ(boundary_vertices(mesh), (std::vector<Index>{0, 1, 2, 3}));
}

TEST(BoundaryTriangles, OfASolidLookOutward) {
    const Mesh ball = shapes::tetrahedral_ball(6);
    Cells cells = ball.cells();
    for (Eigen::Index c = 0; c < cells.rows(); c += 3)
        std::swap(cells(c, 1), cells(c, 2));  // inverted tetrahedra
    for (const Mesh& mesh : {ball, Mesh(ball.points(), cells)}) {
        const Cells skin = boundary_triangles(mesh);
        EXPECT_EQ(skin.rows(), 2 * 6 * 6 * 6);
        const MeshReport found = report(Mesh(ball.points(), skin));
        EXPECT_EQ(found.boundary_edges, 0);
        EXPECT_EQ(found.turned_edges, 0);
        for (const auto& triangle : skin.rowwise()) {
            const Vector3 p = ball.points().row(triangle[0]);
            const Vector3 q = ball.points().row(triangle[1]);
            const Vector3 r = ball.points().row(triangle[2]);
            ASSERT_GT((q - p).cross(r - p).dot(p), 0.0);
        }
    }
    EXPECT_THROW(boundary_triangles(shapes::icosphere(1)), InputError);
}

}  // namespace
}  // namespace beltrami
