#include "beltrami/framework/read_mesh.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <clocale>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/write_mesh.hpp"
#include "expect_text.hpp"
#include "meshes.hpp"

namespace beltrami {
namespace {

using testing::bytes_of;
using testing::contains;
using testing::Scratch;
using testing::shared_mesh;

namespace fs = std::filesystem;
using Corners = std::vector<Index>;
using Texts = std::vector<std::string>;

void put(const fs::path& path, const std::string& content) {
    std::ofstream(path, std::ios::binary) << content;
}

fs::path data_folder() {
    return fs::path(BELTRAMI_TEST_DATA);
}

template <class T>
std::string stored(T value, std::endian order = std::endian::little) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

class ReadMesh : public ::testing::Test {
  protected:
    Mesh read(const std::string& name, const std::string& content) {
        put(scratch_ / name, content);
        return read_mesh(scratch_ / name);
    }

    /// "sentence | hint" of the error.
    std::string error(const std::string& name, const std::string& content) {
        put(scratch_ / name, content);
        return error_of(scratch_ / name);
    }

    static std::string error_of(const fs::path& path) {
        try {
            (void)read_mesh(path);
        } catch (const InputError& e) {
            EXPECT_FALSE(e.hint().empty()) << e.what();
            EXPECT_TRUE(contains(e.what(), {path.string()}));
            EXPECT_FALSE(contains(std::string(e.what()), {"\n"}));
            return std::string(e.what()) + " | " + e.hint();
        }
        return "no error";
    }

    Scratch scratch_;
};

std::vector<Index> corners(const Mesh& mesh) {
    return {mesh.cells().data(), mesh.cells().data() + mesh.cells().size()};
}

// ---------------------------------------------------------------------------------------------------- OBJ

TEST_F(ReadMesh, ObjTakesEveryFormOfCorner) {
    const Mesh mesh = read("a.obj",
                           "# a comment\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\ng part\n"
                           "f 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 2/1/1 3/1/1\nf -3 -2 -1\n");
    EXPECT_EQ(mesh.kind(), CellKind::triangle);
    EXPECT_EQ(mesh.cell_count(), 5);
    for (Index c = 0; c < 5; ++c)
        EXPECT_EQ(mesh.cells().row(c), Eigen::RowVector3i(0, 1, 2));
    EXPECT_TRUE(mesh.notes().empty());
}

TEST_F(ReadMesh, ObjToleratesByteOrderMarkLineEndsTrailingBlanksAndJoinedLines) {
    const Mesh crlf =
        read("a.obj", "\xEF\xBB\xBFv 0 0 0  \r\nv 1 0 0 # here\r\nv 0 +1 0\t\r\n\r\nf 1 2 \\\r\n 3\r\n");
    EXPECT_EQ(corners(crlf), (Corners{0, 1, 2}));
    EXPECT_EQ(crlf.points()(2, 1), 1.0);
    const Mesh cr = read("b.obj", "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3");
    EXPECT_EQ(cr.cell_count(), 1);
}

TEST_F(ReadMesh, ObjColors) {
    const Mesh mesh = read("a.obj", "v 0 0 0 1 0 .5\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
    EXPECT_EQ(mesh.field("color").values.row(0), Eigen::RowVector3d(1, 0, .5));
    const Mesh bytes = read("b.obj", "v 0 0 0 255 0 51\nv 1 0 0 0 255 0\nv 0 1 0 0 0 255\nf 1 2 3\n");
    EXPECT_DOUBLE_EQ(bytes.field("color").values(0, 2), 0.2);
    const Mesh some = read("c.obj", "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    EXPECT_TRUE(some.fields().empty());
    EXPECT_EQ(some.notes(), (Texts{"colours on only 1 of 3 vertices were left out"}));
    EXPECT_TRUE(read("d.obj", "v 0 0 0 1\nv 1 0 0 1\n").fields().empty());  // a weight
}

TEST_F(ReadMesh, ObjLinesAndPoints) {
    const Mesh lines = read("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nl 1 2 3\n");
    EXPECT_EQ(lines.kind(), CellKind::segment);
    EXPECT_EQ(corners(lines), (Corners{0, 1, 1, 2}));
    EXPECT_EQ(read("b.obj", "v 0 0 0\n").kind(), CellKind::point);
    const Mesh mixed = read("c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\nf 1 2 3\n");
    EXPECT_EQ(mixed.kind(), CellKind::triangle);
    EXPECT_EQ(mixed.notes(), (Texts{"2 segments beside the triangles were left out"}));
}

TEST_F(ReadMesh, ObjFacesMayComeBeforeTheirVertices) {
    EXPECT_EQ(read("a.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").cell_count(), 1);
}

TEST_F(ReadMesh, ObjErrorsNameTheLine) {
    EXPECT_TRUE(
        contains(error("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
                 {"line 4: a face or line names vertex 4, but the vertices are 1 to 3", "start at 1"}));
    EXPECT_TRUE(contains(error("b.obj", "v 0 0 0\nf 0 1 1\n"), {"line 2: a face or line names vertex 0"}));
    EXPECT_TRUE(
        contains(error("c.obj", "v 0 0 0\nf -1 -2 -1\n"), {"line 2: a face or line names vertex -2"}));
    EXPECT_TRUE(contains(error("d.obj", "v 0 0 0\nv 1 nan 0\n"),
                         {"line 2: vertex 2 of 2 has 'nan', which is not a finite number"}));
    EXPECT_TRUE(contains(error("e.obj", "v 0 0 0\nv 1 2\n"), {"line 2: a vertex has 2 coordinates, not 3"}));
    EXPECT_TRUE(contains(error("f.obj", "v 0 0 1e999\n"), {"line 1: vertex 1 of 1 has '1e999'"}));
    EXPECT_TRUE(
        contains(error("g.obj", "v 0 0 zero\n"), {"line 1: vertex 1 of 1 has 'zero' where a number is due"}));
    EXPECT_TRUE(contains(error("h.obj", "v 0 0 0\nf 1 x 1\n"),
                         {"line 2: face or line 1 of 1 has 'x' where a whole number is due"}));
    EXPECT_TRUE(contains(error("i.obj", "f 1 2 3\n"),
                         {"line 1: a face or line names vertex 3, but there are no vertices"}));
}

TEST_F(ReadMesh, ObjNotesForeignLines) {
    EXPECT_EQ(read("a.obj", "v 0 0 0\nhello\nworld\n").notes(),
              (Texts{"2 lines that are not OBJ statements were skipped, the first is line 2"}));
}

TEST_F(ReadMesh, NumbersDoNotDependOnTheLocale) {
    const char* const set = std::setlocale(LC_ALL, "de_DE.UTF-8");  // where there is one
    EXPECT_EQ(read("a.obj", "v 0.5 1e-400 -2.5E+1\n").points(), Eigen::RowVector3d(0.5, 0, -25));
    if (set != nullptr) std::setlocale(LC_ALL, "C");
}

// ----------------------------------------------------------------------------------------------- polygons

double area(const Mesh& mesh) {
    return cell_measures(mesh).sum();
}

TEST_F(ReadMesh, QuadsTakeTheDiagonalThatFoldsNothing) {
    // An arrowhead: only the diagonal through the notch (corner 3) stays inside.
    const Mesh arrow = read("a.obj", "v 0 0 0\nv 2 -1 0\nv 0 3 0\nv .5 .2 0\nf 1 2 3 4\n");
    EXPECT_NEAR(area(arrow), 2.25, 1e-12);
    for (Index c = 0; c < 2; ++c) {
        const Vector3 u = arrow.points().row(arrow.cells()(c, 1)) - arrow.points().row(arrow.cells()(c, 0));
        const Vector3 w = arrow.points().row(arrow.cells()(c, 2)) - arrow.points().row(arrow.cells()(c, 0));
        EXPECT_GT(u.cross(w).z(), 0);
    }
    EXPECT_EQ(arrow.notes(), (Texts{"1 quadrilateral was split into 2 triangles"}));
}

TEST_F(ReadMesh, QuadsTakeTheDelaunayDiagonal) {
    const Mesh kite = read("a.obj", "v -3 0 0\nv 0 -1 0\nv 3 0 0\nv 0 1 0\nf 1 2 3 4\n");
    EXPECT_EQ(corners(kite), (Corners{0, 1, 3, 1, 2, 3}));
    const Mesh square = read("b.obj", "v 0 0 0\nv .1 0 0\nv .1 .1 0\nv 0 .1 0\nf 1 2 3 4\n");
    EXPECT_EQ(corners(square), (Corners{0, 1, 2, 0, 2, 3}));
}

TEST_F(ReadMesh, NonConvexPolygonsAreTriangulatedInside) {
    // A star of ten corners, tilted; its area is known from the shoelace formula.
    std::string text;
    double twice = 0;
    std::vector<std::pair<double, double>> p;
    for (int i = 0; i < 10; ++i) {
        const double radius = i % 2 == 0 ? 2.0 : 0.6;
        p.emplace_back(radius * std::cos(i * M_PI / 5), radius * std::sin(i * M_PI / 5));
        text += fmt::format("v {} {} {}\n", p.back().first, p.back().second * 0.8, p.back().second * 0.6);
    }
    for (std::size_t i = 0; i < 10; ++i) {
        const auto& [x, y] = p[i];
        const auto& [u, v] = p[(i + 1) % 10];
        twice += x * v - u * y;
    }
    const Mesh star = read("a.obj", text + "f 1 2 3 4 5 6 7 8 9 10\n");
    EXPECT_EQ(star.cell_count(), 8);
    EXPECT_NEAR(area(star), twice / 2, 1e-12);
    EXPECT_EQ(star.notes(), (Texts{"1 polygon was split into 8 triangles"}));
    for (Index c = 0; c < 8; ++c) {  // turned as the polygon is
        const Vector3 u = star.points().row(star.cells()(c, 1)) - star.points().row(star.cells()(c, 0));
        const Vector3 w = star.points().row(star.cells()(c, 2)) - star.points().row(star.cells()(c, 0));
        EXPECT_GT(u.cross(w).z(), 0);
    }
}

TEST_F(ReadMesh, PolygonsThatNoPlaneHoldsFallBackToAFan) {
    const Mesh crossed = read("a.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nv -1 .5 0\nf 1 2 3 4 5\n");
    EXPECT_EQ(crossed.cell_count(), 3);
    const Mesh flat = read("b.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nv 4 0 0\nf 1 2 3 4 5\n");
    EXPECT_EQ(flat.cell_count(), 3);
    const Mesh same_place = read("c.obj", "v 0 0 0\nv 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4 5\n");
    EXPECT_EQ(same_place.cell_count(), 3);
}

TEST_F(ReadMesh, RepeatedCornersAndSmallPolygons) {
    const Mesh mesh = read(
        "a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 1 2\nf 1 2 2 3\nf 1 2 3 4 1\nf 1 2\nf 2 2 2 2\n");
    EXPECT_EQ(corners(mesh), (Corners{0, 0, 1, 0, 1, 2, 0, 1, 2, 0, 2, 3}));
    EXPECT_EQ(mesh.notes(), (Texts{"1 quadrilateral was split into 2 triangles",
                                   "1 polygon with repeated corners became triangles",
                                   "2 polygons with fewer than three different corners were left out"}));
}

// ---------------------------------------------------------------------------------------------------- OFF

TEST_F(ReadMesh, OffVariants) {
    const std::string body = "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    for (const std::string head : {"OFF\n", "OFF ", "", "# made by hand\nOFF # here\n\n"}) {
        EXPECT_EQ(corners(read("a.off", head + body)), (Corners{0, 1, 2})) << head;
    }
    EXPECT_EQ(read("b.off", "OFF\n3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n").cell_count(), 1);
    const Mesh bytes =
        read("c.off", "COFF\n3 1 0\n0 0 0 255 0 51 255\n1 0 0 0 0 0 255\n0 1 0 0 0 0 255\n3 0 1 2\n");
    EXPECT_DOUBLE_EQ(bytes.field("color").values(0, 2), 0.2);
    const Mesh floats = read("d.off", "COFF\n3 1 0\n0 0 0 .5 0 0 1\n1 0 0 0 0 0 1\n0 1 0 0 0 0 1\n3 0 1 2\n");
    EXPECT_EQ(floats.field("color").values(0, 0), 0.5);
    const Mesh normals = read("e.off", "NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n");
    EXPECT_EQ(normals.field("normal").values.col(2).sum(), 3);
    EXPECT_EQ(read("f.off", "OFF 1 0 0\n1 2 3\n").kind(), CellKind::point);
}

TEST_F(ReadMesh, OffErrors) {
    EXPECT_TRUE(contains(error("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
                         {"line 6: face 1 of 1 names vertex 3, but the vertices are 0 to 2"}));
    std::string cut = "OFF\n100 1 0\n";
    for (int i = 0; i < 57; ++i)
        cut += "0.125 1.25 2.5\n";
    EXPECT_TRUE(contains(error("b.off", cut), {"the file ends before vertex 58 of 100 is complete"}));
    EXPECT_TRUE(contains(
        error("c.off", "OFF\n2000000000 1 0\n0 0 0\n"),
        {"line 2: a vertex count of 2000000000 is announced, but the rest of the file has room for"}));
    EXPECT_TRUE(contains(error("d.off", "OFF\n-3 1 0\n"), {"a vertex count of -3 is out of range"}));
    EXPECT_TRUE(contains(error("e.off", "OFF\n99999999999999999999 1 0\n"), {"where a whole number is due"}));
    EXPECT_TRUE(contains(error("f.off", "OFF BINARY\n"), {"binary OFF files are not read"}));
    EXPECT_TRUE(contains(error("g.off", "solid thing\n"), {"does not start with OFF"}));
    EXPECT_TRUE(contains(error("h.off", "OFF\n0 0 0\n"), {"the file has no vertices"}));
}

// ---------------------------------------------------------------------------------------------------- PLY

std::string ply_head(const std::string& format, const std::string& body) {
    return "ply\nformat " + format + " 1.0\ncomment c\n" + body + "end_header\n";
}

TEST_F(ReadMesh, PlyGroupsPropertiesAndKeepsTheRest) {
    const Mesh mesh =
        read("a.ply", ply_head("ascii",
                               "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                               "property float nx\nproperty float ny\nproperty float nz\n"
                               "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                               "property float quality\nproperty float flow_x\nproperty float flow_y\n"
                               "property float flow_z\nproperty int s_x\n"
                               "element face 1\nproperty list uchar int vertex_index\nproperty float f\n") +
                          "0 0 0 0 0 1 255 0 51 7.5 1 2 3 4\n1 0 0 0 0 1 0 0 0 0 0 0 0 0\n"
                          "0 1 0 0 0 1 0 0 0 0 0 0 0 0\n3 0 1 2 9.5\n");
    std::vector<std::string> names;
    for (const Field& field : mesh.fields())
        names.push_back(field.name);
    EXPECT_EQ(names, (Texts{"normal", "color", "quality", "flow", "s_x"}));
    EXPECT_EQ(mesh.field("color").values.row(0), Eigen::RowVector3d(1, 0, 0.2));
    EXPECT_EQ(mesh.field("flow").values.row(0), Eigen::RowVector3d(1, 2, 3));
    EXPECT_EQ(mesh.field("quality").values(0, 0), 7.5);
    EXPECT_EQ(corners(mesh), (Corners{0, 1, 2}));
}

TEST_F(ReadMesh, PlyBothBinaryOrdersAndAnyTypes) {
    for (const auto order : {std::endian::little, std::endian::big}) {
        std::string text = ply_head(
            order == std::endian::little ? "binary_little_endian" : "binary_big_endian",
            "element junk 2\nproperty list ushort double stuff\nproperty short a\n"
            "element vertex 3\nproperty double x\nproperty double y\nproperty double z\nproperty short t\n"
            "element face 1\nproperty uchar flag\nproperty list uint ushort vertex_indices\n");
        const auto add = [&](auto value) { text.append(stored(value, order)); };
        for (int i = 0; i < 2; ++i) {
            add(std::uint16_t{1});
            add(1.5);
            add(std::int16_t{3});
        }
        for (int i = 0; i < 3; ++i) {
            add(0.1 * i);
            add(1e-3 * i * i);
            add(1.0);
            add(static_cast<std::int16_t>(-i));
        }
        add(std::uint8_t{1});
        add(std::uint32_t{3});
        for (std::uint16_t i = 0; i < 3; ++i)
            add(i);
        const Mesh mesh = read("a.ply", text);
        EXPECT_EQ(mesh.points().row(2), Eigen::RowVector3d(0.2, 4e-3, 1));
        EXPECT_EQ(mesh.field("t").values(2, 0), -2);
        EXPECT_EQ(corners(mesh), (Corners{0, 1, 2}));
    }
}

TEST_F(ReadMesh, PlyStripsEdgesAndTetrahedra) {
    const std::string vertices = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string rows = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n";
    const Mesh strips = read(
        "a.ply", ply_head("ascii", vertices + "element tristrips 1\nproperty list int int vertex_indices\n") +
                     rows + "9 0 1 2 3 -1 0\n 1 1 4\n");
    EXPECT_EQ(corners(strips), (Corners{0, 1, 2, 2, 1, 3}));  // 0 1 1 and 1 1 4 only steer
    const Mesh edges =
        read("b.ply",
             ply_head("ascii", vertices + "element edge 2\nproperty int vertex1\nproperty int vertex2\n") +
                 rows + "0 1\n1 2\n");
    EXPECT_EQ(edges.kind(), CellKind::segment);
    EXPECT_EQ(corners(edges), (Corners{0, 1, 1, 2}));
    const Mesh tets =
        read("c.ply",
             ply_head("ascii", vertices + "element tetrahedron 1\nproperty list uchar int vertex_indices\n") +
                 rows + "4 0 1 2 4\n");
    EXPECT_EQ(tets.kind(), CellKind::tetrahedron);
}

TEST_F(ReadMesh, PlyErrors) {
    const std::string vertices = "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
    EXPECT_TRUE(contains(error("a.ply", ply_head("ascii", vertices + faces) + "0 0 0\n1 0 0\n3 0 1 2\n"),
                         {"line 13: face 1 of 1 names vertex 2, but the vertices are 0 to 1"}));
    EXPECT_TRUE(contains(error("b.ply", ply_head("ascii", vertices) + "0.5 0 0\n1 0.5\n"),
                         {"line 10: vertex 2 of 2 has no value of 'z'"}));
    EXPECT_TRUE(
        contains(error("c.ply", ply_head("binary_little_endian", vertices) + std::string(20, '\0')),
                 {"a vertex count of 2 is announced, but the rest of the file has room for 1 at most"}));
    EXPECT_TRUE(
        contains(error("d.ply", "ply\nformat ascii 1.0\nelement vertex 2\n"), {"before 'end_header'"}));
    EXPECT_TRUE(contains(
        error("e.ply",
              ply_head("ascii", "element vertex 2\nproperty float x\nproperty float y\n") + "0 0\n1 1\n"),
        {"lack one of the properties x, y, z"}));
    EXPECT_TRUE(contains(error("f.ply", ply_head("ascii", "element vertex 2\nproperty quaternion x\n")),
                         {"line 5: a property has a type"}));
    EXPECT_TRUE(contains(error("g.ply", ply_head("binary_little_endian", vertices + faces) +
                                            std::string(24, '\0') + "\xFF" + "abcd"),
                         {"the file ends before face 1 of 1 is complete"}));
    EXPECT_TRUE(contains(error("h.ply", ply_head("ascii", "element vertex 999999999999\nproperty float x\n")),
                         {"out of range"}));
    std::string nan = ply_head("binary_little_endian", vertices) + std::string(24, '\xFF');
    EXPECT_TRUE(contains(error("i.ply", nan), {"vertex 1 of 2: a coordinate is not a finite number"}));
    EXPECT_TRUE(contains(error("j.ply", "this is no ply\n"), {"does not start with 'ply'"}));
}

TEST_F(ReadMesh, FieldsThatAreNotFiniteAreLeftOut) {
    const Mesh mesh = read(
        "a.ply",
        ply_head(
            "ascii",
            "element vertex 1\nproperty float x\nproperty float y\nproperty float z\nproperty float q\n") +
            "0 0 0 nan\n");
    EXPECT_TRUE(mesh.fields().empty());
    EXPECT_EQ(mesh.notes(), (Texts{"field 'q' has values that are not finite numbers and was left out"}));
}

TEST_F(ReadMesh, FieldsOfTheSameNameAreRenamed) {
    const Mesh mesh =
        read("a.ply", ply_head("ascii",
                               "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                               "property float q\nproperty float q\n") +
                          "0 0 0 1 2\n");
    EXPECT_EQ(mesh.field("q_2").values(0, 0), 2);
}

// ------------------------------------------------------------------------------------- STL, Medit, XYZ

TEST_F(ReadMesh, StlWelds) {
    const Mesh mesh = read(
        "a.stl",
        "solid two words\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
        "endfacet\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex -0 1 "
        "0\nendloop\nendfacet\nendsolid\n");
    EXPECT_EQ(mesh.vertex_count(), 4);
    EXPECT_EQ(corners(mesh), (Corners{0, 1, 2, 1, 3, 2}));
    EXPECT_EQ(mesh.notes(), (Texts{"6 corners of triangles were welded to 4 vertices"}));
}

TEST_F(ReadMesh, BinaryStlMayStartWithSolid) {
    std::string text = "solid but binary";
    text.resize(80, ' ');
    text += stored<std::uint32_t>(1);
    for (const float x : {0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F})
        text += stored(x);
    EXPECT_TRUE(contains(error("b.stl", text), {"a triangle count of 1 is announced"}));
    EXPECT_EQ(read("a.stl", text + std::string(2, char{})).cell_count(), 1);
}

TEST_F(ReadMesh, StlErrors) {
    EXPECT_TRUE(
        contains(error("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"),
                 {"line 6: the file ends inside a facet"}));
    EXPECT_TRUE(contains(error("b.stl", "hello\n"), {"neither an ASCII STL file"}));
    EXPECT_TRUE(contains(
        error("c.stl",
              "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\n"),
        {"line 7: a facet has 2 vertices, not 3"}));
}

TEST_F(ReadMesh, MeditSurfacesAndSections) {
    const Mesh mesh = read(
        "a.mesh",
        "MeshVersionFormatted 2\nDimension\n3\n# comment\nVertices\n4\n0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n"
        "Corners 2\n1\n2\nEdges 1\n1 2 0\nQuadrilaterals 1\n1 2 3 4 0\nTriangles 1\n1 2 3 0\nEnd\n");
    EXPECT_EQ(mesh.cell_count(), 3);
    EXPECT_EQ(mesh.notes().size(), 2U);
    EXPECT_TRUE(contains(
        error("b.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices 1\n0 0 0 1\nTriangles 1\n1 1 2 0\n"),
        {"line 6: triangle 1 of 1 names vertex 2, but the vertices are 1 to 1"}));
    EXPECT_TRUE(contains(
        error("c.mesh",
              "MeshVersionFormatted 2\nDimension 3\nVertices 1\n0 0 0 1\nHexahedra 1\n1 1 1 1 1 1 1 1 0\n"),
        {"hexahedra, which are not read"}));
    EXPECT_TRUE(contains(error("d.mesh", "{}"), {"MeshVersionFormatted"}));
}

TEST_F(ReadMesh, XyzPointsAndNormals) {
    EXPECT_EQ(read("a.xyz", "# p\n0 0 0\n1 2 3\n").points().row(1), Eigen::RowVector3d(1, 2, 3));
    EXPECT_EQ(read("b.xyz", "0 0 0 0 0 1\n").field("normal").values(0, 2), 1);
    EXPECT_TRUE(
        contains(error("c.xyz", "0 0 0\n1 2 3 4 5 6\n"), {"line 2: there are 6 numbers where 3 are due"}));
    EXPECT_TRUE(contains(error("d.xyz", "0 0\n"), {"line 1: there are 2 numbers where 3 or 6 are due"}));
}

// ---------------------------------------------------------------------------------------------------- VTK

TEST_F(ReadMesh, VtkErrors) {
    const std::string head =
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0\n1 0 0\n0 1 "
        "0\n";
    EXPECT_TRUE(contains(error("a.vtk", head + "CELLS 1 4\n3 0 1 3\nCELL_TYPES 1\n5\n"),
                         {"cell 1 of 1 names vertex 3, but the vertices are 0 to 2"}));
    EXPECT_TRUE(contains(error("b.vtk", head + "CELLS 1 9\n8 0 1 2 0 1 2 0 1\nCELL_TYPES 1\n12\n"),
                         {"VTK's type 12", "Tetrahedralize"}));
    EXPECT_TRUE(contains(error("c.vtk", head + "POINT_DATA 2\n"), {"point data for 2 points, but 3 points"}));
    EXPECT_TRUE(contains(error("d.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n"),
                         {"neither POLYDATA nor UNSTRUCTURED_GRID"}));
    EXPECT_TRUE(contains(
        error("e.vtk", "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 100 float\nabc"),
        {"the file ends before coordinate 300 of 300"}));
    EXPECT_TRUE(contains(error("f.vtk", head + "CELLS 2000000000 9\n"), {"announced"}));
    EXPECT_TRUE(contains(error("g.vtu", "<VTKFile type='ImageData'/>"),
                         {"neither an UnstructuredGrid nor PolyData"}));
    EXPECT_TRUE(contains(error("h.vtu", "<VTKFile type='Unstr"), {"not well-formed XML"}));
    EXPECT_TRUE(contains(
        error(
            "i.vtu",
            "<VTKFile type='UnstructuredGrid'><UnstructuredGrid><Piece NumberOfPoints='5'><Points><DataArray "
            "type='Float32'>1 2 3</DataArray></Points></Piece></UnstructuredGrid></VTKFile>"),
        {"line 1: 5 points are announced, but 3 coordinates are there"}));
    EXPECT_TRUE(
        contains(error("j.vtu", "<VTKFile type='UnstructuredGrid' compressor='vtkLZ4DataCompressor'/>"),
                 {"vtkLZ4DataCompressor"}));
}

TEST_F(ReadMesh, XmlPiecesAreJoined) {
    std::string piece =
        "<Piece NumberOfPoints='3' NumberOfCells='1'><PointData><DataArray type='Float32' Name='u'>1 2 "
        "3</DataArray></PointData>"
        "<Points><DataArray type='Float32' NumberOfComponents='3'>0 0 0 1 0 0 0 1 "
        "0</DataArray></Points><Cells>"
        "<DataArray type='Int32' Name='connectivity'>0 1 2</DataArray><DataArray type='Int32' "
        "Name='offsets'>3</DataArray>"
        "<DataArray type='UInt8' Name='types'>5</DataArray></Cells></Piece>";
    const Mesh mesh = read("a.vtu", "<VTKFile type='UnstructuredGrid'><UnstructuredGrid>" + piece + piece +
                                        "</UnstructuredGrid></VTKFile>");
    EXPECT_EQ(corners(mesh), (Corners{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ(mesh.field("u").values(5, 0), 3);
}

/// What VTK and meshio wrote: one shape of six points, as two tetrahedra or as two triangles, a quadrilateral
/// and more.
class ForeignFiles : public ::testing::TestWithParam<std::string> {};

TEST_P(ForeignFiles, AreRead) {
    const Mesh mesh = read_mesh(data_folder() / GetParam());
    const bool stl = GetParam().ends_with(".stl");
    ASSERT_EQ(mesh.vertex_count(), 6);
    EXPECT_DOUBLE_EQ(mesh.points().sum(), 8.375);
    const bool solid = GetParam().find("grid") != std::string::npos || GetParam() == "meshio.mesh" ||
                       (GetParam().starts_with("vtk") && GetParam().ends_with(".vtu"));
    EXPECT_EQ(mesh.kind(), solid ? CellKind::tetrahedron : CellKind::triangle);
    EXPECT_EQ(mesh.cell_count(), solid ? 2 : GetParam().starts_with("meshio") ? 4 : 6);
    if (solid) {
        EXPECT_EQ(mesh.cells().row(1), Eigen::RowVector4i(0, 2, 3, 4));
    }
    if (stl || GetParam() == "meshio.mesh") return;
    for (Index v = 0; v < 6; ++v)
        EXPECT_DOUBLE_EQ(mesh.field("value").values(v, 0), 0.1 * v);
    if (GetParam().ends_with(".ply")) return;
    for (Index v = 0; v < 6; ++v) {
        EXPECT_EQ(mesh.field("flow").values.row(v), Eigen::RowVector3d(3 * v, 3 * v + 1, 3 * v + 2));
        EXPECT_EQ(mesh.field("count").values(v, 0), v);
        if (GetParam().starts_with("vtk")) {
            EXPECT_FLOAT_EQ(static_cast<float>(mesh.field("a name").values(v, 0)),
                            0.1F * static_cast<float>(v));
        }
    }
}

std::vector<std::string> data_files() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(data_folder()))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

std::string test_name(const ::testing::TestParamInfo<std::string>& info) {
    std::string name = info.param;
    std::replace(name.begin(), name.end(), '.', '_');
    return name;
}

INSTANTIATE_TEST_SUITE_P(Data, ForeignFiles, ::testing::ValuesIn(data_files()), test_name);

// -------------------------------------------------------------------------------------------- bad files

TEST_F(ReadMesh, FilesThatAreNone) {
    EXPECT_TRUE(contains(error_of(scratch_ / "missing.obj"), {"there is no such file"}));
    EXPECT_TRUE(contains(error_of(scratch_ / ""), {"this is a folder"}));
    EXPECT_TRUE(contains(error("a.obj", ""), {"the file is empty"}));
    EXPECT_TRUE(contains(error("a.fbx", "x"), {"files that end in .fbx are not read",
                                               ".obj, .off, .ply, .stl, .vtk, .vtu, .vtp, .mesh, .xyz"}));
    EXPECT_TRUE(contains(error("bunny", "x"), {"the name has no ending"}));
    EXPECT_TRUE(contains(error_of("/dev/null"), {"not an ordinary file"}));
    EXPECT_EQ(read("UPPER.OBJ", "v 0 0 0\n").vertex_count(), 1);
}

TEST_F(ReadMesh, GarbageUnderAnyEndingIsAnError) {
    std::mt19937 random(7);
    std::string garbage(5000, '\0');
    for (char& c : garbage)
        c = static_cast<char>(random());
    for (const char* ending : {"obj", "off", "ply", "stl", "vtk", "vtu", "vtp", "mesh", "xyz"}) {
        EXPECT_NE(error(std::string("a.") + ending, garbage), "no error") << ending;
        EXPECT_NE(error(std::string("b.") + ending, "\n \n"), "no error") << ending;
    }
}

/// Small files of every format and encoding.
std::map<std::string, std::string> samples() {
    std::map<std::string, std::string> files;
    for (const std::string& name : data_files())
        files[name] = bytes_of(data_folder() / name);
    files["a.obj"] =
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 1\nv 2 2 2 .5 .5 .5\nf 1 2 3\nf 1/1 2/1 "
        "3/1 4/1\nf -1 -2 -3 -4 -5\nl 1 2\n";
    files["a.off"] =
        "COFF\n5 3 0\n0 0 0 1 2 3 4\n1 0 0 1 2 3 4\n1 1 0 1 2 3 4\n0 1 0 1 2 3 4\n-1 .5 0 1 2 3 4\n3 0 1 "
        "2\n4 0 1 2 3\n5 0 1 2 3 4\n";
    files["strips.ply"] =
        ply_head("ascii",
                 "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar "
                 "red\nproperty uchar green\n"
                 "property uchar blue\nelement tristrips 1\nproperty list int int vertex_indices\n") +
        "0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n1 1 0 1 2 3\n7 0 1 2 3 -1 0 1\n";
    files["a.xyz"] = "0 0 0 0 0 1\n1 2 3 0 0 1\n";
    Points points(4, 3);
    points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    const Fields fields{
        {"u", Block::Ones(4, 1)}, {"color", Block::Constant(4, 3, 0.5)}, {"w", Block::Ones(4, 3)}};
    const Scratch scratch;
    for (const int corners : {2, 3, 4}) {
        Cells cells(2, corners);
        for (int k = 0; k < corners; ++k)
            cells.col(k) << k, (k + 1) % 4;
        for (const char* ending : {"ply", "vtu"}) {
            const std::string name = fmt::format("written_{}.{}", corners, ending);
            write_mesh(scratch / name, Mesh(points, cells, fields));
            files[name] = bytes_of(scratch / name);
        }
    }
    return files;
}

/// Reads it, or says why not, and does nothing else.
void expect_mesh_or_input_error(const fs::path& path, const std::string& content, const std::string& what) {
    put(path, content);
    try {
        (void)read_mesh(path);
    } catch (const InputError& e) {
        EXPECT_FALSE(e.hint().empty()) << e.what();
    } catch (const std::exception& e) {
        ADD_FAILURE() << what << ": " << e.what();
    }
    fs::remove(path);  // a file that is overwritten waits for the disk, a new one does not
}

TEST(ReadMeshFuzz, TruncatedFiles) {
    const auto files = samples();
    const Scratch scratch;
    for (const auto& [name, content] : files) {
        const std::size_t step = std::max<std::size_t>(1, content.size() / 150);
        for (std::size_t size = 0; size < content.size(); size += step) {
            expect_mesh_or_input_error(scratch / name, content.substr(0, size),
                                       fmt::format("{} cut at {}", name, size));
        }
    }
}

TEST(ReadMeshFuzz, FlippedBytes) {
    const auto files = samples();
    const Scratch scratch;
    std::mt19937 random(20240607);
    for (const auto& [name, content] : files) {
        for (int round = 0; round < 300; ++round) {
            std::string changed = content;
            const int flips = 1 + static_cast<int>(random() % 4);
            for (int i = 0; i < flips; ++i) {
                char& c = changed[random() % changed.size()];
                // Digits for digits reach further than noise: counts and numbers stay numbers.
                if (c >= '0' && c <= '9' && random() % 2 == 0) {
                    c = static_cast<char>('0' + random() % 10);
                } else {
                    c = static_cast<char>(random());
                }
            }
            expect_mesh_or_input_error(scratch / name, changed, fmt::format("{} round {}", name, round));
        }
    }
}

TEST(ReadMeshFuzz, InsertedAndRemovedPieces) {
    const auto files = samples();
    const Scratch scratch;
    std::mt19937 random(99);
    for (const auto& [name, content] : files) {
        for (int round = 0; round < 100; ++round) {
            std::string changed = content;
            const std::size_t at = random() % changed.size();
            if (round % 2 == 0) {
                changed.erase(at, 1 + random() % 20);
            } else {
                const char* const pieces[] = {"9",      "99999999",         "-",          " ", "\n", "nan ",
                                              "1e308 ", "\xFF\xFF\xFF\xFF", "4294967295 "};
                changed.insert(at, pieces[random() % std::size(pieces)]);
            }
            expect_mesh_or_input_error(scratch / name, changed, fmt::format("{} round {}", name, round));
        }
    }
}

// -------------------------------------------------------------------------------------------- real meshes

struct Counts {
    const char* name;
    Index vertices;
    Index cells;
    CellKind kind = CellKind::triangle;
};

TEST(ReadMeshReal, CountsAreThoseOfTheirSources) {
    BELTRAMI_SKIP_WITHOUT(shared_mesh("README.md"));
    constexpr Counts all[] = {{"bunny_full.obj", 35947, 69451},
                              {"bunny_3485.off", 3485, 6966},
                              {"bunny_res2_dirty.ply", 8171, 16301},
                              {"armadillo_43k.off", 43243, 86482},
                              {"dragon_100k.ply", 100250, 202520},
                              {"dragon_5k.ply", 5205, 11102},
                              {"igea_134k.ply", 134345, 268686},
                              {"nefertiti_35k.obj", 35002, 70000},
                              {"spot.obj", 2930, 5856},
                              {"spot_quads.obj", 188, 372},
                              {"rocker_arm.obj", 10044, 20088},
                              {"double_torus.obj", 3070, 6144},
                              {"fertility.off", 4494, 9000},
                              {"moebius.obj", 280, 448},
                              {"three_fins.obj", 75, 108},
                              {"bones.off", 2154, 4204},
                              {"suzanne.obj", 507, 968},
                              {"disk.obj", 5000, 9769},
                              {"square.off", 415, 768},
                              {"cowhead.obj", 4537, 9024},
                              {"plane_holes.obj", 8519, 16747},
                              {"elephant_holes.off", 2798, 4463},
                              {"teapot.obj", 3644, 6320},
                              {"fandisk.obj", 6475, 12946},
                              {"cube_minus_sphere.obj", 2066, 4128},
                              {"anchor.off", 519, 1050},
                              {"mpi_letters.off", 90, 180},
                              {"capsule.obj", 5252, 10200},
                              {"beetle.obj", 1148, 2053},
                              {"blobby_flipped.off", 2027, 4050},
                              {"face_color.obj", 845, 1610},
                              {"sphere_color.ply", 114, 224},
                              {"kitten.xyz", 5210, 0, CellKind::point},
                              {"hand_tets.mesh", 7234, 29998, CellKind::tetrahedron},
                              {"bunny_tets.mesh", 5433, 34055, CellKind::tetrahedron},
                              {"cube_tets.vtk", 9261, 48000, CellKind::tetrahedron}};
    for (const Counts& counts : all) {
        const Mesh mesh = read_mesh(shared_mesh(counts.name));
        EXPECT_EQ(mesh.vertex_count(), counts.vertices) << counts.name;
        EXPECT_EQ(mesh.cell_count(), counts.cells) << counts.name;
        EXPECT_EQ(mesh.kind(), counts.kind) << counts.name;
    }
}

TEST(ReadMeshReal, NotesAndFields) {
    BELTRAMI_SKIP_WITHOUT(shared_mesh("README.md"));
    EXPECT_EQ(read_mesh(shared_mesh("spot_quads.obj")).notes(),
              (Texts{"160 quadrilaterals and 16 larger polygons were split into 368 triangles"}));
    EXPECT_EQ(read_mesh(shared_mesh("hand_tets.mesh")).notes(),
              (Texts{"9556 polygons beside the tetrahedra were left out"}));
    EXPECT_NE(read_mesh(shared_mesh("bunny_res2_dirty.ply")).find_field("confidence"), nullptr);
    EXPECT_EQ(read_mesh(shared_mesh("face_color.obj")).field("color").values.cols(), 3);
    EXPECT_LE(read_mesh(shared_mesh("sphere_color.ply")).field("color").values.maxCoeff(), 1.0);
    EXPECT_EQ(read_mesh(shared_mesh("kitten.xyz")).field("normal").values.rows(), 5210);
    const Mesh quads = read_mesh(shared_mesh("spot_quads.obj"));
    for (Index c = 0; c < quads.cell_count(); ++c)
        EXPECT_FALSE(is_degenerate(quads, c)) << c;
}

}  // namespace
}  // namespace beltrami
