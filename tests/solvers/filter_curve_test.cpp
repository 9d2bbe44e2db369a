#include "beltrami/solvers/filter_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "beltrami/framework/error.hpp"

namespace beltrami {
namespace {

TEST(FilterCurve, IsLinearBetweenAndConstantBeyond) {
    const FilterCurve curve({{1.0, 2.0}, {3.0, 4.0}, {3.0, 1.0}, {5.0, 0.0}});
    EXPECT_EQ(curve(0.0), 2.0);
    EXPECT_EQ(curve(2.0), 3.0);
    EXPECT_EQ(curve(3.0), 1.0);
    EXPECT_EQ(curve(4.0), 0.5);
    EXPECT_EQ(curve(9.0), 0.0);
}

TEST(FilterCurve, MeansAreExact) {
    const FilterCurve curve({{1.0, 2.0}, {3.0, 4.0}, {3.0, 1.0}, {5.0, 0.0}});
    EXPECT_NEAR(curve.mean(0.0, 1.0), 2.0, 1e-14);
    EXPECT_NEAR(curve.mean(1.0, 3.0), 3.0, 1e-14);
    EXPECT_NEAR(curve.mean(2.0, 4.0), (3.5 + 0.75) / 2.0, 1e-14);
    EXPECT_NEAR(curve.mean(0.0, 10.0), (2.0 + 6.0 + 1.0) / 10.0, 1e-14);
    EXPECT_EQ(curve.mean(2.0, 2.0), 3.0);
    // Against a sum over many points.
    double sum = 0.0;
    for (int i = 0; i < 100000; ++i)
        sum += curve(0.5 + 5.0 * (i + 0.5) / 100000.0) / 100000.0;
    EXPECT_NEAR(curve.mean(0.5, 5.5), sum, 1e-4);
}

TEST(FilterCurve, Names) {
    const FilterCurve low = FilterCurve::low_pass(10.0, 20.0);
    EXPECT_EQ(low(10.0), 1.0);
    EXPECT_EQ(low(15.0), 0.5);
    EXPECT_EQ(low(20.0), 0.0);
    EXPECT_DOUBLE_EQ(FilterCurve::high_pass(10.0, 20.0)(12.0), 1.0 - low(12.0));
    EXPECT_EQ(FilterCurve::band_pass(10.0, 20.0)(15.0), 1.0);
    EXPECT_EQ(FilterCurve::band_pass(10.0, 20.0)(9.5), 0.5);
    EXPECT_EQ(FilterCurve::band_pass(10.0, 20.0)(21.0), 0.0);
    EXPECT_EQ(FilterCurve::notch(10.0, 20.0)(15.0), 0.0);
    EXPECT_EQ(FilterCurve::notch(10.0, 20.0)(30.0), 1.0);
    EXPECT_EQ(FilterCurve::enhancement(10.0, 20.0, 3.0)(15.0), 2.0);
    EXPECT_EQ(FilterCurve::band_exaggeration(0.0, 20.0, 3.0)(0.0), 3.0);
    EXPECT_EQ(FilterCurve::band_exaggeration(0.0, 20.0, 3.0)(40.0), 1.0);
}

TEST(FilterCurve, TellsWhatItChanges) {
    using Intervals = std::vector<std::pair<double, double>>;
    EXPECT_EQ(FilterCurve::low_pass(10.0, 20.0).differs_from(0.0, 50.0), (Intervals{{0.0, 20.0}}));
    EXPECT_EQ(FilterCurve::low_pass(10.0, 20.0).differs_from(1.0, 50.0), (Intervals{{10.0, 50.0}}));
    EXPECT_EQ(FilterCurve::notch(10.0, 20.0).differs_from(1.0, 50.0), (Intervals{{9.0, 21.0}}));
    EXPECT_TRUE(FilterCurve({{0.0, 1.0}}).differs_from(1.0, 50.0).empty());
    const FilterCurve two({{0.0, 1.0}, {1.0, 1.0}, {2.0, 3.0}, {3.0, 1.0}, {4.0, 1.0}, {5.0, 2.0}});
    EXPECT_EQ(two.differs_from(1.0, 9.0), (Intervals{{1.0, 3.0}, {4.0, 9.0}}));
}

TEST(FilterCurve, RefusesWhatMakesNoSense) {
    EXPECT_THROW(FilterCurve({}), InputError);
    EXPECT_THROW(FilterCurve({{2.0, 1.0}, {1.0, 1.0}}), InputError);
    EXPECT_THROW(FilterCurve({{-1.0, 1.0}}), InputError);
    EXPECT_THROW(FilterCurve({{1.0, NAN}}), InputError);
    EXPECT_THROW(FilterCurve::low_pass(2.0, 1.0), InputError);
    EXPECT_THROW(FilterCurve::notch(2.0, 2.0), InputError);
}

}  // namespace
}  // namespace beltrami
