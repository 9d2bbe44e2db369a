// Motion on a domain that adjusts itself, against the motion of the whole mesh.

#include "beltrami/solvers/local_integrator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"
#include "refined.hpp"

namespace beltrami::testing {
namespace {

constexpr double dt = 1e-3;
using std::numbers::pi;

// A skin that swings back at 10 per second, and moves with its surroundings over `reach` mean edge lengths.
Pde skin(const Laplacian& laplacian, double reach, double damping) {
    const double l2 = reach * reach * laplacian.mass().sum() / laplacian.vertex_count();
    const double w2 = std::pow(2.0 * pi * 10.0, 2);
    return {.alpha = 1.0,
            .beta_1 = damping,
            .beta_2 = 1e-4 * damping,
            .gamma = {0.2 * w2 * l2, w2 * l2 * l2},
            .foundation = w2};
}

double energy_norm(const Laplacian& laplacian, const Pde& pde, const Block& u, const Block& v) {
    Block stretched;
    PdeOperator(laplacian, pde.foundation, pde.gamma).apply(u, stretched);
    return std::sqrt(0.5 * pde.alpha * (laplacian.mass().asDiagonal() * v.cwiseAbs2()).sum() +
                     0.5 * u.cwiseProduct(stretched).sum());
}

struct Motion {
    std::string shape;
    double reach;
    double damping;
    double tolerance;
};

class LocalIntegratorOn : public ::testing::TestWithParam<Motion> {};

// Pressed down for 40 steps and let go; the whole mesh moves along by TimeIntegrator and Cholesky.
TEST_P(LocalIntegratorOn, StaysWithinItsBoundOfTheWholeMesh) {
    const auto& [shape, reach, damping, tolerance] = GetParam();
    const Laplacian laplacian(shapes::from_name(shape));
    const Pde pde = skin(laplacian, reach, damping);
    LocalIntegrator local(laplacian, pde, dt, 3, {.tolerance = tolerance});
    TimeIntegrator global(laplacian, pde,
                          {.step = dt,
                           .method = TimeMethod::backward_euler,
                           .steps = 200,
                           .linear = {.kind = SolverKind::cholesky, .tolerance = 1e-12}});
    global.set_state(Block::Zero(laplacian.vertex_count(), 3));
    const Index v = laplacian.vertex_count() / 3;
    bool appeared = false;
    double largest_force = 0.0;
    for (int step = 1; step <= 120; ++step) {
        std::vector<Hold> holds;
        Constraints held(3);
        if (step <= 40) {
            const std::array<double, 3> down{0.0, 0.1 * std::sin(pi * step / 80.0), -0.2 * step / 40.0};
            holds.push_back({{v}, {1.0}, {down.begin(), down.end()}});
            held.fix(v, down);
        }
        const LocalStep result = local.advance(holds);
        global.advance(held);
        ASSERT_TRUE(result.converged) << step;
        appeared = appeared || result.active > 0;
        const double error = energy_norm(laplacian, pde, local.u() - global.u(), local.v() - global.v());
        ASSERT_LE(error, result.error_bound * 1.001 + 1e-9 * result.scale) << "step " << step;
        if (result.active > 0) {
            EXPECT_LE(result.put_in, 1.5 * tolerance * result.scale);
            EXPECT_NEAR(result.energy, std::pow(energy_norm(laplacian, pde, local.u(), local.v()), 2),
                        1e-8 * result.scale * result.scale);
        }
        if (step <= 40) {
            const Block expected = global.reaction().row(v);
            largest_force = std::max(largest_force, expected.norm());
            EXPECT_LT((local.forces() - expected).norm(), 5.0 * tolerance * largest_force) << "step " << step;
            for (Index c = 0; c < 3; ++c)
                EXPECT_NEAR(local.u()(v, c), holds[0].value[static_cast<std::size_t>(c)], 1e-12);
        }
    }
    EXPECT_TRUE(appeared);
    EXPECT_DOUBLE_EQ(local.time(), 120 * dt);
}

INSTANTIATE_TEST_SUITE_P(Motions, LocalIntegratorOn,
                         ::testing::Values(Motion{"icosphere:4", 1.5, 20.0, 1e-2},
                                           Motion{"icosphere:4", 2.5, 100.0, 1e-3},
                                           Motion{"bumpy-sphere:4000", 1.5, 50.0, 1e-3},
                                           Motion{"fins:4:20", 2.0, 50.0, 1e-3},
                                           Motion{"tetrahedral-ball:9", 1.0, 50.0, 1e-2}));

TEST(LocalIntegrator, TheDomainAppearsGrowsAndIsEmptyAfterRelease) {
    const Laplacian laplacian(shapes::icosphere(5));
    LocalIntegrator motion(laplacian, skin(laplacian, 2.0, 150.0), dt, 3, {.tolerance = 1e-2});
    EXPECT_TRUE(motion.domain().empty());
    const Index v = 5000;
    std::vector<Index> sizes;
    for (int step = 1; step <= 50; ++step) {
        sizes.push_back(motion.advance(std::array{Hold{{v}, {1.0}, {0.0, 0.0, -0.1 * step / 50.0}}}).active);
        EXPECT_TRUE(motion.domain().is_active(v));
    }
    EXPECT_GT(sizes.front(), 0);
    EXPECT_GT(sizes.back(), 2 * sizes.front());
    EXPECT_LT(sizes.back(), laplacian.vertex_count() / 2) << "the patch is local";
    Index before = sizes.back();
    bool shrank = false;
    int step = 0;
    for (; step < 2000 && !motion.domain().empty(); ++step) {
        const LocalStep result = motion.advance({});
        shrank = shrank || (result.active > 0 && result.active < before);
        before = result.active;
    }
    EXPECT_TRUE(motion.domain().empty());
    EXPECT_TRUE(shrank) << "before it vanished";
    EXPECT_LT(step, 500);
    EXPECT_EQ(motion.u().cwiseAbs().maxCoeff(), 0.0);
    // Nothing to do at rest.
    const LocalStep rest = motion.advance({});
    EXPECT_EQ(rest.active, 0);
    EXPECT_EQ(rest.iterations, 0);
    EXPECT_EQ(rest.bytes, 0.0);
}

TEST(LocalIntegrator, TenThousandRandomContactsLeakNothing) {
    const Mesh mesh = shapes::bumpy_sphere(600);
    const Laplacian laplacian(mesh);
    LocalIntegrator motion(laplacian, skin(laplacian, 0.5, 120.0), 0.02, 1, {.tolerance = 1e-2});
    std::mt19937 engine(3);
    const auto random = [&](int below) {
        return static_cast<Index>(engine() % static_cast<unsigned>(below));
    };
    double work = 0.0;
    double dissipated = 0.0;
    double largest = 0.0;
    int rests = 0;
#ifdef __SANITIZE_ADDRESS__
    constexpr int contacts = 500;
#else
    constexpr int contacts = 10000;
#endif
    for (int contact = 0; contact < contacts; ++contact) {
        // At a vertex, on an edge or inside a triangle, for one to three steps, then none for up to nine.
        const Index t = random(mesh.cell_count());
        const int corners = 1 + random(3);
        Hold hold{{}, {}, {0.02 * (random(200) - 100) / 100.0}};
        for (int k = 0; k < corners; ++k) {
            hold.vertices.push_back(laplacian.order().working(mesh.cells()(t, k)));
            hold.weights.push_back(1.0 / corners);
        }
        for (int step = 1 + random(3); step > 0; --step) {
            const LocalStep result = motion.advance(std::array{hold});
            ASSERT_TRUE(result.converged);
            work += result.work;
            dissipated += result.dissipated;
            largest = std::max(largest, result.energy);
            ASSERT_GE(work - dissipated - result.energy, -1e-9 * largest);
        }
        for (int step = random(10); step > 0; --step) {
            const LocalStep result = motion.advance({});
            dissipated += result.dissipated;
            ASSERT_GE(work - dissipated - result.energy, -1e-9 * largest);
            rests += result.active == 0 ? 1 : 0;
        }
    }
    int steps = 0;
    for (; steps < 1000 && !motion.domain().empty(); ++steps)
        (void)motion.advance({});
    EXPECT_TRUE(motion.domain().empty());
    EXPECT_EQ(motion.domain().slot_count(), 1);
    EXPECT_EQ(motion.u().cwiseAbs().maxCoeff(), 0.0);
    EXPECT_GT(rests, contacts / 100) << "the domain vanished between contacts too";
    // Storage is that of the largest domain, not of ten thousand.
    EXPECT_LT(motion.memory_bytes(), 3U << 20U);
}

// Energy put in by contacts is never less than what is stored plus dissipated, whatever they do.
TEST(LocalIntegrator, IsPassive) {
    const Laplacian laplacian(shapes::jittered(shapes::grid(40, 40), 0.2));
    for (const double damping : {0.0, 30.0}) {
        Pde pde = skin(laplacian, 1.5, damping);
        LocalIntegrator motion(laplacian, pde, dt, 2, {.tolerance = 1e-3});
        std::mt19937 engine(11);
        const auto random = [&] { return 2.0 * (engine() / 4294967295.0) - 1.0; };
        std::array<double, 2> place{};
        double balance = 0.0;  // put in - dissipated
        double largest = 0.0;
        for (int step = 0; step < 300; ++step) {
            for (double& p : place)
                p += 0.02 * random();
            std::vector<Hold> holds;
            if (step % 60 < 40) holds.push_back({{800}, {1.0}, {place.begin(), place.end()}});
            if (step % 50 < 20) holds.push_back({{850, 851}, {0.4, 0.6}, {-place[0], place[1]}});
            const LocalStep result = motion.advance(holds);
            ASSERT_TRUE(result.converged);
            ASSERT_GE(result.dissipated, 0.0);
            balance += result.work - result.dissipated;
            largest = std::max(largest, balance);
            ASSERT_GE(balance - result.energy, -1e-9 * largest) << "step " << step;
            // The books agree with what can be computed of the state.
            ASSERT_NEAR(result.energy, std::pow(energy_norm(laplacian, pde, motion.u(), motion.v()), 2),
                        1e-8 * largest);
        }
    }
}

// Short steps in which next to nothing changes, and large tolerances.
TEST(LocalIntegrator, IsPassiveAndComesToRestWhateverTheStepAndTheTolerance) {
    const Laplacian laplacian(shapes::icosphere(3));
    const Pde pde = skin(laplacian, 1.5, 100.0);
    for (const double step : {1e-2, 1e-3, 1e-4}) {
        for (const double tolerance : {1e-3, 2e-2, 0.5}) {
            LocalIntegrator motion(laplacian, pde, step, 2, {.tolerance = tolerance});
            double balance = 0.0;
            double largest = 0.0;
            const auto pressed = static_cast<int>(0.02 / step);
            for (int s = 1; s <= pressed; ++s) {
                const LocalStep result =
                    motion.advance(std::array{Hold{{300}, {1.0}, {0.1 * s / pressed, -0.2 * s / pressed}}});
                balance += result.work - result.dissipated;
                largest = std::max(largest, balance);
                ASSERT_GE(balance - result.energy, -1e-9 * largest) << step << " " << tolerance << " " << s;
            }
            const auto most = static_cast<int>(0.5 / step);
            int s = 0;
            for (; s < most && !motion.domain().empty(); ++s) {
                const LocalStep result = motion.advance({});
                balance -= result.dissipated;
                ASSERT_GE(balance - result.energy, -1e-9 * largest) << step << " " << tolerance << " " << s;
            }
            EXPECT_TRUE(motion.domain().empty()) << step << " " << tolerance;
        }
    }
}

TEST(LocalIntegrator, OverflowIsAnErrorAndChangesNothing) {
    const Laplacian laplacian(shapes::icosphere(2));
    LocalIntegrator motion(laplacian, skin(laplacian, 1.5, 10.0), 1e-60, 1);
    EXPECT_THROW(motion.advance(std::array{Hold{{3}, {1.0}, {1e99}}}), SolveError);
    EXPECT_EQ(motion.time(), 0.0);
    EXPECT_EQ(motion.u().cwiseAbs().maxCoeff(), 0.0);
}

TEST(LocalIntegrator, LateStepsSaySoAndCatchUp) {
    const Laplacian laplacian(shapes::icosphere(4));
    const Pde pde = skin(laplacian, 3.0, 60.0);
    LocalIntegrator late(laplacian, pde, dt, 1, {.tolerance = 1e-4});
    LocalIntegrator in_time(laplacian, pde, dt, 1, {.tolerance = 1e-4});
    const auto hold = [](int step) {
        return std::array{Hold{{700}, {1.0}, {-0.1 * std::min(1.0, step / 20.0)}}};
    };
    int late_steps = 0;
    double error_while_late = 0.0;
    double error_after = 0.0;
    for (int step = 1; step <= 200; ++step) {
        const bool hurry = step > 20 && step <= 30;
        const auto result = late.advance(
            hold(step),
            hurry ? std::optional(LocalIntegrator::Clock::now() - std::chrono::seconds(1)) : std::nullopt);
        const LocalStep other = in_time.advance(hold(step));
        if (hurry) {
            EXPECT_EQ(result.iterations, result.in_time ? 0 : 1);
            late_steps += result.in_time ? 0 : 1;
        } else {
            EXPECT_TRUE(result.in_time);
            EXPECT_TRUE(result.converged);
        }
        const double error =
            energy_norm(laplacian, pde, late.u() - in_time.u(), late.v() - in_time.v()) / result.scale;
        if (hurry) error_while_late = std::max(error_while_late, error);
        error_after = error;
        EXPECT_LE(error * result.scale, 1.001 * (result.error_bound + other.error_bound)) << step;
    }
    EXPECT_GT(late_steps, 5);
    EXPECT_GT(error_while_late, 1e-3);
    EXPECT_LT(error_after, 0.02 * error_while_late);
}

// Never in time: what it does is wrong, says so, and stays bounded.
TEST(LocalIntegrator, StepsThatAreAlwaysLateAddNoEnergy) {
    const Laplacian laplacian(shapes::bumpy_sphere(3000));
    const Pde pde = skin(laplacian, 4.0, 5.0);
    LocalIntegrator motion(laplacian, pde, dt, 3, {.tolerance = 1e-3});
    double balance = 0.0;
    double largest = 0.0;
    int late = 0;
    for (int step = 1; step <= 400; ++step) {
        std::vector<Hold> holds;
        if (step % 200 < 100)
            holds.push_back({{1000, 1001}, {0.3, 0.7}, {0.0, 0.05 * std::sin(0.1 * step), -0.1}});
        const auto result = motion.advance(holds, LocalIntegrator::Clock::time_point::min());
        late += result.in_time ? 0 : 1;
        balance += result.work - result.dissipated;
        largest = std::max(largest, balance);
        ASSERT_GE(balance - result.energy, -1e-9 * largest) << "step " << step;
    }
    EXPECT_GT(late, 200);
    // And let go, it is empty some time after.
    int step = 0;
    for (; step < 20000 && !motion.domain().empty(); ++step)
        (void)motion.advance({}, LocalIntegrator::Clock::time_point::min());
    EXPECT_TRUE(motion.domain().empty());
}

TEST(LocalIntegrator, StepsCostTheSameWhereTheMeshIsRefinedElsewhere) {
    Mesh mesh = shapes::geodesic_icosahedron(24);
    const double l2 = 4.0 * 4.0 * pi / mesh.vertex_count();
    const double w2 = std::pow(2.0 * pi * 10.0, 2);
    const Pde pde{
        .alpha = 1.0, .beta_1 = 100.0, .gamma = {0.1 * w2 * l2, 0.1 * w2 * l2 * l2}, .foundation = w2};
    const Vector3 middle = mesh.points().row(1000).transpose();
    std::vector<std::vector<Cost>> costs;
    for (int level = 0; level < 3; ++level) {
        const Laplacian laplacian(mesh);
        LocalIntegrator motion(laplacian, pde, dt, 3, {.tolerance = 1e-2});
        costs.emplace_back();
        for (int step = 1; step <= 60; ++step) {
            std::vector<Hold> holds;
            if (step <= 30)
                holds.push_back({{laplacian.order().working(1000)}, {1.0}, {0.0, 0.0, -0.01 * step}});
            const LocalStep s = motion.advance(holds);
            costs.back().push_back(cost_of(s));
        }
        mesh = refined_where(mesh, [&](const Vector3& p) { return (p - middle).norm() > 1.2; });
    }
    EXPECT_EQ(costs[0], costs[1]);
    EXPECT_EQ(costs[0], costs[2]);
    EXPECT_GT(mesh.vertex_count(), 100000);
}

TEST(LocalIntegrator, GoesOnAsAGlobalSolveWhereTheDomainIsTheMesh) {
    const Laplacian laplacian(shapes::icosphere(2));
    const Pde pde = skin(laplacian, 3.0, 20.0);
    LocalIntegrator motion(laplacian, pde, dt, 1, {.tolerance = 1e-6});
    LocalStep step;
    for (int s = 1; s <= 20; ++s)
        step = motion.advance(std::array{Hold{{40}, {1.0}, {-0.01 * s}}});
    EXPECT_TRUE(step.whole);
    EXPECT_EQ(step.active, laplacian.vertex_count());
    EXPECT_TRUE(step.converged);
}

TEST(LocalIntegrator, RefusesBadStepsAndHolds) {
    const Laplacian laplacian(shapes::icosphere(1));
    const Pde pde = skin(laplacian, 1.0, 1.0);
    for (const double step : {0.0, -1e-3, double{INFINITY}, double{NAN}})
        EXPECT_THROW(LocalIntegrator(laplacian, pde, step, 1), InputError) << step;
    EXPECT_THROW(LocalIntegrator(laplacian, Pde{}, dt, 1), InputError) << "no time derivative";
    EXPECT_THROW(LocalIntegrator(laplacian, {.alpha = 1.0, .foundation = -1.0}, dt, 1), InputError);
    LocalIntegrator motion(laplacian, pde, dt, 1);
    EXPECT_THROW(motion.advance(std::array{Hold{{99}, {1.0}, {1.0}}}), InputError);
    EXPECT_THROW(motion.advance(std::array{Hold{{3}, {1.0}, {1.0, 2.0}}}), InputError);
    EXPECT_THROW(motion.advance(std::array{Hold{{3}, {1.0, 2.0}, {1.0}}}), InputError);
    EXPECT_THROW(motion.advance(std::array{Hold{{3}, {1.0}, {NAN}}}), InputError);
    EXPECT_THROW(motion.advance(std::array{Hold{{3}, {1.0}, {1e200}}}), InputError);
    EXPECT_THROW(motion.advance(std::array{Hold{{3}, {1.0}, std::vector<double>(1000, 1.0)}}), InputError);
    EXPECT_THROW(motion.advance(std::array{Hold{{3, 3}, {0.5, 0.5}, {1.0}}}), InputError);
    EXPECT_THROW(motion.advance(std::array{Hold{{3, 4}, {0.5, 0.4}, {1.0}}}), InputError);
    EXPECT_THROW(motion.advance(std::array{Hold{{3}, {1.0}, {1.0}}, Hold{{3}, {1.0}, {2.0}}}), InputError);
    EXPECT_THROW(LocalIntegrator(laplacian, pde, dt, 0), InputError);
    EXPECT_EQ(motion.time(), 0.0);
    EXPECT_TRUE(motion.advance(std::array{Hold{{3}, {1.0}, {1.0}}}).converged);
    EXPECT_EQ(motion.time(), dt);
}

// The foundation in the whole-mesh integrator: one vertex's worth of mass on a spring.
TEST(LocalIntegrator, FoundationIsASpringOfEveryVertex) {
    const Laplacian laplacian(shapes::icosphere(1));
    TimeIntegrator motion(laplacian, {.alpha = 1.0, .gamma = {1.0}, .foundation = 4.0},
                          {.step = 1e-3, .method = TimeMethod::implicit_midpoint, .steps = 1000});
    motion.set_state(Block::Ones(laplacian.vertex_count(), 1));
    for (int step = 0; step < 1000; ++step)
        motion.advance(Constraints(1));
    EXPECT_NEAR(motion.u().maxCoeff(), std::cos(2.0), 1e-6);
    EXPECT_NEAR(motion.u().minCoeff(), std::cos(2.0), 1e-6);
}

}  // namespace
}  // namespace beltrami::testing
