#include "beltrami/framework/write_mesh.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/read_mesh.hpp"
#include "expect_text.hpp"
#include "meshes.hpp"

namespace beltrami {
namespace {

using testing::bytes_of;
using testing::contains;
using testing::Scratch;
using testing::shared_mesh;

namespace fs = std::filesystem;
using Texts = std::vector<std::string>;
using Paths = std::vector<fs::path>;

std::size_t files_in(const fs::path& folder) {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

Block noise(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Block block(rows, columns);
    for (Eigen::Index i = 0; i < block.size(); ++i)
        block.data()[i] = normal(random) * 1e-3;
    return block;
}

Mesh sample(CellKind kind, Fields fields = {}) {
    const Points points = noise(7, 3, 1);
    if (kind == CellKind::point) return Mesh(points, std::move(fields));
    Cells cells(5, static_cast<int>(kind));
    for (Index c = 0; c < 5; ++c) {
        for (int k = 0; k < static_cast<int>(kind); ++k)
            cells(c, k) = (c * 3 + k) % 7;
    }
    return {points, cells, std::move(fields)};
}

template <class Write>
std::string error_of(Write&& write) {
    try {
        write();
    } catch (const InputError& e) {
        EXPECT_FALSE(e.hint().empty()) << e.what();
        return std::string(e.what()) + " | " + e.hint();
    }
    return "no error";
}

class WriteMeshKinds : public ::testing::TestWithParam<std::tuple<const char*, CellKind>> {};

TEST_P(WriteMeshKinds, ComesBackToTheLastBit) {
    const auto [ending, kind] = GetParam();
    const Scratch scratch;
    const fs::path path = scratch / (std::string("out") + ending);
    const Mesh mesh = sample(kind);
    const bool text = std::string(ending) == ".obj" || std::string(ending) == ".off";
    const bool refused = (text && kind == CellKind::tetrahedron) ||
                         (ending == std::string(".off") && kind == CellKind::segment);
    if (refused) {
        EXPECT_TRUE(
            contains(error_of([&] { write_mesh(path, mesh); }), {path.string(), "cannot hold", ".vtu"}));
        EXPECT_FALSE(fs::exists(path));
        return;
    }
    const Fields fields = text ? Fields{}
                               : Fields{{"value", noise(7, 1, 2)},
                                        {"flow", noise(7, 3, 3)},
                                        {"normal", noise(7, 3, 4)},
                                        {"color", noise(7, 3, 5)}};
    write_mesh(path, mesh, fields);
    const Mesh back = read_mesh(path);
    EXPECT_EQ(back.kind(), kind);
    EXPECT_EQ(back.points(), mesh.points());
    EXPECT_EQ(back.cells(), mesh.cells());
    ASSERT_EQ(back.fields().size(), fields.size());
    for (std::size_t f = 0; f < fields.size(); ++f) {
        EXPECT_EQ(back.fields()[f].name, fields[f].name);
        EXPECT_EQ(back.fields()[f].values, fields[f].values) << fields[f].name;
    }
    EXPECT_EQ(back.notes().size(), 0U);
}

INSTANTIATE_TEST_SUITE_P(All, WriteMeshKinds,
                         ::testing::Combine(::testing::Values(".ply", ".vtu", ".obj", ".off"),
                                            ::testing::Values(CellKind::point, CellKind::segment,
                                                              CellKind::triangle, CellKind::tetrahedron)));

TEST(WriteMesh, PlyColorsAreBytes) {
    const Scratch scratch;
    Block color = Block::Zero(7, 3);
    color.row(3) << 1, 0.2, 128 / 255.0;
    write_mesh(scratch / "a.ply", sample(CellKind::triangle, {{"color", color}}));
    EXPECT_TRUE(contains(bytes_of(scratch / "a.ply"), {"property uchar red"}));
    EXPECT_EQ(read_mesh(scratch / "a.ply").field("color").values, color);
    write_mesh(scratch / "b.obj", sample(CellKind::triangle), {{"color", color}});
    EXPECT_EQ(read_mesh(scratch / "b.obj").field("color").values, color);
}

TEST(WriteMesh, PlyOpacityIsBytesOnlyWhereNothingIsLost) {
    const Scratch scratch;
    const Field color{"color", Block::Ones(7, 3)};
    write_mesh(scratch / "a.ply", sample(CellKind::triangle), {color, {"alpha", Block::Ones(7, 1)}});
    EXPECT_TRUE(contains(bytes_of(scratch / "a.ply"), {"property uchar alpha"}));
    EXPECT_EQ(read_mesh(scratch / "a.ply").field("alpha").values, Block::Ones(7, 1));
    const Block computed = Block::Constant(7, 1, 0.1234);
    write_mesh(scratch / "b.ply", sample(CellKind::triangle), {color, {"alpha", computed}});
    EXPECT_EQ(read_mesh(scratch / "b.ply").field("alpha").values, computed);
}

TEST(WriteMesh, PlyNamesThatPlyCannotHold) {
    const Scratch scratch;
    const Block ones = Block::Ones(7, 1);
    write_mesh(scratch / "a.ply", sample(CellKind::triangle),
               {{"mean curvature", ones}, {"x", 2 * ones}, {"modes", Block::Ones(7, 2)}});
    const Mesh back = read_mesh(scratch / "a.ply");
    std::vector<std::string> names;
    for (const Field& field : back.fields())
        names.push_back(field.name);
    EXPECT_EQ(names, (Texts{"mean_curvature", "x_", "modes_0", "modes_1"}));
    EXPECT_EQ(back.points(), sample(CellKind::triangle).points());
}

TEST(WriteMesh, VtuKeepsAnyNameAndShape) {
    const Scratch scratch;
    const Fields fields{{"a \"name\" <&> \xC3\xBC", noise(7, 1, 8)}, {"modes", noise(7, 5, 9)}};
    write_mesh(scratch / "a.vtu", sample(CellKind::tetrahedron), fields);
    const Mesh back = read_mesh(scratch / "a.vtu");
    for (const Field& field : fields)
        EXPECT_EQ(back.field(field.name).values, field.values);
}

TEST(WriteMesh, GivenFieldsWinOverCarriedOnes) {
    const Scratch scratch;
    const Mesh mesh = sample(CellKind::triangle, {{"u", Block::Zero(7, 1)}, {"v", Block::Ones(7, 1)}});
    write_mesh(scratch / "a.ply", mesh, {{"u", Block::Constant(7, 1, 5.0)}, {"w", Block::Ones(7, 1)}});
    const Mesh back = read_mesh(scratch / "a.ply");
    EXPECT_EQ(back.fields().size(), 3U);
    EXPECT_EQ(back.field("u").values(0, 0), 5.0);
    write_mesh(scratch / "a.obj", mesh);  // carried fields that OBJ cannot hold are left out
    EXPECT_EQ(read_mesh(scratch / "a.obj").fields().size(), 0U);
}

TEST(WriteMesh, RefusedFieldsLeaveNoFile) {
    const Scratch scratch;
    const Mesh mesh = sample(CellKind::triangle);
    const auto error = [&](const char* name, const Fields& fields) {
        return error_of([&] { write_mesh(scratch / name, mesh, fields); });
    };
    Block bad = Block::Zero(7, 1);
    bad(4, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(contains(error("a.ply", {{"u", bad}}),
                         {"field 'u' has a value at vertex 4 that is not a finite number"}));
    bad(4, 0) = std::numeric_limits<double>::infinity();
    EXPECT_TRUE(contains(error("a.vtu", {{"u", bad}}), {"vertex 4"}));
    EXPECT_TRUE(contains(error("a.obj", {{"u", Block::Zero(7, 1)}}),
                         {"field 'u' cannot be written", ".ply or .vtu"}));
    EXPECT_TRUE(contains(error("a.off", {{"color", Block::Zero(7, 3)}}), {"no fields"}));
    EXPECT_TRUE(contains(error("a.ply", {{"u", Block::Zero(6, 1)}}), {"6 values for 7 vertices"}));
    EXPECT_TRUE(contains(error("a.ply", {{"u", Block::Zero(7, 1)}, {"u", Block::Zero(7, 1)}}),
                         {"two fields are named 'u'"}));
    EXPECT_TRUE(contains(error("a.ply", {{"", Block::Zero(7, 1)}}), {"no name"}));
    EXPECT_TRUE(contains(error("a.stl", {}), {"files that end in .stl", ".ply, .vtu, .obj, .off"}));
    EXPECT_TRUE(contains(error("a", {}), {"no ending"}));
    EXPECT_EQ(files_in(scratch / ""), 0U);
}

TEST(WriteMesh, NamesThatCannotBeWritten) {
    const Scratch scratch;
    const auto error = [&](const fs::path& path) { return error_of([&] { check_writable_mesh(path); }); };
    EXPECT_TRUE(contains(error(scratch / "none/a.ply"), {"there is no folder"}));
    fs::create_directory(scratch / "folder.ply");
    EXPECT_TRUE(contains(error(scratch / "folder.ply"), {"this is a folder"}));
    std::ofstream(scratch / "file") << "x";
    EXPECT_NE(error(scratch / "file/a.ply"), "no error");
    EXPECT_TRUE(contains(error(scratch / "a.xyz"), {".xyz"}));
    EXPECT_EQ(error(scratch / "a.ply"), "no error");
    EXPECT_EQ(error("a.PLY"), "no error");
    if (::geteuid() != 0) {  // root may write anywhere
        fs::create_directory(scratch / "locked");
        fs::permissions(scratch / "locked", fs::perms::owner_read | fs::perms::owner_exec);
        EXPECT_TRUE(contains(error(scratch / "locked/a.ply"), {"may not be written to"}));
        fs::permissions(scratch / "locked", fs::perms::owner_all);
    }
}

TEST(WriteWhole, LeavesTheOldFileWhereTheWriterThrows) {
    const Scratch scratch;
    write_whole(scratch / "a.txt", [](std::ostream& stream) { stream << "old"; });
    EXPECT_THROW(write_whole(scratch / "a.txt",
                             [](std::ostream& stream) {
                                 stream << "new";
                                 throw std::runtime_error("stop");
                             }),
                 std::runtime_error);
    EXPECT_EQ(bytes_of(scratch / "a.txt"), "old");
    EXPECT_EQ(files_in(scratch / ""), 1U);
    write_whole(scratch / "a.txt", [](std::ostream& stream) { stream << "new"; });
    EXPECT_EQ(bytes_of(scratch / "a.txt"), "new");
}

TEST(WriteWhole, KeepsLinksAndPermissions) {
    const Scratch scratch;
    std::ofstream(scratch / "target") << "old";
    fs::permissions(scratch / "target", fs::perms::owner_read | fs::perms::owner_write);
    fs::create_symlink("target", scratch / "link");
    write_whole(scratch / "link", [](std::ostream& stream) { stream << "new"; });
    EXPECT_TRUE(fs::is_symlink(scratch / "link"));
    EXPECT_EQ(bytes_of(scratch / "target"), "new");
    EXPECT_EQ(fs::status(scratch / "target").permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST(WriteWhole, NoticesAFullDisk) {
    const fs::path full = "/dev/full";
    BELTRAMI_SKIP_WITHOUT(full);
    EXPECT_TRUE(contains(error_of([&] {
                             write_whole(full,
                                         [](std::ostream& stream) { stream << std::string(100000, 'x'); });
                         }),
                         {"could not be written to its end"}));
    EXPECT_TRUE(contains(error_of([&] { write_whole(full, [](std::ostream& stream) { stream << "x"; }); }),
                         {"No space left"}));
    EXPECT_TRUE(fs::is_character_file(full));
}

TEST(SeriesWriter, EveryStepLeavesAReadableSeries) {
    const Scratch scratch;
    const Mesh mesh = sample(CellKind::triangle);
    SeriesWriter series(scratch / "heat.pvd");
    EXPECT_EQ(series.files(), (Paths{scratch / "heat.pvd"}));
    for (int step = 0; step < 3; ++step) {
        series.add(0.1 * step, mesh, {{"u", Block::Constant(7, 1, step)}});
        const std::string text = bytes_of(scratch / "heat.pvd");
        EXPECT_TRUE(contains(text, {fmt::format("file=\"heat_{:04}.vtu\"", step)}));
        EXPECT_TRUE(contains(text, {"</VTKFile>"}));
    }
    EXPECT_TRUE(contains(bytes_of(scratch / "heat.pvd"), {"timestep=\"0.2\""}));
    EXPECT_EQ(series.files().size(), 4U);
    EXPECT_EQ(read_mesh(series.files()[2]).field("u").values(0, 0), 1.0);
    EXPECT_EQ(files_in(scratch / ""), 4U);
    EXPECT_TRUE(contains(error_of([&] { SeriesWriter(scratch / "heat.vtu"); }), {".pvd"}));
    EXPECT_TRUE(contains(error_of([&] { SeriesWriter(scratch / "none/heat.pvd"); }), {"there is no folder"}));
    EXPECT_NE(error_of([&] { series.add(std::numeric_limits<double>::infinity(), mesh, {}); }), "no error");
}

TEST(WriteMesh, RealMeshesComeBack) {
    BELTRAMI_SKIP_WITHOUT(shared_mesh("README.md"));
    const Scratch scratch;
    for (const char* name : {"igea_134k.ply", "hand_tets.mesh", "kitten.xyz", "face_color.obj"}) {
        const Mesh mesh = read_mesh(shared_mesh(name));
        write_mesh(scratch / "out.vtu", mesh);
        const Mesh back = read_mesh(scratch / "out.vtu");
        EXPECT_EQ(back.points(), mesh.points()) << name;
        EXPECT_EQ(back.cells(), mesh.cells()) << name;
        EXPECT_EQ(back.fields().size(), mesh.fields().size()) << name;
    }
}

}  // namespace
}  // namespace beltrami
