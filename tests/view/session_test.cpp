// The viewer's session without a server: requests in, messages out, against the library's own functions.

#include "view/session.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>

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
        std::memcpy(list.data(), arrays.data() + at, list.size() * sizeof(Number));
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

// A session with one page, which waits for what it is told.
class Page {
  public:
    explicit Page(const Mesh& mesh, const std::string& argument = "mesh.obj")
        : laplacian(mesh),
          session_(mesh, report(mesh), laplacian, {.argument = argument, .scratch = folder()}) {
        session_.speak_through({[this](ClientId, const Outgoing& message) { take(message); },
                                [this](const Outgoing& message) { take(message); }});
        handlers_ = session_.handlers();
        handlers_.opened(1);
    }

    void ask(const json& request) { handlers_.text(1, request.dump()); }
    void ask_raw(const std::string& text) { handlers_.text(1, text); }
    void close() { handlers_.closed(1); }
    void open() { handlers_.opened(1); }
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
        ask({{"do", "task"}, {"task", wait_state_task_}});
        return wait("state").header;
    }
    void turn_to(const std::string& task) {
        wait_state_task_ = task;
        ask({{"do", "task"}, {"task", task}});
    }

    Scratch scratch;
    Laplacian laplacian;

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
    Page page(mesh);
    const Message sent = page.wait("mesh");
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
        heat(page.laplacian, Block::Zero(mesh.vertex_count(), 1), {{7, 50.0}}, {.time = 0.1, .steps = 5}).u;
    expect_near(last.floats("values"), expected, 1e-5);
    EXPECT_EQ(page.wait("done").header["error"], "");
    const json state = page.state();
    EXPECT_EQ(state["heat"]["sources"], json::parse("[[7, 50.0]]"));
    EXPECT_EQ(state["command"][0], "beltrami heat mesh.obj --source 7=50 --time 0.1 --steps 5 -o heat.ply");
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
                interpolate(page.laplacian, fixed, options).value, 1e-6);
    page.ask({{"do", "paint.fix"}, {"vertices", {101}}, {"value", nullptr}, {"id", 4}});
    fixed.free(101);
    expect_near(page.wait_for_id("frame", 4).floats("values"),
                interpolate(page.laplacian, fixed, options).value, 1e-6);
    page.ask({{"do", "paint.set"}, {"gamma_2", 0.0}, {"id", 5}});
    expect_near(page.wait_for_id("frame", 5).floats("values"), interpolate(page.laplacian, fixed, {}).value,
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
            const Block expected = interpolate(page.laplacian, {{0, 1.0}, {9, 2.0}}).value;
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
        R"({"do":"save","format":"ply"})",
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
    for (int i = 0; i < 2000; ++i) {
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

}  // namespace
}  // namespace beltrami::view
