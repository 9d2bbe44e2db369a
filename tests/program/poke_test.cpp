// The command poke, run as a person runs it.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "meshes.hpp"
#include "process.hpp"

namespace beltrami::testing {
namespace {

namespace fs = std::filesystem;

std::string path_file(const Scratch& scratch, const std::string& name, const std::string& text) {
    write_text(scratch / name, text);
    return scratch / name;
}

std::vector<std::vector<std::string>> csv(const fs::path& path) {
    std::vector<std::vector<std::string>> rows;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        rows.emplace_back();
        std::size_t begin = 0;
        for (std::size_t comma = 0; comma != std::string::npos; begin = comma + 1) {
            comma = line.find(',', begin);
            rows.back().push_back(line.substr(begin, comma - begin));
        }
    }
    return rows;
}

TEST(PokeCommand, LogsEveryStepAndWritesWhatItSays) {
    const Scratch scratch;
    const std::string path = path_file(
        scratch, "p.csv",
        "time,x,y,z,dx,dy,dz\n# down\n0,0,0,1,0,0,0\n0.02,0,0,1,0,0,-0.05\n0.05,0.1,0,0.99,0,0,-0.05\n");
    const std::string other = path_file(scratch, "q.csv", "0.01,7,0.01,0,0\n0.03,7,0.02,0,0\n");
    const Outcome outcome =
        run_beltrami({"poke", "shape:icosphere:4", "--path", path, "--path", other, "-o", scratch / "out.ply",
                      "--log", scratch / "log.csv", "--series", scratch / "s.pvd", "--every", "10",
                      "--picture", scratch / "p.png", "--summary", scratch / "s.json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto json = read_json(scratch / "s.json");
    const auto log = csv(scratch / "log.csv");
    ASSERT_GT(log.size(), 50U);
    EXPECT_EQ(static_cast<int>(log.size()) - 1, json["result"]["steps"].get<int>());
    EXPECT_EQ(log[0][0], "step");
    for (const auto& row : log)
        ASSERT_EQ(row.size(), log[0].size());
    const auto column = [&](const std::string& name) {
        return static_cast<std::size_t>(std::find(log[0].begin(), log[0].end(), name) - log[0].begin());
    };
    double most = 0.0;
    for (std::size_t i = 1; i < log.size(); ++i)
        most = std::max(most, std::stod(log[i][column("active")]));
    EXPECT_EQ(most, json["result"]["most_active"].get<double>());
    EXPECT_EQ(log[5][column("touching_1")], "0");
    EXPECT_EQ(log[20][column("touching_1")], "1");
    EXPECT_LT(std::stod(log[30][column("fz_0")]), 0.0);
    EXPECT_TRUE(json["result"]["at_rest"].get<bool>());
    const Mesh pressed = read_mesh(scratch / "s_0003.vtu");  // at 0.03
    EXPECT_LT(pressed.field("displacement").values.col(2).minCoeff(), -0.045);
    EXPECT_EQ(pressed.field("domain").values.maxCoeff(), 2.0);
    EXPECT_TRUE((pressed.points() - pressed.field("displacement").values)
                    .isApprox(shapes::icosphere(4).points(), 1e-12));
    EXPECT_GT(fs::file_size(scratch / "p.png"), 1000U);
    EXPECT_EQ(read_mesh(scratch / "out.ply").field("displacement").values.cwiseAbs().maxCoeff(), 0.0);
}

TEST(PokeCommand, RefusesBadInputAndWritesNothing) {
    const Scratch scratch;
    const std::string good = path_file(scratch, "good.csv", "0,3,0,0,0\n0.01,3,0,0,-0.05\n");
    const auto refused = [&](const std::string& text, const Arguments& more, const std::string& part) {
        const std::string path = text.empty() ? good : path_file(scratch, "bad.csv", text);
        expect_refused(
            scratch,
            Arguments{"poke", "shape:icosphere:3", "--path", path, "--log", scratch / "log.csv"} + more,
            {part});
        EXPECT_FALSE(fs::exists(scratch / "log.csv"));
    };
    refused("0,3,0,0,0\n0,3,0,0,-0.05\n", {}, "line 2, the time");
    refused("0.1,3,0,0,0\n0,3,0,0,-0.05\n", {}, "line 2, the time");
    refused("0,3,0,0,0\n0.1,0,0,3,0,0,-0.05\n", {}, "leaves the surface");
    refused("0,99999,0,0,0\n", {}, "vertex 99999");
    refused("0,1.5,0,0,0\n", {}, "vertex 1.5");
    refused("0,3,0,0\n", {}, "not a waypoint");
    refused("time,vertex\nnonsense\n", {}, "not a waypoint");
    refused("# nothing\n", {}, "no waypoints");
    refused("0,3,nan,0,0\n", {}, "");
    refused("0,3,1e200,0,0\n0.1,3,1e200,0,0\n", {}, "between 1e-100 and 1e100");
    refused("", {"--rate", "0"}, "rate");
    refused("", {"--rate", "-5"}, "rate");
    refused("", {"--rate", "1e10", "--real-time"}, "rate");
    refused("", {"--tolerance", "0"}, "tolerance");
    refused("", {"--gamma", "-1"}, "gamma");
    refused("", {"--density", "0"}, "mass");
    refused("", {"--every", "0"}, "--every");
    refused("", {"--time", "0"}, "time");
    refused("", {"--path", (scratch / "absent.csv").string()}, "cannot be read");
    // On a vertex without cells.
    Points points = shapes::icosphere(2).points();
    points.conservativeResize(points.rows() + 1, 3);
    points.row(points.rows() - 1) << 3, 3, 3;
    write_mesh(scratch / "isolated.ply", Mesh(points, shapes::icosphere(2).cells()));
    expect_refused(scratch,
                   {"poke", scratch / "isolated.ply", "--path",
                    path_file(scratch, "i.csv", fmt::format("0,{},0,0,0\n", points.rows() - 1))},
                   {"leaves the surface"});
    // Nothing to touch.
    expect_refused(scratch, {"poke", "shape:circle:30", "--path", good}, {"no surface"});
}

TEST(PokeCommand, CtrlCKeepsTheLogAndTheSeries) {
    const Scratch scratch;
    const std::string path = path_file(scratch, "p.csv", "0,3,0,0,0\n100,3,0,0,-0.05\n");
    const Outcome outcome =
        run_beltrami({"poke", "shape:icosphere:4", "--path", path, "--log", scratch / "log.csv", "--series",
                      scratch / "s.pvd", "-o", scratch / "out.ply"},
                     scratch / "s_0002.vtu");
    EXPECT_EQ(outcome.status, 130) << outcome.err;
    EXPECT_GT(csv(scratch / "log.csv").size(), 20U);
    EXPECT_TRUE(fs::exists(scratch / "s.pvd"));
    EXPECT_FALSE(fs::exists(scratch / "out.ply"));
}

TEST(PokeCommand, EveryRealSurfaceGivesWay) {
    const Scratch scratch;
    BELTRAMI_SKIP_WITHOUT(shared_mesh("bunny_3485.off"));
    for (const fs::path& file : shared_meshes()) {
        const Mesh mesh = read_mesh(file);
        if (mesh.vertex_count() > BELTRAMI_LARGEST_LOCAL_MESH) continue;
        Index v = mesh.vertex_count() / 3;
        if (mesh.kind() == CellKind::tetrahedron) v = boundary_vertices(mesh)[0];
        if (mesh.cell_count() > 0) {
            const Laplacian laplacian(mesh);
            while (laplacian.graph().degree(laplacian.order().working(v)) == 0)
                ++v;
        }
        const double depth =
            0.01 * (mesh.points().colwise().maxCoeff() - mesh.points().colwise().minCoeff()).norm();
        const std::string path =
            path_file(scratch, "p.csv", fmt::format("0,{0},0,0,0\n0.01,{0},0,0,{1}\n", v, -depth));
        const fs::path out = scratch / "out.ply";
        fs::remove(out);
        const Outcome outcome =
            run_beltrami({"poke", file, "--path", path, "--time", "0.02", "-o", out.string(), "--quiet"});
        if (outcome.status == 0) {
            EXPECT_TRUE(read_mesh(out).points().allFinite()) << file;
        } else {
            EXPECT_EQ(outcome.status, 2) << file << outcome.err;
            EXPECT_EQ(mesh.cell_count(), 0) << file << outcome.err;
        }
    }
}

}  // namespace
}  // namespace beltrami::testing
