#include "beltrami/apps/heat/heat.hpp"

#include <limits>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::random_block;
using testing::relative_difference;

TEST(Heat, ShowsTheStartAndEveryStepInTheUsersOrder) {
    const Mesh mesh = shapes::shuffled(shapes::icosphere(2)).mesh;
    const Block initial = random_block(mesh.vertex_count(), 1);
    std::vector<double> times;
    Block first;
    Block last;
    const Evolution result = heat(Laplacian(mesh), initial, Constraints{{5, 100.0}},
                                  {.time = 0.5, .steps = 4, .on_frame = [&](const Frame& frame) {
                                       EXPECT_EQ(frame.step, static_cast<int>(times.size()));
                                       times.push_back(frame.time);
                                       (times.size() == 1 ? first : last) = frame.u;
                                       EXPECT_EQ(frame.u(5, 0), 100.0);
                                   }});
    EXPECT_EQ(times, (std::vector{0.0, 0.125, 0.25, 0.375, 0.5}));
    Block expected = initial;
    expected(5, 0) = 100.0;
    EXPECT_EQ(first, expected) << "held values are imposed on the start";
    EXPECT_EQ(last, result.u);
}

// No new extremes: backward Euler with a lumped mass on a Delaunay mesh keeps to them for any step.
TEST(Heat, BackwardEulerObeysTheMaximumPrinciple) {
    const Laplacian laplacian(shapes::icosphere(3));
    Block initial = Block::Zero(laplacian.vertex_count(), 1);
    initial(17, 0) = 1.0;
    for (const double time : {1e-4, 0.1, 10.0}) {
        const Evolution result = heat(laplacian, initial, Constraints(), {.time = time, .steps = 3});
        EXPECT_GT(result.u.minCoeff(), -1e-8);
        EXPECT_LT(result.u.maxCoeff(), 1.0);
        EXPECT_LT(result.energy_after, result.energy_before);
    }
}

TEST(Heat, IsNotBuiltAgainForOtherSources) {
    const long before = EdgeOperator<double>::builds();
    const Laplacian laplacian(shapes::icosphere(2));
    for (Index source = 0; source < 10; ++source) {
        (void)heat(laplacian, Block::Zero(162, 1), Constraints{{source, 1.0}}, {.time = 0.1, .steps = 2});
    }
    EXPECT_EQ(EdgeOperator<double>::builds(), before + 1);
}

TEST(Heat, CanBeCancelledBetweenSteps) {
    Progress* self = nullptr;
    int frames = 0;
    Progress progress;
    self = &progress;
    EXPECT_THROW((void)heat(Laplacian(shapes::icosphere(1)), random_block(42, 1), Constraints(),
                            {.time = 1.0,
                             .steps = 100,
                             .progress = &progress,
                             .on_frame =
                                 [&](const Frame&) {
                                     if (++frames == 3) self->cancel();
                                 }}),
                 Cancelled);
    EXPECT_EQ(frames, 3);
}

TEST(Heat, IsolatedVerticesKeepTheirInitialValue) {
    Points points(43, 3);
    points << shapes::icosphere(1).points(), 9.0, 9.0, 9.0;
    const Block u = heat(Laplacian(Mesh(points, shapes::icosphere(1).cells())), Block::Constant(43, 1, 4.0),
                         Constraints{{0, 0.0}}, {.time = 1.0, .steps = 5, .method = TimeMethod::bdf2})
                        .u;
    EXPECT_EQ(u(42, 0), 4.0);
    EXPECT_LT(u(1, 0), 4.0);
}

TEST(Heat, RefusesWrongShapesAndTimes) {
    const Laplacian laplacian(shapes::icosphere(0));
    const EvolveOptions good{.time = 1.0, .steps = 1};
    EXPECT_THROW((void)heat(laplacian, Block::Zero(11, 1), Constraints{{11, 1.0}}, good), InputError);
    EXPECT_THROW((void)heat(laplacian, Block::Zero(11, 1), Constraints(), good), InputError);
    EXPECT_THROW((void)heat(laplacian, Block::Zero(13, 1), Constraints(), good), InputError);
    EXPECT_THROW((void)heat(laplacian, Block::Zero(12, 2), Constraints{{0, 1.0}}, good), InputError);
    EXPECT_THROW((void)heat(laplacian, Block::Zero(12, 1), Constraints{{12, 1.0}}, good), InputError);
    for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
        EXPECT_THROW((void)heat(laplacian, Block::Zero(12, 1), Constraints(), {.time = bad, .steps = 1}),
                     InputError);
    }
    EXPECT_THROW((void)heat(laplacian, Block::Zero(12, 1), Constraints(), {.time = 1.0, .steps = 0}),
                 InputError);
}

}  // namespace
}  // namespace beltrami
