#include "beltrami/operators/singularities.hpp"

#include <gtest/gtest.h>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"
#include "turned_meshes.hpp"

namespace beltrami {
namespace {

using testing::moebius_strip;
using testing::partly_turned;
using testing::random_block;

Singularities find(const Mesh& mesh, const Block& field) {
    return singularities(mesh, tangent_frames(mesh), field);
}

// The field w(p) at every vertex.
template <class Function>
Block sampled(const Mesh& mesh, Function w) {
    Block field(mesh.vertex_count(), 3);
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        field.row(v) = w(Vector3(mesh.points().row(v)));
    return field;
}

// Poincare and Hopf: on a closed surface the indices add up to the Euler characteristic, for every field.
TEST(Singularities, AddUpToTheEulerCharacteristic) {
    const std::vector<std::pair<Mesh, int>> closed = {{shapes::geodesic_tetrahedron(1), 2},
                                                      {shapes::icosphere(0), 2},
                                                      {shapes::icosphere(3), 2},
                                                      {partly_turned(shapes::icosphere(2)), 2},
                                                      {shapes::bumpy_sphere(500), 2},
                                                      {shapes::torus(1.0, 0.4, 30, 12), 0},
                                                      {shapes::genus(2, 3), -2},
                                                      {shapes::genus(3, 2), -4}};
    for (const auto& [mesh, euler_characteristic] : closed) {
        for (const std::uint32_t seed : {1U, 2U, 3U}) {
            const Singularities found = find(mesh, random_block(mesh.vertex_count(), 3, seed));
            EXPECT_EQ(found.index_sum, euler_characteristic);
            EXPECT_EQ(found.undefined_triangles, 0);
            int sum = 0;
            for (const Singularity& s : found.list) {
                EXPECT_NE(s.index, 0);
                sum += s.index;
            }
            EXPECT_EQ(sum, found.index_sum);
        }
    }
}

TEST(Singularities, OfAGradientOnTheSphereAreItsPoles) {
    const Mesh sphere = testing::rigidly_moved(shapes::icosphere(4));
    const TangentFrames frames = tangent_frames(sphere);
    const Vector3 axis = Vector3(0.3, 0.5, 0.81).normalized();
    const Singularities found =
        singularities(sphere, frames, Block(axis.transpose().replicate(sphere.vertex_count(), 1)));
    ASSERT_EQ(found.list.size(), 2U);
    const Vector3 centre = sphere.points().colwise().mean();
    for (const Singularity& s : found.list) {
        EXPECT_EQ(s.index, 1);
        EXPECT_GT(std::abs((s.position - centre).normalized().dot(axis)), 0.99);
    }
}

TEST(Singularities, HaveTheSignAndTheSizeOfTheTurn) {
    const Mesh plane = shapes::jittered(shapes::grid(21, 21, 2.0, 2.0), 0.2);
    const auto at = [](const Vector3& p) { return std::complex<double>(p.x() - 0.97, p.y() - 1.03); };
    const auto power = [&](auto f) {
        return find(plane, sampled(plane, [&](const Vector3& p) {
                        const std::complex<double> w = f(at(p));
                        return Eigen::RowVector3d(w.real(), w.imag(), 0.0);
                    }));
    };
    const std::complex<double> i(0.0, 1.0);
    EXPECT_EQ(power([&](auto z) { return z; }).index_sum, 1) << "a source";
    EXPECT_EQ(power([&](auto z) { return -z; }).index_sum, 1) << "a sink";
    EXPECT_EQ(power([&](auto z) { return i * z; }).index_sum, 1) << "a vortex";
    EXPECT_EQ(power([&](auto z) { return std::conj(z); }).index_sum, -1) << "a saddle";
    EXPECT_EQ(power([&](auto z) { return z * z; }).index_sum, 2) << "a dipole";
    EXPECT_TRUE(power([&](auto) { return i; }).list.empty());
    const Singularities saddle = power([&](auto z) { return std::conj(z); });
    ASSERT_EQ(saddle.list.size(), 1U);
    EXPECT_LT((saddle.list[0].position - Vector3(0.97, 1.03, 0.0)).norm(), 0.1);
}

TEST(Singularities, AVectorThatVanishesIsFoundInATriangleAround) {
    const Mesh plane = shapes::grid(10, 10, 2.0, 2.0);
    const Vector3 middle(1.0, 1.0, 0.0);
    const Singularities source =
        find(plane, sampled(plane, [&](const Vector3& p) { return Eigen::RowVector3d(p - middle); }));
    EXPECT_EQ(source.index_sum, 1);
    ASSERT_EQ(source.list.size(), 1U);
    EXPECT_LT((source.list[0].position - middle).norm(), 0.3);
    // A constant field with a hole of one vertex has no singularity.
    Block constant = sampled(plane, [](const Vector3&) { return Eigen::RowVector3d(1.0, 2.0, 0.0); });
    constant.row(60).setZero();
    EXPECT_TRUE(find(plane, constant).list.empty());
    EXPECT_EQ(find(plane, constant).undefined_triangles, 0);
}

TEST(Singularities, AreNotCountedWhereThereIsNoField) {
    const Mesh two = shapes::together({shapes::icosphere(2), shapes::icosphere(1)});
    Block field = random_block(two.vertex_count(), 3);
    field.bottomRows(42).setZero();
    const Singularities found = find(two, field);
    EXPECT_EQ(found.index_sum, 2);
    EXPECT_EQ(found.undefined_triangles, 80);
}

TEST(Singularities, RefuseOtherShapesAndOneSidedSurfaces) {
    EXPECT_THROW((void)find(shapes::icosphere(0), Block::Zero(12, 2)), InputError);
    EXPECT_THROW((void)find(shapes::icosphere(0), Block::Zero(11, 3)), InputError);
    const Mesh strip = moebius_strip(20);
    EXPECT_THROW((void)find(strip, Block::Ones(strip.vertex_count(), 3)), InputError);
}

}  // namespace
}  // namespace beltrami
