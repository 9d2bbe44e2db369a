// The commands fair and membrane, and what interpolate does with displacements, colours and bounds.

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

const Arguments upper = {"--box", "-2,-2,0.1,2,2,2"};

TEST(ProgramFair, MovesItsRegionAndNothingElse) {
    const Scratch scratch;
    const fs::path out = scratch / "out.ply";
    const Outcome outcome =
        run_beltrami(Arguments{"fair", sphere, "--bilaplacian", "1", "-o", out, "--picture",
                               scratch / "p.png", "--summary", scratch / "s.json"} +
                     upper);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Mesh before = shapes::icosphere(3);
    const Mesh after = read_mesh(out);
    const Block moved = after.field("displacement").values;
    EXPECT_LT((before.points() + moved - after.points()).cwiseAbs().maxCoeff(), 1e-12);
    Index region = 0;
    for (Index v = 0; v < before.vertex_count(); ++v) {
        const bool inside = before.points()(v, 2) >= 0.1;
        region += inside ? 1 : 0;
        if (!inside) {
            ASSERT_EQ(after.points().row(v), before.points().row(v));
        }
    }
    EXPECT_GT(moved.rowwise().norm().maxCoeff(), 0.05);
    EXPECT_EQ(read_json(scratch / "s.json")["result"]["region"], region);
    EXPECT_GT(fs::file_size(scratch / "p.png"), 1000U);
}

TEST(ProgramFair, ARegionIsAFileAFieldOrABox) {
    const Scratch scratch;
    const Mesh mesh = shapes::icosphere(3);
    Block mask = Block::Zero(mesh.vertex_count(), 1);
    std::string list = "vertex\n# the upper part\n";
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.points()(v, 2) < 0.1) continue;
        mask(v, 0) = 1.0;
        list += std::to_string(v) + (v % 2 == 0 ? ", " : "\r\n");
    }
    write_mesh(scratch / "in.ply", mesh, {{"mask", mask}});
    write_text(scratch / "region.csv", list);
    const auto points = [&](const Arguments& region) {
        const Outcome outcome =
            run_beltrami(Arguments{"fair", scratch / "in.ply", "-o", scratch / "out.ply"} + region);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return read_mesh(scratch / "out.ply").points();
    };
    const Points by_box = points(upper);
    EXPECT_EQ(points({"--region-field", "mask"}), by_box);
    EXPECT_EQ(points({"--region-file", scratch / "region.csv"}), by_box);
}

TEST(ProgramFair, AFlowOfEverythingShrinksASphereStepByStep) {
    const Scratch scratch;
    ASSERT_EQ(run_beltrami({"fair", sphere, "--all", "--laplacian", "1", "--time", "0.5", "--steps", "5",
                            "--series", scratch / "f.pvd", "--every", "2", "-o", scratch / "out.ply"})
                  .status,
              0);
    // 1 / (1 + 2 dt)^5
    EXPECT_NEAR(read_mesh(scratch / "out.ply").points().rowwise().norm().mean(), std::pow(1.2, -5), 5e-3);
    EXPECT_TRUE(fs::exists(scratch / "f_0003.vtu")) << "steps 0, 2, 4 and the last";
    EXPECT_FALSE(fs::exists(scratch / "f_0004.vtu"));
    EXPECT_EQ(read_mesh(scratch / "f_0003.vtu").points(), read_mesh(scratch / "out.ply").points());
}

TEST(ProgramMembrane, ComesToRestWithEvenTriangles) {
    const Scratch scratch;
    const Outcome outcome =
        run_beltrami(Arguments{"membrane", sphere, "-o", scratch / "out.ply", "--series", scratch / "m.pvd",
                               "--summary", scratch / "s.json", "--picture", scratch / "p.png"} +
                     upper);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto result = read_json(scratch / "s.json")["result"];
    EXPECT_EQ(result["at_rest"], true);
    const auto areas = result["areas"].get<std::vector<double>>();
    const auto energy = result["energy"].get<std::vector<double>>();
    EXPECT_TRUE(std::is_sorted(energy.rbegin(), energy.rend()));
    EXPECT_LT(areas.back(), 0.7 * areas.front());
    EXPECT_EQ(areas.size(), result["steps"].get<std::size_t>() + 1);
    EXPECT_TRUE(fs::exists(scratch / fmt::format("m_{:04}.vtu", areas.size() - 1)));
    EXPECT_FALSE(fs::exists(scratch / fmt::format("m_{:04}.vtu", areas.size())));
}

TEST(ProgramMembrane, SpansAFixedBoundary) {
    const Scratch scratch;
    for (const char* weights : {"area", "cotangent"}) {
        const Outcome outcome = run_beltrami({"membrane", "shape:cylinder:1:1:48x16", "--fix-boundary",
                                              "--weights", weights, "-o", scratch / "out.ply"});
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_NEAR(read_mesh(scratch / "out.ply").points().leftCols(2).rowwise().norm().minCoeff(), 0.848,
                    3e-3)
            << "the neck of the catenoid";
    }
}

TEST(ProgramMembrane, CtrlCKeepsTheFinishedSteps) {
    const Scratch scratch;
    const Outcome outcome =
        run_beltrami(Arguments{"membrane", "shape:icosphere:6", "--step", "1e-4", "--steps", "100000",
                               "--series", scratch / "m.pvd", "-o", scratch / "out.ply"} +
                         upper,
                     scratch / "m_0002.vtu");
    EXPECT_EQ(outcome.status, 130) << outcome.err;
    EXPECT_NE(outcome.err.find("are readable"), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(scratch / "out.ply"));
    EXPECT_EQ(read_mesh(scratch / "m_0002.vtu").vertex_count(), 40962);
}

TEST(ProgramInterpolate, MovesTheMeshByDisplacements) {
    const Scratch scratch;
    ASSERT_EQ(run_beltrami({"interpolate", "shape:grid:20x20", "--fix", "0=0,0,0", "--fix", "20=0,0,0",
                            "--fix", "420=0,0,0", "--fix", "220=0,0,0.5", "--bilaplacian", "1", "--displace",
                            "-o", scratch / "out.ply", "--picture", scratch / "p.png"})
                  .status,
              0);
    const Mesh moved = read_mesh(scratch / "out.ply");
    EXPECT_EQ(moved.points()(220, 2), 0.5);
    EXPECT_EQ(moved.field("displacement").values(220, 2), 0.5);
}

TEST(ProgramInterpolate, WritesColoursThatViewersShow) {
    const Scratch scratch;
    const Arguments paint = {"interpolate",
                             "shape:grid:20x20",
                             "--fix",
                             "90=255,0,0",
                             "--fix",
                             "100=0,255,0",
                             "--fix",
                             "350=0,0,51",
                             "--colours",
                             "255",
                             "--bilaplacian",
                             "1",
                             "--summary",
                             scratch / "s.json",
                             "-o",
                             scratch / "out.ply",
                             "--picture",
                             scratch / "p.png"};
    const Outcome outcome = run_beltrami(paint);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("overshot the range of colours"), std::string::npos) << outcome.err;
    EXPECT_GT(read_json(scratch / "s.json")["result"]["clamped_vertices"], 0);
    EXPECT_NE(bytes_of(scratch / "out.ply").find("property uchar red"), std::string::npos);
    const Block colour = read_mesh(scratch / "out.ply").field("color").values;
    EXPECT_EQ(colour.row(90), Eigen::RowVector3d(1, 0, 0));
    EXPECT_NEAR(colour(350, 2), 0.2, 1e-9);
    const Outcome bounded = run_beltrami(paint + Arguments{"--bounded"});
    ASSERT_EQ(bounded.status, 0) << bounded.err;
    EXPECT_EQ(bounded.err.find("overshot"), std::string::npos) << bounded.err;
    EXPECT_EQ(read_json(scratch / "s.json")["result"]["clamped_vertices"], 0);
    EXPECT_GT(read_json(scratch / "s.json")["result"]["at_bounds"], 0);
}

TEST(ProgramInterpolate, StaysWithinBounds) {
    const Scratch scratch;
    const auto range = [&](const Arguments& more) {
        const Outcome outcome =
            run_beltrami(Arguments{"interpolate", "shape:grid:30x30", "--fix", "470=4", "--fix", "480=8",
                                   "--fix", "0=5", "--bilaplacian", "1", "-o", scratch / "out.ply"} +
                         more);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        const Block value = read_mesh(scratch / "out.ply").field("value").values;
        return std::pair(value.minCoeff(), value.maxCoeff());
    };
    EXPECT_LT(range({}).first, 3.5);
    EXPECT_EQ(range({"--bounded"}), std::pair(4.0, 8.0));
    EXPECT_EQ(range({"--bounds", "3.5,9"}).first, 3.5);
}

TEST(ProgramFair, RefusesBadRegionsAndOptions) {
    const Scratch scratch;
    write_text(scratch / "empty.csv", "vertex\n");
    write_text(scratch / "words.csv", "1\ntwo\n");
    write_text(scratch / "half.csv", "1.5\n2.5\n");
    write_text(scratch / "far.csv", "1\n642\n");
    write_text(scratch / "negative.csv", "-1\n");
    write_mesh(scratch / "in.ply", shapes::icosphere(3), {{"nothing", Block::Zero(642, 1)}});
    std::vector<Arguments> refused;
    for (const char* command : {"fair", "membrane"}) {
        for (const Arguments& region : std::vector<Arguments>{{},
                                                              {"--box", "5,5,5,6,6,6"},
                                                              {"--box", "1,1,1,0,0,0"},
                                                              {"--box", "nan,0,0,1,1,1"},
                                                              {"--box", "0,0,0,1,1"},
                                                              {"--box", "-2,-2,-2,2,2,2"},
                                                              {"--region-file", scratch / "empty.csv"},
                                                              {"--region-file", scratch / "words.csv"},
                                                              {"--region-file", scratch / "half.csv"},
                                                              {"--region-file", scratch / "far.csv"},
                                                              {"--region-file", scratch / "negative.csv"},
                                                              {"--region-file", scratch / "missing.csv"},
                                                              {"--region-field", "nothing"},
                                                              {"--region-field", "missing"},
                                                              upper + Arguments{"--region-field", "nothing"},
                                                              upper + Arguments{"--steps", "0"},
                                                              upper + Arguments{"--every", "0"},
                                                              upper + Arguments{"--tolerance", "0"}}) {
            refused.push_back(Arguments{command, scratch / "in.ply"} + region);
        }
    }
    for (const Arguments& options : std::vector<Arguments>{{"--time", "0"},
                                                           {"--time", "-1"},
                                                           {"--time", "nan"},
                                                           {"--time", "1", "--steps", "-3"},
                                                           {"--steps", "3"},
                                                           {"--series", scratch / "f.pvd"},
                                                           {"--laplacian", "0", "--bilaplacian", "0"},
                                                           {"--laplacian", "-1"},
                                                           {"--bilaplacian", "inf"}}) {
        refused.push_back(Arguments{"fair", sphere} + upper + options);
    }
    refused.push_back({"fair", sphere, "--all"});
    refused.push_back({"fair", "shape:nothing", "--all", "--time", "1"});
    for (const Arguments& options :
         std::vector<Arguments>{{"--step", "0"}, {"--step", "-1"}, {"--weights", "magic"}})
        refused.push_back(Arguments{"membrane", sphere} + upper + options);
    refused.push_back({"membrane", sphere, "--fix-boundary"});
    refused.push_back({"membrane", "shape:grid:1x1", "--fix-boundary"});
    refused.push_back(Arguments{"membrane", "shape:tetrahedral-ball:3"} + upper);
    for (const Arguments& options :
         std::vector<Arguments>{{"--fix", "1=2", "--displace"},
                                {"--fix", "1=2", "--colours", "1"},
                                {"--fix", "1=0,0,2", "--colours", "1"},
                                {"--fix", "1=0,0,1", "--colours", "7"},
                                {"--fix", "1=0,0,1", "--colours", "1", "--displace"},
                                {"--fix", "1=2", "--bounds", "3,4"},
                                {"--fix", "1=2", "--bounds", "4,1"},
                                {"--fix", "1=2", "--bounds", "1"}}) {
        refused.push_back(Arguments{"interpolate", sphere} + options);
    }
    for (const Arguments& arguments : refused)
        expect_refused(scratch, arguments);
}

TEST(ProgramFair, SaysWhichVerticesOfTheRegionStay) {
    const Scratch scratch;
    write_text(scratch / "in.obj",
               "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.4 0.4 1\nv 0 0 2\n"
               "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
    for (const char* command : {"fair", "membrane"}) {
        const Outcome outcome = run_beltrami({command, scratch / "in.obj", "--box", "-1,-1,0.5,2,2,3", "-o",
                                              scratch / "out.ply", "--summary", scratch / "s.json"});
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_NE(outcome.err.find("1 isolated vertices of the region stay"), std::string::npos)
            << outcome.err;
        EXPECT_EQ(read_json(scratch / "s.json")["result"]["stayed"], 1);
        EXPECT_LT(read_mesh(scratch / "out.ply").points()(4, 2), 0.1);
        EXPECT_EQ(read_mesh(scratch / "out.ply").points()(5, 2), 2.0);
    }
}

// Every real mesh, its upper half free: a finite result or a clear sentence.
TEST(ProgramFair, EveryRealMeshEndsWell) {
    const fs::path folder = shared_mesh("");
    BELTRAMI_SKIP_WITHOUT(folder);
    const Scratch scratch;
    int solved = 0;
    int file_count = 0;
    for (const fs::path& file : shared_meshes()) {
        if (fs::file_size(file) > BELTRAMI_LARGEST_MESH) continue;
        ++file_count;
        const Points points = read_mesh(file).points();
        const Eigen::RowVector3d lower = points.colwise().minCoeff();
        const Eigen::RowVector3d higher = points.colwise().maxCoeff();
        Eigen::Index longest = 0;
        (higher - lower).maxCoeff(&longest);
        Eigen::RowVector3d from = lower;
        from[longest] = 0.5 * (lower[longest] + higher[longest]) + 1e-6 * (higher - lower)[longest];
        const std::string box = fmt::format("--box={},{},{},{},{},{}", from[0], from[1], from[2], higher[0],
                                            higher[1], higher[2]);
        const fs::path out = scratch / "out.ply";
        for (const Arguments& command : std::vector<Arguments>{
                 {"fair", file, "--bilaplacian", "1"},
                 {"fair", file, "--bilaplacian", "1", "--laplacian", "1", "--time", "1e-4"},
                 {"membrane", file, "--steps", "2"},
                 {"membrane", file, "--steps", "2", "--weights", "cotangent"}}) {
            fs::remove(out);
            const Outcome outcome =
                run_beltrami(command + Arguments{box, "--free-components", "keep", "-o", out});
            if (outcome.status == 0) {
                EXPECT_TRUE(read_mesh(out).points().allFinite()) << file;
                ++solved;
            } else {
                EXPECT_TRUE(outcome.status == 2 || outcome.status == 3)
                    << file << outcome.status << outcome.err;
                EXPECT_TRUE(contains(outcome.err, {"error: ", "hint: "})) << file << outcome.err;
                EXPECT_FALSE(fs::exists(out)) << file;
            }
        }
    }
    EXPECT_GT(solved, file_count * 3);
}

}  // namespace
}  // namespace beltrami::testing
