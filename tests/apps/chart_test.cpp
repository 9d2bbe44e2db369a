#include "beltrami/apps/picture/chart.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "beltrami/apps/picture/picture.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Place {
    int x;
    int y;
};

/// Where the image has about that colour, column by column.
std::vector<Place> places_of(const Image& image, const Colour& colour, int tolerance = 12) {
    std::vector<Place> places;
    for (int x = 0; x < image.width; ++x) {
        for (int y = 0; y < image.height; ++y) {
            const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                                       static_cast<std::size_t>(x));
            bool same = true;
            for (std::size_t k = 0; k < 3; ++k)
                same =
                    same && std::abs(image.rgb[i + k] - 255.0F * colour[k]) <= static_cast<float>(tolerance);
            if (same) places.push_back({x, y});
        }
    }
    return places;
}

Vector ramp(Eigen::Index n) {
    return Vector::LinSpaced(n, 0.0, static_cast<double>(n - 1));
}

TEST(Chart, ALineRisesFromCornerToCorner) {
    const Chart chart{
        .title = "t", .across = "n", .up = "v", .lines = {{.name = {}, .x = ramp(11), .y = ramp(11)}}};
    const Image image = draw_chart(chart, 400, 300);
    const std::vector<Place> line = places_of(image, chart_colour(0));
    ASSERT_GT(line.size(), 200u);
    const Place first = line.front();
    const Place last = line.back();
    EXPECT_LT(first.x, 100);
    EXPECT_GT(first.y, 230);
    EXPECT_GT(last.x, 350);
    EXPECT_LT(last.y, 80);
    const double slope = static_cast<double>(last.y - first.y) / (last.x - first.x);
    for (const Place& p : line)
        EXPECT_NEAR(p.y, first.y + slope * (p.x - first.x), 4.0);
    EXPECT_EQ(draw_chart(chart, 400, 300).rgb, image.rgb);
}

TEST(Chart, AnExponentialIsStraightOnALogarithmicAxis) {
    Chart chart{.title = {}, .across = "n", .up = "v", .logarithmic = true, .lines = {}};
    Vector y = (-0.5 * ramp(21).array()).exp();
    chart.lines.push_back({.name = {}, .x = ramp(21), .y = y});
    const std::vector<Place> line = places_of(draw_chart(chart, 500, 400), chart_colour(0));
    ASSERT_GT(line.size(), 200u);
    const double slope =
        static_cast<double>(line.back().y - line.front().y) / (line.back().x - line.front().x);
    EXPECT_GT(slope, 0.3);
    for (const Place& p : line)
        EXPECT_NEAR(p.y, line.front().y + slope * (p.x - line.front().x), 4.0);
}

TEST(Chart, WhatHasNoPlaceIsAGap) {
    for (const double missing : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
        Vector y = Vector::Constant(31, 10.0);
        y.segment(10, 11).setConstant(missing);
        const Chart chart{.title = {},
                          .across = "n",
                          .up = "v",
                          .logarithmic = true,
                          .lines = {{.name = {}, .x = ramp(31), .y = y}}};
        const Image image = draw_chart(chart, 400, 300);
        std::vector<int> columns(400, 0);
        for (const Place& p : places_of(image, chart_colour(0), 60))
            columns[static_cast<std::size_t>(p.x)] = 1;
        EXPECT_EQ(*std::max_element(columns.begin() + 190, columns.begin() + 240), 0);
        EXPECT_EQ(columns[100], 1);
        EXPECT_EQ(columns[330], 1);
    }
    const Vector none = Vector::Constant(3, nan);
    EXPECT_NO_THROW(
        draw_chart({.title = {}, .across = {}, .up = {}, .lines = {{{}, ramp(3), none}}}, 200, 150));
    EXPECT_NO_THROW(draw_chart({}, 200, 150));
}

TEST(Chart, RefusesWhatCannotBeDrawn) {
    EXPECT_THROW(draw_chart({}, 10, 300), InputError);
    EXPECT_THROW(draw_chart({}, 300, 100000), InputError);
    EXPECT_THROW(
        draw_chart({.title = {}, .across = {}, .up = {}, .lines = {{{}, ramp(3), ramp(4)}}}, 300, 300),
        InputError);
}

TEST(DrawLines, AreDarkInFrontAndHiddenBehind) {
    const Mesh sphere = shapes::icosphere(4);
    const Block values = Block::Constant(sphere.vertex_count(), 1, 1.0);
    const PictureOptions options{.width = 300, .height = 300, .bar = false};
    const Colour ink{0.08F, 0.08F, 0.10F};
    const auto meridian = [](double side) {  // in front (+z) or behind
        Points points(41, 3);
        Cells cells(40, 2);
        for (Index i = 0; i <= 40; ++i) {
            const double angle = -1.2 + 2.4 * i / 40.0;  // not to the rim, where its width is seen
            points.row(i) << 0.0, std::sin(angle), side * std::cos(angle);
            if (i < 40) cells.row(i) << i, i + 1;
        }
        return Mesh(points, cells);
    };
    const Image plain = draw(sphere, &values, options);
    const std::vector<Place> seen = places_of(draw_lines(sphere, &values, meridian(1.0), options), ink, 60);
    EXPECT_GT(seen.size(), 200u);
    for (const Place& p : seen)
        EXPECT_NEAR(p.x, 150, 4);
    EXPECT_EQ(draw_lines(sphere, &values, meridian(-1.0), options).rgb, plain.rgb);
    EXPECT_THROW(draw_lines(sphere, &values, sphere, options), InputError);
}

}  // namespace
}  // namespace beltrami
