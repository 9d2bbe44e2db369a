#include "beltrami/solvers/time_integrator.hpp"

#include <array>
#include <limits>
#include <string>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::random_block;
using testing::relative_difference;

constexpr std::array all_methods{TimeMethod::backward_euler, TimeMethod::implicit_midpoint, TimeMethod::bdf2};

TimeOptions options_of(double step, TimeMethod method, SolverKind kind = SolverKind::cholesky) {
    return {.step = step, .method = method, .steps = 100, .linear = {.kind = kind, .tolerance = 1e-12}};
}

struct DenseTerms {
    Eigen::MatrixXd M, K, C;
    DenseTerms(const Laplacian& laplacian, const Pde& pde)
        : M(laplacian.mass().asDiagonal()),
          K(dense(PdeOperator(laplacian, 0.0, pde.gamma).to_sparse())),
          C(pde.beta_1 * M + pde.beta_2 * K) {}
};

const std::vector<Pde> pdes{{.beta_1 = 1.0},
                            {.alpha = 1.0},
                            {.alpha = 2.0, .beta_1 = 0.3, .beta_2 = 0.05, .gamma = {1.0, 0.1}},
                            {.beta_1 = 0.5, .beta_2 = 0.2, .gamma = {0.7}}};

// Eq. (14) and (15) of Kim & Rossignac, with dt on both sides as printed.
TEST(BackwardEuler, IsThePublishedStep) {
    const Laplacian laplacian(shapes::with_noise(shapes::icosphere(1), 0.1));
    const double dt = 0.02;
    const Block u = random_block(42, 2, 1);
    const Block v = random_block(42, 2, 2);
    const Block f = random_block(42, 2, 3);
    for (const Pde& pde : pdes) {
        const DenseTerms d(laplacian, pde);
        const Eigen::MatrixXd A = (pde.alpha + pde.beta_1 * dt) * d.M + (pde.beta_2 + dt) * dt * d.K;
        const Eigen::MatrixXd velocity = A.ldlt().solve(-dt * (d.K * u) + pde.alpha * (d.M * v) + dt * f);
        TimeIntegrator integrator(laplacian, pde, options_of(dt, TimeMethod::backward_euler));
        integrator.set_state(u, v);
        integrator.advance(Constraints(2), &f);
        EXPECT_LT(relative_difference(integrator.v(), Block(velocity)), 1e-9);
        EXPECT_LT(relative_difference(integrator.u(), Block(u + dt * velocity)), 1e-9);
        EXPECT_EQ(integrator.time(), dt);
    }
}

// The equations that define midpoint and BDF2, checked on what the integrator gives.
TEST(ImplicitMidpoint, SatisfiesItsEquation) {
    const Laplacian laplacian(shapes::with_noise(shapes::icosphere(1), 0.1));
    const double dt = 0.02;
    const Block f = random_block(42, 1, 3);
    for (const Pde& pde : pdes) {
        const DenseTerms d(laplacian, pde);
        TimeIntegrator integrator(laplacian, pde, options_of(dt, TimeMethod::implicit_midpoint));
        integrator.set_state(random_block(42, 1, 1), random_block(42, 1, 2));
        for (int step = 0; step < 3; ++step) {
            const Block u = integrator.u();
            const Block v = integrator.v();
            integrator.advance(Constraints(), &f);
            const Block rate = (integrator.u() - u) / dt;
            Block residual = d.C * rate + d.K * (0.5 * (integrator.u() + u)) - f;
            if (pde.alpha > 0.0) {
                residual += pde.alpha / dt * d.M * (integrator.v() - v);
                EXPECT_LT(relative_difference(Block(0.5 * (integrator.v() + v)), rate), 1e-9);
            }
            EXPECT_LT(residual.norm(), 1e-8 * (d.K * u).norm());
        }
    }
}

TEST(Bdf2, SatisfiesItsEquationAfterAStepOfBackwardEuler) {
    const Laplacian laplacian(shapes::with_noise(shapes::icosphere(1), 0.1));
    const double dt = 0.02;
    for (const Pde& pde : pdes) {
        const DenseTerms d(laplacian, pde);
        TimeIntegrator integrator(laplacian, pde, options_of(dt, TimeMethod::bdf2));
        TimeIntegrator euler(laplacian, pde, options_of(dt, TimeMethod::backward_euler));
        const Block u_0 = random_block(42, 1, 1);
        const Block v_0 = random_block(42, 1, 2);
        integrator.set_state(u_0, v_0);
        euler.set_state(u_0, v_0);
        integrator.advance(Constraints());
        euler.advance(Constraints());
        EXPECT_LT(relative_difference(integrator.u(), euler.u()), 1e-10);
        Block u_before = u_0;
        Block v_before = v_0;
        for (int step = 0; step < 3; ++step) {
            const Block u = integrator.u();
            const Block v = integrator.v();
            integrator.advance(Constraints());
            const Block rate = (3.0 * integrator.u() - 4.0 * u + u_before) / (2.0 * dt);
            const Block acceleration = (3.0 * integrator.v() - 4.0 * v + v_before) / (2.0 * dt);
            EXPECT_LT(relative_difference(rate, integrator.v()), 1e-8);
            const Block residual = pde.alpha * d.M * acceleration + d.C * rate + d.K * integrator.u();
            EXPECT_LT(residual.norm(), 1e-8 * (d.K * u_0).norm());
            u_before = u;
            v_before = v;
        }
    }
}

TEST(TimeIntegrator, HeatIsConservedWhereNothingIsHeld) {
    const Laplacian laplacian(shapes::with_noise(shapes::icosphere(2), 0.2));
    for (const TimeMethod method : all_methods) {
        TimeIntegrator integrator(laplacian, {.beta_1 = 1.0}, options_of(0.01, method));
        const Block u = random_block(laplacian.vertex_count(), 1) + Block::Ones(laplacian.vertex_count(), 1);
        integrator.set_state(u);
        for (int step = 0; step < 50; ++step)
            integrator.advance(Constraints());
        EXPECT_NEAR(laplacian.mass().dot(integrator.u().col(0)), laplacian.mass().dot(u.col(0)), 1e-9)
            << name(method);
        EXPECT_LT((integrator.u().array() - integrator.u().mean()).abs().maxCoeff(), 0.9);
    }
}

TEST(TimeIntegrator, AWaveWithoutCurvatureDriftsEvenly) {
    const Laplacian laplacian(shapes::icosphere(1));
    for (const TimeMethod method : all_methods) {
        TimeIntegrator integrator(laplacian, {.alpha = 1.0}, options_of(0.1, method));
        integrator.set_state(Block::Constant(42, 1, 3.0), Block::Constant(42, 1, -2.0));
        for (int step = 0; step < 10; ++step)
            integrator.advance(Constraints());
        EXPECT_LT(relative_difference(integrator.u(), Block(Block::Constant(42, 1, 1.0))), 1e-11)
            << name(method);
        EXPECT_NEAR(integrator.time(), 1.0, 1e-14);
        EXPECT_EQ(integrator.step_count(), 10);
    }
}

TEST(ImplicitMidpoint, KeepsTheEnergyOfAWaveOverTenThousandSteps) {
    const Laplacian laplacian(shapes::icosphere(1));
    TimeIntegrator integrator(laplacian, {.alpha = 1.0}, options_of(0.05, TimeMethod::implicit_midpoint));
    integrator.set_state(random_block(42, 2, 1), random_block(42, 2, 2));
    const Vector before = integrator.energy();
    double worst = 0.0;
    for (int step = 0; step < 10000; ++step) {
        integrator.advance(Constraints(2));
        worst = std::max(worst, relative_difference(integrator.energy(), before));
    }
    EXPECT_LT(worst, 1e-10);
    EXPECT_EQ(integrator.summary().factorizations, 1);
    RecordProperty("drift", std::to_string(worst * 1e10) + "e-10");
}

TEST(ImplicitMidpoint, KeepsTheEnergyToTheToleranceOfConjugateGradients) {
    const Laplacian laplacian(shapes::icosphere(2));
    for (const double tolerance : {1e-6, 1e-9}) {
        TimeOptions options = options_of(0.05, TimeMethod::implicit_midpoint, SolverKind::cg);
        options.linear.tolerance = tolerance;
        TimeIntegrator integrator(laplacian, {.alpha = 1.0}, options);
        integrator.set_state(random_block(162, 1, 1), random_block(162, 1, 2));
        const Vector before = integrator.energy();
        for (int step = 0; step < 500; ++step)
            integrator.advance(Constraints());
        EXPECT_LT(relative_difference(integrator.energy(), before), 500 * tolerance);
    }
}

TEST(TimeIntegrator, BackwardEulerAndDampingOnlyLoseEnergy) {
    const Laplacian laplacian(shapes::icosphere(2));
    const Pde undamped{.alpha = 1.0};
    const Pde damped{.alpha = 1.0, .beta_1 = 0.1, .beta_2 = 0.01};
    for (const auto& [pde, method] : {std::pair{undamped, TimeMethod::backward_euler},
                                      std::pair{damped, TimeMethod::implicit_midpoint}}) {
        TimeIntegrator integrator(laplacian, pde, options_of(0.05, method));
        integrator.set_state(random_block(162, 1, 1), random_block(162, 1, 2));
        double last = integrator.energy()[0];
        const double first = last;
        for (int step = 0; step < 50; ++step) {
            integrator.advance(Constraints());
            EXPECT_LE(integrator.energy()[0], last * (1.0 + 1e-12));
            last = integrator.energy()[0];
        }
        EXPECT_LT(last, 0.9 * first);
    }
}

TEST(TimeIntegrator, EnergyIsKineticPlusElastic) {
    const Laplacian laplacian(shapes::icosphere(1));
    const Pde pde{.alpha = 3.0, .gamma = {1.0, 0.2}};
    const DenseTerms d(laplacian, pde);
    TimeIntegrator integrator(laplacian, pde, options_of(0.1, TimeMethod::bdf2));
    const Block u = random_block(42, 2, 1);
    const Block v = random_block(42, 2, 2);
    integrator.set_state(u, v);
    for (Index c = 0; c < 2; ++c) {
        const double expected = 1.5 * v.col(c).dot(d.M * v.col(c)) + 0.5 * u.col(c).dot(d.K * u.col(c));
        EXPECT_NEAR(integrator.energy()[c], expected, 1e-12 * expected);
    }
}

// K~ sums to zero over a component, so what the held vertices give and what the load gives is what moves the
// mass.
TEST(TimeIntegrator, ReactionsAndLoadMoveTheMass) {
    const Mesh two = shapes::together({shapes::icosphere(1), shapes::with_noise(shapes::icosphere(1), 0.2)});
    const Laplacian laplacian(two);
    const Components components = connected_components(laplacian.graph());
    const Pde pde{.alpha = 1.0, .beta_1 = 0.5, .beta_2 = 0.1, .gamma = {1.0, 0.1}};
    const double dt = 0.05;
    TimeIntegrator integrator(laplacian, pde, options_of(dt, TimeMethod::backward_euler));
    integrator.set_state(random_block(84, 1, 1), random_block(84, 1, 2));
    const Block f = random_block(84, 1, 3);
    for (int step = 1; step <= 3; ++step) {
        const Block v = integrator.v();
        integrator.advance(Constraints{{0, 0.1 * step}, {40, -0.2}, {60, 1.0}}, &f);
        Vector sums = Vector::Zero(2);
        for (Index i = 0; i < 84; ++i) {
            const double momentum =
                pde.alpha * (integrator.v()(i, 0) - v(i, 0)) / dt + pde.beta_1 * integrator.v()(i, 0);
            sums[components.of_vertex[static_cast<std::size_t>(i)]] +=
                integrator.reaction()(i, 0) + f(i, 0) - laplacian.mass()[i] * momentum;
        }
        EXPECT_LT(sums.cwiseAbs().maxCoeff(), 1e-9 * integrator.reaction().cwiseAbs().maxCoeff());
        EXPECT_EQ((integrator.reaction().array() != 0.0).count(), 3);
        EXPECT_DOUBLE_EQ(integrator.u()(0, 0), 0.1 * step);
    }
}

TEST(TimeIntegrator, HeldVerticesFollowTheirValuesAndMayChange) {
    const Laplacian laplacian(shapes::icosphere(2));
    for (const TimeMethod method : all_methods) {
        for (const Pde& pde : {Pde{.beta_1 = 1.0}, Pde{.alpha = 1.0}}) {
            TimeIntegrator integrator(laplacian, pde, options_of(0.01, method, SolverKind::cg));
            integrator.set_state(Block::Zero(162, 1));
            const long before = EdgeOperator<double>::builds();
            for (Index step = 0; step < 20; ++step) {
                integrator.advance(Constraints{{step, 1.0}, {step + 50, -0.5}});
                EXPECT_NEAR(integrator.u()(step, 0), 1.0, 1e-14);
                EXPECT_NEAR(integrator.u()(step + 50, 0), -0.5, 1e-14);
            }
            EXPECT_EQ(EdgeOperator<double>::builds(), before);
            EXPECT_EQ(integrator.summary().factorizations, 0);
        }
    }
}

TEST(TimeIntegrator, HeatWithHeldVerticesEndsAtTheSteadyState) {
    const Laplacian laplacian(shapes::icosphere(2));
    const Constraints held{{0, 1.0}, {100, -1.0}};
    LinearSolver steady(PdeOperator(laplacian, 0.0, {1.0}), {});
    Block expected = Block::Zero(162, 1);
    ASSERT_TRUE(steady.solve(Block::Zero(162, 1), held, expected).converged);
    for (const TimeMethod method : {TimeMethod::backward_euler, TimeMethod::bdf2}) {
        TimeIntegrator integrator(laplacian, {.beta_1 = 1.0}, options_of(1.0, method));
        for (int step = 0; step < 60; ++step)
            integrator.advance(held);
        EXPECT_LT(relative_difference(integrator.u(), expected), 1e-6) << name(method);
    }
}

TEST(TimeIntegrator, AFailedStepLeavesTheStateAsItWas) {
    const Laplacian laplacian(shapes::icosphere(2));
    TimeOptions options = options_of(1.0, TimeMethod::bdf2, SolverKind::cg);
    options.linear.max_iterations = 2;
    TimeIntegrator integrator(laplacian, {.alpha = 1.0}, options);
    const Block u = random_block(162, 1);
    integrator.set_state(u);
    EXPECT_THROW(integrator.advance(Constraints()), SolveError);
    EXPECT_EQ(integrator.u(), u);
    EXPECT_EQ(integrator.step_count(), 0);
    EXPECT_FALSE(integrator.summary().converged);
}

TEST(TimeIntegrator, ACancelLeavesTheStateAsItWas) {
    const Laplacian laplacian(shapes::icosphere(2));
    Progress* self = nullptr;
    int reports = 0;
    Progress progress([&](const ProgressReport&) {
        if (++reports == 3) self->cancel();
    });
    self = &progress;
    TimeOptions options = options_of(1.0, TimeMethod::backward_euler, SolverKind::cg);
    options.linear.progress = &progress;
    TimeIntegrator integrator(laplacian, {.beta_1 = 1.0}, options);
    const Block u = random_block(162, 1);
    integrator.set_state(u);
    EXPECT_THROW(integrator.advance(Constraints()), Cancelled);
    EXPECT_EQ(integrator.u(), u);
}

TEST(TimeIntegrator, IsolatedVerticesStayWhereTheyAre) {
    Points points(43, 3);
    points << shapes::icosphere(1).points(), 9.0, 9.0, 9.0;
    const Laplacian laplacian(Mesh(points, shapes::icosphere(1).cells()));
    const Index isolated = laplacian.order().working(42);
    for (const TimeMethod method : all_methods) {
        for (const auto kind : {SolverKind::cg, SolverKind::cholesky}) {
            TimeIntegrator integrator(laplacian, {.alpha = 1.0}, options_of(0.1, method, kind));
            integrator.set_state(Block::Constant(43, 1, 5.0), random_block(43, 1));
            for (int step = 0; step < 5; ++step)
                integrator.advance(Constraints());
            EXPECT_EQ(integrator.u()(isolated, 0), 5.0);
            EXPECT_TRUE(integrator.u().allFinite());
        }
    }
}

TEST(TimeIntegrator, SetStateStartsAgain) {
    const Laplacian laplacian(shapes::icosphere(1));
    TimeIntegrator integrator(laplacian, {.alpha = 1.0}, options_of(0.1, TimeMethod::bdf2));
    const Block u = random_block(42, 1, 1);
    const Block v = random_block(42, 1, 2);
    integrator.set_state(u, v);
    for (int step = 0; step < 4; ++step)
        integrator.advance(Constraints());
    const Block first = integrator.u();
    integrator.set_state(u, v);
    EXPECT_EQ(integrator.time(), 0.0);
    for (int step = 0; step < 4; ++step)
        integrator.advance(Constraints());
    EXPECT_LT(relative_difference(integrator.u(), first), 1e-13);
}

TEST(TimeIntegrator, SummaryIsOfTheSolverThatDidTheWork) {
    const Laplacian laplacian(shapes::grid(80, 80));
    TimeOptions options{.step = 1e-3, .method = TimeMethod::bdf2, .steps = 10000};
    TimeIntegrator integrator(laplacian, {.beta_1 = 1.0}, options);
    integrator.set_state(random_block(laplacian.vertex_count(), 1));
    for (int step = 0; step < 3; ++step)
        integrator.advance(Constraints());
    EXPECT_EQ(integrator.summary().solver, "cholesky")
        << "10000 steps pay for a factor; the start does not count";
}

TEST(TimeIntegrator, RefusesWrongShapesAndNumbers) {
    const Laplacian laplacian(shapes::icosphere(0));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double bad : {0.0, -0.1, nan, std::numeric_limits<double>::infinity()}) {
        EXPECT_THROW(TimeIntegrator(laplacian, Pde{.beta_1 = 1.0}, {.step = bad}), InputError);
    }
    EXPECT_THROW(TimeIntegrator(laplacian, Pde{.beta_1 = 1.0}, {.step = 1.0, .steps = 0}), InputError);
    for (const Pde& pde : {Pde{}, Pde{.beta_2 = 1.0}, Pde{.alpha = -1.0}, Pde{.alpha = 1.0, .beta_1 = nan},
                           Pde{.alpha = 1.0, .beta_2 = -1.0}, Pde{.alpha = 1.0, .gamma = {1.0, -1.0}}}) {
        EXPECT_THROW(TimeIntegrator(laplacian, pde, {.step = 1.0}), InputError);
    }
    TimeIntegrator integrator(laplacian, {.beta_1 = 1.0}, {.step = 1.0});
    EXPECT_THROW(integrator.set_state(Block::Zero(11, 1)), InputError);
    EXPECT_THROW(integrator.set_state(Block::Zero(12, 1), Block::Zero(12, 2)), InputError);
    integrator.set_state(Block::Zero(12, 1));
    Constraints wide(40);
    wide.fix(11, std::vector<double>(40, 1.0));
    EXPECT_THROW(integrator.advance(wide), InputError);
    EXPECT_THROW(integrator.advance(Constraints{{12, 1.0}}), InputError);
    const Block short_load = Block::Zero(11, 1);
    const Block wide_load = Block::Zero(12, 2);
    EXPECT_THROW(integrator.advance(Constraints(), &short_load), InputError);
    EXPECT_THROW(integrator.advance(Constraints(), &wide_load), InputError);
    EXPECT_NO_THROW(integrator.advance(Constraints(7))) << "none held, of however many columns";
}

// A vertex that jumps and is then held still has no velocity left when it is let go.
TEST(ImplicitMidpoint, AHeldVertexHasTheVelocityThatMovesIt) {
    const Laplacian laplacian(shapes::icosphere(1));
    TimeIntegrator integrator(laplacian, {.alpha = 1.0}, options_of(0.1, TimeMethod::implicit_midpoint));
    const Constraints held{{3, 1.0}};
    integrator.advance(held);
    EXPECT_NEAR(integrator.v()(3, 0), 10.0, 1e-9);
    integrator.advance(held);
    EXPECT_NEAR(integrator.v()(3, 0), 0.0, 1e-9);
}

TEST(TimeIntegrator, AnIsolatedVertexStaysWhereItWasLetGo) {
    Points points(4, 3);
    points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 5, 5;
    const Laplacian laplacian(Mesh(points, Cells(Eigen::RowVector3i(0, 1, 2))), {.renumber = false});
    for (const TimeMethod method : all_methods) {
        TimeIntegrator integrator(laplacian, {.alpha = 1.0}, options_of(0.1, method));
        integrator.advance(Constraints());
        integrator.advance(Constraints{{3, 1.0}});
        for (int step = 0; step < 3; ++step) {
            integrator.advance(Constraints());
            EXPECT_EQ(integrator.u()(3, 0), 1.0) << name(method);
        }
    }
}

}  // namespace
}  // namespace beltrami
