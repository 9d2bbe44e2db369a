#include "beltrami/apps/picture/picture.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string>

#include "beltrami/apps/picture/camera.hpp"
#include "beltrami/apps/picture/colour_map.hpp"
#include "beltrami/apps/picture/ticks.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

using Pixel = std::array<int, 3>;

const Pixel white{255, 255, 255};

Pixel pixel(const Image& image, int x, int y) {
    const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                               static_cast<std::size_t>(x));
    return {image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]};
}

/// The rectangle of pixels that are not white: left, top, right, bottom, all inclusive.
std::array<int, 4> drawn(const Image& image) {
    std::array<int, 4> box{image.width, image.height, -1, -1};
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            if (pixel(image, x, y) == white) continue;
            box = {std::min(box[0], x), std::min(box[1], y), std::max(box[2], x), std::max(box[3], y)};
        }
    }
    return box;
}

bool is_blank(const Image& image) {
    return drawn(image)[2] < 0;
}

void expect_near(const Pixel& actual, const Colour& expected, double tolerance) {
    for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(actual[k], 255.0 * expected[k], tolerance) << "channel " << k;
}

/// A triangle's corners one a row.
Mesh triangles(const std::vector<std::array<double, 3>>& corners) {
    Points points(static_cast<Eigen::Index>(corners.size()), 3);
    Cells cells(points.rows() / 3, 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const auto& c = corners[static_cast<std::size_t>(i)];
        points.row(i) << c[0], c[1], c[2];
        cells(i / 3, i % 3) = static_cast<Index>(i);
    }
    return {points, cells};
}

const Mesh& square() {
    static const Mesh mesh = shapes::grid(8, 8);
    return mesh;
}

std::string complaint(const std::function<void()>& action) {
    try {
        action();
    } catch (const InputError& error) {
        return error.what();
    }
    return "none";
}

const PictureOptions small{.width = 200, .height = 160, .bar = false};

TEST(Picture, SphereIsCentredOnWhite) {
    const Image image = draw(shapes::icosphere(4), nullptr, {.width = 300, .height = 200});
    ASSERT_EQ(image.rgb.size(), 300U * 200U * 3U);
    for (const auto& [x, y] : {std::pair{0, 0}, {299, 0}, {0, 199}, {299, 199}})
        EXPECT_EQ(pixel(image, x, y), white);
    const auto [left, top, right, bottom] = drawn(image);
    EXPECT_NEAR(left + right, 299, 1);
    EXPECT_NEAR(top + bottom, 199, 1);
    EXPECT_NEAR(bottom - top, 0.9 * 200, 2) << "fills the height up to the margin";
    EXPECT_NEAR(right - left, bottom - top, 1);
}

TEST(Picture, ColoursFollowTheField) {
    const Mesh mesh = shapes::icosphere(5);
    const Block z = mesh.points().col(2).array() + 2.0;
    PictureOptions options = small;
    options.up = "z";
    const Image image = draw(mesh, &z, options);
    const ColourScale scale(1.0, 3.0);
    // At half the radius above and below the middle; light changes brightness by less than the colours
    // differ.
    expect_near(pixel(image, 100, 80 - 36), scale.colour(2.5), 30);
    expect_near(pixel(image, 100, 80 + 36), scale.colour(1.5), 30);
}

TEST(Picture, FlatPiecesHaveTheColoursOfTheBar) {
    const Block x = square().points().col(0);
    const Image image = draw(square(), &x, {.width = 400, .height = 400, .bar = false});
    const ColourScale scale(0.0, 1.0);
    expect_near(pixel(image, 200, 200), scale.colour(0.5), 3);
    expect_near(pixel(image, 110, 300), scale.colour(0.25), 3);
    expect_near(pixel(image, 290, 100), scale.colour(0.75), 3);
}

TEST(Picture, GivenRangeClamps) {
    const Block x = square().points().col(0);
    PictureOptions options = small;
    options.range = {0.4, 0.5};
    const Image image = draw(square(), &x, options);
    expect_near(pixel(image, 40, 80), ColourMap::sequential()(0.0), 2);
    expect_near(pixel(image, 160, 80), ColourMap::sequential()(1.0), 2);
}

TEST(Picture, ConstantFields) {
    for (const double value : {0.0, 7.0, -1e300, 1e-310}) {
        const Block field = Block::Constant(square().vertex_count(), 1, value);
        const Image image = draw(square(), &field, {.width = 400, .height = 300});
        expect_near(pixel(image, 150, 150), ColourMap::sequential()(0.5), 2);
    }
}

TEST(Picture, ValuesThatAreNotFiniteAreGrey) {
    Block field = square().points().col(0);
    field.bottomRows(field.rows() / 2).setConstant(nan);  // the upper half
    field(0, 0) = std::numeric_limits<double>::infinity();
    const Image image = draw(square(), &field, small);
    expect_near(pixel(image, 100, 30), no_value_colour, 2);
    expect_near(pixel(image, 100, 140), ColourScale(0.0, 1.0).colour(0.5), 4);
    field.setConstant(nan);
    const Image grey = draw(square(), &field, {.width = 200, .height = 160});
    expect_near(pixel(grey, 100, 80), no_value_colour, 2);
}

TEST(Picture, ExtremeValuesAndCoordinates) {
    const Block field = (square().points().col(0).array() * 2.0 - 1.0) * 1.7e308;
    const Image image = draw(square(), &field, small);
    expect_near(pixel(image, 100, 80), ColourMap::diverging()(0.5), 4);
    for (const double size : {1e-300, 1e-20, 1e300}) {
        const Mesh sphere = shapes::icosphere(3, size);
        const auto box = drawn(draw(sphere, nullptr, small));
        EXPECT_NEAR(box[3] - box[1], 0.9 * 160, 3) << size;
    }
}

TEST(Picture, RgbAsItIs) {
    const Block rgb = Eigen::RowVector3d(0.2, 0.9, 2.0).replicate(square().vertex_count(), 1);
    const Image image = draw(square(), &rgb, small);
    expect_near(pixel(image, 100, 80), {0.2F, 0.9F, 1.0F}, 1);
}

TEST(Picture, BothSidesAreLitAlike) {
    const Mesh mesh = triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
    const Image image = draw(mesh, nullptr, small);
    EXPECT_EQ(pixel(image, 80, 100), pixel(image, 120, 60)) << "of opposite orientation";
    const auto [left, top, right, bottom] = drawn(image);
    for (int y = top; y <= bottom; ++y) {
        for (int x = left; x <= right; ++x)
            ASSERT_NE(pixel(image, x, y), white) << "seam at " << x << " " << y;
    }
}

TEST(Picture, NearerHidesFarther) {
    const Mesh mesh = triangles({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, {-1, -1, 1}, {1, -1, 1}, {0, 1, 1}});
    Block rgb(6, 3);
    rgb << 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1;
    PictureOptions options = small;
    expect_near(pixel(draw(mesh, &rgb, options), 100, 100), {0, 0, 1}, 2);
    options.view = "back";
    expect_near(pixel(draw(mesh, &rgb, options), 100, 100), {1, 0, 0}, 2);
}

TEST(Picture, Edges) {
    const Image without = draw(square(), nullptr, small);
    PictureOptions options = small;
    options.edges = true;
    const Image with = draw(square(), nullptr, options);
    EXPECT_NE(with.rgb, without.rgb);
    EXPECT_EQ(drawn(with), drawn(without));
    // Where there are as many edges as pixels they would hide the surface.
    const Mesh dense = shapes::grid(300, 300);
    EXPECT_EQ(draw(dense, nullptr, options).rgb, draw(dense, nullptr, small).rgb);
}

TEST(Picture, EveryKindOfMesh) {
    const Mesh ball = shapes::tetrahedral_ball(4);
    EXPECT_NE(pixel(draw(ball, nullptr, small), 100, 80), white);

    const Image cloud = draw(Mesh(shapes::icosphere(3).points()), nullptr, small);
    EXPECT_NEAR(drawn(cloud)[3] - drawn(cloud)[1], 0.9 * 160, 4);

    const Image circle = draw(shapes::circle(50), nullptr, small);
    EXPECT_EQ(pixel(circle, 100, 80), white);
    EXPECT_NEAR(drawn(circle)[0] + drawn(circle)[2], 199, 1);
    EXPECT_NEAR(drawn(circle)[3] - drawn(circle)[1], 0.9 * 160, 3);

    EXPECT_FALSE(is_blank(draw(shapes::fins(3, 4), nullptr, small)));
}

TEST(Picture, FromTheSideAFlatMeshIsALine) {
    PictureOptions options = small;
    options.view = "right";
    const auto [left, top, right, bottom] = drawn(draw(square(), nullptr, options));
    EXPECT_LE(right - left, 4);
    EXPECT_GE(bottom - top, 130);
}

TEST(Picture, EmptyAndDegenerateMeshes) {
    EXPECT_TRUE(is_blank(draw(Mesh(Points(0, 3)), nullptr, small)));
    EXPECT_TRUE(is_blank(draw(Mesh(Points(0, 3), Cells(0, 3)), nullptr, small)));
    EXPECT_TRUE(is_blank(draw(Mesh(Points(0, 3), Cells(0, 4)), nullptr, {})));
    const Block none(0, 1);
    EXPECT_TRUE(is_blank(draw(Mesh(Points(0, 3)), &none, {})));

    const Block values = Block::Ones(6, 1);
    const Mesh one_place = triangles(std::vector<std::array<double, 3>>(6, {3, 3, 3}));
    EXPECT_FALSE(is_blank(draw(one_place, &values, small)));
    EXPECT_NE(pixel(draw(Mesh(one_place.points()), &values, small), 100, 80), white);
    Cells twice(1, 3);
    twice << 0, 0, 1;
    EXPECT_FALSE(is_blank(draw(Mesh(square().points(), twice), nullptr, small)));
}

TEST(Picture, IsolatedVerticesCountNeitherForFitNorForColours) {
    Points points(square().vertex_count() + 1, 3);
    points << square().points(), 100.0, 100.0, 100.0;
    const Mesh mesh(points, square().cells());
    Block field(points.rows(), 1);
    field << square().points().col(0), 1e6;
    const Block without = square().points().col(0);
    EXPECT_EQ(draw(mesh, &field).rgb, draw(square(), &without).rgb);
}

TEST(Picture, TitleAndBar) {
    const Block x = square().points().col(0);
    const Image bare = draw(square(), &x, {.width = 400, .height = 300, .bar = false});
    const Image with_bar = draw(square(), &x, {.width = 400, .height = 300});
    EXPECT_GT(drawn(with_bar)[2], 370);
    EXPECT_LT(drawn(bare)[2], 350);
    const Image titled =
        draw(square(), &x, {.width = 400, .height = 300, .title = "\u03b3 = 1", .bar = false});
    EXPECT_LT(drawn(titled)[1], drawn(bare)[1]);
    EXPECT_LT(drawn(titled)[0], drawn(bare)[0]);
    // No room for either: the drawing alone.
    const Image tiny = draw(square(), &x, {.width = 16, .height = 16, .title = "title"});
    EXPECT_NE(pixel(tiny, 8, 8), white);
    EXPECT_NO_THROW(draw(square(), &x, {.width = 200, .height = 100, .title = std::string(5000, 'w')}));
}

TEST(Picture, SameBytesAgain) {
    const Mesh mesh = shapes::bumpy_sphere(2000);
    const Block y = mesh.points().col(1);
    const PictureOptions options{.view = "iso", .title = "again", .edges = true};
    EXPECT_EQ(encode_png(draw(mesh, &y, options)), encode_png(draw(mesh, &y, options)));
}

TEST(Picture, LargeSizesAreDrawn) {
    const Image image = draw(shapes::icosphere(2), nullptr, {.width = 16384, .height = 16});
    EXPECT_NE(pixel(image, 8192, 8), white);
}

TEST(Picture, BadInputIsExplained) {
    const auto drawing = [](const PictureOptions& options) {
        return complaint([&] { (void)draw(square(), nullptr, options); });
    };
    EXPECT_EQ(drawing({.width = 15}), "a picture of 15 x 800 pixels cannot be drawn");
    EXPECT_EQ(drawing({.height = 16385}), "a picture of 1000 x 16385 pixels cannot be drawn");
    EXPECT_EQ(drawing({.view = "sideways"}), "there is no view 'sideways'");
    for (const char* view : {"", "1,2", "1,2,3,4", "1,2,x", "0,0,0", "nan,0,1", "1,,2", "1,2,3,"}) {
        EXPECT_EQ(drawing({.view = view}), std::string("there is no view '") + view + "'");
    }
    EXPECT_EQ(drawing({.up = "w"}), "a picture cannot have 'w' up");
    EXPECT_EQ(drawing({.range = std::pair{2.0, 1.0}}), "colours cannot range from 2 to 1");
    EXPECT_EQ(drawing({.range = std::pair{nan, 1.0}}), "colours cannot range from nan to 1");
    EXPECT_NE(drawing({.title = "\xff\xfe"}), "none");
    const auto with_field = [](const Block& field) {
        return complaint([&] { (void)draw(square(), &field); });
    };
    EXPECT_EQ(with_field(Block::Zero(3, 1)), "the field has 3 rows for 81 vertices");
    EXPECT_EQ(with_field(Block::Zero(81, 2)), "a field of 2 columns cannot be drawn");
}

TEST(Picture, SideBySide) {
    Image black{10, 6, std::vector<std::uint8_t>(180, 0)};
    Image grey{4, 4, std::vector<std::uint8_t>(48, 128)};
    const Image sheet = side_by_side({black, grey, black}, 2);
    EXPECT_EQ(sheet.width, 20);
    EXPECT_EQ(sheet.height, 12);
    EXPECT_EQ(pixel(sheet, 0, 0), (Pixel{0, 0, 0}));
    EXPECT_EQ(pixel(sheet, 10, 0), white);
    EXPECT_EQ(pixel(sheet, 13, 1), (Pixel{128, 128, 128}));
    EXPECT_EQ(pixel(sheet, 17, 1), white);
    EXPECT_EQ(pixel(sheet, 0, 6), (Pixel{0, 0, 0}));
    EXPECT_EQ(pixel(sheet, 10, 6), white);
    EXPECT_EQ(side_by_side({black}, 5).width, 10);
    EXPECT_THROW(side_by_side({}, 1), InputError);
    EXPECT_THROW(side_by_side({black}, 0), InputError);
    EXPECT_THROW(side_by_side({Image{10, 6, {}}}, 1), InputError);
    EXPECT_THROW(side_by_side(std::vector<Image>(4000, black), 4000), InputError);
}

TEST(Picture, Png) {
    const std::string png = encode_png(draw(square(), nullptr, {.width = 321, .height = 123}));
    EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
    const auto number = [&](std::size_t at) {
        int value = 0;
        for (std::size_t i = 0; i < 4; ++i)
            value = 256 * value + static_cast<unsigned char>(png[at + i]);
        return value;
    };
    EXPECT_EQ(png.substr(12, 4), "IHDR");
    EXPECT_EQ(number(16), 321);
    EXPECT_EQ(number(20), 123);
    EXPECT_EQ(png[24], 8) << "bits a channel";
    EXPECT_EQ(png[25], 2) << "RGB";
    EXPECT_EQ(png.substr(png.size() - 8, 4), "IEND");
    EXPECT_THROW(encode_png({}), InputError);
    EXPECT_THROW(encode_png({2, 2, {1, 2, 3}}), InputError);
    EXPECT_THROW(encode_png({32768, 1, std::vector<std::uint8_t>(98304)}), InputError);
}

double lightness(const Colour& c) {
    const auto linear = [](double v) {
        return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    };
    return 116.0 * std::cbrt(0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2])) - 16.0;
}

TEST(ColourMap, LightnessChangesEvenly) {
    const ColourMap& sequential = ColourMap::sequential();
    const double step = (lightness(sequential(1.0)) - lightness(sequential(0.0))) / 20;
    for (int i = 0; i < 20; ++i) {
        const double change = lightness(sequential((i + 1) / 20.0)) - lightness(sequential(i / 20.0));
        EXPECT_NEAR(change, step, 0.3 * step) << i;
    }
    const ColourMap& diverging = ColourMap::diverging();
    for (int i = 0; i < 10; ++i) {
        const double near = 0.05 * i;
        const double far = 0.05 * (i + 1);
        EXPECT_GT(lightness(diverging(0.5 + near)) - lightness(diverging(0.5 + far)), 2.0) << i;
        EXPECT_GT(lightness(diverging(0.5 - near)) - lightness(diverging(0.5 - far)), 2.0) << i;
        EXPECT_NEAR(lightness(diverging(0.5 + far)), lightness(diverging(0.5 - far)), 6.0) << i;
    }
}

TEST(ColourMap, EndsAndBeyond) {
    for (const ColourMap* map : {&ColourMap::sequential(), &ColourMap::diverging()}) {
        EXPECT_EQ((*map)(-3.0), (*map)(0.0));
        EXPECT_EQ((*map)(1e300), (*map)(1.0));
        EXPECT_EQ((*map)(nan), no_value_colour);
    }
}

TEST(ColourScale, DivergesAroundZero) {
    EXPECT_FALSE(ColourScale(0.0, 1.0).is_diverging());
    EXPECT_FALSE(ColourScale(-2.0, -1.0).is_diverging());
    EXPECT_FALSE(ColourScale(-1e-12, 1.0).is_diverging()) << "rounding is not a sign";
    EXPECT_FALSE(ColourScale(0.0, 0.0).is_diverging());
    const ColourScale scale(-1.0, 4.0);
    EXPECT_TRUE(scale.is_diverging());
    EXPECT_EQ(scale.colour(0.0), ColourMap::diverging()(0.5));
    EXPECT_EQ(scale.colour(4.0), ColourMap::diverging()(1.0));
    EXPECT_EQ(scale.colour(-1.0), ColourMap::diverging()(0.375)) << "as strong as 1";
    EXPECT_EQ(scale.colour(-9.0), scale.colour(-1.0)) << "beyond the range";
}

std::string labels(double low, double high, int wanted) {
    const Ticks ticks = ticks_between(low, high, wanted);
    std::string text;
    for (const Tick& tick : ticks.ticks)
        text += tick.label + " ";
    return text + ticks.factor;
}

TEST(Ticks, RoundNumbers) {
    EXPECT_EQ(labels(0, 1, 5), "0.0 0.2 0.4 0.6 0.8 1.0 ");
    EXPECT_EQ(labels(-1, 1, 4), "\u22121.0 \u22120.5 0.0 0.5 1.0 ");
    EXPECT_EQ(labels(3, 47, 5), "10 20 30 40 ");
    EXPECT_EQ(labels(0, 100, 5), "0 20 40 60 80 100 ");
    EXPECT_EQ(labels(0, 3e-5, 3), "0 1 2 3 \u00d710\u207b\u2075");
    EXPECT_EQ(labels(0, 2e6, 2), "0 1 2 \u00d710\u2076");
    EXPECT_EQ(labels(1000.001, 1000.002, 2), "1000.0010 1000.0015 1000.0020 ");
    EXPECT_EQ(labels(0.25, 0.25, 5), "0.25 ");
    EXPECT_EQ(labels(0, 0, 5), "0 ");
    EXPECT_EQ(labels(0.0001, 99.9, 5), "0 20 40 60 80 100 ") << "ends that look round";
    for (const auto& [low, high] : {std::pair{-1.7e308, 1.7e308}, {0.0, 5e-324}, {1e16, 1e16 + 4}}) {
        EXPECT_LE(ticks_between(low, high, 5).ticks.size(), 13U);
    }
}

TEST(Camera, NamedViews) {
    for (const char* up : {"x", "y", "z"}) {
        for (const char* view : {"front", "back", "left", "right", "top", "bottom", "iso", "1,2,-3", "0,0,1",
                                 "1,0,0", "0,1,0", "1e300,-1e300,0"}) {
            const Camera c = camera_from(view, up);
            Eigen::Matrix3d axes;
            axes << c.right, c.up, c.toward;
            EXPECT_NEAR((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-12)
                << view << up;
            EXPECT_NEAR(axes.determinant(), 1.0, 1e-12) << view << up << ": not a mirror image";
        }
    }
    EXPECT_EQ(camera_from("front", "y").toward, Vector3::UnitZ());
    EXPECT_EQ(camera_from("right", "y").toward, Vector3::UnitX());
    EXPECT_EQ(camera_from("front", "z").toward, -Vector3::UnitY());
    EXPECT_EQ(camera_from("top", "z").toward, Vector3::UnitZ());
    EXPECT_EQ(camera_from("top", "z").up, Vector3::UnitY());
    EXPECT_EQ(camera_from("0,2,0", "y").up, camera_from("top", "y").up);
}

// Where the red arrows of given vectors are: left, top, right, bottom.
std::array<int, 4> red(const Image& image) {
    std::array<int, 4> box{image.width, image.height, -1, -1};
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const Pixel p = pixel(image, x, y);
            if (p[0] < 120 || p[1] > p[0] / 2 || p[2] > p[0] / 2) continue;
            box = {std::min(box[0], x), std::min(box[1], y), std::max(box[2], x), std::max(box[3], y)};
        }
    }
    return box;
}

TEST(DrawVectors, ArrowsLieAlongTheirVectors) {
    const Index middle = 40;
    for (const bool upward : {false, true}) {
        const Vector3 vector = upward ? Vector3::UnitY() : Vector3::UnitX();
        const Block field = vector.transpose().replicate(square().vertex_count(), 1);
        const Image image = draw_vectors(square(), field, {middle}, small);
        const auto [left, top, right, bottom] = red(image);
        ASSERT_GE(right, 0);
        const int along = upward ? bottom - top : right - left;
        const int across = upward ? right - left : bottom - top;
        EXPECT_GT(along, 2 * across);
        EXPECT_NEAR(0.5 * (left + right), 100.0, 3.0) << "the middle of the picture";
        EXPECT_NEAR(0.5 * (top + bottom), 80.0, 3.0);
        // The barbs are at the tip.
        const auto count_red = [&](int x0, int y0, int x1, int y1) {
            int count = 0;
            for (int y = y0; y <= y1; ++y) {
                for (int x = x0; x <= x1; ++x)
                    count += pixel(image, x, y)[1] < pixel(image, x, y)[0] / 2 ? 1 : 0;
            }
            return count;
        };
        const int x = (left + right) / 2;
        const int y = (top + bottom) / 2;
        if (upward) {
            EXPECT_GT(count_red(left, top, right, y), count_red(left, y, right, bottom));
        } else {
            EXPECT_GT(count_red(x, top, right, bottom), count_red(left, top, x, bottom));
        }
    }
}

TEST(DrawVectors, WhatIsBehindTheSurfaceIsHidden) {
    const Mesh sphere = shapes::icosphere(4);
    const Block field = Vector3::UnitX().transpose().replicate(sphere.vertex_count(), 1);
    Index front = 0;
    Index back = 0;
    sphere.points().col(2).maxCoeff(&front);
    sphere.points().col(2).minCoeff(&back);
    EXPECT_GE(red(draw_vectors(sphere, field, {front}, small))[2], 0);
    EXPECT_LT(red(draw_vectors(sphere, field, {back}, small))[2], 0);
    EXPECT_NE(draw_vectors(sphere, field, {back}, small).rgb, draw(sphere, nullptr, small).rgb)
        << "but there are other arrows";
}

TEST(DrawVectors, ColoursAreThoseOfTheLengths) {
    Block field = Block::Zero(square().vertex_count(), 3);
    field.col(0).setConstant(2.0);
    PictureOptions options = small;
    options.range = {0.0, 2.0};
    const Image bright = draw_vectors(square(), field, {}, options);
    options.range = {2.0, 4.0};
    const Image dark = draw_vectors(square(), field, {}, options);
    const auto total = [](const Image& image) {
        return std::accumulate(image.rgb.begin(), image.rgb.end(), 0L);
    };
    EXPECT_GT(total(bright), total(dark)) << "the end of the map is yellow, its start violet";
}

TEST(DrawVectors, TakesZerosNansAndAnyMesh) {
    Block field = Block::Zero(square().vertex_count(), 3);
    EXPECT_FALSE(is_blank(draw_vectors(square(), field, {3}, small)));
    field.setConstant(nan);
    EXPECT_LT(red(draw_vectors(square(), field, {3}, small))[2], 0);
    field.row(3).setConstant(1.0);
    EXPECT_FALSE(is_blank(draw_vectors(square(), field, {3, 4}, small)));
    for (const Mesh& mesh : {shapes::circle(12), shapes::tetrahedral_cube(2), Mesh(square().points())}) {
        const Image image = draw_vectors(mesh, Block::Ones(mesh.vertex_count(), 3), {}, small);
        EXPECT_NE(image.rgb, draw(mesh, nullptr, small).rgb);
    }
}

TEST(DrawVectors, RefusesOtherShapesAndVertices) {
    const Index n = square().vertex_count();
    EXPECT_NE(complaint([&] { draw_vectors(square(), Block::Zero(n, 1), {}); }), "none");
    EXPECT_NE(complaint([&] { draw_vectors(square(), Block::Zero(n - 1, 3), {}); }), "none");
    EXPECT_NE(complaint([&] { draw_vectors(square(), Block::Zero(n, 3), {n}); }), "none");
    EXPECT_NE(complaint([&] { draw_vectors(square(), Block::Zero(n, 3), {-1}); }), "none");
}

}  // namespace
}  // namespace beltrami
