// The command signature.

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "beltrami/beltrami.hpp"
#include "expect_text.hpp"
#include "meshes.hpp"
#include "process.hpp"

namespace beltrami::testing {
namespace {

namespace fs = std::filesystem;

/// A mesh with fields, its basis, and the command's first words.
struct Given {
    Scratch scratch;
    Mesh mesh = shapes::bumpy_sphere(400);
    fs::path in = scratch / "in.ply";
    fs::path out = scratch / "out.ply";
    fs::path basis = scratch / "b";

    explicit Given(int count = 60) {
        Block bump = (-4.0 * (mesh.points().col(0).array() - 1.0).square()).exp().matrix();
        write_mesh(in, mesh, {{"bump", bump}, {"direction", mesh.points()}});
        const Outcome outcome = run_beltrami({"harmonics", in, "-k", std::to_string(count), "-o", basis});
        EXPECT_EQ(outcome.status, 0) << outcome.err;
    }
    [[nodiscard]] Arguments command(const std::string& kind, const Arguments& more = {}) const {
        return Arguments{"signature", in, "--basis", basis, "--kind", kind} + more;
    }
    /// The mesh that the command wrote.
    [[nodiscard]] Mesh result(const std::string& kind, const Arguments& more = {}) const {
        const Outcome outcome =
            run_beltrami(command(kind, more) + Arguments{"-o", out, "--summary", scratch / "s.json"});
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return read_mesh(out);
    }
    [[nodiscard]] nlohmann::json summary() const { return read_json(scratch / "s.json")["result"]; }
};

double difference(const Block& a, const Block& b) {
    return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

TEST(ProgramSignature, HeatAndWaveKernels) {
    const Given given;
    const StoredBasis basis(given.basis);
    const Mesh hks = given.result("hks", {"--count", "7", "--picture", given.scratch / "p.png"});
    const Block expected = heat_kernel_signature(basis, heat_signature_times(basis, 7));
    for (const Index c : {0, 6})
        EXPECT_LT(difference(hks.field("hks_" + std::to_string(c)).values, expected.col(c)), 1e-12);
    EXPECT_EQ(hks.find_field("hks_7"), nullptr);
    EXPECT_EQ(given.summary()["times"].size(), 7u);
    EXPECT_GT(fs::file_size(given.scratch / "p.png"), 5000u);
    const Mesh scaled = given.result("hks", {"--times", "0.1,0.5", "--by-trace"});
    const Block by_trace = heat_kernel_signature(basis, Eigen::Vector2d(0.1, 0.5), true);
    EXPECT_LT(difference(scaled.field("hks_1").values, by_trace.col(1)), 1e-12);
    const Mesh wks = given.result("wks", {"--energies", "2,3,3.5,4", "--sigma", "0.3"});
    const Block wave = wave_kernel_signature(basis, {Eigen::Vector4d(2.0, 3.0, 3.5, 4.0), 0.3});
    EXPECT_LT(difference(wks.field("wks_2").values, wave.col(2)), 1e-12);
    EXPECT_EQ(given.summary()["sigma"], 0.3);
}

TEST(ProgramSignature, DistancesToTheNearest) {
    const Given given;
    const StoredBasis basis(given.basis);
    const Block both = given.result("biharmonic", {"--from", "3", "200"}).field("biharmonic").values;
    const Block expected = biharmonic_distance(basis, 3).cwiseMin(biharmonic_distance(basis, 200));
    EXPECT_LT(difference(both, expected), 1e-12);
    EXPECT_EQ(both(3, 0), 0.0);
    EXPECT_EQ(both(200, 0), 0.0);
    const Block diffusion = given.result("diffusion", {"--from", "3"}).field("diffusion").values;
    const Vector time = Vector::Constant(1, 1.0 / basis.eigenvalues()[1]);
    EXPECT_LT(difference(diffusion, diffusion_distance(basis, 3, time)), 1e-12);
    EXPECT_LT(difference(given.result("commute", {"--from", "3"}).field("commute").values,
                         commute_time_distance(basis, 3)),
              1e-12);
}

TEST(ProgramSignature, HeatAndWavesInTime) {
    const Given given;
    const StoredBasis basis(given.basis);
    const SpectralPropagation state(basis, read_mesh(given.in).field("bump").values);
    const Mesh heat = given.result("heat", {"--initial", "bump", "--times", "0,0.2"});
    EXPECT_LT(difference(heat.field("heat_1").values, state.heat(0.2)), 1e-9);
    EXPECT_LT(given.summary()["left_out"], 0.05);
    const Mesh wave = given.result("wave", {"--initial", "bump", "--times", "0.7"});
    EXPECT_LT(difference(wave.field("wave").values, state.wave(0.7)), 1e-9);
    // A vector field at rest, and one that moves from zero.
    EXPECT_EQ(given.result("heat", {"--initial", "direction", "--times", "0.1"}).field("heat").values.cols(),
              3);
    const Block moved = given.result("wave", {"--velocity", "bump", "--times", "0.001"}).field("wave").values;
    EXPECT_LT(difference(moved, 0.001 * state.heat(0.0)), 1e-3);
    const Outcome spike =
        run_beltrami(given.command("heat", {"--from", "5", "--times", "1", "-o", given.scratch / "x.ply"}));
    EXPECT_EQ(spike.status, 0);
    EXPECT_NE(spike.err.find("is not in the basis"), std::string::npos) << spike.err;
}

TEST(ProgramSignature, RefusesWhatCannotBe) {
    const Given given(5);
    const auto refused = [&](const std::string& kind, const Arguments& more, const std::string& part = {}) {
        expect_refused(given.scratch, given.command(kind, more), {part});
    };
    refused("magic", {});
    refused("hks", {"--from", "3"}, "--from does not go with --kind hks");
    refused("hks", {"--times", "1,x"}, "--times 1,x");
    refused("hks", {"--times", "-1"});
    refused("hks", {"--count", "0"});
    refused("hks", {"--count", "3", "--times", "1"});
    refused("hks", {"--energies", "1"});
    refused("wks", {"--sigma", "0"});
    refused("wks", {"--by-trace"});
    refused("diffusion", {}, "--from");
    refused("biharmonic", {"--from", "400"}, "400");
    refused("biharmonic", {"--from", "-1"});
    refused("biharmonic", {"--from", "1", "--times", "1"});
    refused("heat", {"--from", "1"}, "--times");
    refused("heat", {"--times", "1"}, "--initial");
    refused("heat", {"--times", "1", "--initial", "bump", "--from", "1"});
    refused("heat", {"--times", "1", "--initial", "missing"}, "missing");
    refused("heat", {"--times", "1", "--initial", "bump", "--velocity", "bump"});
    refused("wave", {"--times", "1", "--initial", "bump", "--velocity", "direction"});
    refused("wave", {"--times", "inf", "--initial", "bump"});
    expect_refused(given.scratch, {"signature", "shape:icosphere:2", "--basis", given.basis, "--kind", "hks"},
                   {"another mesh"});
}

}  // namespace
}  // namespace beltrami::testing
