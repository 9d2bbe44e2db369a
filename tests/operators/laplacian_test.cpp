#include "beltrami/operators/laplacian.hpp"

#include <array>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/stiffness.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::graph_of;
using testing::random_block;
using testing::relative_difference;

Block apply_in_user_order(const Laplacian& laplacian, const Block& u) {
    Block y;
    laplacian.stiffness().apply(laplacian.order().to_working(u), y);
    return laplacian.order().to_user(y);
}

TEST(Laplacian, IsTheSameBehindItsRenumbering) {
    for (const Mesh& mesh : {shapes::shuffled(shapes::with_noise(shapes::icosphere(3), 0.2)).mesh,
                             shapes::shuffled(shapes::tetrahedral_cube(4)).mesh}) {
        const Laplacian fast(mesh);
        const Laplacian plain(mesh, {.renumber = false});
        const Block u = random_block(mesh.vertex_count(), 2);
        EXPECT_LT(relative_difference(apply_in_user_order(fast, u), apply_in_user_order(plain, u)), 1e-12);
        EXPECT_LT(relative_difference(fast.order().to_user(Block(fast.mass())), Block(plain.mass())), 1e-14);
        EXPECT_LT(fast.graph().bandwidth(), plain.graph().bandwidth() / 2)
            << "renumbering serves to narrow the band";
        for (Index v = 0; v < 5; ++v)
            EXPECT_EQ(plain.order().working(v), v);
    }
}

TEST(Laplacian, TakesTheWeightsAndTheMassThatWereAskedFor) {
    const Mesh mesh = shapes::with_noise(shapes::icosphere(1), 0.2);
    const auto graph = graph_of(mesh);
    const auto weights = [&](Weights w) {
        return Laplacian(mesh, {.weights = w, .renumber = false}).stiffness().edges();
    };
    EXPECT_EQ(weights(Weights::cotangent), stiffness(mesh, graph).edges());
    EXPECT_EQ(weights(Weights::area_weighted), area_weighted_stiffness(mesh, graph).edges());
    EXPECT_EQ(weights(Weights::combinatorial), combinatorial_stiffness(graph).edges());
    EXPECT_EQ(Laplacian(mesh, {.mass = Mass::voronoi, .renumber = false}).mass(),
              lumped_mass(mesh, Mass::voronoi));
    EXPECT_EQ(Laplacian(mesh, {.renumber = false}).mass(), lumped_mass(mesh));
}

TEST(Laplacian, InverseMassIsOneOverTheMassAndZeroWhereThereIsNone) {
    Points points(43, 3);
    points << shapes::icosphere(1).points(), 5.0, 5.0, 5.0;
    const Laplacian laplacian(Mesh(points, shapes::icosphere(1).cells()));
    EXPECT_EQ(laplacian.isolated_vertices(), 1);
    const Index isolated = laplacian.order().working(42);
    EXPECT_EQ(laplacian.inverse_mass()[isolated], 0.0);
    for (Index v = 0; v < 43; ++v) {
        if (v == isolated) continue;
        EXPECT_DOUBLE_EQ(laplacian.inverse_mass()[v] * laplacian.mass()[v], 1.0);
    }
}

TEST(Laplacian, LeavesDegenerateCellsOutAndCountsThem) {
    const Mesh good = shapes::grid(2, 2);
    Points points(10, 3);
    points << good.points(), 0.25, 0.0, 0.0;
    Cells cells(good.cell_count() + 2, 3);
    cells.topRows(good.cell_count()) = good.cells();
    cells.row(good.cell_count()) << 0, 1, 9;
    cells.row(good.cell_count() + 1) << 4, 4, 8;
    for (const Weights weights : {Weights::cotangent, Weights::combinatorial, Weights::area_weighted}) {
        const Laplacian laplacian(Mesh(points, cells), {.weights = weights});
        EXPECT_EQ(laplacian.left_out_cells(), 2);
        EXPECT_EQ(laplacian.isolated_vertices(), 1) << "vertex 9 is in a cell without area only";
        EXPECT_EQ(laplacian.graph().edge_count(), 16);
        EXPECT_TRUE(laplacian.stiffness().diagonal().allFinite());
    }
    EXPECT_EQ(Laplacian(good).left_out_cells(), 0);
}

TEST(Laplacian, RefusesMeshesWithoutCellsOfAnySize) {
    EXPECT_THROW(Laplacian(Mesh(Points::Random(4, 3))), InputError);
    EXPECT_THROW(Laplacian(Mesh(Points::Random(4, 3), Cells(0, 3))), InputError);
    EXPECT_THROW(Laplacian(Mesh(Points::Zero(3, 3), Cells{{0, 1, 2}})), InputError);
    EXPECT_THROW(Laplacian(shapes::tetrahedral_cube(1), {.mass = Mass::voronoi}), InputError);
}

TEST(Laplacian, CanBeMadeOfAnOperatorOfOnesOwn) {
    const auto graph = graph_of(shapes::icosphere(0));
    const Laplacian laplacian(combinatorial_stiffness(graph), Vector::Ones(12), Renumbering::identity(12));
    EXPECT_EQ(laplacian.vertex_count(), 12);
    EXPECT_EQ(laplacian.isolated_vertices(), 0);
    EXPECT_THROW(Laplacian(combinatorial_stiffness(graph), Vector::Ones(11), Renumbering::identity(12)),
                 InputError);
    EXPECT_THROW(Laplacian(combinatorial_stiffness(graph), Vector::Ones(12), Renumbering::identity(11)),
                 InputError);
}

TEST(Laplacian, CopiesShareTheirNumbers) {
    const Laplacian laplacian(shapes::icosphere(1));
    const long before = EdgeOperator<double>::builds();
    const Laplacian copy = laplacian;  // NOLINT(performance-unnecessary-copy-initialization)
    EXPECT_EQ(&copy.stiffness(), &laplacian.stiffness());
    EXPECT_EQ(&copy.mass(), &laplacian.mass());
    EXPECT_EQ(EdgeOperator<double>::builds(), before);
}

TEST(DirichletEnergy, OfLinearFunctionsIsTheirSlope) {
    const Mesh plane = shapes::shuffled(shapes::jittered(shapes::grid(9, 7), 0.3)).mesh;  // the unit square
    const Laplacian laplacian(plane);
    const Renumbering& order = laplacian.order();
    const auto energy = [&](const Block& field) {
        return dirichlet_energy(laplacian, order.to_working(field));
    };
    EXPECT_NEAR(energy(plane.points().col(0)), 0.5, 1e-13);
    EXPECT_NEAR(energy(3.0 * plane.points().col(0) - 4.0 * plane.points().col(1)), 12.5, 1e-12);
    EXPECT_NEAR(energy(Block::Constant(plane.vertex_count(), 2, 7.0)), 0.0, 1e-11);
    EXPECT_NEAR(energy(plane.points()), 1.0, 1e-13);  // of columns the sum
    const Block u = random_block(plane.vertex_count(), 2);
    EXPECT_NEAR(energy(-3.0 * u), 9.0 * energy(u), 1e-10);
    EXPECT_NEAR(energy(u), energy(u.col(0)) + energy(u.col(1)), 1e-11);
    EXPECT_GT(energy(u), 0.0);
}

// Of length, area and volume: 1/2 of the integral of |grad u|^2 scales as the size to the power d - 2.
TEST(DirichletEnergy, ScalesWithTheDimension) {
    const std::vector<Mesh> meshes = {shapes::circle(20), shapes::icosphere(2), shapes::tetrahedral_cube(3)};
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const Laplacian laplacian(meshes[i]);
        const Laplacian larger(testing::scaled(meshes[i], 4.0));
        const Block u = random_block(meshes[i].vertex_count(), 1);
        const double factor = std::array{0.25, 1.0, 4.0}[i];
        EXPECT_NEAR(dirichlet_energy(larger, u), factor * dirichlet_energy(laplacian, u),
                    1e-11 * dirichlet_energy(laplacian, u));
    }
}

}  // namespace
}  // namespace beltrami
