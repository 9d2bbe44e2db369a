// The viewer's session without a server: requests in, messages out, against the library's own functions.

#include "view/session.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <deque>
#include <fstream>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <random>
#include <sstream>
#include <thread>

#include "beltrami/beltrami.hpp"
#include "meshes.hpp"

namespace beltrami::view {
namespace {

using nlohmann::json;
using testing::Scratch;

struct Message {
    json header;
    std::string arrays;

    [[nodiscard]] std::vector<float> floats(const std::string& name) const {
        return array<float>(name, "f32");
    }
    [[nodiscard]] std::vector<std::uint32_t> numbers(const std::string& name) const {
        return array<std::uint32_t>(name, "u32");
    }

  private:
    template <class Number>
    [[nodiscard]] std::vector<Number> array(const std::string& name, const std::string& type) const {
        const json& place = header.at("arrays").at(name);
        EXPECT_EQ(place.at("type"), type);
        std::vector<Number> list(place.at("count").get<std::size_t>());
        const auto at = place.at("at").get<std::size_t>();
        EXPECT_EQ(at % 4, 0U);
        EXPECT_LE(at + list.size() * sizeof(Number), arrays.size());
        if (!list.empty()) std::memcpy(list.data(), arrays.data() + at, list.size() * sizeof(Number));
        return list;
    }
};

Message decoded(const Outgoing& outgoing) {
    const std::string& bytes = *outgoing.bytes;
    if (!outgoing.binary) return {json::parse(bytes), {}};
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data(), sizeof length);
    EXPECT_EQ(length % 4, 0U);
    return {json::parse(bytes.substr(4, length)), bytes.substr(4 + length)};
}

std::optional<Laplacian> laplacian_of(const Mesh& mesh) {
    if (mesh.kind() == CellKind::point) return std::nullopt;
    return Laplacian(mesh);
}

// A session with one page, which waits for what it is told. A second one can be opened by its number; messages to it alone
// are counted, and no more.
class Page {
  public:
    explicit Page(const Mesh& mesh, const std::string& argument = "mesh.obj",
                  std::size_t most_bytes_of_moments = SessionOptions{}.most_bytes_of_moments)
        : made_laplacian_(laplacian_of(mesh)),
          session_(mesh, report(mesh), made_laplacian_,
                   {.argument = argument,
                    .scratch = folder(),
                    .why_no_laplacian = "the mesh has no cells",
                    .most_bytes_of_moments = most_bytes_of_moments}) {
        session_.speak_through({[this](ClientId client, const Outgoing& message) {
                                    if (client == 1) take(message);
                                },
                                [this](const Outgoing& message) { take(message); }});
        handlers_ = session_.handlers();
        handlers_.opened(1);
    }

    void ask(const json& request, ClientId client = 1) { handlers_.text(client, request.dump()); }
    void ask_raw(const std::string& text) { handlers_.text(1, text); }
    void close(ClientId client = 1) { handlers_.closed(client); }
    void open(ClientId client = 1) { handlers_.opened(client); }
    std::optional<Download> file(const std::string& name) { return handlers_.file(name); }

    /// The next message of that kind that satisfies the condition, out of those that came since the last wait.
    Message wait(const std::string& kind, const std::function<bool(const Message&)>& wanted = {}) {
        std::unique_lock lock(mutex_);
        Message found;
        const bool came = changed_.wait_for(lock, std::chrono::seconds(60), [&] {
            while (!messages_.empty()) {
                Message message = std::move(messages_.front());
                messages_.pop_front();
                if (message.header["kind"] != kind || (wanted && !wanted(message))) continue;
                found = std::move(message);
                return true;
            }
            return false;
        });
        EXPECT_TRUE(came) << "no message " << kind;
        if (!came) throw std::runtime_error("no message " + kind);
        return found;
    }
    Message wait_for_id(const std::string& kind, long id) {
        return wait(kind, [id](const Message& m) { return m.header.at("id") == id; });
    }
    json state() {
        const long id = ++last_asked_;
        ask({{"do", "task"}, {"task", wait_state_task_}, {"id", id}});
        return wait_for_id("state", id).header;
    }
    /// The messages of that kind that came since the last wait.
    std::size_t count(const std::string& kind) {
        const std::lock_guard lock(mutex_);
        return static_cast<std::size_t>(std::count_if(
            messages_.begin(), messages_.end(), [&](const Message& m) { return m.header["kind"] == kind; }));
    }
    [[nodiscard]] const Laplacian& laplacian() const { return *made_laplacian_; }
    void turn_to(const std::string& task) {
        wait_state_task_ = task;
        ask({{"do", "task"}, {"task", task}});
    }

    Scratch scratch;

  private:
    std::filesystem::path folder() {
        std::filesystem::create_directories(scratch / "session");
        return scratch / "session";
    }
    void take(const Outgoing& outgoing) {
        {
            const std::lock_guard lock(mutex_);
            messages_.push_back(decoded(outgoing));
        }
        changed_.notify_all();
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Message> messages_;
    std::string wait_state_task_ = "look";
    long last_asked_ = 1'000'000'000;
    std::optional<Laplacian> made_laplacian_;
    ServerHandlers handlers_;
    Session session_;
};

void expect_near(const std::vector<float>& values, const Block& expected, double tolerance) {
    ASSERT_EQ(static_cast<Eigen::Index>(values.size()), expected.size());
    double worst = 0.0;
    for (Eigen::Index i = 0; i < expected.size(); ++i)
        worst = std::max(
            worst, std::abs(static_cast<double>(values[static_cast<std::size_t>(i)]) - expected.data()[i]));
    EXPECT_LE(worst, tolerance);
}

TEST(ViewSession, APageGetsTheMeshAndTheState) {
    const Mesh mesh = shapes::icosphere(2);
    Page page(mesh, "../meshes/bunny.obj");
    const Message sent = page.wait("mesh");
    EXPECT_EQ(sent.header["name"], "bunny.obj");
    EXPECT_EQ(sent.header["vertices"], mesh.vertex_count());
    expect_near(sent.floats("positions"), mesh.points(), 1e-7);
    EXPECT_EQ(sent.numbers("triangles").size(), static_cast<std::size_t>(3 * mesh.cell_count()));
    EXPECT_EQ(page.wait("state").header["task"], "look");
}

TEST(ViewSession, HeatIsWhatTheLibraryComputes) {
    const Mesh mesh = shapes::icosphere(3);
    Page page(mesh);
    page.turn_to("heat");
    page.ask({{"do", "heat.source"}, {"vertex", 7}, {"value", 50.0}});
    page.ask({{"do", "heat.set"}, {"time", 0.1}, {"steps", 5}});
    page.ask({{"do", "run"}, {"id", 12}});
    const Message last = page.wait("frame", [](const Message& m) { return m.header["step"] == 5; });
    EXPECT_EQ(last.header["id"], 12);
    const Block expected =
        heat(page.laplacian(), Block::Zero(mesh.vertex_count(), 1), {{7, 50.0}}, {.time = 0.1, .steps = 5}).u;
    expect_near(last.floats("values"), expected, 1e-5);
    EXPECT_EQ(page.wait("done").header["error"], "");
    const json state = page.state();
    EXPECT_EQ(state["heat"]["sources"], json::parse("[[7, 50.0]]"));
    EXPECT_EQ(state["command"][0], "beltrami heat mesh.obj --source 7=50 --time 0.1 --steps 5 -o heat.ply");
}

// The field of a file that was asked for, which has that name.
Block saved_field(Page& page, const json& request, const std::string& name, const std::string& field) {
    page.ask(request);
    EXPECT_EQ(page.wait("saved").header["name"], name);
    const auto file = page.file(name);
    if (!file) throw std::runtime_error("no file " + name);
    const std::filesystem::path path = page.scratch / name;
    std::ofstream(path, std::ios::binary) << file->body;
    return read_mesh(path).field(field).values;
}

TEST(ViewSession, AMomentOfASimulationIsSaved) {
    const Mesh mesh = shapes::icosphere(3);
    Page page(mesh);
    page.turn_to("heat");
    page.ask({{"do", "save"}, {"format", "ply"}, {"step", 2}});
    EXPECT_EQ(page.wait("refused").header["what"], "nothing was simulated yet");
    page.ask({{"do", "heat.source"}, {"vertex", 7}, {"value", 50.0}});
    page.ask({{"do", "heat.set"}, {"time", 0.1}, {"steps", 5}});
    page.ask({{"do", "run"}, {"id", 1}});
    page.wait("done");
    const auto after = [&](int steps) {
        return heat(page.laplacian(), Block::Zero(mesh.vertex_count(), 1), {{7, 50.0}},
                    {.time = 0.02 * steps, .steps = steps})
            .u;
    };
    const auto error = [](const Block& a, const Block& b) { return (a - b).cwiseAbs().maxCoeff(); };
    const json save = {{"do", "save"}, {"format", "ply"}};
    json moment = save;
    moment["step"] = 2;
    EXPECT_LE(error(saved_field(page, moment, "heat-2.ply", "u"), after(2)), 50.0 * 1e-7);
    moment["format"] = "vtu";
    EXPECT_LE(error(saved_field(page, moment, "heat-2.vtu", "u"), after(2)), 50.0 * 1e-7);
    moment["step"] = 0;
    EXPECT_EQ(saved_field(page, moment, "heat-0.vtu", "u").maxCoeff(), 50.0);
    // The last one is what the command line computes, to the last digit that a solve has.
    EXPECT_LE(error(saved_field(page, save, "heat.ply", "u"), after(5)), 50.0 * 1e-9);
    moment = save;
    moment["step"] = 5;
    EXPECT_LE(error(saved_field(page, moment, "heat.ply", "u"), after(5)), 50.0 * 1e-9);
    // What was placed has no moments.
    page.ask({{"do", "save"}, {"format", "csv"}, {"step", 2}});
    EXPECT_EQ(page.wait("saved").header["name"], "heat.csv");
    for (const json& wrong : std::vector<json>{-1, 2.5, "2", 10001, nullptr}) {
        page.ask({{"do", "save"}, {"format", "ply"}, {"step", wrong}});
        EXPECT_NE(page.wait("refused").header["what"].get<std::string>().find("'step'"), std::string::npos)
            << wrong;
    }
    page.ask({{"do", "save"}, {"format", "ply"}, {"step", 6}});
    EXPECT_EQ(page.wait("refused").header["what"], "the moment of step 6 is not kept");
}

// A page that gives up what `every` of each frame tells it to has only moments that can be saved.
TEST(ViewSession, AMomentThatAPageHasCanBeSavedHoweverManyThereWere) {
    const Mesh mesh = shapes::icosphere(1);
    Page page(mesh, "mesh.obj", 10'000);
    page.turn_to("wave");
    page.ask({{"do", "wave.impulse"}, {"vertex", 0}, {"value", 1.0}});
    page.ask({{"do", "wave.set"}, {"steps", 301}});
    page.ask({{"do", "run"}, {"id", 1}});
    std::map<int, std::vector<float>> kept;
    for (int step = 0; step < 301;) {
        const Message frame = page.wait("frame");
        step = frame.header["step"];
        const int every = frame.header["every"];
        std::erase_if(kept, [every](const auto& moment) { return moment.first % every != 0; });
        kept[step] = frame.floats("values");
    }
    page.wait("done");
    EXPECT_GE(kept.size(), 8U);
    EXPECT_LE(kept.size(), 24U);
    for (const auto& [step, values] : kept) {
        const std::string name = step == 301 ? "wave.ply" : fmt::format("wave-{}.ply", step);
        expect_near(values, saved_field(page, {{"do", "save"}, {"format", "ply"}, {"step", step}}, name, "u"),
                    step == 301 ? 1e-6 : 0.0);
    }
    page.ask({{"do", "save"}, {"format", "ply"}, {"step", 1}});
    EXPECT_EQ(page.wait("refused").header["what"], "the moment of step 1 is not kept");
    page.close();
    page.open();
    for (const auto& [step, values] : kept)
        EXPECT_EQ(page.wait("frame").header["step"], step);
}

TEST(ViewSession, ASimulationThatWasCancelledSavesTheStepThatItReached) {
    Page page(shapes::icosphere(3));
    page.turn_to("heat");
    page.ask({{"do", "heat.source"}, {"vertex", 0}, {"value", 1.0}});
    page.ask({{"do", "heat.set"}, {"steps", 10000}});
    page.ask({{"do", "run"}, {"id", 1}});
    page.wait("frame", [](const Message& m) { return m.header["step"] == 3; });
    page.ask({{"do", "cancel"}});
    page.wait_for_id("done", 1);
    page.ask({{"do", "save"}, {"format", "ply"}});
    const std::string name = page.wait("saved").header["name"];
    EXPECT_TRUE(name.starts_with("heat-") && name.ends_with(".ply")) << name;
}

TEST(ViewSession, ASimulationPausesResumesAndIsCancelled) {
    Page page(shapes::icosphere(3));
    page.turn_to("wave");
    page.ask({{"do", "wave.impulse"}, {"vertex", 0}, {"value", 1.0}});
    page.ask({{"do", "wave.set"}, {"steps", 10000}});
    page.ask({{"do", "run"}, {"id", 1}});
    page.wait("frame", [](const Message& m) { return m.header["step"] == 3; });
    page.ask({{"do", "pause"}});
    page.wait("state", [](const Message& m) {
        return m.header["running"].is_object() && m.header["running"]["paused"];
    });
    page.ask({{"do", "resume"}});
    page.wait("frame");
    page.ask({{"do", "pause"}});
    page.ask({{"do", "cancel"}});
    EXPECT_TRUE(page.wait_for_id("done", 1).header["cancelled"]);
    page.wait("state", [](const Message& m) { return m.header["running"].is_null(); });
}

TEST(ViewSession, PaintIsWhatTheLibraryComputesAndFollowsEveryChange) {
    const Mesh mesh = shapes::icosphere(3);
    Page page(mesh);
    page.turn_to("paint");
    page.ask({{"do", "paint.set"}, {"gamma_1", 1.0}, {"gamma_2", 0.02}, {"id", 1}});
    page.ask({{"do", "paint.fix"}, {"vertices", {0}}, {"value", {0.0}}, {"id", 2}});
    page.ask({{"do", "paint.fix"}, {"vertices", {100, 101}}, {"value", {2.0}}, {"id", 3}});
    Constraints fixed{{0, 0.0}, {100, 2.0}, {101, 2.0}};
    const InterpolateOptions options{.laplacian = 1.0, .bilaplacian = 0.02};
    expect_near(page.wait_for_id("frame", 3).floats("values"),
                interpolate(page.laplacian(), fixed, options).value, 1e-6);
    page.ask({{"do", "paint.fix"}, {"vertices", {101}}, {"value", nullptr}, {"id", 4}});
    fixed.free(101);
    expect_near(page.wait_for_id("frame", 4).floats("values"),
                interpolate(page.laplacian(), fixed, options).value, 1e-6);
    page.ask({{"do", "paint.set"}, {"gamma_2", 0.0}, {"id", 5}});
    expect_near(page.wait_for_id("frame", 5).floats("values"), interpolate(page.laplacian(), fixed, {}).value,
                1e-6);
    EXPECT_EQ(page.state()["command"][0],
              "beltrami interpolate mesh.obj --fix 0=0 --fix 100=2 --laplacian 1 --bilaplacian 0 "
              "--free-components keep -o "
              "paint.ply");
    page.ask({{"do", "clear"}, {"id", 6}});
    expect_near(page.wait_for_id("frame", 6).floats("values"), Block::Zero(mesh.vertex_count(), 1), 0.0);
}

TEST(ViewSession, DisplacementsAndColoursHaveConstraintsOfTheirOwn) {
    Page page(shapes::icosphere(2));
    page.turn_to("paint");
    page.ask({{"do", "paint.fix"}, {"vertices", {5}}, {"value", {1.0}}});
    page.ask({{"do", "paint.set"}, {"mode", "displacement"}});
    page.ask({{"do", "paint.fix"}, {"vertices", {3}}, {"value", {0.0, 0.0, 0.5}}, {"id", 9}});
    const Message frame = page.wait_for_id("frame", 9);
    EXPECT_EQ(frame.header["mode"], "displacement");
    EXPECT_FLOAT_EQ(frame.floats("values")[3 * 3 + 2], 0.5F);
    EXPECT_EQ(page.state()["paint"]["fixed"].size(), 1U);
    page.ask({{"do", "paint.set"}, {"mode", "colors"}});
    page.ask({{"do", "paint.fix"}, {"vertices", {3}}, {"value", {2.0, 0.0, 0.0}}});
    EXPECT_NE(page.wait("refused").header["what"].get<std::string>().find("colour"), std::string::npos);
    page.ask({{"do", "paint.set"}, {"mode", "scalar"}});
    EXPECT_EQ(page.state()["paint"]["fixed"], json::parse("[[5, 1.0]]"));
}

TEST(ViewSession, APokeGrowsADomainThatVanishesAfterRelease) {
    const Mesh mesh = shapes::icosphere(4);
    Page page(mesh);
    page.turn_to("poke");
    const Points& p = mesh.points();
    page.ask({{"do", "poke.hold"},
              {"point", {p(0, 0), p(0, 1), p(0, 2)}},
              {"displacement", {0.0, 0.0, -0.05}},
              {"id", 1}});
    const Message touched = page.wait("frame", [](const Message& m) { return m.header["active"] > 20; });
    EXPECT_TRUE(touched.header["force"].is_array());
    EXPECT_EQ(touched.floats("displacement").size(), 3 * touched.numbers("vertices").size());
    EXPECT_EQ(touched.numbers("level").size(), touched.numbers("vertices").size());
    page.ask({{"do", "poke.release"}, {"id", 2}});
    const Message rest = page.wait("frame", [](const Message& m) { return m.numbers("vertices").empty(); });
    EXPECT_TRUE(rest.header["force"].is_null());
    EXPECT_GE(page.state()["poke"]["waypoints"].get<int>(), 1);
    // Once more, on the same skin.
    page.ask({{"do", "poke.hold"},
              {"point", {p(9, 0), p(9, 1), p(9, 2)}},
              {"displacement", {0.02, 0.0, 0.0}},
              {"id", 3}});
    page.wait("frame", [](const Message& m) { return m.header["active"] > 20; });
    page.close();  // whoever held it is gone
    page.wait("frame", [](const Message& m) { return m.numbers("vertices").empty(); });
}

TEST(ViewSession, HarmonicsAreCertifiedShownAndFilter) {
    const Mesh mesh = shapes::icosphere(3);
    Page page(mesh);
    page.turn_to("harmonics");
    page.ask({{"do", "harmonics.show"}, {"k", 1}});
    EXPECT_EQ(page.wait("refused").header["hint"], "press Compute first");
    page.ask({{"do", "harmonics.compute"}, {"count", 50}, {"id", 1}});
    const Message spectrum = page.wait("spectrum");
    EXPECT_TRUE(spectrum.header["complete"]);
    ASSERT_EQ(spectrum.floats("frequencies").size(), 50U);
    EXPECT_NEAR(spectrum.floats("frequencies")[1], std::sqrt(2.0), 0.02);
    page.ask({{"do", "harmonics.show"}, {"k", 4}, {"id", 2}});
    EXPECT_EQ(page.wait_for_id("frame", 2).floats("values").size(),
              static_cast<std::size_t>(mesh.vertex_count()));
    const double cutoff = spectrum.header["cutoff"];
    page.ask({{"do", "harmonics.filter"},
              {"curve", {{0.5 * cutoff, 1.0}, {0.6 * cutoff, 0.0}}},
              {"on", "positions"},
              {"id", 3}});
    const Message smooth = page.wait_for_id("frame", 3);
    EXPECT_LT(smooth.header["roughness"], 1.0);
    EXPECT_EQ(smooth.floats("positions").size(), static_cast<std::size_t>(3 * mesh.vertex_count()));
    page.ask({{"do", "harmonics.filter"}, {"curve", {{0.0, 1.0}}}, {"on", "positions"}, {"id", 4}});
    expect_near(page.wait_for_id("frame", 4).floats("positions"), mesh.points(), 1e-6);
    page.ask({{"do", "harmonics.filter"}, {"curve", {{1.0, 1.0}}}, {"on", "colors"}});
    EXPECT_EQ(page.wait("refused").header["what"], "the mesh has no colours");
}

TEST(ViewSession, ComputingHarmonicsIsCancelledAndNotLostForAClick) {
    Page page(shapes::icosphere(6));
    page.turn_to("harmonics");
    page.ask({{"do", "harmonics.compute"}, {"count", 3000}, {"id", 1}});
    page.wait("state", [](const Message& m) { return !m.header["running"].is_null(); });
    page.ask({{"do", "paint.fix"}, {"vertices", {0}}, {"value", {1.0}}});
    EXPECT_EQ(page.wait("refused").header["what"], "harmonics are being computed");
    page.ask({{"do", "cancel"}});
    EXPECT_TRUE(page.wait_for_id("done", 1).header["cancelled"]);
    page.ask({{"do", "paint.fix"}, {"vertices", {0}}, {"value", {1.0}}, {"id", 2}});
    page.wait_for_id("frame", 2);
}

TEST(ViewSession, APageThatIsLoadedAgainFindsEverything) {
    Page page(shapes::icosphere(2));
    page.turn_to("heat");
    page.ask({{"do", "heat.source"}, {"vertex", 1}, {"value", 3.0}});
    page.ask({{"do", "heat.set"}, {"steps", 4}});
    page.ask({{"do", "run"}, {"id", 1}});
    page.wait("done");
    page.close();
    page.open();
    page.wait("mesh");
    EXPECT_EQ(page.wait("state").header["task"], "heat");
    for (int step = 0; step <= 4; ++step)
        EXPECT_EQ(page.wait("frame").header["step"], step);
}

TEST(ViewSession, WhatIsSavedIsWhatTheProgramReads) {
    const Mesh mesh = shapes::icosphere(2);
    Page page(mesh);
    page.turn_to("paint");
    page.ask({{"do", "save"}, {"format", "ply"}});
    EXPECT_EQ(page.wait("refused").header["what"], "nothing is painted yet");
    page.ask({{"do", "paint.fix"}, {"vertices", {0}}, {"value", {1.0}}});
    page.ask({{"do", "paint.fix"}, {"vertices", {9}}, {"value", {2.0}}, {"id", 1}});
    page.wait_for_id("frame", 1);
    for (const std::string format : {"ply", "vtu", "obj"}) {
        page.ask({{"do", "save"}, {"format", format}});
        EXPECT_EQ(page.wait("saved").header["path"], "files/paint." + format);
        const auto file = page.file("paint." + format);
        ASSERT_TRUE(file);
        const std::filesystem::path path = page.scratch / ("paint." + format);
        std::ofstream(path, std::ios::binary) << file->body;
        const Mesh read = read_mesh(path);
        EXPECT_EQ(read.vertex_count(), mesh.vertex_count());
        if (format != "obj") {
            const Block expected = interpolate(page.laplacian(), {{0, 1.0}, {9, 2.0}}).value;
            EXPECT_LE((read.field("value").values - expected).cwiseAbs().maxCoeff(), 1e-9);
        }
    }
    page.ask({{"do", "save"}, {"format", "csv"}});
    page.wait("saved");
    EXPECT_EQ(page.file("paint.csv")->body, "vertex,value\n0,1\n9,2\n");
    EXPECT_FALSE(page.file("passwd"));
}

TEST(ViewSession, GarbageIsRefused) {
    Page page(shapes::icosphere(1));
    const std::vector<std::string> valid = {
        R"({"do":"task","task":"paint"})",
        R"({"do":"paint.fix","vertices":[1,2],"value":[1.5],"id":3})",
        R"({"do":"heat.source","vertex":1,"value":2})",
        R"({"do":"wave.set","time":1,"steps":3,"beta_2":0.1})",
        R"({"do":"poke.hold","point":[0,0,1],"displacement":[0,0,0.1]})",
        R"({"do":"harmonics.filter","curve":[[1,2],[3,4]],"on":"positions"})",
        R"({"do":"save","format":"ply","step":2})",
        R"({"do":"field","name":"x"})",
    };
    for (const std::string text :
         {"", "null", "[]", "3", "{", "{\"do\":3}", "{\"do\":\"\"}", "{\"do\":\"paint.fix\"}",
          R"({"do":"paint.fix","vertices":[99999],"value":[1]})",
          R"({"do":"paint.fix","vertices":[1],"value":[1e400]})",
          R"({"do":"heat.source","vertex":-1,"value":1})", R"({"do":"heat.set","time":-1})",
          R"({"do":"heat.set","steps":1e9})", R"({"do":"poke.hold","point":[0,0],"displacement":[0,0,0]})",
          R"({"do":"poke.hold","point":[0,0,1],"displacement":[1e9,0,0]})",
          R"({"do":"task","task":"../../etc"})", R"({"do":"save","format":"exe"})"}) {
        page.ask_raw(text);
        EXPECT_FALSE(page.wait("refused").header["what"].get<std::string>().empty()) << text;
    }
    std::mt19937 random(1);
    for (int i = 0; i < 10000; ++i) {
        std::string text = valid[random() % valid.size()];
        for (unsigned k = 0; k < 1 + random() % 4; ++k)
            text[random() % text.size()] = static_cast<char>(random() % 256);
        page.ask_raw(text);
    }
    page.ask({{"do", "cancel"}});
    page.turn_to("paint");
    page.ask({{"do", "paint.set"}, {"mode", "scalar"}});
    page.ask({{"do", "paint.fix"}, {"vertices", {0}}, {"value", {1.0}}, {"id", 1000000000000}});
    page.wait_for_id("frame", 1000000000000);
}

// Deep brackets are a bomb for parsers that call themselves.
TEST(ViewSession, DeepBracketsAreRefused) {
    Page page(shapes::icosphere(0));
    for (const std::size_t closed : {std::size_t{0}, std::size_t{200'000}}) {
        std::string text = R"({"do":"field","name":)";
        text.append(200'000, '[').append(closed, ']').append(closed > 0 ? "}" : "");
        page.ask_raw(text);
        EXPECT_FALSE(page.wait("refused").header["what"].get<std::string>().empty());
    }
}

TEST(ViewSession, ACloudOfPointsCanBeLookedAt) {
    const Mesh cloud(shapes::icosphere(1).points(), {{"height", shapes::icosphere(1).points().col(2)}});
    Page page(cloud, "cloud.xyz");
    const Message sent = page.wait("mesh");
    EXPECT_EQ(sent.numbers("points").size(), static_cast<std::size_t>(cloud.vertex_count()));
    page.ask({{"do", "field"}, {"name", "height"}});
    expect_near(page.wait("field").floats("values"), cloud.points().col(2), 1e-6);
    for (const json& request :
         std::vector<json>{{{"do", "task"}, {"task", "paint"}},
                           {{"do", "paint.fix"}, {"vertices", {0}}, {"value", {1.0}}},
                           {{"do", "heat.source"}, {"vertex", 0}, {"value", 1.0}},
                           {{"do", "poke.hold"}, {"point", {0, 0, 1}}, {"displacement", {0, 0, 0}}},
                           {{"do", "harmonics.compute"}, {"count", 3}},
                           {{"do", "run"}},
                           {{"do", "clear"}}}) {
        page.ask(request);
        EXPECT_EQ(page.wait("refused").header["what"], "the mesh has no cells") << request;
    }
    EXPECT_EQ(page.state()["task"], "look");
    page.ask({{"do", "save"}, {"format", "ply"}});
    EXPECT_EQ(page.wait("saved").header["name"], "mesh.ply");
}

TEST(ViewSession, EveryTaskTakesSegmentsSolidsAndPieces) {
    const Mesh sphere = shapes::icosphere(2);
    Points with_strays(sphere.vertex_count() + 2, 3);
    with_strays << Points::Constant(1, 3, 0.5), sphere.points(), Points::Constant(1, 3, 9.0);
    const Mesh strays(with_strays,
                      Cells(sphere.cells().array() + 1));  // the first and the last vertex are in no cell
    for (const Mesh& mesh : {shapes::circle(30), shapes::tetrahedral_ball(3), strays,
                             shapes::together({sphere, sphere.with_points(sphere.points().array() + 5.0)})}) {
        SCOPED_TRACE(mesh.vertex_count());
        Page page(mesh);
        const Index far = mesh.vertex_count() - 1;
        for (const std::string task : {"heat", "wave"}) {
            page.turn_to(task);
            page.ask({{"do", task == "heat" ? "heat.source" : "wave.impulse"},
                      {"vertex", far - 1},
                      {"value", 1.0}});
            page.ask({{"do", task + ".set"}, {"steps", 3}});
            page.ask({{"do", "run"}, {"id", 1}});
            EXPECT_EQ(page.wait("done").header["error"], "");
        }
        page.turn_to("paint");
        page.ask({{"do", "paint.set"}, {"bounded", true}, {"gamma_2", 0.01}, {"id", 1}});
        page.ask({{"do", "paint.fix"}, {"vertices", {far}}, {"value", {1.0}}, {"id", 2}});
        EXPECT_EQ(page.wait_for_id("frame", 2).floats("values")[static_cast<std::size_t>(far)], 1.0F);
        EXPECT_EQ(page.count("done"), 0U);
        page.turn_to("poke");
        const auto p = mesh.points().row(mesh.vertex_count() / 2);
        page.ask({{"do", "poke.hold"},
                  {"point", {p[0], p[1], p[2]}},
                  {"displacement", {0.0, 0.0, 0.01}},
                  {"id", 3}});
        if (mesh.kind() == CellKind::segment) {
            EXPECT_EQ(page.wait("refused").header["what"], "segments have no surface to touch");
        } else {
            page.wait("frame",
                      [](const Message& m) { return m.header["task"] == "poke" && m.header["active"] > 0; });
        }
        page.turn_to("harmonics");
        page.ask({{"do", "harmonics.compute"}, {"count", 8}, {"id", 4}});
        EXPECT_TRUE(page.wait("spectrum").header["complete"]);
        page.ask({{"do", "harmonics.filter"}, {"curve", {{0.0, 1.0}}}, {"on", "positions"}, {"id", 5}});
        expect_near(page.wait_for_id("frame", 5).floats("positions"), mesh.points(), 1e-5);
    }
}

TEST(ViewSession, WhatIsClearedWhileItRunsComesNoMore) {
    Page page(shapes::icosphere(3));
    page.turn_to("heat");
    page.ask({{"do", "heat.source"}, {"vertex", 0}, {"value", 1.0}});
    page.ask({{"do", "heat.set"}, {"steps", 10000}});
    page.ask({{"do", "run"}, {"id", 1}});
    page.wait("frame");
    page.ask({{"do", "clear"}, {"id", 2}});
    EXPECT_TRUE(page.wait_for_id("done", 1).header["cancelled"]);
    EXPECT_EQ(page.state()["heat"]["sources"].size(), 0U);
    page.ask({{"do", "save"}, {"format", "ply"}});
    EXPECT_EQ(page.wait("refused").header["what"], "nothing was simulated yet");
    page.close();
    page.open();
    page.wait("state");
    EXPECT_EQ(page.count("frame"), 0U);
}

TEST(ViewSession, AClickEndsASimulationThatHasNotBegun) {
    Page page(shapes::icosphere(3));
    for (long id = 1; id <= 20; ++id) {
        page.turn_to("heat");
        page.ask({{"do", "heat.source"}, {"vertex", 0}, {"value", 1.0}});
        page.ask({{"do", "heat.set"}, {"steps", 10000}});
        page.ask({{"do", "run"}, {"id", 2 * id}});
        page.ask({{"do", "paint.fix"}, {"vertices", {0}}, {"value", {1.0}}, {"id", 2 * id + 1}});
        EXPECT_TRUE(page.wait_for_id("done", 2 * id).header["cancelled"]);
        page.wait("frame", [&](const Message& m) {
            return m.header["task"] == "paint" && m.header["id"] == 2 * id + 1;
        });
    }
    EXPECT_TRUE(page.state()["running"].is_null());
}

// Nothing but a simulation waits, so nothing else can be paused.
TEST(ViewSession, OnlySimulationsArePausedOrCancelled) {
    Page page(shapes::icosphere(6));
    page.ask({{"do", "pause"}});
    page.ask({{"do", "cancel"}});
    page.turn_to("harmonics");
    page.ask({{"do", "harmonics.compute"}, {"count", 3000}, {"id", 1}});
    page.wait("progress");
    page.ask({{"do", "pause"}});
    const json state = page.state();
    ASSERT_TRUE(state["running"].is_object());
    EXPECT_FALSE(state["running"]["paused"]);
    page.ask({{"do", "cancel"}});
    EXPECT_TRUE(page.wait_for_id("done", 1).header["cancelled"]);
    for (long id = 10; id < 30; ++id) {
        page.ask({{"do", "paint.fix"}, {"vertices", {id}}, {"value", {1.0}}, {"id", id}});
        page.ask({{"do", "cancel"}, {"id", id}});
        page.wait_for_id("frame", id);
    }
}

TEST(ViewSession, AnEigenfunctionThatWasClearedIsNotShownAgain) {
    Page page(shapes::icosphere(2));
    page.turn_to("harmonics");
    page.ask({{"do", "harmonics.compute"}, {"count", 9}, {"id", 1}});
    page.wait("spectrum");
    page.ask({{"do", "harmonics.show"}, {"k", 3}, {"id", 2}});
    page.wait_for_id("frame", 2);
    page.ask({{"do", "clear"}, {"id", 3}});
    page.wait_for_id("frame", 3);
    page.close();
    page.open();
    page.wait("spectrum");
    EXPECT_TRUE(page.wait("frame").header["arrays"].contains("positions"));
    EXPECT_EQ(page.count("frame"), 0U);
}

TEST(ViewSession, APokeThatIsBrokenOffLeavesTheSurfaceAtRest) {
    const Mesh mesh = shapes::icosphere(4);
    Page page(mesh);
    page.turn_to("poke");
    const json hold = {{"do", "poke.hold"},
                       {"point", {mesh.points()(0, 0), mesh.points()(0, 1), mesh.points()(0, 2)}},
                       {"displacement", {0.0, 0.0, -0.05}}};
    for (int time = 0; time < 3; ++time) {
        page.ask(hold);
        page.wait("frame",
                  [](const Message& m) { return m.header["task"] == "poke" && m.header["active"] > 20; });
        page.ask({{"do", "paint.fix"}, {"vertices", {0}}, {"value", {1.0 + time}}, {"id", 7}});
        page.wait("frame", [](const Message& m) {
            return m.header["task"] == "poke" && m.numbers("vertices").empty();
        });
        page.wait_for_id("frame", 7);
    }
}

// A touch that comes just when the surface has come to rest moves it again.
TEST(ViewSession, NoTouchIsLost) {
    const Mesh mesh = shapes::icosphere(2);
    Page page(mesh);
    page.turn_to("poke");
    const json hold = {{"do", "poke.hold"},
                       {"point", {mesh.points()(0, 0), mesh.points()(0, 1), mesh.points()(0, 2)}},
                       {"displacement", {0.0, 0.0, 0.0}}};
    for (int i = 0; i < 10000; ++i) {
        page.ask(hold);
        page.ask({{"do", "poke.release"}});
    }
    json push = hold;
    push["displacement"] = {0.0, 0.0, -0.05};
    push["id"] = 5;
    page.ask(push);
    page.wait("frame", [](const Message& m) { return m.header["id"] == 5 && m.header["active"] > 0; });
}

TEST(ViewSession, AFingerLeavesWithItsOwnPage) {
    const Mesh mesh = shapes::icosphere(3);
    Page page(mesh);
    page.open(2);
    page.turn_to("poke");
    const json hold = {{"do", "poke.hold"},
                       {"point", {mesh.points()(0, 0), mesh.points()(0, 1), mesh.points()(0, 2)}},
                       {"displacement", {0.0, 0.0, -0.05}}};
    page.ask(hold, 2);
    page.wait("frame", [](const Message& m) { return m.header["active"] > 0; });
    page.close(2);
    page.wait("frame", [](const Message& m) { return m.numbers("vertices").empty(); });
}

TEST(ViewSession, ThePathOfAPokeCanBeForgotten) {
    const Mesh mesh = shapes::icosphere(3);
    Page page(mesh);
    page.turn_to("poke");
    page.ask({{"do", "poke.hold"},
              {"point", {mesh.points()(0, 0), mesh.points()(0, 1), mesh.points()(0, 2)}},
              {"displacement", {0.0, 0.0, -0.05}}});
    page.wait("frame", [](const Message& m) { return m.header["active"] > 0; });
    page.ask({{"do", "poke.release"}});
    page.wait("frame", [](const Message& m) { return m.numbers("vertices").empty(); });
    page.ask({{"do", "save"}, {"format", "ply"}});
    page.wait("saved");
    const std::filesystem::path path = page.scratch / "poke.ply";
    std::ofstream(path, std::ios::binary) << page.file("poke.ply")->body;
    EXPECT_NEAR(read_mesh(path).field("displacement").values(0, 2), -0.05, 1e-6);
    page.ask({{"do", "clear"}});
    page.ask({{"do", "save"}, {"format", "csv"}});
    EXPECT_EQ(page.wait("refused").header["what"], "nothing was touched yet");
}

TEST(ViewSession, TheCommandLineOfAPokeMakesTheSurfaceThatIsSaved) {
    const Mesh mesh = shapes::icosphere(2);  // small: no step is late, not even in the sanitizers
    Page page(mesh);
    page.turn_to("poke");
    json hold = {{"do", "poke.hold"},
                 {"point", {mesh.points()(0, 0), mesh.points()(0, 1), mesh.points()(0, 2)}},
                 {"displacement", {0.0, 0.0, -0.05}},
                 {"id", 1}};
    page.ask(hold);
    page.wait_for_id("frame", 1);
    // Let go while it still moves: then what it was is a matter of each step.
    hold["displacement"] = {0.05, 0.0, 0.05};
    hold["id"] = 2;
    page.ask(hold);
    page.wait_for_id("frame", 2);
    page.ask({{"do", "poke.release"}});
    page.wait("frame", [](const Message& m) { return m.numbers("vertices").empty(); });
    const Block saved = saved_field(page, {{"do", "save"}, {"format", "ply"}}, "poke.ply", "displacement");
    page.ask({{"do", "save"}, {"format", "csv"}});
    page.wait("saved");
    const std::string csv = page.file("poke.csv")->body;
    const std::string command = page.state()["command"][0];

    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    ContactPath path;
    while (std::getline(lines, line)) {
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream numbers(line);
        Waypoint& w = path.emplace_back();
        numbers >> w.time;
        for (double& x : w.point)
            numbers >> x;
        for (double& x : w.displacement)
            numbers >> x;
    }
    EXPECT_GE(path.size(), 3U);
    EXPECT_EQ(path.back().displacement, Vector3(0.05, 0.0, 0.05));
    double rate = 0.0;
    double time = 0.0;
    ASSERT_EQ(std::sscanf(command.c_str(), "beltrami poke mesh.obj --path poke.csv --rate %lf --time %lf -o",
                          &rate, &time),
              2)
        << command;
    EXPECT_NEAR(time, path.back().time + 1.0 / rate, 1e-12);
    const PokeResult again =
        poke(mesh, page.laplacian(), {path}, {.skin = skin_of(mesh), .rate = rate, .time = time});
    EXPECT_LE((saved - again.displacement).cwiseAbs().maxCoeff(), 1e-9) << command << '\n' << csv;
}

TEST(ViewSession, AFileGoesToThePageThatAskedForItAndTheOldestMakesRoom) {
    Page page(shapes::icosphere(1));
    page.open(2);
    page.ask({{"do", "save"}, {"format", "ply"}}, 2);
    for (int wait = 0; wait < 10000 && !page.file("mesh.ply"); ++wait)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_TRUE(page.file("mesh.ply"));
    EXPECT_EQ(page.count("saved"), 0U);
    page.turn_to("paint");
    page.ask({{"do", "paint.fix"}, {"vertices", {0}}, {"value", {1.0}}, {"id", 1}});
    page.wait_for_id("frame", 1);
    for (const std::string format : {"vtu", "ply", "csv", "obj"}) {
        page.ask({{"do", "save"}, {"format", format}});
        page.wait("saved");
        EXPECT_TRUE(page.file("paint." + format));
    }
    EXPECT_FALSE(page.file("mesh.ply"));
    EXPECT_TRUE(page.file("paint.vtu"));
}

// Each state lists all that is painted: with so much of it not every stroke of the brush is followed by one, but the last is.
TEST(ViewSession, AStateThatTakesLongIsToldLessOften) {
    const Mesh mesh = shapes::icosphere(5);
    Page page(mesh);
    page.turn_to("paint");
    page.ask({{"do", "paint.set"}, {"mode", "colors"}});
    std::vector<Index> all(static_cast<std::size_t>(mesh.vertex_count()));
    std::iota(all.begin(), all.end(), 0);
    page.ask({{"do", "paint.fix"}, {"vertices", all}, {"value", {0.0, 0.0, 0.0}}, {"id", 1}});
    page.wait_for_id("frame", 1);
    constexpr long strokes = 200;
    for (long id = 2; id < 2 + strokes; ++id)
        page.ask({{"do", "paint.fix"}, {"vertices", {id}}, {"value", {0.5, 1.0, 0.0}}, {"id", id}});
    const std::size_t states = page.count("state");
    EXPECT_LT(states, static_cast<std::size_t>(strokes));
    const json last = page.wait_for_id("state", 1 + strokes).header;
    EXPECT_EQ(last["paint"]["fixed"].size(), all.size());
    EXPECT_EQ(last["paint"]["fixed"][1 + strokes][2], 1.0);
}

TEST(ViewSession, TimesAreBoundedHoweverOftenTheyAreSet) {
    Page page(shapes::icosphere(1));
    page.turn_to("heat");
    page.ask({{"do", "heat.source"}, {"vertex", 0}, {"value", 1e12}});
    const double usual = page.state()["heat"]["time"];
    page.ask({{"do", "heat.set"}, {"time", 0.5e12 * usual}, {"steps", 2}});
    page.ask({{"do", "heat.set"}, {"time", 1e13 * usual}});
    EXPECT_NE(page.wait("refused").header["what"].get<std::string>().find("'time'"), std::string::npos);
    page.ask({{"do", "run"}, {"id", 1}});
    EXPECT_EQ(page.wait_for_id("done", 1).header["error"], "");
}

TEST(ViewSession, EndsWhateverIsGoingOn) {
    const Mesh mesh = shapes::icosphere(4);
    for (const std::string task : {"wave", "paused wave", "poke", "harmonics", "paint", "save"}) {
        SCOPED_TRACE(task);
        Page page(mesh);
        if (task.ends_with("wave")) {
            page.turn_to("wave");
            page.ask({{"do", "wave.impulse"}, {"vertex", 0}, {"value", 1.0}});
            page.ask({{"do", "wave.set"}, {"steps", 10000}});
            page.ask({{"do", "run"}});
            page.wait("frame");
            if (task != "wave") page.ask({{"do", "pause"}});
        } else if (task == "poke") {
            page.ask({{"do", "poke.hold"}, {"point", {0, 0, 1}}, {"displacement", {0, 0, -0.05}}});
            page.wait("frame");
        } else if (task == "harmonics") {
            page.ask({{"do", "harmonics.compute"}, {"count", 500}});
            page.wait("state", [](const Message& m) { return !m.header["running"].is_null(); });
        } else if (task == "paint") {
            page.turn_to("paint");
            for (Index v = 0; v < 100; ++v)
                page.ask({{"do", "paint.fix"}, {"vertices", {v}}, {"value", {1.0}}});
        } else {
            page.ask({{"do", "save"}, {"format", "vtu"}});
        }
        page.close();
    }
}

}  // namespace
}  // namespace beltrami::view
