#include "beltrami/apps/membrane/membrane.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/read_mesh.hpp"
#include "beltrami/framework/shapes.hpp"
#include "meshes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::relative_difference;

std::vector<Index> upper_half(const Mesh& mesh, int axis) {
    const double middle = 0.5 * (mesh.points().col(axis).minCoeff() + mesh.points().col(axis).maxCoeff());
    std::vector<Index> vertices;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.points()(v, axis) > middle) vertices.push_back(v);
    }
    return vertices;
}

TEST(Membrane, AnswersInTheUsersOrderAndShowsEveryStep) {
    const Mesh mesh = shapes::icosphere(3);
    const auto [shuffled, new_number] = shapes::shuffled(mesh, 3);
    const std::vector<Index> region = upper_half(mesh, 2);
    std::vector<Index> renumbered;
    for (const Index v : region)
        renumbered.push_back(new_number[static_cast<std::size_t>(v)]);
    const MembraneOptions three{.flow = {.step = 0.1}, .steps = 3};
    const Points film = membrane(mesh, Laplacian(mesh), region, three).points;
    int frames = 0;
    MembraneOptions watched = three;
    watched.on_frame = [&](const Frame& frame) {
        EXPECT_EQ(frame.step, frames++);
        EXPECT_NEAR(frame.time, 0.1 * frame.step, 1e-12);
        EXPECT_EQ(frame.u.row(renumbered.front()) == shuffled.points().row(renumbered.front()),
                  frame.step == 0);
    };
    const MembraneResult other = membrane(shuffled, Laplacian(shuffled), renumbered, watched);
    EXPECT_EQ(frames, 4);
    EXPECT_EQ(other.areas.size(), 4U);
    EXPECT_FALSE(other.at_rest);
    EXPECT_LT(relative_difference(Points(other.points(new_number, Eigen::all)), film), 1e-6);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (std::ranges::count(region, v) == 0) {
            ASSERT_EQ(film.row(v), mesh.points().row(v)) << "held to the last bit";
        }
    }
}

// Figure 7: bunnies whose lower half is held.
TEST(Membrane, BunniesComeToRest) {
    for (const auto& [file, axis] : {std::pair{testing::shared_mesh("bunny_3485.off"), 1},
                                     std::pair{testing::shared_mesh("bunny_res2_dirty.ply"), 1}}) {
        BELTRAMI_SKIP_WITHOUT(file);
        const Mesh bunny = read_mesh(file);
        const Laplacian laplacian(bunny);
        for (const Weights weights : {Weights::area_weighted, Weights::cotangent}) {
            MembraneOptions options{.flow = {.weights = weights}};
            options.free_components = FreeComponents::keep_at_zero;
            const MembraneResult film = membrane(bunny, laplacian, upper_half(bunny, axis), options);
            EXPECT_TRUE(film.at_rest);
            EXPECT_TRUE(film.points.allFinite());
            EXPECT_TRUE(std::is_sorted(film.energy.rbegin(), film.energy.rend()));
            // The area of the region falls to what the rim spans. With area weights it may rise on the way, by little:
            // where triangles that had collapsed unfold.
            EXPECT_LT(film.areas.back(), 0.4 * film.areas.front());
            EXPECT_LT(film.areas.back(), 1.02 * *std::ranges::min_element(film.areas));
            const double low = bunny.points().col(axis).minCoeff();
            const double high = bunny.points().col(axis).maxCoeff();
            for (Index v = 0; v < bunny.vertex_count(); ++v) {
                if (laplacian.graph().degree(laplacian.order().working(v)) == 0) continue;
                ASSERT_LE(film.points(v, axis), 0.5 * (low + high) + 0.05 * (high - low))
                    << "nothing sticks out of the film";
            }
        }
    }
}

TEST(Membrane, ComponentsThatNothingHoldsAreRefusedOrStay) {
    const Mesh two = shapes::together({shapes::icosphere(1), shapes::icosphere(1)});
    std::vector<Index> region(42 + 20);
    std::iota(region.begin(), region.end(), 0);
    EXPECT_THROW((void)membrane(two, Laplacian(two), region, {}), InputError);
    const MembraneResult film =
        membrane(two, Laplacian(two), region, {.free_components = FreeComponents::keep_at_zero});
    EXPECT_EQ(film.points.topRows(42), two.points().topRows(42));
    EXPECT_GT((film.points - two.points()).bottomRows(42).cwiseAbs().maxCoeff(), 0.1);
}

TEST(Membrane, CanBeCancelledBetweenSteps) {
    const Mesh mesh = shapes::icosphere(2);
    Progress progress;
    int frames = 0;
    MembraneOptions options{.steps = 100, .progress = &progress};
    options.on_frame = [&](const Frame&) {
        if (++frames == 3) progress.cancel();
    };
    EXPECT_THROW((void)membrane(mesh, Laplacian(mesh), upper_half(mesh, 2), options), Cancelled);
    EXPECT_EQ(frames, 3);
}

TEST(Membrane, IsolatedVerticesStayAndAreCounted) {
    Points points(43, 3);
    points << shapes::icosphere(1).points(), 9.0, 9.0, 9.0;
    const Mesh mesh(points, shapes::icosphere(1).cells());
    const std::vector<Index> region = {0, 1, 2, 42};
    const MembraneResult film = membrane(mesh, Laplacian(mesh), region, {});
    EXPECT_EQ(film.stayed, 1);
    EXPECT_EQ(film.points.row(42), points.row(42));
    EXPECT_EQ(membrane(mesh, Laplacian(mesh), std::vector<Index>{42}, {}).points, points)
        << "a region that has nothing to move is at rest";
}

TEST(Membrane, RefusesWhatHasNoAnswer) {
    const Mesh mesh = shapes::icosphere(1);
    const Laplacian laplacian(mesh);
    const std::vector<Index> region = {0, 1};
    const std::vector<Index> outside = {42};
    EXPECT_THROW((void)membrane(mesh, laplacian, {}, {}), InputError);
    EXPECT_THROW((void)membrane(mesh, laplacian, outside, {}), InputError);
    EXPECT_THROW((void)membrane(mesh, laplacian, region, {.steps = -1}), InputError);
    EXPECT_THROW((void)membrane(mesh, laplacian, region, {.flow = {.step = -1.0}}), InputError);
    const Mesh solid = shapes::tetrahedral_cube(2);
    EXPECT_THROW((void)membrane(solid, Laplacian(solid), region, {}), InputError);
}

}  // namespace
}  // namespace beltrami
