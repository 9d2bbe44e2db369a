// The commands harmonics and filter.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "expect_text.hpp"
#include "meshes.hpp"
#include "numerics.hpp"
#include "process.hpp"

namespace beltrami::testing {
namespace {

namespace fs = std::filesystem;
const std::string bumpy = "shape:bumpy-sphere:2000";

Outcome harmonics(const fs::path& basis, const Arguments& more, const std::string& mesh = bumpy) {
    return run_beltrami(Arguments{"harmonics", mesh, "-o", basis} + more);
}

TEST(ProgramHarmonics, WritesACertifiedBasis) {
    const Scratch scratch;
    const Outcome outcome =
        harmonics(scratch / "b", {"-k", "90", "--summary", scratch / "s.json", "--band", "40"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.out, {"needs", "spectrum", "90 pairs", "complete", "wrote"}));
    const auto manifest = read_json(scratch / "b/manifest.json");
    EXPECT_TRUE(manifest["certificate"]["complete"]);
    EXPECT_LE(manifest["certificate"]["max_residual"], 1e-8);
    EXPECT_LE(manifest["certificate"]["max_orthogonality_error"], 1e-8);
    EXPECT_EQ(manifest["pairs"], 90);
    Index pairs = 0;
    for (const auto& band : manifest["certificate"]["bands"]) {
        EXPECT_EQ(band["inertia_upper"].get<Index>() - band["inertia_lower"].get<Index>(), band["found"]);
        EXPECT_EQ(band["inertia_lower"], pairs);
        pairs += band["found"].get<Index>();
    }
    const auto summary = read_json(scratch / "s.json");
    EXPECT_EQ(summary["result"]["spectrum"]["certificate"]["complete"], true);
    EXPECT_EQ(summary["result"]["spectrum"]["method"], "bands");
    const StoredBasis basis(scratch / "b");
    EXPECT_NO_THROW(basis.check(shapes::bumpy_sphere(2000)));
    EXPECT_NEAR(basis.eigenvalues()[0], 0.0, 1e-12);
}

TEST(ProgramHarmonics, ACutoffMethodsAndBoundaries) {
    const Scratch scratch;
    ASSERT_EQ(harmonics(scratch / "c", {"--cutoff", "25e"}).status, 0);
    const StoredBasis cut(scratch / "c");
    EXPECT_NEAR(cutoff_frequency(cut), frequency_of_edges(cut.mean_edge(), 25.0), 1e-9);
    ASSERT_EQ(harmonics(scratch / "f", {"-k", "642", "--method", "full"}, "shape:icosphere:3").status, 0);
    EXPECT_EQ(StoredBasis(scratch / "f").count(), 642);
    ASSERT_EQ(harmonics(scratch / "d", {"-k", "20", "--hold-boundary", "--mass", "consistent", "--float"},
                        "shape:grid:20x20")
                  .status,
              0);
    const StoredBasis held(scratch / "d");
    EXPECT_EQ(held.zero_modes(), 0);
    EXPECT_EQ(held.bands()[0].type(), NpyType::float32);
    for (const char* kind : {"combinatorial", "cotangent", "weighted", "symmetrized"}) {
        ASSERT_EQ(harmonics(scratch / kind, {"-k", "20", "--laplacian", kind}).status, 0) << kind;
        EXPECT_TRUE(StoredBasis(scratch / kind).complete());
    }
}

TEST(ProgramHarmonics, TheHierarchicalMethod) {
    const Scratch scratch;
    const Arguments request = {"-k", "20", "--method", "hierarchical", "--tolerance", "1e-3"};
    ASSERT_EQ(harmonics(scratch / "h", request + Arguments{"--summary", scratch / "s.json"}).status, 0);
    EXPECT_EQ(read_json(scratch / "s.json")["result"]["spectrum"]["method"], "hierarchical");
    ASSERT_EQ(harmonics(scratch / "b", {"-k", "20", "--method", "bands"}).status, 0);
    const StoredBasis found(scratch / "h");
    EXPECT_TRUE(found.complete());
    EXPECT_LT(relative_difference(found.eigenvalues(), StoredBasis(scratch / "b").eigenvalues()), 1e-4);
    // It cannot start in the middle of a spectrum.
    expect_refused(scratch,
                   {"filter", bumpy, "--limited-memory", "--filter", "band:4,5", "--method", "hierarchical"},
                   {"lowest pairs", "bands"});
}

TEST(ProgramHarmonics, DrawsAFunction) {
    const Scratch scratch;
    const std::string picture = scratch / "p.png";
    ASSERT_EQ(harmonics(scratch / "b",
                        {"-k", "12", "--picture", picture, "--show", "5", "--summary", scratch / "s.json"})
                  .status,
              0);
    EXPECT_GT(fs::file_size(picture), 1000U);
    const auto field = read_json(scratch / "s.json")["result"]["fields"]["function-5"];
    EXPECT_EQ(field["max"][0], StoredBasis(scratch / "b").function(5).maxCoeff());
    const Outcome refused = harmonics(scratch / "r", {"-k", "12", "--picture", picture, "--show", "12"});
    EXPECT_EQ(refused.status, 2);
    EXPECT_TRUE(contains(refused.err, {"--show 12", "12 functions"}));
    EXPECT_FALSE(fs::exists(scratch / "r"));
}

TEST(ProgramHarmonics, MemoryDoesNotGrowWithPairs) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the sanitizer keeps what is freed";
#endif
    const Scratch scratch;
    const auto peak = [&](const std::string& count) {
        const Outcome outcome = harmonics(
            scratch / count, {"-k", count, "--band", "40", "--summary", scratch / "s.json", "--threads", "1"},
            "shape:bumpy-sphere:10000");
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return read_json(scratch / "s.json")["peak_memory_bytes"].get<double>();
    };
    // 480 more functions take 38 MB on disk.
    EXPECT_LT(peak("600") - peak("120"), 8e6);
}

TEST(ProgramHarmonics, DirtyMeshesEndWell) {
    const Scratch scratch;
    // A triangle without area, a vertex in no cell, and two pieces.
    write_text(scratch / "in.obj",
               "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 5 5 5\nv 3 0 0\nv 4 0 0\nv 3 1 0\nv 2 0 0\n"
               "f 1 2 3\nf 2 4 3\nf 6 7 8\nf 1 2 9\n");
    const Outcome outcome = harmonics(scratch / "b", {"-k", "5"}, scratch / "in.obj");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, {"no area", "isolated"}));
    const StoredBasis basis(scratch / "b");
    EXPECT_EQ(basis.zero_modes(), 2);
    for (Index k = 0; k < 5; ++k)
        EXPECT_EQ(basis.function(k)[4], 0.0);
}

TEST(ProgramHarmonics, RefusesWithASentence) {
    const Scratch scratch;
    const auto refused = [&](const Arguments& more, std::initializer_list<std::string> parts,
                             const std::string& mesh = bumpy) {
        const Outcome outcome = harmonics(scratch / "r", more, mesh);
        EXPECT_EQ(outcome.status, 2) << outcome.out;
        EXPECT_TRUE(contains(outcome.err, {"error: ", "hint: "})) << outcome.err;
        EXPECT_TRUE(contains(outcome.err, parts)) << outcome.err;
        EXPECT_FALSE(fs::exists(scratch / "r"));
    };
    refused({}, {"-k"});
    refused({"-k", "0"}, {"-k"});
    refused({"-k", "163"}, {"162"}, "shape:icosphere:2");
    refused({"--cutoff", "-3"}, {"cutoff"});
    refused({"--cutoff", "abc"}, {"abc"});
    refused({"-k", "5", "--memory", "lots"}, {"--memory"});
    refused({"-k", "5", "--hold-boundary"}, {"boundary"});
    refused({"-k", "5", "--hold", "99999"}, {"99999"});
    refused({"-k", "5", "--mass", "consistent", "--laplacian", "cotangent"}, {"consistent"});
    ASSERT_EQ(harmonics(scratch / "b", {"-k", "5"}).status, 0);
    EXPECT_TRUE(contains(harmonics(scratch / "b", {"-k", "5"}).err, {"--resume"}));
    const Outcome other = harmonics(scratch / "b", {"-k", "9", "--resume"}, "shape:icosphere:3");
    EXPECT_EQ(other.status, 2);
    EXPECT_TRUE(contains(other.err, {"another mesh"}));
    const Outcome done = harmonics(scratch / "b", {"-k", "5", "--resume"});
    EXPECT_EQ(done.status, 0);
    EXPECT_TRUE(contains(done.out, {"complete already"}));
    // What cannot be certified is an error, and nothing is left that looks like a basis.
    const Outcome failed = harmonics(scratch / "t", {"-k", "30", "--tolerance", "1e-18"});
    EXPECT_EQ(failed.status, 3) << failed.out;
    EXPECT_FALSE(fs::exists(scratch / "t/manifest.json"));
}

TEST(ProgramHarmonics, CtrlCKeepsFinishedBands) {
    const Scratch scratch;
    const Arguments many = {"harmonics", "shape:bumpy-sphere:20000", "-k", "600", "-o", scratch / "b"};
    const Outcome stopped = run_beltrami(many, scratch / "b/manifest.json");
    EXPECT_EQ(stopped.status, 130) << stopped.out << stopped.err;
    EXPECT_TRUE(contains(stopped.err, {"--resume"}));
    const StoredBasis basis(scratch / "b");
    EXPECT_GT(basis.count(), 0);
    EXPECT_FALSE(basis.complete());
}

// Twenty times at a random moment, until it is done: the same basis as of a run that nobody stopped.
// The same eigenvalues, and each function in the span of those with nearly the same one.
void expect_same_basis(const fs::path& folder, const StoredBasis& whole) {
    const StoredBasis basis(folder);
    const Index count = whole.count();
    ASSERT_EQ(basis.count(), count);
    EXPECT_TRUE(basis.complete());
    const Vector& values = whole.eigenvalues();
    EXPECT_LT((basis.eigenvalues() - values).cwiseAbs().maxCoeff(), 1e-8 * values[count - 1]);
    const Columns H = inverse_transform(whole, Block::Identity(count, count));
    const Columns G = inverse_transform(basis, Block::Identity(count, count));
    const Columns parts = H.transpose() * whole.mass().asDiagonal() * G;
    for (Index k = 0; k < count; ++k) {
        double outside = 0.0;
        for (Index j = 0; j < count; ++j)
            outside += std::abs(values[j] - values[k]) > 1e-3 * values[k] ? parts(j, k) * parts(j, k) : 0.0;
        EXPECT_LT(std::sqrt(outside), 1e-8) << k;
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        EXPECT_NE(entry.path().extension(), ".part");
}

TEST(ProgramHarmonics, SurvivesBeingKilledTwentyTimes) {
    const Scratch scratch;
    const int kills = BELTRAMI_LARGEST_LOCAL_MESH < 10000 ? 4 : 20;  // the sanitizers are ten times slower
    const std::string mesh = "shape:bumpy-sphere:3000";
    const Arguments request = {"-k", "300", "--band", "20"};
    const auto start = std::chrono::steady_clock::now();
    ASSERT_EQ(harmonics(scratch / "whole", request, mesh).status, 0);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const StoredBasis whole(scratch / "whole");
    std::mt19937 engine(11);
    Index landed = 0;
    int finished = 0;
    const auto folder = [&] { return scratch / fmt::format("b{}", finished); };
    std::vector<fs::file_time_type> times;
    for (int killed = 0; killed < kills;) {
        const double moment = seconds * (0.05 + 0.3 * (engine() / 4294967295.0));
        if (!kill_beltrami_after(moment,
                                 Arguments{"harmonics", mesh, "-o", folder(), "--resume"} + request)) {
            expect_same_basis(folder(), whole);
            ++finished;
            landed = 0;
            times.clear();
            continue;
        }
        ++killed;
        if (!fs::exists(fs::path(folder()) / "manifest.json")) continue;
        const StoredBasis basis(folder());
        EXPECT_GE(basis.count(), landed);
        landed = basis.count();
        // Nothing is computed again: bands that have landed stay as they are.
        for (std::size_t band = 0; band < basis.bands().size(); ++band) {
            const auto time = fs::last_write_time(fs::path(folder()) / fmt::format("band-{:05}.npy", band));
            if (band < times.size()) {
                EXPECT_EQ(time, times[band]);
            } else {
                times.push_back(time);
            }
        }
    }
    ASSERT_EQ(harmonics(folder(), request + Arguments{"--resume"}, mesh).status, 0);
    expect_same_basis(folder(), whole);
}

TEST(ProgramFilter, FiltersWithABasisAndWithout) {
    const Scratch scratch;
    ASSERT_EQ(harmonics(scratch / "b", {"--cutoff", "9"}).status, 0);
    const auto filtered_points = [&](const Arguments& more) {
        const Outcome outcome =
            run_beltrami(Arguments{"filter", bumpy, "-o", scratch / "out.ply", "--picture", scratch / "p.png",
                                   "--summary", scratch / "s.json"} +
                         more);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_GT(fs::file_size(scratch / "p.png"), 1000U);
        return read_mesh(scratch / "out.ply").points();
    };
    const Points before = shapes::bumpy_sphere(2000).points();
    const Arguments with = {"--basis", scratch / "b"};
    EXPECT_EQ(filtered_points(with + Arguments{"--filter", "identity"}), before);
    for (const char* filter : {"low-pass:4,5", "exaggerate:3,6,2", "notch:40e,25e", "curve:0=1,5=0.5,12=0"}) {
        const Points stored = filtered_points(with + Arguments{"--filter", filter});
        EXPECT_NE(stored, before);
        const Points limited = filtered_points({"--limited-memory", "--cutoff", "9", "--filter", filter});
        EXPECT_LT((stored - limited).cwiseAbs().maxCoeff(), 1e-8) << filter;
        EXPECT_GT(read_json(scratch / "s.json")["result"]["pairs"], 0);
    }
    EXPECT_GT(filtered_points(with + Arguments{"--filter", "low-pass:#30"}).norm(), 1.0);
}

TEST(ProgramFilter, FiltersNormalsColoursAndFields) {
    const Scratch scratch;
    const Mesh mesh = shapes::bumpy_sphere(1000);
    const Block height = mesh.points().col(2);
    write_mesh(scratch / "in.ply", mesh,
               {{"height", height}, {"color", (mesh.points().array() * 0.4 + 0.5).matrix()}});
    ASSERT_EQ(harmonics(scratch / "b", {"-k", "100"}, scratch / "in.ply").status, 0);
    const auto field = [&](const std::string& on, const std::string& name) {
        const Outcome outcome =
            run_beltrami({"filter", scratch / "in.ply", "--basis", scratch / "b", "--filter", "low-pass:2,3",
                          "--on", on, "-o", scratch / "out.ply"});
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        const Mesh out = read_mesh(scratch / "out.ply");
        EXPECT_EQ(out.points(), mesh.points());
        return out.field(name).values;
    };
    EXPECT_LT((field("normals", "normal").rowwise().norm().array() - 1.0).abs().maxCoeff(), 1e-5);
    const Block colours = field("colors", "color");
    EXPECT_GE(colours.minCoeff(), 0.0);
    EXPECT_LE(colours.maxCoeff(), 1.0);
    const Block smooth = field("height", "height");
    EXPECT_GT((smooth - height).cwiseAbs().maxCoeff(), 0.01);
    EXPECT_LT((smooth - height).cwiseAbs().maxCoeff(), 0.5);
    expect_refused(
        scratch,
        {"filter", scratch / "in.ply", "--basis", scratch / "b", "--filter", "low-pass:2", "--on", "mood"},
        {"mood"});
}

TEST(ProgramFilter, RefusesWithASentence) {
    const Scratch scratch;
    ASSERT_EQ(harmonics(scratch / "b", {"-k", "20"}).status, 0);
    const Arguments with = {"filter", bumpy, "--basis", scratch / "b", "--filter"};
    for (const char* filter :
         {"smooth", "low-pass", "low-pass:", "low-pass:x", "low-pass:5,4", "band:3", "curve:1,2",
          "low-pass:#20", "low-pass:#-1", "enhance:1,2", "low-pass:0e", "notch:3,3"}) {
        expect_refused(scratch, with + Arguments{filter});
    }
    expect_refused(scratch, {"filter", bumpy, "--filter", "low-pass:3"}, {"--basis"});
    expect_refused(scratch, {"filter", bumpy, "--basis", scratch / "none", "--filter", "low-pass:3"},
                   {"none"});
    expect_refused(scratch,
                   {"filter", "shape:icosphere:3", "--basis", scratch / "b", "--filter", "low-pass:3"},
                   {"another mesh"});
    expect_refused(scratch, {"filter", bumpy, "--limited-memory", "--filter", "low-pass:#3"}, {"#3"});
    fs::resize_file(scratch / "b/band-00000.npy", 1000);
    expect_refused(scratch, with + Arguments{"low-pass:3"}, {"band-00000.npy"});
}

}  // namespace
}  // namespace beltrami::testing
