#include "beltrami/framework/mesh.hpp"

#include <limits>
#include <string>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami {
namespace {

const Points three{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

TEST(Mesh, KnowsItsKindByItsCells) {
    EXPECT_EQ(Mesh(three).kind(), CellKind::point);
    EXPECT_EQ(Mesh(three).cell_count(), 0);
    EXPECT_EQ(Mesh(three, Cells{{0, 1}}).kind(), CellKind::segment);
    EXPECT_EQ(Mesh(three, Cells{{0, 1, 2}}).kind(), CellKind::triangle);
    EXPECT_EQ(shapes::tetrahedral_cube(1).kind(), CellKind::tetrahedron);
    EXPECT_EQ(Mesh(three, Cells(0, 3)).kind(), CellKind::triangle);
}

TEST(Mesh, RefusesWhatCannotBeAMesh) {
    EXPECT_THROW(Mesh(three, Cells{{0, 1, 3}}), InputError);
    EXPECT_THROW(Mesh(three, Cells{{0, 1, -1}}), InputError);
    EXPECT_THROW(Mesh(three, Cells(1, 1)), InputError);
    EXPECT_THROW(Mesh(three, Cells(1, 5)), InputError);
    Points broken = three;
    broken(1, 2) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(Mesh(broken, Cells{{0, 1, 2}}), InputError);
    EXPECT_THROW((void)Mesh(three).with_points(broken), InputError);
    EXPECT_THROW((void)Mesh(three).with_points(Points::Zero(2, 3)), InputError);
    EXPECT_THROW(Mesh(three, Fields{{"a", Block::Zero(2, 1)}}), InputError);
    EXPECT_THROW(Mesh(three, Fields{{"a", Block::Zero(3, 1)}, {"a", Block::Zero(3, 1)}}), InputError);
}

TEST(Mesh, CarriesFieldsAndNotes) {
    const Mesh mesh = Mesh(three, Cells{{0, 1, 2}}, {{"heat", Block::Ones(3, 1)}}).with_notes({"welded"});
    EXPECT_EQ(mesh.field("heat").values.sum(), 3.0);
    EXPECT_EQ(mesh.find_field("cold"), nullptr);
    const Mesh moved = mesh.with_points(2.0 * three);
    EXPECT_EQ(moved.points(), 2.0 * three);
    EXPECT_EQ(moved.field("heat").values.sum(), 3.0);
    EXPECT_EQ(moved.notes(), std::vector<std::string>{"welded"});
    try {
        (void)mesh.field("cold");
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(error.hint().find("heat"), std::string::npos) << "the hint lists the names there are";
    }
}

}  // namespace
}  // namespace beltrami
