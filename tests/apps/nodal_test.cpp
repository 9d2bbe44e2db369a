#include "beltrami/apps/nodal/nodal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "meshes.hpp"
#include "stored.hpp"

namespace beltrami {
namespace {

constexpr double pi = std::numbers::pi;

// Courant's theorem, on a rectangle of simple eigenvalues without a weight of the wrong sign.
TEST(NodalLines, ObeyCourant) {
    const testing::Scratch scratch;
    const Mesh mesh = shapes::grid(29, 22, 1.37, 1.0);
    const StoredBasis basis = testing::stored_basis(scratch / "b", mesh, 40);
    Index most = 0;
    for (Index k = 0; k < basis.count(); ++k) {
        const NodalLines found = nodal_lines(mesh, basis.function(k));
        EXPECT_LE(found.domains, k + 1) << "function " << k;
        if (k > 0) {
            EXPECT_GE(found.domains, 2) << "orthogonal to the constant";
            EXPECT_FALSE(found.lines.lines.empty());
        }
        most = std::max(most, found.domains);
    }
    EXPECT_GE(most, 6);
    // cos(pi x / 1.37): straight across.
    const NodalLines first = nodal_lines(mesh, basis.function(1));
    EXPECT_EQ(first.domains, 2);
    EXPECT_NEAR(first.lines.length, 1.0, 1e-3);
}

// The drum: Bessel's J0(j02 r) is 0 at r = j01 / j02 and, being held, on the rim.
TEST(NodalLines, HeldVerticesAreNoLine) {
    const testing::Scratch scratch;
    const Mesh mesh = shapes::disk(24);
    Constraints held;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.points().row(v).norm() > 1.0 - 1e-9) held.fix(v, 0.0);
    }
    const StoredBasis basis = testing::stored_basis(scratch / "b", mesh, 6, held);
    for (const double sign : {1.0, -1.0}) {
        const NodalLines none = nodal_lines(mesh, sign * basis.function(0));
        EXPECT_TRUE(none.lines.lines.empty());
        EXPECT_EQ(none.domains, 1);
        const NodalLines diameter = nodal_lines(mesh, sign * basis.function(1));
        ASSERT_EQ(diameter.lines.lines.size(), 1u);
        EXPECT_EQ(diameter.domains, 2);
        EXPECT_FALSE(diameter.lines.lines[0].closed);
        EXPECT_NEAR(diameter.lines.length, 2.0, 0.05);
        const NodalLines circle = nodal_lines(mesh, sign * basis.function(5));
        ASSERT_EQ(circle.lines.lines.size(), 1u);
        EXPECT_EQ(circle.domains, 2);
        EXPECT_TRUE(circle.lines.lines[0].closed);
        EXPECT_NEAR(circle.lines.length, 2.0 * pi * 2.404826 / 5.520078, 0.01);
    }
}

// The smaller of two spheres has no part in the first function of the larger one but rounding.
TEST(NodalLines, StayOnTheComponentOfTheFunction) {
    const Mesh large = shapes::icosphere(3, 2.0);
    const Mesh both = shapes::together({large, shapes::icosphere(3)});
    Vector values(both.vertex_count());
    for (Index v = 0; v < both.vertex_count(); ++v)
        values[v] = v < large.vertex_count() ? both.points()(v, 2) + 0.1 : 1e-12 * std::sin(7.0 * v);
    const NodalLines found = nodal_lines(both, values);
    EXPECT_EQ(found.lines.lines.size(), 1u);
    EXPECT_EQ(found.domains, 2);
    EXPECT_NEAR(found.lines.length, 2.0 * pi * std::sqrt(4.0 - 0.01), 0.1);
    const NodalLines higher = nodal_lines(both, values, 1.1);
    EXPECT_NEAR(higher.lines.length, 2.0 * pi * std::sqrt(3.0), 0.1);
    EXPECT_EQ(higher.domains, 3) << "the small sphere is below";
    EXPECT_THROW(nodal_lines(both, Vector::Zero(3)), InputError);
    EXPECT_THROW(nodal_lines(shapes::circle(4), Vector::Zero(4)), InputError);
}

}  // namespace
}  // namespace beltrami
