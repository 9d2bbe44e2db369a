// The program's contract: what it prints, writes and returns, for good input and for bad.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "expect_text.hpp"
#include "meshes.hpp"
#include "process.hpp"

namespace beltrami::testing {
namespace {

namespace fs = std::filesystem;

TEST(Program, HelpAndVersionSucceed) {
    EXPECT_EQ(run_beltrami({"--help"}).status, 0);
    EXPECT_EQ(run_beltrami({"heat", "--help"}).status, 0);
    EXPECT_EQ(run_beltrami({"--version"}).status, 0);
    EXPECT_NE(run_beltrami({"--help"}).out.find("icosphere"), std::string::npos);
}

TEST(Program, InterpolateWritesWhatTheSummarySays) {
    const Scratch scratch;
    const fs::path out = scratch / "out.ply";
    const fs::path summary = scratch / "summary.json";
    const Outcome outcome =
        run_beltrami({"interpolate", "shape:icosphere:4", "--fix", "0=-1", "--fix", "3=2", "--laplacian", "1",
                      "--bilaplacian", "0.1", "-o", out, "--summary", summary});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Mesh mesh = read_mesh(out);
    const Block& value = mesh.field("value").values;
    EXPECT_EQ(value(0, 0), -1.0);
    EXPECT_EQ(value(3, 0), 2.0);
    const auto json = read_json(summary);
    EXPECT_EQ(json["command"], "interpolate");
    EXPECT_EQ(json["mesh"]["vertices"], mesh.vertex_count());
    EXPECT_EQ(json["solver"]["converged"], true);
    for (const char* key : {"name", "why", "iterations", "relative_residual"})
        EXPECT_TRUE(json["solver"].contains(key));
    EXPECT_GT(json["seconds"]["total"], 0.0);
    EXPECT_GT(json["peak_memory_bytes"], 0);
    EXPECT_EQ(json["outputs"][0], out.string());
    EXPECT_DOUBLE_EQ(json["result"]["fields"]["value"]["max"][0], value.maxCoeff());
}

TEST(Program, InterpolateReadsCsvAndColumns) {
    const Scratch scratch;
    const fs::path csv = scratch / "fix.csv";
    write_text(csv, "vertex,x,y,z\n# a comment\n0, 1, 2, 3\r\n5,4,5,6\n");
    const fs::path out = scratch / "out.vtu";
    ASSERT_EQ(
        run_beltrami({"interpolate", "shape:icosphere:2", "--fix-file", csv, "--fix", "9=0,0,0", "-o", out})
            .status,
        0);
    const Block value = read_mesh(out).field("value").values;
    EXPECT_EQ(value.row(0), Eigen::RowVector3d(1, 2, 3));
    EXPECT_EQ(value.row(5), Eigen::RowVector3d(4, 5, 6));
    EXPECT_EQ(value.row(9), Eigen::RowVector3d::Zero());
}

TEST(Program, HeatHoldsItsSourceAndWritesEveryStep) {
    const Scratch scratch;
    const fs::path out = scratch / "out.ply";
    const fs::path series = scratch / "heat.pvd";
    const Outcome outcome = run_beltrami({"heat", "shape:grid:20x20", "--source", "0=100", "--initial",
                                          "440=50", "--time", "0.1", "--steps", "5", "--method", "bdf2",
                                          "--series", series, "-o", out, "--picture", scratch / "heat.png"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Block u = read_mesh(out).field("u").values;
    EXPECT_EQ(u(0, 0), 100.0);
    EXPECT_GT(u.minCoeff(), 0.0);
    EXPECT_TRUE(fs::exists(series));
    EXPECT_TRUE(fs::exists(scratch / "heat_0005.vtu"));
    EXPECT_FALSE(fs::exists(scratch / "heat_0006.vtu"));
    EXPECT_GT(fs::file_size(scratch / "heat.png"), 1000U);
    EXPECT_EQ(read_mesh(scratch / "heat_0000.vtu").field("u").values(440, 0), 50.0);
}

TEST(Program, HeatKeepsTheMeanOfAFieldTheFileCarries) {
    const Scratch scratch;
    const Mesh sphere = shapes::icosphere(3);
    const fs::path in = scratch / "in.ply";
    write_mesh(in, sphere, {{"warm", Block(sphere.points().col(2).array() + 5.0)}});
    const fs::path out = scratch / "out.ply";
    ASSERT_EQ(run_beltrami({"heat", in, "--initial-field", "warm", "--time", "0.5", "-o", out}).status, 0);
    const Vector mass = lumped_mass(sphere);
    const Mesh result = read_mesh(out);
    EXPECT_NEAR(mass.dot(result.field("u").values.col(0)) / mass.sum(), 5.0, 1e-8);
    EXPECT_TRUE(result.find_field("warm") != nullptr) << "what the file carried is kept";
}

TEST(Program, WavePoissonAndCurvatureRun) {
    const Scratch scratch;
    EXPECT_EQ(run_beltrami({"wave", "shape:icosphere:3", "--impulse", "0=1", "--steps", "20", "--time", "1",
                            "--damping", "0.1,0.01", "-o", scratch / "w.ply"})
                  .status,
              0);
    EXPECT_EQ(
        run_beltrami({"poisson", "shape:grid:10x10", "--fix-boundary", "1", "-o", scratch / "p.ply"}).status,
        0);
    EXPECT_NEAR(read_mesh(scratch / "p.ply").field("u").values.minCoeff(), 1.0, 1e-9);
    ASSERT_EQ(run_beltrami({"curvature", "shape:icosphere:3:2", "-o", scratch / "c.ply"}).status, 0);
    const Mesh curved = read_mesh(scratch / "c.ply");
    EXPECT_NEAR(curved.field("mean_curvature").values.mean(), 0.5, 5e-3);
    EXPECT_EQ(curved.field("mean_curvature_normal").values.cols(), 3);
}

TEST(Program, PoissonRecoversAPotentialFromItsGradient) {
    const Scratch scratch;
    const Mesh grid = shapes::grid(16, 16);
    const Block gradient = Eigen::RowVector3d(2.0, -1.0, 0.0).replicate(grid.vertex_count(), 1);
    write_mesh(scratch / "in.vtu", grid, {{"slope", gradient}});
    ASSERT_EQ(run_beltrami({"poisson", scratch / "in.vtu", "--rhs-gradient", "slope", "--fix", "0=0", "-o",
                            scratch / "out.ply"})
                  .status,
              0);
    const Block u = read_mesh(scratch / "out.ply").field("u").values;
    const Vector exact = grid.points() * Vector3(2.0, -1.0, 0.0);
    EXPECT_LT((u.col(0) - exact).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Program, InfoPrintsJsonThatParses) {
    const Outcome outcome = run_beltrami({"info", "shape:torus:1:0.3:20x10", "--json"});
    ASSERT_EQ(outcome.status, 0);
    EXPECT_EQ(nlohmann::json::parse(outcome.out)["genus"], 1);
}

TEST(Program, OutputsKeepTheUsersOrder) {
    const Scratch scratch;
    const Mesh sphere = shapes::icosphere(3);
    const auto [mixed, number] = shapes::shuffled(sphere, 7);
    write_mesh(scratch / "a.ply", sphere);
    write_mesh(scratch / "b.ply", mixed);
    const auto fix = [](Index a, Index b) {
        return std::vector<std::string>{"--fix", fmt::format("{}=0", a), "--fix", fmt::format("{}=1", b)};
    };
    const std::vector<std::string> a = {"interpolate", scratch / "a.ply", "-o", scratch / "a_out.ply"};
    const std::vector<std::string> b = {"interpolate", scratch / "b.ply", "-o", scratch / "b_out.ply"};
    ASSERT_EQ(run_beltrami(a + fix(10, 200)).status, 0);
    ASSERT_EQ(run_beltrami(b + fix(number[10], number[200])).status, 0);
    const Block of_a = read_mesh(scratch / "a_out.ply").field("value").values;
    const Mesh out_b = read_mesh(scratch / "b_out.ply");
    EXPECT_EQ(out_b.points(), mixed.points());
    for (Index v = 0; v < sphere.vertex_count(); ++v) {
        EXPECT_NEAR(of_a(v, 0), out_b.field("value").values(number[static_cast<std::size_t>(v)], 0), 1e-9);
    }
}

TEST(Program, RefusesBadFiles) {
    const Scratch scratch;
    write_text(scratch / "empty.obj", "");
    write_text(scratch / "garbage.ply", std::string("\x00\x01\xff\xfe ply", 8));
    write_text(scratch / "truncated.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n");
    write_text(scratch / "range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    write_text(scratch / "nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");
    write_text(scratch / "infinite.obj", "v 0 0 0\nv 1 0 0\nv 0 1e999 0\nf 1 2 3\n");
    write_text(scratch / "points.xyz", "0 0 0\n1 0 0\n0 1 0\n");
    write_text(scratch / "mesh.unknown", "v 0 0 0\n");
    for (const char* name : {"missing.obj", "empty.obj", "garbage.ply", "truncated.off", "range.obj",
                             "nan.obj", "infinite.obj", "points.xyz", "mesh.unknown"}) {
        expect_refused(scratch, {"heat", scratch / name, "--source", "0=1"});
        expect_refused(scratch, {"interpolate", scratch / name, "--fix", "0=1"});
    }
    expect_refused(scratch, {"heat", scratch / "", "--source", "0=1"});
    expect_refused(scratch, {"heat", "shape:dodecahedron", "--source", "0=1"});
    expect_refused(scratch, {"heat", "shape:icosphere:-3", "--source", "0=1"});
}

TEST(Program, RefusesBadOptions) {
    const Scratch scratch;
    const std::string mesh = "shape:icosphere:2";
    write_text(scratch / "bad.csv", "vertex,x\n3,abc\n");
    write_text(scratch / "empty.csv", "vertex,x\n");
    const std::vector<std::vector<std::string>> refused = {
        {"interpolate", mesh, "--fix", "3=1", "--fix", "3=2"},
        {"interpolate", mesh, "--fix", "162=1"},
        {"interpolate", mesh, "--fix", "-1=1"},
        {"interpolate", mesh, "--fix", "3"},
        {"interpolate", mesh, "--fix", "3=abc"},
        {"interpolate", mesh, "--fix", "3=nan"},
        {"interpolate", mesh, "--fix", "3=1", "--fix", "4=1,2"},
        {"interpolate", mesh, "--fix-file", scratch / "bad.csv"},
        {"interpolate", mesh, "--fix-file", scratch / "empty.csv"},
        {"interpolate", mesh, "--fix-file", scratch / "missing.csv"},
        {"interpolate", mesh},
        {"interpolate", mesh, "--fix", "3=1", "--laplacian", "-1"},
        {"interpolate", mesh, "--fix", "3=1", "--laplacian", "0", "--bilaplacian", "0"},
        {"interpolate", mesh, "--fix", "3=1", "--tolerance", "0"},
        {"interpolate", mesh, "--fix", "3=1", "--solver", "magic"},
        {"interpolate", mesh, "--fix", "3=1", "--threads", "-2"},
        {"interpolate", mesh, "--fix", "3=1", "--view", "sideways", "--picture", scratch / "p.png"},
        {"interpolate", mesh, "--fix", "3=1", "--picture", scratch / "p.jpg"},
        {"heat", mesh, "--source", "3=1", "--time", "-1"},
        {"heat", mesh, "--source", "3=1", "--time", "nan"},
        {"heat", mesh, "--source", "3=1", "--steps", "0"},
        {"heat", mesh, "--source", "3=1", "--steps", "-5"},
        {"heat", mesh, "--source", "3=1", "--every", "0"},
        {"heat", mesh, "--source", "3=1", "--method", "magic"},
        {"heat", mesh, "--initial-field", "warmth"},
        {"heat", mesh, "--source", "3=1", "--series", scratch / "no/such/folder/heat.pvd"},
        {"heat", mesh, "--source", "3=1", "--series", scratch / "heat.txt"},
        {"heat", mesh},
        {"wave", mesh, "--impulse", "3=1", "--damping", "-1"},
        {"wave", mesh},
        {"poisson", mesh, "--fix-boundary", "0"},
        {"poisson", mesh, "--rhs-field", "nothing", "--fix", "0=0"},
        {"poisson", mesh},
        {"curvature", mesh, "--correction", "c3"},
        {"curvature", "shape:tetrahedral-cube:3"},
        {"interpolate", mesh, "--fix", "3=1", "--picture", scratch / "p.png", "--range", "1,0"},
        {"interpolate", mesh, "--fix", "3=1", "--summary", scratch / "refused.ply"},
        {"interpolate", "shape:icosphere:2:1e80", "--fix", "3=1"},
        {"dance", mesh},
    };
    for (const auto& arguments : refused)
        expect_refused(scratch, arguments);
    EXPECT_EQ(run_beltrami({"heat", mesh, "--source", "3=1"}).status, 2) << "nothing would be written";
    EXPECT_EQ(run_beltrami({"heat", mesh, "--source", "3=1", "-o", scratch / "no/such/folder/x.ply"}).status,
              2);
    EXPECT_EQ(run_beltrami({"heat", mesh, "--source", "3=1", "-o", scratch / "x.docx"}).status, 2);
    EXPECT_EQ(run_beltrami({}).status, 2);
    // The viewer's pictures are held to the same.
    EXPECT_EQ(run_beltrami({"view", mesh, "--screenshot", scratch / "p.jpg"}).status, 2);
    EXPECT_EQ(run_beltrami({"view", mesh, "--screenshot", scratch / "p.png", "--range", "1,0"}).status, 2);
    EXPECT_EQ(run_beltrami({"view", mesh, "--screenshot", scratch / "p.png", "--range=-inf,inf"}).status, 2);
    // Files that hold no fields are refused before the work, not after it.
    const Outcome obj = run_beltrami({"heat", mesh, "--source", "3=1", "-o", scratch / "x.obj"});
    EXPECT_EQ(obj.status, 2);
    EXPECT_EQ(obj.out.find("solver"), std::string::npos);
    write_mesh(scratch / "in.ply", shapes::icosphere(2));
    EXPECT_EQ(run_beltrami({"heat", scratch / "in.ply", "--source", "3=1", "-o", scratch / "in.ply"}).status,
              2);
}

TEST(Program, NamesComponentsThatNothingHolds) {
    const Scratch scratch;
    write_mesh(scratch / "two.ply", shapes::together({shapes::icosphere(1), shapes::icosphere(2)}));
    const std::vector<std::string> command = {"interpolate", scratch / "two.ply", "--fix", "0=1", "--fix",
                                              "5=2"};
    const std::vector<std::string> out = {"-o", scratch / "out.ply"};
    const Outcome refused = run_beltrami(command + out);
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find("1 component"), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("42"), std::string::npos)
        << "the second sphere begins at vertex 42: " << refused.err;
    ASSERT_EQ(run_beltrami(command + out + std::vector<std::string>{"--free-components", "keep"}).status, 0);
    const Block value = read_mesh(scratch / "out.ply").field("value").values;
    EXPECT_EQ(value.bottomRows(162).cwiseAbs().maxCoeff(), 0.0);
    EXPECT_GT(value.topRows(42).minCoeff(), 0.99);
}

TEST(Program, WarnsOfDegenerateCellsAndIsolatedVertices) {
    const Scratch scratch;
    write_text(scratch / "in.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nv 0.5 0 0\nf 1 2 3\nf 1 2 5\n");
    const Outcome outcome = run_beltrami({"heat", scratch / "in.obj", "--initial", "3=7", "--source", "0=1",
                                          "-o", scratch / "out.ply", "--summary", scratch / "s.json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("1 of 2 triangles"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("2 isolated vertices"), std::string::npos) << outcome.err;
    EXPECT_EQ(read_mesh(scratch / "out.ply").field("u").values(3, 0), 7.0);
    EXPECT_EQ(read_json(scratch / "s.json")["warnings"].size(), 2U);
}

TEST(Program, WarnsWhereTheMaximumPrincipleFails) {
    const Scratch scratch;
    // A flat rhombus whose short diagonal is between two obtuse angles: its weight is negative.
    write_text(scratch / "in.obj",
               "v -1 0 0\nv 1 0 0\nv 0 0.2 0\nv 0 -0.2 0\nv 0 1 0\nf 1 2 3\nf 2 1 4\nf 1 3 5\nf 3 2 5\n");
    const Outcome outcome = run_beltrami({"heat", scratch / "in.obj", "--initial", "0=1", "--time", "1e-3",
                                          "--steps", "1", "-o", scratch / "out.ply"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_LT(read_mesh(scratch / "out.ply").field("u").values.minCoeff(), 0.0);
    EXPECT_NE(outcome.err.find("outside 0 to 1"), std::string::npos) << outcome.err;
    const Outcome delaunay =
        run_beltrami({"heat", "shape:icosphere:2", "--initial", "0=1", "-o", scratch / "d.ply"});
    EXPECT_EQ(delaunay.err.find("warning"), std::string::npos) << delaunay.err;
}

TEST(Program, ASolveThatDoesNotConvergeExitsWith3AndWritesNothing) {
    const Scratch scratch;
    const Outcome outcome =
        run_beltrami({"interpolate", "shape:icosphere:4", "--fix", "0=0", "--fix", "9=1", "--solver", "cg",
                      "--max-iterations", "3", "-o", scratch / "out.ply"});
    EXPECT_EQ(outcome.status, 3);
    EXPECT_TRUE(contains(outcome.err, {"error: ", "hint: "})) << outcome.err;
    EXPECT_FALSE(fs::exists(scratch / "out.ply"));
}

TEST(Program, CtrlCKeepsTheFinishedSteps) {
    const Scratch scratch;
    const fs::path series = scratch / "heat.pvd";
    const Outcome outcome = run_beltrami({"heat", "shape:icosphere:4", "--source", "0=1", "--steps", "100000",
                                          "--series", series, "-o", scratch / "out.ply"},
                                         scratch / "heat_0003.vtu");
    EXPECT_EQ(outcome.status, 130) << outcome.err;
    EXPECT_FALSE(fs::exists(scratch / "out.ply"));
    ASSERT_TRUE(fs::exists(series));
    std::ifstream file(series);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    EXPECT_NE(text.find("heat_0003.vtu"), std::string::npos);
    EXPECT_NE(text.find("</VTKFile>"), std::string::npos);
    for (const auto& entry : fs::directory_iterator(series.parent_path())) {
        const std::string name = entry.path().filename();
        EXPECT_TRUE(name.ends_with(".vtu") || name == "heat.pvd") << name << " was left behind";
        if (name.ends_with(".vtu")) {
            EXPECT_EQ(read_mesh(entry.path()).vertex_count(), 2562);
        }
    }
}

// Every real mesh: a finite result or a clear refusal.
TEST(Program, EveryRealMeshEndsWell) {
    const fs::path folder = shared_mesh("");
    BELTRAMI_SKIP_WITHOUT(folder);
    const Scratch scratch;
    std::vector<fs::path> files = shared_meshes();
    std::erase_if(files, [](const fs::path& file) { return fs::file_size(file) > BELTRAMI_LARGEST_MESH; });
    EXPECT_FALSE(files.empty());
    for (const fs::path& file : files) {
        const fs::path out = scratch / "out.ply";
        const std::vector<std::string> write = {"-o", out, "--free-components", "keep"};
        const auto check = [&](const std::vector<std::string>& arguments, const char* field) {
            fs::remove(out);
            const Outcome outcome = run_beltrami(arguments);
            if (outcome.status == 0) {
                EXPECT_TRUE(read_mesh(out).field(field).values.allFinite()) << file;
            } else {
                EXPECT_EQ(outcome.status, 2) << file << "\n" << outcome.err;
                EXPECT_TRUE(contains(outcome.err, {"error: ", "hint: "})) << file << "\n" << outcome.err;
                EXPECT_FALSE(fs::exists(out)) << file;
                EXPECT_EQ(file.extension(), ".xyz") << file << " is a mesh: " << outcome.err;
            }
        };
        EXPECT_EQ(run_beltrami({"info", file}).status, 0) << file;
        check({"heat", file, "--source", "0=1", "--steps", "3", "-o", out}, "u");
        check(std::vector<std::string>{"interpolate", file, "--fix", "0=0", "--fix", "30=1"} + write,
              "value");
    }
}

}  // namespace
}  // namespace beltrami::testing
