// Table 1 of Kim & Rossignac, "Localized bi-Laplacian Solver on a Triangle Mesh and Its Applications": the
// radius of spheres, 2 / |Laplacian of x| at each vertex, with both corrections. The columns of the standard
// deviation are left out: they do not agree with the printed ranges by any usual definition.
#include <gtest/gtest.h>

#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/curvature.hpp"

namespace beltrami {
namespace {

/// A printed number, and one unit of its last digit. Ranges that the paper prints as 0.00 or a few 1e-6 are
/// what its single precision left of zero.
struct Printed {
    double value;
    double unit;
};
constexpr Printed zero{0.0, 1e-5};

struct Row {
    const char* name;
    Mesh sphere;
    int vertices;
    Printed mean_1, range_1, mean_2, range_2;
};
void PrintTo(const Row& row, std::ostream* out) {
    *out << row.name << " " << row.vertices;
}

std::vector<Row> rows() {
    using namespace shapes;  // NOLINT(google-build-using-namespace)
    return {{"latlong", latlong_sphere(1, 100), 6, {150.0, 0.1}, zero, {100., 1.}, zero},
            {"latlong", latlong_sphere(2, 100), 14, {112.1, 0.1}, {4.4, 0.1}, {99.8, 0.1}, {9.9, 0.1}},
            {"latlong", latlong_sphere(3, 100), 26, {106.7, 0.1}, {6.3, 0.1}, {99.3, 0.1}, {21.6, 0.1}},
            {"latlong", latlong_sphere(4, 100), 42, {104.7, 0.1}, {7.4, 0.1}, {99.2, 0.1}, {27.2, 0.1}},
            {"latlong", latlong_sphere(14, 100), 422, {101.7, 0.1}, {14.2, 0.1}, {99.8, 0.1}, {33.1, 0.1}},
            {"icosahedron", geodesic_icosahedron(1, 5), 12, {5.73, 0.01}, zero, {5.00, 0.01}, zero},
            {"icosahedron",
             geodesic_icosahedron(3, 5),
             92,
             {5.08, 0.01},
             {0.045, 0.001},
             {4.99, 0.01},
             {0.65, 0.01}},
            {"icosahedron",
             geodesic_icosahedron(5, 5),
             252,
             {5.03, 0.01},
             {0.047, 0.001},
             {5.00, 0.01},
             {0.67, 0.01}},
            {"tetrahedron", geodesic_tetrahedron(1, 5), 4, {15.00, 0.01}, zero, {5.00, 0.01}, zero},
            {"tetrahedron",
             geodesic_tetrahedron(2, 5),
             10,
             {7.04, 0.01},
             {1.88, 0.01},
             {4.86, 0.01},
             {3.56, 0.01}},
            {"tetrahedron",
             geodesic_tetrahedron(4, 5),
             34,
             {5.39, 0.01},
             {0.84, 0.01},
             {4.93, 0.01},
             {3.96, 0.01}},
            {"tetrahedron",
             geodesic_tetrahedron(10, 5),
             202,
             {5.06, 0.01},
             {0.49, 0.01},
             {4.99, 0.01},
             {3.67, 0.01}},
            {"tetrahedron",
             geodesic_tetrahedron(20, 5),
             802,
             {5.02, 0.01},
             {0.27, 0.01},
             {5.00, 0.01},
             {3.55, 0.01}}};
}

class KimRossignacTable1 : public ::testing::TestWithParam<Row> {};

TEST_P(KimRossignacTable1, MeanAndRangeOfTheRadius) {
    const Row& row = GetParam();
    ASSERT_EQ(row.sphere.vertex_count(), row.vertices);
    const Laplacian laplacian(row.sphere);
    const auto compare = [&](CurvatureCorrection correction, Printed mean, Printed range,
                             const char* column) {
        const Vector radius = mean_curvature(row.sphere, laplacian, correction).mean.cwiseInverse();
        // One unit of the last printed digit, and the rounding of this sum.
        EXPECT_NEAR(radius.mean(), mean.value, mean.unit + 1e-9) << "mean, " << column;
        EXPECT_NEAR(radius.maxCoeff() - radius.minCoeff(), range.value, range.unit + 1e-9)
            << "range, " << column;
        RecordProperty(std::string("mean_") + column, std::to_string(radius.mean()));
        RecordProperty(std::string("range_") + column, std::to_string(radius.maxCoeff() - radius.minCoeff()));
    };
    compare(CurvatureCorrection::c1, row.mean_1, row.range_1, "c1");
    compare(CurvatureCorrection::c2, row.mean_2, row.range_2, "c2");
}

INSTANTIATE_TEST_SUITE_P(All, KimRossignacTable1, ::testing::ValuesIn(rows()));

}  // namespace
}  // namespace beltrami
