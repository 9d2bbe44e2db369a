#include "beltrami/apps/poisson/poisson.hpp"

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/gradient.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::random_block;
using testing::relative_difference;

TEST(Poisson, SolvesKuEqualsMinusMf) {
    const Mesh mesh = shapes::shuffled(shapes::with_noise(shapes::icosphere(2), 0.2)).mesh;
    const Laplacian laplacian(mesh);
    const Block f = random_block(mesh.vertex_count(), 2);
    Constraints fixed(2);
    fixed.fix(7, std::vector{1.0, 2.0});
    const Block u = poisson(laplacian, f, fixed).u;
    EXPECT_EQ(u(7, 1), 2.0);
    const Laplacian plain(mesh, {.renumber = false});
    Block Ku;
    plain.stiffness().apply(u, Ku);
    Block residual = Ku + plain.mass().asDiagonal() * f;
    residual.row(7).setZero();
    EXPECT_LT(residual.norm(), 1e-8 * Ku.norm());
}

TEST(Poisson, FindsAFieldFromItsGradient) {
    // In the plane a linear field has the same gradient everywhere, so averages over vertices and cells are
    // exact.
    const Mesh mesh = shapes::shuffled(shapes::jittered(shapes::grid(10, 8), 0.3)).mesh;
    const Vector3 slope(2.0, -1.0, 0.0);
    const Vector linear = mesh.points() * slope;
    const Points vectors = slope.transpose().replicate(mesh.vertex_count(), 1);
    const Block u = poisson_from_gradient(mesh, Laplacian(mesh), vectors, Constraints{{5, linear[5]}}).u;
    EXPECT_LT(relative_difference(u, Block(linear)), 1e-9);
}

TEST(Poisson, LeavesIsolatedVerticesAtZero) {
    Points points(43, 3);
    points << shapes::icosphere(1).points(), 9.0, 9.0, 9.0;
    const Laplacian laplacian(Mesh(points, shapes::icosphere(1).cells()));
    const Block u = poisson(laplacian, Block::Ones(43, 1), Constraints{{0, 1.0}}).u;
    EXPECT_EQ(u(42, 0), 0.0);
    EXPECT_TRUE(u.allFinite());
}

TEST(Poisson, RefusesWhatHasNoAnswer) {
    const Mesh mesh = shapes::icosphere(0);
    const Laplacian laplacian(mesh);
    const Constraints fixed{{0, 1.0}};
    EXPECT_THROW((void)poisson(laplacian, Block::Zero(11, 1), fixed), InputError);
    EXPECT_THROW((void)poisson(laplacian, Block::Zero(12, 2), fixed), InputError);
    EXPECT_THROW((void)poisson(laplacian, Block::Zero(12, 1), Constraints()), InputError);
    EXPECT_THROW((void)poisson(laplacian, Block::Zero(12, 1), Constraints{{12, 0.0}}), InputError);
    EXPECT_THROW((void)poisson_from_gradient(mesh, laplacian, Points::Zero(11, 3), fixed), InputError);
    EXPECT_THROW((void)poisson_from_gradient(shapes::icosphere(1), laplacian, Points::Zero(42, 3), fixed),
                 InputError);
}

}  // namespace
}  // namespace beltrami
