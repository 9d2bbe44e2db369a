#include "beltrami/solvers/free_components.hpp"

#include <string>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami {
namespace {

// Spheres of 12, 42 and 12 vertices, then an isolated vertex: 0..11, 12..53, 54..65, 66.
Laplacian three_spheres() {
    const Mesh mesh = shapes::together({shapes::icosphere(0), shapes::icosphere(1), shapes::icosphere(0)});
    Points points(67, 3);
    points << mesh.points(), 9.0, 9.0, 9.0;
    return Laplacian(Mesh(points, mesh.cells()));
}

TEST(HoldFreeComponents, RefusesAndNamesThem) {
    const Constraints held{{20, 1.0}};
    try {
        (void)hold_free_components(three_spheres(), held, FreeComponents::refuse);
        FAIL();
    } catch (const InputError& error) {
        const std::string what = error.what();
        EXPECT_NE(what.find("2 components"), std::string::npos) << what;
        EXPECT_NE(what.find("0, 54"), std::string::npos) << what;
        EXPECT_EQ(what.find("66"), std::string::npos) << "an isolated vertex is no component: " << what;
    }
}

TEST(HoldFreeComponents, HoldsThemAtZero) {
    const Constraints held{{20, 1.0}, {66, 5.0}};
    const Constraints all = hold_free_components(three_spheres(), held, FreeComponents::keep_at_zero);
    EXPECT_EQ(all.size(), 2 + 24);
    for (Index v = 0; v < 67; ++v) {
        const bool of_free_component = v < 12 || (v >= 54 && v < 66);
        ASSERT_EQ(all.is_fixed(v), of_free_component || v == 20 || v == 66) << v;
        if (of_free_component) {
            EXPECT_EQ(all.value(v)[0], 0.0);
        }
    }
    EXPECT_EQ(all.value(20)[0], 1.0);
    EXPECT_EQ(all.value(66)[0], 5.0);
}

TEST(HoldFreeComponents, ChangesNothingWhereEveryComponentIsHeld) {
    const Constraints held{{0, 1.0}, {53, 2.0}, {60, 3.0}};
    EXPECT_EQ(hold_free_components(three_spheres(), held, FreeComponents::refuse).size(), 3);
}

TEST(HoldFreeComponents, NamesTenAtMost) {
    const Mesh many = shapes::together(std::vector<Mesh>(15, shapes::icosphere(0)));
    try {
        (void)hold_free_components(Laplacian(many), Constraints(), FreeComponents::refuse);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("108, ..."), std::string::npos) << error.what();
    }
    EXPECT_THROW(
        (void)hold_free_components(Laplacian(many), Constraints{{180, 0.0}}, FreeComponents::keep_at_zero),
        InputError);
}

}  // namespace
}  // namespace beltrami
