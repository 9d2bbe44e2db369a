#include "beltrami/framework/cell_geometry.hpp"

#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::relative_difference;

TEST(SignedMeasure, OfCellsThatAreKnown) {
    EXPECT_EQ(signed_measure(Mesh(Points{{0, 0, 0}, {3, 4, 0}}, Cells{{0, 1}}), 0), 5.0);
    EXPECT_EQ(signed_measure(Mesh(Points{{0, 0, 1}, {2, 0, 1}, {0, 3, 1}}, Cells{{0, 1, 2}}), 0), 3.0);
    const Points corner{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
    EXPECT_DOUBLE_EQ(signed_measure(Mesh(corner, Cells{{0, 1, 2, 3}}), 0), 1.0);
    EXPECT_DOUBLE_EQ(signed_measure(Mesh(corner, Cells{{1, 0, 2, 3}}), 0), -1.0);
    EXPECT_DOUBLE_EQ(cell_measures(Mesh(corner, Cells{{1, 0, 2, 3}}))[0], 1.0);
}

TEST(CellMeasures, AgreeWithGramDeterminants) {
    for (const Mesh& mesh : {shapes::with_noise(shapes::icosphere(1), 0.3),
                             shapes::with_noise(shapes::circle(9), 0.3), shapes::tetrahedral_ball(3)}) {
        const Vector measures = cell_measures(mesh);
        for (Index c = 0; c < mesh.cell_count(); ++c) {
            EXPECT_NEAR(measures[c], testing::reference_element(mesh, c).measure, 1e-13);
        }
    }
}

TEST(IsDegenerate, SeesShapeAndNotSize) {
    const auto triangle = [](double height, double scale) {
        const Points corners{{0, 0, 0}, {scale, 0, 0}, {0.5 * scale, height * scale, 0}};
        return is_degenerate(Mesh(corners, Cells{{0, 1, 2}}), 0);
    };
    for (const double scale : {1e-6, 1.0, 1e6}) {
        EXPECT_FALSE(triangle(1.0, scale));
        EXPECT_FALSE(triangle(1e-9, scale)) << "a sliver is still a triangle";
        EXPECT_TRUE(triangle(1e-13, scale));
        EXPECT_TRUE(triangle(0.0, scale));
    }
    EXPECT_TRUE(is_degenerate(Mesh(Points{{1, 1, 1}, {1, 1, 1}}, Cells{{0, 1}}), 0)) << "no length";
    const Points square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    EXPECT_TRUE(is_degenerate(Mesh(square, Cells{{0, 1, 2, 3}}), 0)) << "flat";
    EXPECT_TRUE(names_a_vertex_twice(Mesh(square, Cells{{0, 1, 0}}), 0));
    EXPECT_FALSE(names_a_vertex_twice(Mesh(square, Cells{{0, 1, 2}}), 0));
}

TEST(NonDegenerateCells, KeepTheirOrder) {
    const Points square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.5, 0, 0}};
    const Mesh mesh(square, Cells{{0, 1, 2}, {0, 1, 3}, {1, 1, 2}, {0, 3, 2}});
    EXPECT_EQ(non_degenerate_cells(mesh), (Cells{{0, 1, 2}, {0, 3, 2}}));
    EXPECT_EQ(non_degenerate_cells(shapes::icosphere(1)), shapes::icosphere(1).cells());
}

TEST(EdgeLengths, AreInTheGraphsOrder) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(1), 0.3);
    const EdgeGraph graph(mesh.vertex_count(), mesh.cells());
    const Vector lengths = edge_lengths(graph, mesh.points());
    for (Index e = 0; e < graph.edge_count(); ++e) {
        const auto upper = graph.upper()[static_cast<std::size_t>(e)];
        EXPECT_DOUBLE_EQ(lengths[e], (mesh.points().row(graph.lower(e)) - mesh.points().row(upper)).norm());
    }
    EXPECT_EQ(longest_edge(Mesh(Points{{0, 0, 0}, {1, 0, 0}, {0, 7, 0}}, Cells{{0, 1, 2}}), 0),
              std::sqrt(50.0));
}

}  // namespace
}  // namespace beltrami
