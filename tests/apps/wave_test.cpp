#include "beltrami/apps/wave/wave.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/mass.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::random_block;
using testing::relative_difference;

TEST(Wave, MidpointKeepsTheEnergy) {
    const Laplacian laplacian(shapes::icosphere(2));
    const Evolution result = wave(laplacian, random_block(162, 1), Constraints{{3, 0.5}},
                                  {.time = 10.0,
                                   .steps = 300,
                                   .method = TimeMethod::implicit_midpoint,
                                   .linear = {.kind = SolverKind::cholesky}});
    EXPECT_NEAR(result.energy_after, result.energy_before, 1e-9 * result.energy_before);
    EXPECT_GT(result.energy_before, 0.0);
}

TEST(Wave, DampingTakesEnergy) {
    const Laplacian laplacian(shapes::icosphere(2));
    const EvolveOptions options{.time = 1.0, .steps = 50, .method = TimeMethod::implicit_midpoint};
    for (const Damping& damping : {Damping{.beta_1 = 1.0}, Damping{.beta_2 = 0.1}}) {
        const Evolution result = wave(laplacian, random_block(162, 1), Constraints(), options, damping);
        EXPECT_LT(result.energy_after, 0.5 * result.energy_before);
    }
}

// An impulse is momentum: what it moves in the mean does not depend on the mesh or on the vertex.
TEST(Wave, AnImpulseMovesTheMeanByItsMomentumOverTheMass) {
    for (const int level : {1, 3}) {
        const Mesh sphere = shapes::shuffled(shapes::icosphere(level)).mesh;
        const Vector mass = lumped_mass(sphere);
        for (const Index v : {0, 41}) {
            const Block still = Block::Zero(sphere.vertex_count(), 2);
            Constraints impulses(2);
            impulses.fix(v, std::array{3.0, -1.0});
            const EvolveOptions options{.time = 2.0, .steps = 20, .method = TimeMethod::implicit_midpoint};
            const Block u = wave(Laplacian(sphere), still, impulses, options).u;
            const Vector momentum = u.transpose() * mass / 2.0;
            EXPECT_NEAR(momentum[0], 3.0, 1e-7);
            EXPECT_NEAR(momentum[1], -1.0, 1e-7);
        }
    }
}

// One unit of length in one unit of time, on a ring where waves keep their shape.
TEST(Wave, TravelsAtUnitSpeed) {
    const Mesh ring = shapes::circle(800, 1.0);
    const auto bump = [&](double at) {
        Block u(800, 1);
        for (Index v = 0; v < 800; ++v) {
            const double angle =
                std::remainder(2.0 * std::numbers::pi * v / 800 - at, 2.0 * std::numbers::pi);
            u(v, 0) = std::exp(-20.0 * angle * angle);
        }
        return u;
    };
    const EvolveOptions options{.time = 1.0, .steps = 400, .method = TimeMethod::implicit_midpoint};
    const Block u = wave(Laplacian(ring), bump(3.0), Constraints(), options).u;
    EXPECT_LT(relative_difference(u, Block(0.5 * (bump(2.0) + bump(4.0)))), 0.01);
}

TEST(Wave, RefusesImpulsesThatCannotAct) {
    Points points(13, 3);
    points << shapes::icosphere(0).points(), 9.0, 9.0, 9.0;
    const Laplacian laplacian(Mesh(points, shapes::icosphere(0).cells()));
    const EvolveOptions options{.time = 1.0, .steps = 1};
    EXPECT_THROW((void)wave(laplacian, Block::Zero(13, 1), Constraints{{12, 1.0}}, options), InputError);
    EXPECT_THROW((void)wave(laplacian, Block::Zero(13, 1), Constraints{{13, 1.0}}, options), InputError);
    EXPECT_THROW((void)wave(laplacian, Block::Zero(13, 2), Constraints{{0, 1.0}}, options), InputError);
    EXPECT_THROW((void)wave(laplacian, Block::Zero(12, 1), Constraints{{12, 1.0}}, options), InputError);
    EXPECT_THROW((void)wave(laplacian, Block::Zero(12, 1), Constraints(), options), InputError);
    EXPECT_THROW((void)wave(laplacian, Block::Zero(13, 1), Constraints(), options, {.beta_1 = -1.0}),
                 InputError);
}

}  // namespace
}  // namespace beltrami
