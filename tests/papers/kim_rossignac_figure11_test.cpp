// Figure 11 of Kim & Rossignac, "Localized bi-Laplacian Solver on a Triangle Mesh and Its Applications": vector fields
// from four given vectors, (gamma_1, gamma_2) = (1, 0.05), coordinate by coordinate with projection, beside the
// connection Laplacian. The paper prints a picture and no numbers, so the numbers are those of problems whose answer is
// known, and how long the vectors of such a field are.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "beltrami/apps/vectors/vectors.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using std::numbers::pi;

void fix(Constraints& fixed, Index v, const Vector3& vector) {
    fixed.fix(v, std::array{vector.x(), vector.y(), vector.z()});
}

// The unit vectors around the z axis.
Vector3 around(const Mesh& mesh, Index v) {
    return Vector3::UnitZ().cross(Vector3(mesh.points().row(v))).normalized();
}

Block lengths(const Mesh& mesh, const Constraints& fixed, const VectorsOptions& options) {
    return vectors(mesh, Laplacian(mesh), fixed, options).vectors.rowwise().norm();
}

// Two lines of a cylinder carry unit vectors around it. What is parallel to both has length 1 everywhere; coordinates
// go along straight lines from one vector to its opposite and lose even more to the projection.
TEST(KimRossignacFigure11, AroundACylinder) {
    const int nu = 120;
    const Mesh cylinder = shapes::cylinder(1.0, 1.5, nu, 24);
    // The normals of the rims lean by a part of an edge.
    const TangentFrames frames = tangent_frames(cylinder);
    Constraints fixed(3);
    for (Index v = 0; v < cylinder.vertex_count(); ++v) {
        if (std::abs(cylinder.points()(v, 1)) < 1e-9)
            fix(fixed, v, Vector3::UnitZ().cross(Vector3(frames.normal.row(v))));
    }
    const Block parallel =
        lengths(cylinder, fixed, {.method = VectorMethod::connection, .lengths = VectorLengths::solved});
    EXPECT_LT((parallel.array() - 1.0).abs().maxCoeff(), 1e-9);
    const Block bilaplacian =
        lengths(cylinder, fixed,
                {.method = VectorMethod::connection, .lengths = VectorLengths::solved, .bilaplacian = 0.05});
    EXPECT_LT((bilaplacian.array() - 1.0).abs().maxCoeff(), 1e-8);
    const Block straight = lengths(cylinder, fixed, {.method = VectorMethod::coordinates});
    for (Index v = 0; v < cylinder.vertex_count(); ++v) {
        const double angle = std::atan2(std::abs(cylinder.points()(v, 1)), cylinder.points()(v, 0));
        EXPECT_NEAR(straight(v, 0), std::abs((1.0 - 2.0 * angle / pi) * std::cos(angle)), 5e-3);
    }
    EXPECT_LT(straight.minCoeff(), 1e-2);
    RecordProperty("shortest_connection", std::to_string(parallel.minCoeff()));
    RecordProperty("shortest_coordinates", std::to_string(straight.minCoeff()));
}

// Unit vectors along the parallels at 30 and 150 degrees from the pole of a sphere. With x = log tan(theta / 2) a field f
// along the parallels between them solves f'' = cos(theta)^2 f for the connection, integrated here by Runge and Kutta,
// and f'' = f coordinate by coordinate.
double middle_of_band(double edge) {
    constexpr int steps = 2000;
    const double h = edge / steps;
    Eigen::Vector2d f(1.0, 0.0);
    const auto slope = [](double x, const Eigen::Vector2d& y) {
        return Eigen::Vector2d(y[1], std::tanh(x) * std::tanh(x) * y[0]);
    };
    for (int i = 0; i < steps; ++i) {
        const double x = i * h;
        const Eigen::Vector2d a = slope(x, f);
        const Eigen::Vector2d b = slope(x + h / 2, f + h / 2 * a);
        const Eigen::Vector2d c = slope(x + h / 2, f + h / 2 * b);
        const Eigen::Vector2d d = slope(x + h, f + h * c);
        f += h / 6 * (a + 2 * b + 2 * c + d);
    }
    return 1.0 / f[0];
}

TEST(KimRossignacFigure11, BetweenTwoParallelsOfASphere) {
    const double exact_connection = middle_of_band(std::log(std::tan(pi / 12.0)));
    const double exact_coordinates = 0.5;  // 1 / cosh
    std::vector<double> widths;
    std::vector<double> errors;
    for (const int rings : {11, 23, 47}) {
        const Mesh sphere = shapes::latlong_sphere(rings);
        Constraints fixed(3);
        for (Index v = 0; v < sphere.vertex_count(); ++v) {
            if (std::abs(std::abs(sphere.points()(v, 2)) - std::cos(pi / 6.0)) < 1e-9)
                fix(fixed, v, around(sphere, v));
        }
        ASSERT_EQ(fixed.size(), 4 * (rings + 1)) << "two of the rings";
        const Block connection =
            lengths(sphere, fixed, {.method = VectorMethod::connection, .lengths = VectorLengths::solved});
        const Block coordinates = lengths(sphere, fixed, {.method = VectorMethod::coordinates});
        double error = 0.0;
        double error_of_coordinates = 0.0;
        for (Index v = 0; v < sphere.vertex_count(); ++v) {
            if (std::abs(sphere.points()(v, 2)) > 1e-9) continue;
            error = std::max(error, std::abs(connection(v, 0) - exact_connection));
            error_of_coordinates =
                std::max(error_of_coordinates, std::abs(coordinates(v, 0) - exact_coordinates));
        }
        widths.push_back(1.0 / rings);
        errors.push_back(error);
        EXPECT_LT(error_of_coordinates, 3.0 / rings / rings);
    }
    const double order = testing::fitted_order(widths, errors);
    EXPECT_NEAR(order, 2.0, 0.2) << errors.back();
    EXPECT_LT(errors.back(), 1.5e-3);
    EXPECT_GT(exact_connection, 0.75);
    RecordProperty("length_connection", std::to_string(exact_connection));
    RecordProperty("length_coordinates", std::to_string(exact_coordinates));
    RecordProperty("order", std::to_string(order));
}

struct Case {
    std::string name;
    Mesh mesh;
    double radius;  // of the circle on which the vectors are given
    double bilaplacian;
    double coordinates, connection;  // the median length of the field, as measured
};
void PrintTo(const Case& c, std::ostream* out) {
    *out << c.name;
}

class FourVectors : public ::testing::TestWithParam<Case> {};

// Four unit vectors around the z axis, and how long the field is between them. The Gaussian curvature of sphere and torus
// leaves no parallel field, so that the solution of the connection fades as well, but less; with interpolated lengths, as
// is its default, it does not.
TEST_P(FourVectors, FadeLessByTheConnection) {
    const Case& c = GetParam();
    Constraints fixed(3);
    for (const int quarter : {0, 1, 2, 3}) {
        const Vector3 place(c.radius * std::cos(quarter * pi / 2), c.radius * std::sin(quarter * pi / 2),
                            0.0);
        Index v = 0;
        (c.mesh.points().rowwise() - place.transpose()).rowwise().squaredNorm().minCoeff(&v);
        fix(fixed, v, around(c.mesh, v));
    }
    const auto median = [&](const VectorsOptions& options) {
        Block length = lengths(c.mesh, fixed, options);
        EXPECT_NEAR(length.maxCoeff(), 1.0, 1e-3) << "no vector is longer than those given";
        std::nth_element(length.data(), length.data() + length.size() / 2, length.data() + length.size());
        return length(length.size() / 2, 0);
    };
    const double coordinates = median({.method = VectorMethod::coordinates, .bilaplacian = c.bilaplacian});
    const double connection = median(
        {.method = VectorMethod::connection, .lengths = VectorLengths::solved, .bilaplacian = c.bilaplacian});
    EXPECT_NEAR(coordinates, c.coordinates, 0.01);
    EXPECT_NEAR(connection, c.connection, 0.01);
    EXPECT_GT(connection, 1.25 * coordinates);
    const double interpolated = median({.bilaplacian = c.bilaplacian});
    EXPECT_NEAR(interpolated, 1.0, 1e-8);
    RecordProperty("median_coordinates", std::to_string(coordinates));
    RecordProperty("median_connection", std::to_string(connection));
}

INSTANTIATE_TEST_SUITE_P(
    KimRossignacFigure11, FourVectors,
    ::testing::Values(Case{"sphere", shapes::icosphere(4), 1.0, 0.0, 0.221, 0.374},
                      Case{"sphere_mixed", shapes::icosphere(4), 1.0, 0.05, 0.517, 0.677},
                      Case{"torus", shapes::torus(1.0, 0.4, 90, 40), 1.4, 0.0, 0.269, 0.431},
                      Case{"torus_mixed", shapes::torus(1.0, 0.4, 90, 40), 1.4, 0.05, 0.536, 0.700}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace beltrami
