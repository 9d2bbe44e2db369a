// The command nodal.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "beltrami/beltrami.hpp"
#include "expect_text.hpp"
#include "meshes.hpp"
#include "process.hpp"

namespace beltrami::testing {
namespace {

namespace fs = std::filesystem;
const std::string disk = "shape:disk:16";

TEST(ProgramNodal, WritesTheLinesOfADrum) {
    const Scratch scratch;
    const fs::path basis = scratch / "b";
    ASSERT_EQ(run_beltrami({"harmonics", disk, "-k", "6", "--hold-boundary", "-o", basis}).status, 0);
    const Outcome outcome =
        run_beltrami({"nodal", disk, "--basis", basis, "--function", "1", "5", "-o", scratch / "l.vtu",
                      "--picture", scratch / "p.png", "--summary", scratch / "s.json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Mesh lines = read_mesh(scratch / "l.vtu");
    EXPECT_EQ(lines.kind(), CellKind::segment);
    double length = 0.0;
    for (Index c = 0; c < lines.cell_count(); ++c)
        length += (lines.points().row(lines.cells()(c, 0)) - lines.points().row(lines.cells()(c, 1))).norm();
    EXPECT_NEAR(length, 2.0 + 2.0 * std::numbers::pi * 2.404826 / 5.520078, 0.1);
    const Block numbers = lines.field("line").values;
    EXPECT_EQ(numbers.minCoeff(), 0.0);
    EXPECT_EQ(numbers.maxCoeff(), 1.0);
    EXPECT_EQ(lines.field("function").values.maxCoeff(), 5.0);
    for (Index c = 0; c < lines.cell_count(); ++c)
        EXPECT_EQ(numbers(lines.cells()(c, 0), 0), numbers(lines.cells()(c, 1), 0));
    const auto result = read_json(scratch / "s.json")["result"];
    EXPECT_NEAR(result["length"].get<double>(), length, 1e-9);
    EXPECT_EQ(result["lines"], 2);
    EXPECT_EQ(result["functions"][0]["closed"], 0);
    EXPECT_EQ(result["functions"][1]["closed"], 1);
    EXPECT_EQ(result["functions"][1]["domains"], 2);
    EXPECT_GT(fs::file_size(scratch / "p.png"), 5000u);
    // Another level, in a format that other programs skip lines in.
    ASSERT_EQ(run_beltrami({"nodal", disk, "--basis", basis, "--function", "0", "--level=0.3", "-o",
                            scratch / "l.ply"})
                      .status +
                  run_beltrami({"nodal", disk, "--basis", basis, "--function", "0", "--level=-0.3", "-o",
                                scratch / "l.ply"})
                      .status,
              2)
        << "function 0 has one sign: one of the two has no line";
    EXPECT_EQ(read_mesh(scratch / "l.ply").kind(), CellKind::segment);
}

TEST(ProgramNodal, RefusesWhatCannotBe) {
    const Scratch scratch;
    const fs::path basis = scratch / "b";
    ASSERT_EQ(run_beltrami({"harmonics", disk, "-k", "6", "-o", basis}).status, 0);
    const Arguments nodal = {"nodal", disk, "--basis", basis};
    expect_refused(scratch, nodal, {"--function"});
    expect_refused(scratch, nodal + Arguments{"--function", "0"}, {"no lines"});
    expect_refused(scratch, nodal + Arguments{"--function", "6"}, {"no function 6"});
    expect_refused(scratch, nodal + Arguments{"--function", "-1"});
    expect_refused(scratch, nodal + Arguments{"--function", "1", "--level", "1e9"}, {"no lines"});
    expect_refused(scratch, nodal + Arguments{"--function", "1", "--level", "nan"});
    expect_refused(scratch, {"nodal", "shape:disk:15", "--basis", basis, "--function", "1"},
                   {"another mesh"});
    expect_refused(scratch, {"nodal", "shape:tetrahedral-cube:2", "--basis", basis, "--function", "1"},
                   {"tetrahedra"});
    expect_refused(scratch, {"nodal", disk, "--basis", scratch / "missing", "--function", "1"});
}

}  // namespace
}  // namespace beltrami::testing
