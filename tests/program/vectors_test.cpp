// The command `vectors`: what it prints, writes and returns, for good input and for bad.

#include <gtest/gtest.h>

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
#include "turned_meshes.hpp"

namespace beltrami::testing {
namespace {

namespace fs = std::filesystem;

TEST(VectorsCommand, WritesWhatTheSummarySays) {
    const Scratch scratch;
    const fs::path out = scratch / "out.ply";
    const fs::path summary = scratch / "summary.json";
    const fs::path picture = scratch / "out.png";
    const Outcome outcome = run_beltrami({"vectors", "shape:icosphere:4", "--fix", "0=0,1,0", "--fix",
                                          "12=1,0,0", "-o", out, "--summary", summary, "--picture", picture});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.out, {"add up to 2 (Euler characteristic 2)"}));
    const Mesh mesh = read_mesh(out);
    const Block& field = mesh.field("vectors").values;
    ASSERT_EQ(field.cols(), 3);
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        EXPECT_LT(std::abs(field.row(v).dot(mesh.points().row(v))), 0.01 * field.row(v).norm() + 1e-12);
    const auto json = read_json(summary);
    EXPECT_EQ(json["command"], "vectors");
    EXPECT_EQ(json["result"]["method"], "connection");
    EXPECT_EQ(json["solver"]["converged"], true);
    EXPECT_EQ(json["solver"]["unknowns"], 2 * (mesh.vertex_count() - 2));
    const auto& found = json["result"]["singularities"];
    EXPECT_EQ(found["index_sum"], 2);
    EXPECT_EQ(found["count"], found["list"].size());
    int sum = 0;
    for (const auto& one : found["list"]) {
        sum += one["index"].get<int>();
        EXPECT_LT(one["triangle"], mesh.cell_count());
        EXPECT_EQ(one["position"].size(), 3U);
    }
    EXPECT_EQ(sum, 2);
    EXPECT_GT(fs::file_size(picture), 10000U);
}

TEST(VectorsCommand, EveryOptionReachesTheSolve) {
    const Scratch scratch;
    std::ofstream(scratch / "fix.csv") << "vertex,x,y,z\n3,1,0,0\n100,0,1,0\n";
    const Arguments common = {"vectors", "shape:torus:1:0.4:24x12", "--fix-file", scratch / "fix.csv",
                              "-o",      scratch / "out.ply"};
    const Mesh torus = shapes::torus(1.0, 0.4, 24, 12);
    const Laplacian laplacian(torus);
    Constraints fixed(3);
    fixed.fix(3, std::array{1.0, 0.0, 0.0});
    fixed.fix(100, std::array{0.0, 1.0, 0.0});
    const std::vector<std::pair<Arguments, VectorsOptions>> cases = {
        {{}, {}},
        {{"--method", "coordinates"}, {.method = VectorMethod::coordinates}},
        {{"--lengths", "solved"}, {.lengths = VectorLengths::solved}},
        {{"--lengths", "interpolated", "--method", "coordinates"},
         {.method = VectorMethod::coordinates, .lengths = VectorLengths::interpolated}},
        {{"--bilaplacian", "0.3"}, {.laplacian = 0.0, .bilaplacian = 0.3}},
        {{"--laplacian", "1", "--bilaplacian", "0.1", "--solver", "cg"}, {.bilaplacian = 0.1}}};
    for (const auto& [arguments, options] : cases) {
        ASSERT_EQ(run_beltrami(common + arguments).status, 0);
        const Block field = read_mesh(scratch / "out.ply").field("vectors").values;
        const Block expected = vectors(torus, laplacian, fixed, options).vectors;
        EXPECT_LT((field - expected).cwiseAbs().maxCoeff(), 1e-6) << fmt::format("{}", arguments);
    }
}

TEST(VectorsCommand, WarnsOfVectorsOffTheSurface) {
    const Scratch scratch;
    const Arguments command = {"vectors", "shape:grid:4x4", "-o", scratch / "out.ply"};
    const Outcome tilted = run_beltrami(command + Arguments{"--fix", "0=1,0,1", "--fix", "3=1,0,0"});
    EXPECT_EQ(tilted.status, 0);
    EXPECT_TRUE(contains(tilted.err, {"vertex 0", "45.0 degrees"}));
    const Outcome flat = run_beltrami(command + Arguments{"--fix", "0=1,0,0.02"});
    EXPECT_EQ(flat.err.find("degrees"), std::string::npos) << flat.err;
}

TEST(VectorsCommand, RefusesBadInput) {
    const Scratch scratch;
    const Arguments sphere = {"vectors", "shape:icosphere:2"};
    std::ofstream(scratch / "in.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nv 0.5 0 0\nf 1 2 3\nf 1 2 5\n";
    std::ofstream(scratch / "doubled.obj")
        << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 2\nf 1 2 4\n";
    std::ofstream(scratch / "two.csv") << "0,1,2\n";
    write_mesh(scratch / "moebius.ply", moebius_strip(20));
    write_mesh(scratch / "two.ply", shapes::together({shapes::icosphere(1), shapes::icosphere(1)}));
    const std::vector<std::pair<Arguments, std::string>> refused = {
        {sphere, "no vector is given"},
        {sphere + Arguments{"--fix", "3=1"}, "1 number"},
        {sphere + Arguments{"--fix", "3=1,2"}, "2 numbers"},
        {sphere + Arguments{"--fix", "3=1,2,3,4"}, "4 numbers"},
        {sphere + Arguments{"--fix", "3=1,nan,0"}, "not a finite number"},
        {sphere + Arguments{"--fix", "3=1,x,0"}, "cannot be understood"},
        {sphere + Arguments{"--fix", "162=1,0,0"}, "vertex 162"},
        {sphere + Arguments{"--fix", "3=1,0,0", "--fix", "3=0,1,0"}, "held twice"},
        {sphere + Arguments{"--fix-file", scratch / "two.csv"}, "2 numbers"},
        {sphere + Arguments{"--fix", "3=1,1,0", "--laplacian", "0", "--bilaplacian", "0"}, "both 0"},
        {sphere + Arguments{"--fix", "3=1,1,0", "--laplacian", "-1"}, "gamma"},
        {sphere + Arguments{"--fix", "3=1,1,0", "--method", "magic"}, "magic"},
        {sphere + Arguments{"--fix", "3=1,1,0", "--lengths", "long"}, "long"},
        {{"vectors", "shape:grid:3x3", "--fix", "3=0,0,2"}, "right angle to the surface"},
        {{"vectors", scratch / "in.obj", "--fix", "3=1,0,0"}, "vertex 3 has no tangent plane"},
        {{"vectors", scratch / "in.obj", "--fix", "4=1,0,0"}, "vertex 4 has no tangent plane"},
        {{"vectors", scratch / "doubled.obj", "--fix", "2=1,0,0"},
         "normals of the triangles around it cancel"},
        {{"vectors", scratch / "moebius.ply", "--fix", "4=0,1,0"}, "one-sided"},
        {{"vectors", scratch / "two.ply", "--fix", "3=1,2,0"}, "1 component"},
        {{"vectors", "shape:tetrahedral-cube:2", "--fix", "0=1,0,0"}, "tetrahedra"},
        {{"vectors", "shape:circle:9", "--fix", "0=1,0,0"}, "segments"},
    };
    for (const auto& [arguments, why] : refused)
        expect_refused(scratch, arguments, {why});
}

// A vector of length zero is a vector, and one field of zeros is an answer.
TEST(VectorsCommand, ZeroVectorsAreAllowed) {
    const Scratch scratch;
    const Outcome outcome = run_beltrami({"vectors", "shape:icosphere:2", "--fix", "3=0,0,0", "-o",
                                          scratch / "out.ply", "--picture", scratch / "out.png"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(read_mesh(scratch / "out.ply").field("vectors").values.isZero(0.0));
}

// Every real mesh: a finite field or one clear sentence, by both methods.
TEST(VectorsCommand, EveryRealMeshEndsWell) {
    const fs::path folder = shared_mesh("");
    BELTRAMI_SKIP_WITHOUT(folder);
    const Scratch scratch;
    std::vector<fs::path> files = shared_meshes();
    std::erase_if(files, [](const fs::path& file) { return fs::file_size(file) > BELTRAMI_LARGEST_MESH; });
    int solved = 0;
    for (const fs::path& file : files) {
        for (const std::string method : {"connection", "coordinates"}) {
            const fs::path out = scratch / "out.ply";
            fs::remove(out);
            const Outcome outcome =
                run_beltrami({"vectors", file, "--fix", "0=0.3,0.4,0.5", "--fix", "30=1,-0.2,0.1", "--method",
                              method, "--free-components", "keep", "-o", out});
            const std::string what = fmt::format("{} {}: {}", file.string(), method, outcome.err);
            if (outcome.status == 0) {
                ++solved;
                EXPECT_TRUE(read_mesh(out).field("vectors").values.allFinite()) << what;
            } else {
                EXPECT_EQ(outcome.status, 2) << what;
                EXPECT_TRUE(contains(outcome.err, {"error: ", "hint: "})) << what;
                EXPECT_FALSE(fs::exists(out)) << what;
            }
        }
    }
    EXPECT_GT(solved, static_cast<int>(files.size())) << "more than half of them";
}

}  // namespace
}  // namespace beltrami::testing
