#include "beltrami/apps/poke/poke.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "expect_text.hpp"

namespace beltrami::testing {
namespace {

const Vector3 up(0.0, 0.0, 1.0);

ContactPath press(const Vector3& point, double depth, double duration) {
    return {{0.0, point, Vector3::Zero(), "a:1"},
            {0.5 * duration, point, -depth * up, "a:2"},
            {duration, point, -depth * up, "a:3"}};
}

struct Recorded {
    std::vector<Index> active;
    std::vector<Vector3> force, point;
    std::vector<double> lag;
};

PokeResult run(const Mesh& mesh, const std::vector<ContactPath>& paths, PokeOptions options,
               Recorded& recorded) {
    options.on_step = [&](const PokeStep& step) {
        recorded.active.push_back(step.local.active);
        recorded.force.push_back(step.contacts[0].force);
        recorded.point.push_back(step.contacts[0].at.point);
        recorded.lag.push_back(step.lag);
    };
    return poke(mesh, Laplacian(mesh), paths, options);
}

TEST(Poke, PressesHoldsAndComesToRest) {
    const Mesh sphere = shapes::icosphere(5);
    PokeOptions options{.skin = skin_of(sphere)};
    Recorded recorded;
    const PokeResult result = run(sphere, {press(up, 0.1, 0.1)}, options, recorded);
    EXPECT_TRUE(result.at_rest);
    EXPECT_EQ(result.steps, static_cast<int>(recorded.active.size()));
    EXPECT_EQ(result.displacement.cwiseAbs().maxCoeff(), 0.0);
    EXPECT_EQ(*std::max_element(recorded.active.begin(), recorded.active.end()), result.most_active);
    EXPECT_LT(result.most_active, sphere.vertex_count() / 2);
    EXPECT_GT(recorded.active[60], 10);
    EXPECT_EQ(result.late_steps, 0);
    EXPECT_FALSE(result.whole);
    // Pressed down, it pushes back along the path; once the finger is gone there is no force.
    EXPECT_LT(recorded.force[90].z(), 0.0);
    EXPECT_LT(recorded.force[90].head<2>().norm(), 1e-3 * std::abs(recorded.force[90].z()));
    EXPECT_EQ(recorded.force[110], Vector3::Zero());
    EXPECT_GE(result.work, result.dissipated * (1.0 - 1e-9));
}

TEST(Poke, StopsWhenTold) {
    const Mesh sphere = shapes::icosphere(4);
    Recorded recorded;
    const PokeResult result =
        run(sphere, {press(up, 0.1, 0.1)}, {.skin = skin_of(sphere), .time = 0.05}, recorded);
    EXPECT_EQ(result.steps, 50);
    EXPECT_FALSE(result.at_rest);
    // The last step was at 0.049: pressed nearly all the way.
    EXPECT_NEAR(result.displacement.col(2).minCoeff(), -0.098, 1e-3);
}

// Over vertices, edges and triangles: the force changes little from step to step. A finger that jumps from vertex to
// vertex along the same way is what that is compared with.
TEST(Poke, SlidesWithoutJumps) {
    const Mesh sphere = shapes::bumpy_sphere(4000);
    const Vector3 a = sphere.points().row(100).transpose();
    const Vector3 b = sphere.points().row(140).transpose();
    const Vector3 push = -0.05 * a.normalized();
    const SurfaceSearch surface(sphere);
    const ContactPath slide = {{0.0, a, push, "a:1"}, {0.2, b, push, "a:2"}};
    ContactPath jump;
    for (int i = 0; i < 200; ++i) {
        const SurfacePoint hit = surface.closest(a + (b - a) * (i / 199.0));
        const auto heaviest = static_cast<std::size_t>(
            std::max_element(hit.weights.begin(), hit.weights.end()) - hit.weights.begin());
        jump.push_back({1e-3 * i, sphere.points().row(hit.vertices[heaviest]).transpose(), push, "b"});
    }
    const auto largest_jump = [&](const ContactPath& path) {
        Recorded recorded;
        const PokeResult result = run(sphere, {path}, {.skin = skin_of(sphere)}, recorded);
        double largest = 0.0;
        // From when the first push has died down, while it touches.
        for (std::size_t i = 50; i + 1 < 200; ++i)
            largest =
                std::max(largest, (recorded.force[i + 1] - recorded.force[i]).norm() / result.largest_force);
        return largest;
    };
    const double sliding = largest_jump(slide);
    EXPECT_LT(sliding, 0.03);
    EXPECT_GT(largest_jump(jump), 5.0 * sliding);
}

TEST(Poke, TouchesSolidsAndSeveralPointsAtOnce) {
    const Mesh ball = shapes::tetrahedral_ball(6);
    int touching = 0;
    PokeOptions options{.skin = skin_of(ball)};
    options.on_step = [&](const PokeStep& step) {
        touching =
            std::max(touching, (step.contacts[0].touching ? 1 : 0) + (step.contacts[1].touching ? 1 : 0));
    };
    ContactPath later = press(-up, -0.05, 0.05);
    for (Waypoint& w : later)
        w.time += 0.02;
    const PokeResult result = poke(ball, Laplacian(ball), {press(up, 0.05, 0.05), later}, options);
    EXPECT_EQ(touching, 2);
    EXPECT_GT(result.largest_force, 0.0);
}

TEST(Poke, RefusesWhatCannotBeDone) {
    const Mesh sphere = shapes::icosphere(3);
    const Laplacian laplacian(sphere);
    const PokeOptions options{.skin = skin_of(sphere)};
    const auto refused = [&](const std::vector<ContactPath>& paths, const PokeOptions& with,
                             std::initializer_list<std::string> parts) {
        try {
            (void)poke(sphere, laplacian, paths, with);
            ADD_FAILURE() << "accepted";
        } catch (const InputError& error) {
            EXPECT_TRUE(contains(error.what(), parts));
            EXPECT_NE(error.hint(), "");
        }
    };
    refused({}, options, {"nothing touches"});
    refused({{}}, options, {"no path"});
    refused({{{0.0, up, up, "a:1"}, {0.1, 2.0 * up, up, "a:2"}}}, options, {"a:2", "leaves the surface"});
    refused({{{0.0, up, up, "a:1"}, {0.0, up, up, "a:2"}}}, options, {"a:2", "time"});
    refused({{{0.1, up, up, "a:1"}, {0.0, up, up, "a:2"}}}, options, {"a:2", "from 0.1 to 0"});
    refused({{{0.0, up, up, "a:1"}, {0.1, -up, up, "a:2"}}}, options, {"a:2", "straight way"});
    refused({press(up, 0.1, 0.1), press(up, -0.1, 0.1)}, options, {"another value"});
    refused({{{NAN, up, up, "a:1"}}}, options, {"a:1", "not finite"});
    refused({{{0.0, Vector3(NAN, 0, 0), up, "a:1"}}}, options, {"nowhere"});
    for (const double rate : {0.0, -1000.0, double{INFINITY}, double{NAN}}) {
        PokeOptions with = options;
        with.rate = rate;
        refused({press(up, 0.1, 0.1)}, with, {"rate"});
    }
    PokeOptions hurried = options;
    hurried.rate = 1e9;
    hurried.real_time = true;
    refused({press(up, 0.1, 1e-8)}, hurried, {"cannot be met"});
    PokeOptions weightless = options;
    weightless.skin.alpha = 0.0;
    refused({press(up, 0.1, 0.1)}, weightless, {"no mass"});
    PokeOptions no_time = options;
    no_time.time = -1.0;
    refused({press(up, 0.1, 0.1)}, no_time, {"time"});
}

TEST(TouchedSurface, MakesTheStepsOfPoke) {
    const Mesh sphere = shapes::shuffled(shapes::icosphere(4)).mesh;
    const Laplacian laplacian(sphere);
    const ContactPath path = press(up, 0.1, 0.05);
    PokeOptions options{.skin = skin_of(sphere)};
    TouchedSurface skin(sphere, laplacian, options);
    options.on_step = [&](const PokeStep& step) {
        // The path between its waypoints, as poke() has it.
        std::optional<Contact> contact;
        if (step.contacts[0].touching) contact = {path.front().point, step.contacts[0].displacement};
        const LocalStep local = skin.advance(std::array{contact});
        ASSERT_EQ(skin.contacts().size(), 1U);
        EXPECT_EQ(skin.contacts()[0].touching, step.contacts[0].touching);
        EXPECT_EQ(skin.contacts()[0].force, step.contacts[0].force);
        EXPECT_EQ(local.active, step.local.active);
        EXPECT_EQ(local.iterations, step.local.iterations);
        EXPECT_EQ(local.energy, step.local.energy);
        EXPECT_EQ(skin.motion().u(), step.motion.u());
    };
    const PokeResult result = poke(sphere, laplacian, {path}, options);
    EXPECT_GT(result.steps, 50);
    EXPECT_TRUE(skin.motion().domain().empty());
}

// What holds the surface in place is its foundation: no other term has a total. A narrow domain would be held by its rim, too.
TEST(TouchedSurface, TheForceOfAHeldContactIsThatOfTheFoundation) {
    const Mesh ball = shapes::icosphere(4);
    const Laplacian laplacian(ball);
    const Pde pde = skin_of(ball);
    PokeOptions options{.skin = pde};
    options.local.tolerance = 1e-10;
    TouchedSurface skin(ball, laplacian, options);
    const std::array<std::optional<Contact>, 2> contacts{Contact{up, -0.05 * up},
                                                         Contact{Vector3::UnitX(), Vector3(0.01, 0.02, 0.0)}};
    for (int step = 0; step < 500; ++step)
        skin.advance(contacts);
    const Vector3 force = skin.contacts()[0].force + skin.contacts()[1].force;
    const Vector3 carried =
        pde.foundation * (laplacian.mass().asDiagonal() * skin.motion().u()).colwise().sum().transpose();
    EXPECT_LT((force - carried).norm(), 1e-3 * carried.norm());
    EXPECT_LT(skin.contacts()[0].force.z(), 0.0);
}

TEST(TouchedSurface, OppositeFingersPushWithOppositeForces) {
    const Mesh ball = shapes::icosphere(4);
    TouchedSurface skin(ball, Laplacian(ball), {.skin = skin_of(ball)});
    const Vector3 a = ball.points().row(0).transpose();
    for (int step = 0; step < 20; ++step) {
        const double depth = 0.002 * (step + 1);
        skin.advance(std::array<std::optional<Contact>, 2>{Contact{a, -depth * a}, Contact{-a, depth * a}});
        const Vector3 both = skin.contacts()[0].force + skin.contacts()[1].force;
        EXPECT_LT(both.norm(), 1e-3 * skin.contacts()[0].force.norm());
    }
}

TEST(TouchedSurface, ComesToRestAfterRelease) {
    const Mesh ball = shapes::icosphere(4);
    TouchedSurface skin(ball, Laplacian(ball), {.skin = skin_of(ball)});
    const std::optional<Contact> finger = Contact{up, -0.1 * up};
    for (int touch = 0; touch < 2; ++touch) {
        for (int step = 0; step < 30; ++step)
            skin.advance(std::array{finger});
        EXPECT_GT(skin.motion().domain().end(0), 3);
        int steps = 0;
        for (; !skin.motion().domain().empty() && steps < 2000; ++steps) {
            skin.advance({});
            EXPECT_TRUE(skin.contacts().empty());
        }
        EXPECT_LT(steps, 2000);
        EXPECT_TRUE(skin.motion().u().isZero(0.0));
    }
}

TEST(TouchedSurface, RefusesWhatItCannotBe) {
    const Mesh ball = shapes::icosphere(2);
    const Laplacian laplacian(ball);
    EXPECT_THROW(TouchedSurface(ball, laplacian, {.skin = skin_of(ball), .rate = 0.0}), InputError);
    EXPECT_THROW(TouchedSurface(ball, laplacian, {.skin = {}, .rate = 100.0}), InputError);
    const Mesh ring = shapes::circle(12);
    EXPECT_THROW(TouchedSurface(ring, Laplacian(ring), {.skin = skin_of(ring)}), InputError);
}

}  // namespace
}  // namespace beltrami::testing
