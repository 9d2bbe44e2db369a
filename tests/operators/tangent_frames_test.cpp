#include "beltrami/operators/tangent_frames.hpp"

#include <gtest/gtest.h>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"
#include "turned_meshes.hpp"

namespace beltrami {
namespace {

using testing::moebius_strip;
using testing::partly_turned;

TEST(TangentFrames, AreOrthonormalAndTouchTheSphere) {
    const Mesh sphere = shapes::icosphere(4);
    const TangentFrames frames = tangent_frames(sphere);
    EXPECT_FALSE(frames.one_sided);
    EXPECT_EQ(frames.cancelled(), 0);
    for (Index v = 0; v < sphere.vertex_count(); ++v) {
        const Vector3 n = frames.normal.row(v);
        EXPECT_NEAR(n.norm(), 1.0, 1e-14);
        EXPECT_NEAR(frames.axis.row(v).norm(), 1.0, 1e-14);
        EXPECT_NEAR(n.dot(frames.axis.row(v).transpose()), 0.0, 1e-14);
        EXPECT_GT(n.dot(sphere.points().row(v).transpose()), 0.9999);
    }
}

TEST(TangentFrames, NumbersAndVectorsAreTheSameThing) {
    const TangentFrames frames = tangent_frames(shapes::torus(1.0, 0.4, 12, 8));
    for (Index v = 0; v < 96; v += 7) {
        const std::complex<double> z(0.3, -1.7);
        EXPECT_LT(std::abs(frames.to_number(v, frames.to_vector(v, z)) - z), 1e-14);
        const Vector3 n = frames.normal.row(v);
        EXPECT_LT(std::abs(frames.to_number(v, n)), 1e-14) << "what points away is left out";
        const Vector3 one = frames.to_vector(v, 1.0);
        EXPECT_LT((frames.to_vector(v, {0.0, 1.0}) - n.cross(one)).norm(), 1e-14) << "i turns left";
    }
}

TEST(TangentFrames, DoNotCareHowTrianglesAreTurned) {
    const Mesh sphere = shapes::icosphere(3);
    const TangentFrames straight = tangent_frames(sphere);
    const TangentFrames mended = tangent_frames(partly_turned(sphere));
    EXPECT_LT((straight.normal - mended.normal).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_FALSE(mended.one_sided);
    EXPECT_TRUE(tangent_frames(moebius_strip(20)).one_sided);
}

TEST(TangentFrames, KnowWhereThereIsNoTangentPlane) {
    // Three fins that meet in a line at 120 degrees, all turned the same way round: their normals cancel there.
    const Mesh fins = shapes::fins(3, 2);
    const TangentFrames frames = tangent_frames(fins);
    Index without = 0;
    for (Index v = 0; v < fins.vertex_count(); ++v) {
        const bool on_line = fins.points().row(v).head<2>().norm() < 1e-12;
        EXPECT_EQ(frames.has_plane[static_cast<std::size_t>(v)] == 0, on_line) << v;
        EXPECT_NEAR(frames.normal.row(v).norm(), 1.0, 1e-14) << "but a normal all the same";
        without += on_line ? 1 : 0;
    }
    EXPECT_EQ(without, 3);
    EXPECT_EQ(frames.cancelled(), without);

    Points points(5, 3);
    points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 5, 5, 5;
    const TangentFrames some = tangent_frames(Mesh(points, Cells{{0, 1, 2}, {0, 1, 3}}));
    EXPECT_EQ(some.has_plane, (std::vector<char>{1, 1, 1, 0, 0}));
    EXPECT_TRUE(some.normal.row(3).isZero(0.0)) << "in a triangle without area only";
    EXPECT_TRUE(some.normal.row(4).isZero(0.0));
    EXPECT_EQ(some.to_vector(4, 1.0), Vector3::Zero());
    EXPECT_EQ(some.cancelled(), 0) << "isolated vertices are another matter";
}

TEST(TangentFrames, TurningIsTheSmallestRotation) {
    const Vector3 from = Vector3(0.2, -0.5, 0.8).normalized();
    const Vector3 to = Vector3(0.9, 0.1, -0.3).normalized();
    const Vector3 tangent = from.cross(Vector3::UnitX()) * 2.0;
    const Vector3 expected = Eigen::Quaterniond::FromTwoVectors(from, to) * tangent;
    EXPECT_LT((turned(tangent, from, to, Vector3::UnitX()) - expected).norm(), 1e-14);
    // To the opposite normal it is half a turn about the hinge.
    const Vector3 hinge = from.cross(Vector3::UnitY()).normalized();
    const Vector3 over = turned(tangent, from, -from, hinge);
    EXPECT_LT((over - Eigen::AngleAxisd(std::acos(-1.0), hinge) * tangent).norm(), 1e-14);
}

TEST(TangentFrames, NeedTriangles) {
    EXPECT_THROW((void)tangent_frames(shapes::tetrahedral_cube(1)), InputError);
    EXPECT_THROW((void)tangent_frames(shapes::circle(5)), InputError);
}

}  // namespace
}  // namespace beltrami
