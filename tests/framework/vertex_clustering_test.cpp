#include "beltrami/framework/vertex_clustering.hpp"

#include <algorithm>
#include <numbers>
#include <set>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/mesh_report.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami {
namespace {

std::vector<Mesh> large_meshes() {
    return {shapes::icosphere(5),
            shapes::bumpy_sphere(20000),
            shapes::grid(70, 50),
            shapes::genus(3, 12),
            shapes::fins(5, 30),
            shapes::pinched_spheres(4),
            shapes::tetrahedral_ball(14),
            shapes::circle(5000),
            Mesh(shapes::bumpy_sphere(9000).points()),
            shapes::together({shapes::icosphere(4), shapes::icosphere(3, 0.2), shapes::torus(3, 1, 80, 40)})};
}

// Cells as sets of numbers in the original, so that neither order matters.
std::set<std::vector<Index>> cells_of(const VertexClustering& drawn) {
    std::set<std::vector<Index>> cells;
    for (const auto& row : drawn.mesh.cells().rowwise()) {
        std::vector<Index> cell;
        for (const Index v : row)
            cell.push_back(drawn.vertex_of[static_cast<std::size_t>(v)]);
        std::sort(cell.begin(), cell.end());
        cells.insert(cell);
    }
    return cells;
}

TEST(VertexClustering, KeepsVerticesOfTheMeshAndNoMoreThanAllowed) {
    for (const Mesh& mesh : large_meshes()) {
        for (const Index most : {1, 7, 300, 2500}) {
            const VertexClustering drawn = cluster_vertices(mesh, most);
            SCOPED_TRACE(fmt::format("{} {}, at most {}", mesh.cell_count(), plural(mesh.kind()), most));
            EXPECT_LE(drawn.mesh.vertex_count(), most);
            EXPECT_TRUE(std::is_sorted(drawn.vertex_of.begin(), drawn.vertex_of.end()));
            const Points there = mesh.points()(drawn.vertex_of, Eigen::all);
            EXPECT_EQ(drawn.mesh.points(), there);
            EXPECT_EQ(drawn.mesh.kind(), mesh.kind());
            for (std::size_t v = 0; v < drawn.vertex_of.size(); ++v)
                ASSERT_EQ(drawn.cluster_of[static_cast<std::size_t>(drawn.vertex_of[v])],
                          static_cast<Index>(v));
        }
    }
}

TEST(VertexClustering, UsesWhatIsAllowed) {
    for (const Mesh& mesh :
         {shapes::bumpy_sphere(50000), shapes::grid(200, 150), shapes::torus(2, 1, 300, 150),
          shapes::circle(9000), Mesh(shapes::bumpy_sphere(30000).points())}) {
        EXPECT_GT(cluster_vertices(mesh, 5000).mesh.vertex_count(), 4000) << plural(mesh.kind());
    }
}

TEST(VertexClustering, LeavesNoDegenerateOrDuplicateCells) {
    for (const Mesh& mesh : large_meshes()) {
        const VertexClustering drawn = cluster_vertices(mesh, 500);
        EXPECT_EQ(cells_of(drawn).size(), static_cast<std::size_t>(drawn.mesh.cell_count()));
        for (Index c = 0; c < drawn.mesh.cell_count(); ++c)
            ASSERT_FALSE(is_degenerate(drawn.mesh, c));
        if (mesh.kind() != CellKind::point) {
            EXPECT_GT(drawn.mesh.cell_count(), 0);
        }
    }
}

TEST(VertexClustering, ASphereKeepsItsAreaAndItsShape) {
    const Mesh sphere = shapes::icosphere(6);
    for (const Index most : {2000, 10000}) {
        const VertexClustering drawn = cluster_vertices(sphere, most);
        const MeshReport found = report(drawn.mesh);
        EXPECT_NEAR(found.measure, 4.0 * std::numbers::pi, 0.03 * 4.0 * std::numbers::pi);
        EXPECT_EQ(found.components, 1);
        // Every vertex is represented by one that lies within the same box.
        for (Index v = 0; v < sphere.vertex_count(); ++v) {
            const Index cluster = drawn.cluster_of[static_cast<std::size_t>(v)];
            ASSERT_LE((sphere.points().row(v) - drawn.mesh.points().row(cluster)).cwiseAbs().maxCoeff(),
                      1.0000001 * drawn.box);
        }
    }
}

TEST(VertexClustering, SmallMeshesStayAsTheyAre) {
    const Mesh mesh = shapes::genus(1, 3);
    const VertexClustering drawn = cluster_vertices(mesh, mesh.vertex_count());
    EXPECT_EQ(drawn.box, 0.0);
    EXPECT_EQ(drawn.mesh.points(), mesh.points());
    EXPECT_EQ(drawn.mesh.cells(), mesh.cells());
}

TEST(VertexClustering, LeavesOutVerticesWithoutACell) {
    const Mesh mesh(Points{{0, 0, 0}, {9, 9, 9}, {1, 0, 0}, {0, 1, 0}}, Cells{{0, 2, 3}});
    const VertexClustering drawn = cluster_vertices(mesh, 3);
    EXPECT_EQ(drawn.vertex_of, (std::vector<Index>{0, 2, 3}));
    EXPECT_EQ(drawn.cluster_of, (std::vector<Index>{0, -1, 1, 2}));
    EXPECT_EQ(drawn.mesh.cells(), (Cells{{0, 1, 2}}));
}

TEST(VertexClustering, FieldsKeepTheirValues) {
    const Mesh plain = shapes::bumpy_sphere(3000);
    const Mesh mesh(plain.points(), plain.cells(), {{"place", Block(plain.points())}});
    const VertexClustering drawn = cluster_vertices(mesh, 400);
    EXPECT_EQ(drawn.mesh.field("place").values, Block(drawn.mesh.points()));
}

TEST(VertexClustering, DoesNotDependOnTheNumbering) {
    const Mesh mesh = shapes::bumpy_sphere(8000);
    const shapes::Shuffled other = shapes::shuffled(mesh, 3);
    VertexClustering a = cluster_vertices(mesh, 900);
    const VertexClustering b = cluster_vertices(other.mesh, 900);
    for (Index& v : a.vertex_of)
        v = other.new_number[static_cast<std::size_t>(v)];
    EXPECT_EQ(std::set<Index>(a.vertex_of.begin(), a.vertex_of.end()),
              std::set<Index>(b.vertex_of.begin(), b.vertex_of.end()));
    EXPECT_EQ(cells_of(a), cells_of(b));
}

TEST(VertexClustering, VerticesInOnePlaceBecomeOne) {
    const Mesh points(Points(Points::Ones(50, 3)));
    EXPECT_EQ(cluster_vertices(points, 10).mesh.vertex_count(), 1);
}

TEST(VertexClustering, RefusesToLeaveNothing) {
    EXPECT_THROW(cluster_vertices(shapes::icosphere(1), 0), InputError);
}

}  // namespace
}  // namespace beltrami
