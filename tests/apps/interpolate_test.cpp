#include "beltrami/apps/interpolate/interpolate.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/solvers/cholesky.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::relative_difference;

// How far values leave the interval of the given ones.
double overshoot(const Block& value, double low, double high) {
    return std::max({0.0, value.maxCoeff() - high, low - value.minCoeff()});
}

TEST(Interpolate, TheLaplacianObeysTheMaximumPrincipleOnDelaunayMeshes) {
    for (const Mesh& mesh : {shapes::icosphere(4), shapes::grid(40, 40)}) {
        const Laplacian laplacian(mesh);
        const Constraints fixed{{0, -1.0}, {mesh.vertex_count() / 2, 2.0}, {mesh.vertex_count() - 1, 0.5}};
        const auto [value, summary] = interpolate(laplacian, fixed);
        EXPECT_TRUE(summary.converged);
        EXPECT_LT(overshoot(value, -1.0, 2.0), 1e-9);
        for (const Index v : fixed.vertices())
            EXPECT_EQ(value(v, 0), fixed.value(v)[0]);
        // Strictly inside elsewhere: values did spread.
        EXPECT_GT(value.mean(), -0.9);
        EXPECT_LT(value.mean(), 1.9);
    }
}

// Two close vertices of different value are a slope that a plate carries on beyond them.
TEST(Interpolate, TheBilaplacianOvershootsAndTheMixtureLess) {
    const Mesh mesh = shapes::grid(30, 30);
    const Laplacian laplacian(mesh);
    const Constraints fixed{{15 * 31 + 14, 0.0}, {15 * 31 + 17, 1.0}, {0, 0.5}};
    const double plate =
        overshoot(interpolate(laplacian, fixed, {.laplacian = 0.0, .bilaplacian = 1.0}).value, 0, 1);
    const double mixed =
        overshoot(interpolate(laplacian, fixed, {.laplacian = 1.0, .bilaplacian = 0.01}).value, 0, 1);
    const double membrane = overshoot(interpolate(laplacian, fixed).value, 0, 1);
    EXPECT_GT(plate, 0.1);
    EXPECT_LT(mixed, 0.5 * plate);
    EXPECT_LT(membrane, 1e-9);
}

TEST(Interpolate, GivesBackLinearFieldsFromTheRimOfTheirPlane) {
    const Mesh mesh = shapes::shuffled(shapes::jittered(shapes::grid(12, 12), 0.3)).mesh;
    const Block linear = mesh.points() * Eigen::Matrix<double, 3, 2>{{1.0, -2.0}, {3.0, 0.5}, {0.0, 0.0}};
    Constraints fixed(2);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const auto p = mesh.points().row(v).head<2>().array();
        if ((p * (1.0 - p)).prod() == 0.0) fixed.fix(v, std::array{linear(v, 0), linear(v, 1)});
    }
    const auto [value, summary] = interpolate(Laplacian(mesh), fixed);
    EXPECT_LT(relative_difference(value, linear), 1e-9);
    EXPECT_EQ(summary.columns, 2);
}

TEST(Interpolate, AnswersInTheUsersOrder) {
    const Mesh mesh = shapes::icosphere(2);
    const shapes::Shuffled shuffled = shapes::shuffled(mesh, 3);
    Constraints moved;
    const Constraints fixed{{3, 1.0}, {100, -1.0}};
    for (const Index v : fixed.vertices())
        moved.fix(shuffled.new_number[static_cast<std::size_t>(v)], fixed.value(v));
    const Block value = interpolate(Laplacian(mesh), fixed).value;
    const Block other = interpolate(Laplacian(shuffled.mesh), moved).value;
    EXPECT_LT(relative_difference(Block(other(shuffled.new_number, Eigen::all)), value), 1e-8);
}

TEST(Interpolate, BothSolversAgreeOnMixtures) {
    const Laplacian laplacian(shapes::fins(3, 12));
    const Constraints fixed{{0, 0.0}, {200, 1.0}, {400, -1.0}};
    InterpolateOptions options{.laplacian = 1.0, .bilaplacian = 0.05};
    options.linear.kind = SolverKind::cg;
    const auto cg = interpolate(laplacian, fixed, options);
    options.linear.kind = SolverKind::cholesky;
    const auto cholesky = interpolate(laplacian, fixed, options);
    EXPECT_EQ(cg.summary.solver, "cg");
    EXPECT_EQ(cholesky.summary.solver, "cholesky");
    EXPECT_LT(relative_difference(cg.value, cholesky.value), 1e-7);
}

TEST(Interpolate, FreeComponentsAreRefusedOrLeftAtZero) {
    const Mesh two = shapes::together({shapes::icosphere(1), shapes::icosphere(1)});
    const Laplacian laplacian(two);
    const Constraints fixed{{3, 2.0}};
    EXPECT_THROW((void)interpolate(laplacian, fixed), InputError);
    const Block value =
        interpolate(laplacian, fixed, {.free_components = FreeComponents::keep_at_zero}).value;
    EXPECT_LT((value.topRows(42).array() - 2.0).abs().maxCoeff(), 1e-9);
    EXPECT_TRUE(value.bottomRows(42).isZero(0.0));
}

// Measured data on a plate: within the bounds, at the given values, and no less smooth than it must be.
TEST(Interpolate, BoundsKeepTheBilaplacianFromOvershooting) {
    const Mesh mesh = shapes::shuffled(shapes::grid(30, 30)).mesh;
    const Laplacian laplacian(mesh);
    Constraints fixed;
    const Vector values = testing::random_vector(12, 4);
    for (Index i = 0; i < 12; ++i)
        fixed.fix(71 * i + 5, 6.0 + 2.0 * values[i]);
    const Bounds range = range_of(fixed);
    InterpolateOptions options{.laplacian = 0.0, .bilaplacian = 1.0};
    const Block free = interpolate(laplacian, fixed, options).value;
    ASSERT_GT(overshoot(free, range.low[0], range.high[0]), 0.1);
    options.bounds = range;
    const InterpolateResult bounded = interpolate(laplacian, fixed, options);
    EXPECT_EQ(overshoot(bounded.value, range.low[0], range.high[0]), 0.0);
    EXPECT_GT(bounded.summary.factorizations, 1) << "one for each active set";
    for (const Index v : fixed.vertices())
        EXPECT_EQ(bounded.value(v, 0), fixed.value(v)[0]);
    // The energy lies between that of the free field and that of the free field cut off.
    const PdeOperator A(laplacian, 0.0, {0.0, 1.0});
    const auto energy = [&](const Block& user) {
        const Block u = laplacian.order().to_working(user);
        Block product;
        A.apply(u, product);
        return product.col(0).dot(u.col(0));
    };
    EXPECT_LT(energy(free), energy(bounded.value));
    EXPECT_LT(energy(bounded.value), energy(clamped(free, range.low[0], range.high[0]).value));
}

TEST(Interpolate, BoundsLeaveComponentsThatNothingHoldsAtZero) {
    const Mesh two = shapes::together({shapes::icosphere(1), shapes::icosphere(1)});
    const Constraints fixed{{3, 2.0}, {7, 3.0}};
    InterpolateOptions options{.bilaplacian = 1.0, .bounds = range_of(fixed)};
    options.free_components = FreeComponents::keep_at_zero;
    const Block value = interpolate(Laplacian(two), fixed, options).value;
    EXPECT_TRUE(value.bottomRows(42).isZero(0.0));
    EXPECT_GE(value.topRows(42).minCoeff(), 2.0);
    options.bounds->low[0] = 2.5;
    EXPECT_THROW((void)interpolate(Laplacian(two), fixed, options), InputError);
    options.bounds = Bounds{Vector::Zero(2), Vector::Ones(2)};
    EXPECT_THROW((void)interpolate(Laplacian(two), fixed, options), InputError);
}

TEST(Interpolate, RangesAndClampsAreThoseOfTheColumns) {
    Constraints fixed(2);
    fixed.fix(1, std::array{3.0, -1.0});
    fixed.fix(2, std::array{-2.0, 5.0});
    EXPECT_EQ(range_of(fixed).low, Eigen::Vector2d(-2.0, -1.0));
    EXPECT_EQ(range_of(fixed).high, Eigen::Vector2d(3.0, 5.0));
    Block value(3, 2);
    value << 0.5, 1.25, -0.5, 2.0, 0.0, 1.0;
    const Clamped inside = clamped(value, 0.0, 1.0);
    EXPECT_EQ(inside.vertices, 2);
    EXPECT_EQ(inside.farthest, 1.0);
    EXPECT_EQ(inside.value.row(1), Eigen::RowVector2d(0.0, 1.0));
    EXPECT_EQ(inside.value.row(2), value.row(2));
}

TEST(Interpolate, DisplacementsMoveTheMesh) {
    const Mesh mesh = shapes::grid(8, 8);
    Constraints fixed(3);
    for (const Index corner : {0, 8, 72, 80})
        fixed.fix(corner, std::array{0.0, 0.0, 0.0});
    fixed.fix(40, std::array{0.0, 0.1, 0.5});
    const Block value = interpolate(Laplacian(mesh), fixed, {.laplacian = 0.0, .bilaplacian = 1.0}).value;
    const Mesh moved = displaced(mesh, value);
    EXPECT_EQ(moved.points().row(40), mesh.points().row(40) + Eigen::RowVector3d(0.0, 0.1, 0.5));
    EXPECT_EQ(moved.points().row(8), mesh.points().row(8));
    EXPECT_EQ(moved.cells(), mesh.cells());
}

// Scattered handles by the thousand: one operator, one factor or few products, whatever their number.
TEST(Interpolate, FifteenThousandHandlesCostWhatAFewDo) {
    const Mesh mesh = shapes::bumpy_sphere(36000);
    Constraints fixed(3);
    for (Index i = 0; i < 15000; ++i) {
        const Index v = static_cast<Index>((std::int64_t{i} * 48271) % mesh.vertex_count());
        fixed.fix(v, std::span(mesh.points().row(v).data(), 3));
    }
    EXPECT_GT(fixed.size(), 14000);
    const long before = EdgeOperator<double>::builds();
    const Laplacian laplacian(mesh);
    for (const auto& [gamma_1, gamma_2] : {std::pair{1.0, 0.0}, {0.0, 1.0}}) {
        const InterpolateResult result =
            interpolate(laplacian, fixed, {.laplacian = gamma_1, .bilaplacian = gamma_2});
        EXPECT_TRUE(result.summary.converged);
        EXPECT_LE(result.summary.factorizations, 1);
        EXPECT_LT(result.summary.products, 100);
        EXPECT_EQ(result.summary.unknowns, mesh.vertex_count() - fixed.size());
        for (const Index v : fixed.vertices())
            ASSERT_EQ(result.value(v, 2), mesh.points()(v, 2));
        EXPECT_LT((result.value - mesh.points()).rowwise().norm().mean(), 0.02)
            << "a smooth field comes back";
    }
    EXPECT_EQ(EdgeOperator<double>::builds(), before + 1);
}

TEST(Interpolate, RefusesWhatHasNoAnswer) {
    const Laplacian laplacian(shapes::icosphere(0));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Constraints fixed{{0, 1.0}};
    EXPECT_THROW((void)interpolate(laplacian, Constraints()), InputError);
    EXPECT_THROW((void)interpolate(laplacian, Constraints{{12, 1.0}}), InputError);
    EXPECT_THROW((void)interpolate(laplacian, fixed, {.laplacian = 0.0}), InputError);
    EXPECT_THROW((void)interpolate(laplacian, fixed, {.laplacian = -1.0}), InputError);
    EXPECT_THROW((void)interpolate(laplacian, fixed, {.bilaplacian = nan}), InputError);
    EXPECT_THROW((void)interpolate(laplacian, fixed, {.linear = {.tolerance = nan}}), InputError);
    InterpolateOptions hopeless;
    hopeless.linear.kind = SolverKind::cg;
    hopeless.linear.max_iterations = 1;
    EXPECT_THROW((void)interpolate(Laplacian(shapes::icosphere(3)), fixed, hopeless), SolveError)
        << "fixed at one place only is constant, but not after one iteration";
}

// What comes, goes and moves while somebody paints. Two pieces and a stray vertex, which nothing holds at first.
TEST(Interpolator, IsInterpolateAfterEveryChange) {
    const Mesh pieces = shapes::together({shapes::icosphere(3), shapes::icosphere(2)});
    Points points(pieces.vertex_count() + 1, 3);
    points << pieces.points(), Points::Constant(1, 3, 7.0);
    const Mesh mesh = shapes::shuffled(Mesh(points, pieces.cells())).mesh;
    const Laplacian laplacian(mesh);
    Index stray = 0;
    while (laplacian.graph().degree(laplacian.order().working(stray)) > 0)
        ++stray;
    const auto at = [&](Index v) { return v < stray ? v : v + 1; };
    for (const SolverKind kind : {SolverKind::cg, SolverKind::cholesky}) {
        InterpolateOptions options{
            .laplacian = 1.0, .bilaplacian = 0.02, .free_components = FreeComponents::keep_at_zero};
        options.linear.kind = kind;
        options.linear.tolerance = 1e-12;
        Interpolator painted(laplacian, options);
        const auto expect_the_same = [&](const Constraints& fixed, const std::optional<Bounds>& bounds = {}) {
            InterpolateOptions once = options;
            once.bounds = bounds;
            const Block expected = interpolate(laplacian, fixed, once).value;
            const InterpolateResult result = painted(fixed, bounds);
            EXPECT_TRUE(result.summary.converged);
            EXPECT_LT(relative_difference(result.value, expected), 1e-7);
            for (const Index v : fixed.vertices())
                EXPECT_EQ(result.value(v, 0), fixed.value(v)[0]);
        };
        Constraints fixed;
        for (Index i = 0; i < 12; ++i) {  // comes, here and there
            fixed.fix(at((i * 397) % 800), i % 3 - 0.5 * i);
            expect_the_same(fixed);
        }
        fixed.fix(at(397), 5.0);  // moves
        expect_the_same(fixed);
        expect_the_same(fixed, range_of(fixed));
        expect_the_same(fixed);
        fixed.fix(stray, 3.0);
        expect_the_same(fixed);
        fixed.free(stray);  // back to 0
        expect_the_same(fixed);
        EXPECT_EQ(painted(fixed).value(stray, 0), 0.0);
        for (Index i = 0; i < 11; ++i) {  // goes, until a piece is held by nothing
            fixed.free(at((i * 397) % 800));
            expect_the_same(fixed);
        }
        Constraints vectors(3);  // other columns, and back
        vectors.fix(at(3), std::array{1.0, -2.0, 0.5});
        vectors.fix(at(90), std::array{0.0, 2.0, 0.5});
        expect_the_same(vectors);
        expect_the_same(vectors, range_of(vectors));
        expect_the_same(fixed);
    }
}

TEST(Interpolator, BuildsNothingAgainWhileConstraintsComeAndGo) {
    const Laplacian laplacian(shapes::icosphere(4));
    for (const SolverKind kind : {SolverKind::cg, SolverKind::cholesky}) {
        InterpolateOptions options{.laplacian = 1.0, .bilaplacian = 0.01};
        options.linear.kind = kind;
        options.linear.expected_solves = 1000;
        Interpolator painted(laplacian, options);
        Constraints fixed{{0, 1.0}};
        (void)painted(fixed);
        const long operators = EdgeOperator<double>::builds();
        const long analyses = CholeskyAnalysis::builds();
        for (Index i = 1; i < 50; ++i) {
            fixed.fix((i * 31) % 2562, i);
            if (i % 3 == 0) fixed.free(((i - 2) * 31) % 2562);
            (void)painted(fixed);
        }
        EXPECT_EQ(EdgeOperator<double>::builds(), operators);
        EXPECT_EQ(CholeskyAnalysis::builds(), analyses);
    }
}

TEST(Interpolator, IsRightAfterACallThatFailed) {
    const Laplacian laplacian(shapes::icosphere(3));
    const Constraints fixed{{0, 1.0}, {300, -1.0}};
    const Constraints others{{5, 2.0}, {200, 0.0}, {640, 1.0}};
    for (const SolverKind kind : {SolverKind::cg, SolverKind::cholesky}) {
        Progress progress;
        InterpolateOptions options;
        options.linear.kind = kind;
        options.linear.progress = &progress;
        Interpolator painted(laplacian, options);
        const auto expect_right = [&](const Constraints& given) {
            progress.restart();
            EXPECT_LT(relative_difference(painted(given).value, interpolate(laplacian, given).value), 1e-7);
        };
        progress.cancel();  // before anything was made
        EXPECT_THROW((void)painted(fixed), Cancelled);
        expect_right(fixed);
        progress.cancel();
        EXPECT_THROW((void)painted(others), Cancelled);
        expect_right(others);
        EXPECT_THROW((void)painted(Constraints()), InputError);
        EXPECT_THROW((void)painted(Constraints{{642, 1.0}}), InputError);
        EXPECT_THROW((void)painted(fixed, range_of(others)), InputError);
        expect_right(fixed);
    }
    InterpolateOptions hopeless;
    hopeless.linear.kind = SolverKind::cg;
    hopeless.linear.max_iterations = 3;
    Interpolator painted(laplacian, hopeless);
    EXPECT_THROW((void)painted(fixed), SolveError);
    EXPECT_THROW((void)painted(fixed), SolveError) << "nothing was kept of what had not converged";
}

TEST(Interpolator, RefusesCoefficientsThatAreNone) {
    const Laplacian laplacian(shapes::icosphere(1));
    EXPECT_THROW(Interpolator(laplacian, {.laplacian = 0.0}), InputError);
    EXPECT_THROW(Interpolator(laplacian, {.laplacian = -1.0}), InputError);
}

}  // namespace
}  // namespace beltrami
