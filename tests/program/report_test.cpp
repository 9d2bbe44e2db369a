// --report: the file that every command makes, read as the page reads it.

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
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
using nlohmann::json;

std::string from_base64(const std::string& text) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned bits = 0;
    int count = 0;
    for (const char c : text) {
        if (c == '=') break;
        const std::size_t digit = digits.find(c);
        EXPECT_NE(digit, std::string::npos) << "not base64: " << c;
        bits = (bits << 6U) | static_cast<unsigned>(digit);
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes += static_cast<char>((bits >> static_cast<unsigned>(count)) & 255U);
    }
    return bytes;
}

std::string inflated(const std::string& packed) {
    z_stream stream{};
    EXPECT_EQ(inflateInit(&stream), Z_OK);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    std::string bytes;
    std::string part(65536, '\0');
    int state = Z_OK;
    while (state == Z_OK) {
        stream.next_out = reinterpret_cast<Bytef*>(part.data());
        stream.avail_out = static_cast<uInt>(part.size());
        state = inflate(&stream, Z_NO_FLUSH);
        bytes.append(part, 0, part.size() - stream.avail_out);
    }
    EXPECT_EQ(state, Z_STREAM_END);
    EXPECT_EQ(stream.avail_in, 0U);
    inflateEnd(&stream);
    return bytes;
}

struct Message {
    json header;
    std::string arrays;

    [[nodiscard]] std::string kind() const { return header["kind"]; }
    template <class Number>
    [[nodiscard]] std::vector<Number> array(const std::string& name) const {
        const json& place = header["arrays"].at(name);
        EXPECT_EQ(place["type"], (std::is_same_v<Number, float> ? "f32" : "u32"));
        std::vector<Number> numbers(place["count"].get<std::size_t>());
        EXPECT_LE(place["at"].get<std::size_t>() + sizeof(Number) * numbers.size(), arrays.size());
        if (numbers.empty()) return numbers;  // which have no place to copy to
        std::memcpy(numbers.data(), arrays.data() + place["at"].get<std::size_t>(),
                    sizeof(Number) * numbers.size());
        return numbers;
    }
};

Message decoded(const std::string& bytes) {
    if (bytes.starts_with("T")) return {json::parse(bytes.substr(1)), {}};
    EXPECT_TRUE(bytes.starts_with(std::string("P\0\0\0", 4)));
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 4, 4);
    EXPECT_EQ(length % 4, 0U);
    return {json::parse(bytes.substr(8, length)), bytes.substr(8 + length)};
}

struct Page {
    std::string html;
    std::vector<Message> messages;

    [[nodiscard]] std::vector<Message> of(const std::string& kind) const {
        std::vector<Message> found;
        std::copy_if(messages.begin(), messages.end(), std::back_inserter(found),
                     [&](const Message& message) { return message.kind() == kind; });
        return found;
    }
    [[nodiscard]] Message only(const std::string& kind) const {
        const std::vector<Message> found = of(kind);
        EXPECT_EQ(found.size(), 1U) << kind;
        return found.empty() ? Message{} : found.front();
    }
    [[nodiscard]] Message field(const std::string& name) const {
        for (const Message& message : messages) {
            if (message.kind() == "field" && message.header["name"] == name) return message;
        }
        ADD_FAILURE() << "no field " << name;
        return {};
    }
    [[nodiscard]] std::vector<std::string> charts() const {
        std::vector<std::string> titles;
        const Message report = only("report");
        for (const json& chart : report.header["charts"])
            titles.push_back(chart["title"]);
        return titles;
    }
};

Page read_page(const fs::path& path) {
    Page page{bytes_of(path), {}};
    const std::string begin = R"(<script class="beltrami-message" type="text/plain">)";
    for (std::size_t at = page.html.find(begin); at != std::string::npos; at = page.html.find(begin, at)) {
        at += begin.size();
        const std::size_t end = page.html.find("</script>", at);
        page.messages.push_back(decoded(inflated(from_base64(page.html.substr(at, end - at)))));
    }
    return page;
}

/// The words of a line, as a POSIX shell would part it.
std::vector<std::string> words_of(const std::string& line) {
    std::vector<std::string> words(1);
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (line[i] == '\'') {
            quoted = !quoted;
        } else if (!quoted && line[i] == '\\') {
            words.back() += line[++i];
        } else if (!quoted && line[i] == ' ') {
            words.emplace_back();
        } else {
            words.back() += line[i];
        }
    }
    EXPECT_FALSE(quoted);
    return words;
}

bool has_page() {
    static const bool has = [] {
        const fs::path path = fs::temp_directory_path() / "beltrami_has_page.html";
        const Outcome outcome = run_beltrami({"info", "shape:icosphere:0", "--report", path});
        fs::remove(path);
        return outcome.err.find("was built without") == std::string::npos;
    }();
    return has;
}
#define SKIP_WITHOUT_PAGE \
    if (!has_page()) GTEST_SKIP() << "the program was built without Node, and so without the page"

/// Everything that the summary says of the fields is in the page, to float precision.
void expect_fields(const Page& page, const json& summary) {
    if (!summary["result"].contains("fields")) return;
    for (const auto& [name, range] : summary["result"]["fields"].items()) {
        const auto columns = range["columns"].get<std::size_t>();
        const Message field = page.field(name);
        if (field.header.is_null()) continue;
        EXPECT_EQ(field.header["columns"], columns);
        EXPECT_EQ(field.header["as"], columns == 1 ? "scalar" : name == "color" ? "colors" : "vectors");
        const std::vector<float> values = field.array<float>("values");
        ASSERT_EQ(values.size(), columns * page.only("mesh").header["vertices"].get<std::size_t>());
        for (std::size_t c = 0; c < columns; ++c) {
            float low = INFINITY;
            float high = -INFINITY;
            for (std::size_t i = c; i < values.size(); i += columns) {
                low = std::min(low, values[i]);
                high = std::max(high, values[i]);
            }
            EXPECT_EQ(low, static_cast<float>(range["min"][c].get<double>())) << name;
            EXPECT_EQ(high, static_cast<float>(range["max"][c].get<double>())) << name;
        }
    }
}

/// Runs the command with a report and a summary, and checks what holds for all of them.
Page report_of(const Scratch& scratch, const Arguments& arguments) {
    const fs::path html = scratch / "it's a report.html";
    const Arguments words =
        arguments + Arguments{"--report", html, "--summary", scratch / "summary.json", "--threads", "1"};
    const Outcome outcome = run_beltrami(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    if (outcome.status != 0) return {};
    Page page = read_page(html);
    const json summary = read_json(scratch / "summary.json");
    const Message report = page.only("report");
    EXPECT_EQ(report.header["summary"], summary);
    EXPECT_TRUE(std::any_of(summary["outputs"].begin(), summary["outputs"].end(),
                            [&](const json& output) { return output == html.string(); }));
    EXPECT_EQ(words_of(report.header["command"]), Arguments{BELTRAMI_PROGRAM} + words);
    expect_fields(page, summary);
    const Message mesh = page.only("mesh");
    const auto vertices = mesh.header["vertices"].get<std::size_t>();
    EXPECT_EQ(mesh.array<float>("positions").size(), 3 * vertices);
    for (const char* name : {"triangles", "segments", "points", "boundary", "non_manifold"}) {
        for (const std::uint32_t v : mesh.array<std::uint32_t>(name))
            EXPECT_LT(v, vertices) << name;
    }
    for (const json& chart : report.header["charts"]) {
        EXPECT_FALSE(chart["lines"].empty()) << chart["title"];
        for (const json& line : chart["lines"]) {
            EXPECT_EQ(line["x"].size(), line["y"].size()) << chart["title"];
            EXPECT_FALSE(line["x"].empty()) << chart["title"];
        }
    }
    for (const Message& message : page.of("moment"))
        EXPECT_EQ(message.array<float>(message.header["arrays"].begin().key()).size(),
                  vertices * message.header["columns"].get<std::size_t>());
    // What a browser would fetch: all that may name an address is what three.js and SVG name things by, which nothing loads.
    for (const char* fetched : {"src=\"http", "href=\"http", "url(http", "src=http", "href=http", "@import"})
        EXPECT_EQ(page.html.find(fetched), std::string::npos) << fetched;
    return page;
}

TEST(ProgramReport, OfAMeshAlone) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    const Page page = report_of(scratch, {"info", "shape:fins:3:4"});
    const Message mesh = page.only("mesh");
    const Mesh fins = shapes::fins(3, 4);
    EXPECT_EQ(mesh.header["name"], "shape:fins:3:4");
    EXPECT_EQ(mesh.header["decimated"], false);
    EXPECT_EQ(mesh.header["cells"], "triangles");
    EXPECT_EQ(mesh.header["brief"], brief_report(report(fins)));
    EXPECT_EQ(mesh.array<std::uint32_t>("triangles").size(), 3U * 3U * 4U * 4U * 2U);
    EXPECT_EQ(mesh.array<std::uint32_t>("non_manifold").size(), 2U * 4U) << "the seam";
    EXPECT_EQ(mesh.array<std::uint32_t>("boundary").size(), 2U * 3U * 12U) << "three sides of each fin";
    EXPECT_NE(page.html.find("<title>shape:fins:3:4: info</title>"), std::string::npos);
}

TEST(ProgramReport, ShowsWhatTheFileCarries) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    const Mesh mesh = shapes::icosphere(2);
    const Block unit = (mesh.points().array() + 1.0) / 2.0;
    write_mesh(scratch / "a&b <c>.vtu", mesh,
               {{"height", Block(mesh.points().col(2))},
                {"color", unit},
                {"many", Block::Random(mesh.vertex_count(), 40)}});
    const Page page = report_of(scratch, {"info", scratch / "a&b <c>.vtu"});
    EXPECT_EQ(page.field("height").header["as"], "scalar");
    EXPECT_EQ(page.field("color").header["as"], "colors");
    EXPECT_EQ(page.field("many_0").header["columns"], 1);
    EXPECT_EQ(page.field("many_39").header["columns"], 1);
    EXPECT_EQ(page.of("field").size(), 2U + 16U);
    EXPECT_NE(page.html.find("<title>a&amp;b &lt;c&gt;.vtu: info</title>"), std::string::npos);
}

TEST(ProgramReport, OfHeatHasMomentsAndEnergy) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    const Page page = report_of(scratch, {"heat", sphere, "--source", "0=100", "--steps", "150"});
    const std::vector<Message> moments = page.of("moment");
    ASSERT_GE(moments.size(), 30U);
    ASSERT_LE(moments.size(), 60U);
    EXPECT_EQ(moments.front().header["time"], 0.0);
    EXPECT_EQ(moments.back().array<float>("values"), page.field("u").array<float>("values"));
    // At equal distances, but for the last.
    const double step = moments[1].header["time"];
    for (std::size_t i = 0; i + 1 < moments.size(); ++i)
        EXPECT_NEAR(moments[i].header["time"].get<double>(), static_cast<double>(i) * step, 1e-9);
    EXPECT_EQ(page.only("report").header["summary"]["report"]["moments"]["kept"], moments.size());
    EXPECT_EQ(page.only("report").header["summary"]["report"]["moments"]["of"], 151);
    EXPECT_EQ(page.charts(), (std::vector<std::string>{"energy"})) << "a factor needs no iterations";
}

TEST(ProgramReport, OfWaveBeginsAndEndsWhereItDoes) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    const Page page =
        report_of(scratch, {"wave", sphere, "--impulse", "5=1", "--steps", "20", "--solver", "cg"});
    EXPECT_EQ(page.of("moment").size(), 21U);
    ASSERT_EQ(page.charts().size(), 2U);
    const json energy = page.only("report").header["charts"][1]["lines"][0];
    EXPECT_EQ(energy["x"].size(), 21U);
    const json result = page.only("report").header["summary"]["result"];
    EXPECT_EQ(energy["y"][0], result["energy_before"]);
    EXPECT_EQ(energy["y"][20], result["energy_after"]);
}

TEST(ProgramReport, ShowsHowASolveConverged) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    for (const char* solver : {"cg", "multigrid"}) {
        const Page page =
            report_of(scratch, {"interpolate", sphere, "--fix", "0=0", "--fix", "7=1", "--solver", solver});
        const json chart = page.only("report").header["charts"].at(0);
        EXPECT_TRUE(chart["logarithmic"]);
        const auto errors = chart["lines"][0]["y"].get<std::vector<double>>();
        const json summary = page.only("report").header["summary"]["solver"];
        EXPECT_EQ(errors.size(), summary["iterations"]);
        EXPECT_LE(errors.back(), summary["tolerance"]);
        EXPECT_GT(errors.front(), 1e3 * errors.back());
    }
    const Page colours =
        report_of(scratch, {"interpolate", sphere, "--fix", "0=0,0,1", "--fix", "7=1,1,0", "--colours", "1"});
    EXPECT_EQ(colours.field("color").header["as"], "colors");
}

TEST(ProgramReport, ShowsTheMovedMesh) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    const Arguments upper = {"--box", "-2,-2,0.1,2,2,2", "-o", scratch / "out.ply"};
    for (const Arguments& command : {Arguments{"fair", sphere, "--bilaplacian", "1"},
                                     Arguments{"fair", sphere, "--time", "0.1", "--steps", "4"},
                                     Arguments{"membrane", sphere, "--steps", "5"}}) {
        const Page page = report_of(scratch, command + upper);
        const Points moved = read_mesh(scratch / "out.ply").points();
        // Where there are states between, the mesh is as it was, and the last of them moves it to the end.
        const Points start = shapes::icosphere(3).points();
        const std::vector<float> positions = page.only("mesh").array<float>("positions");
        const std::vector<Message> moments = page.of("moment");
        const Points& there = moments.empty() ? moved : start;
        const BlockOf<float> floats = there.cast<float>();
        EXPECT_EQ(positions, std::vector<float>(floats.data(), floats.data() + floats.size()));
        if (moments.empty()) {
            EXPECT_EQ(command.size(), 4U) << "only a fairing until rest has no states between";
            continue;
        }
        EXPECT_EQ(moments.back().array<float>("displacement"),
                  page.field("displacement").array<float>("values"));
        for (const float d : moments.front().array<float>("displacement"))
            ASSERT_EQ(d, 0.0F);
        EXPECT_TRUE(contains(fmt::format("{}", fmt::join(page.charts(), ", ")), {"what the flow lowers"}));
    }
}

TEST(ProgramReport, OfVectorsPoissonAndCurvature) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    EXPECT_EQ(report_of(scratch, {"vectors", sphere, "--fix", "0=1,0,0"}).field("vectors").header["as"],
              "vectors");
    const Page poisson = report_of(scratch, {"poisson", "shape:grid:12x9", "--fix-boundary", "1"});
    EXPECT_EQ(poisson.only("mesh").array<std::uint32_t>("boundary").size(), 2U * 2U * (12U + 9U));
    const Page curvature = report_of(scratch, {"curvature", sphere});
    EXPECT_EQ(curvature.of("field").size(), 2U);
}

TEST(ProgramReport, OfPokeHasForcesAndStates) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    write_text(scratch / "p.csv", "0,0,0,1,0,0,0\n0.02,0,0,1,0,0,-0.05\n0.05,0.1,0,0.99,0,0,-0.05\n");
    const Page page = report_of(scratch, {"poke", "shape:icosphere:4", "--path", scratch / "p.csv"});
    EXPECT_EQ(page.charts(),
              (std::vector<std::string>{"force", "size of the domain", "time of each step", "energy"}));
    const json result = page.only("report").header["summary"]["result"];
    const json charts = page.only("report").header["charts"];
    const auto greatest = [&](std::size_t chart) {
        const auto values = charts[chart]["lines"][0]["y"].get<std::vector<double>>();
        return *std::max_element(values.begin(), values.end());
    };
    EXPECT_EQ(greatest(0), result["largest_force"]);
    EXPECT_EQ(greatest(1), result["most_active"]);
    float deepest = 0.0F;
    for (const Message& moment : page.of("moment")) {
        for (const float d : moment.array<float>("displacement"))
            deepest = std::max(deepest, std::abs(d));
    }
    EXPECT_GE(deepest, 0.0499F);
    EXPECT_LE(deepest, 0.1F);
}

TEST(ProgramReport, OfTheSpectralCommands) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    const std::string basis = scratch / "basis";
    const Page harmonics = report_of(scratch, {"harmonics", sphere, "-k", "20", "-o", basis, "--show", "3"});
    EXPECT_EQ(harmonics.of("field").size(), 12U);
    EXPECT_EQ(harmonics.charts(), (std::vector<std::string>{"spectrum", "frequencies"}));
    const Page filter = report_of(scratch, {"filter", sphere, "--basis", basis, "--filter", "low-pass:#9"});
    EXPECT_EQ(filter.field("displacement").header["as"], "vectors");
    EXPECT_EQ(filter.charts(), (std::vector<std::string>{"filter"}));
    const Page spectrum = report_of(scratch, {"spectrum", sphere, "--basis", basis, "--on", "positions"});
    EXPECT_EQ(spectrum.charts().size(), 2U);
    EXPECT_TRUE(spectrum.of("field").empty());
    const Page distance =
        report_of(scratch, {"signature", sphere, "--basis", basis, "--kind", "biharmonic", "--from", "4"});
    EXPECT_EQ(distance.charts(), (std::vector<std::string>{"vertices within a distance"}));
    const Page states = report_of(scratch, {"signature", sphere, "--basis", basis, "--kind", "heat", "--from",
                                            "4", "--times", "0.1,0.2"});
    EXPECT_EQ(states.only("report").header["charts"][0]["lines"].size(), 3U);
    const Page nodal = report_of(scratch, {"nodal", sphere, "--basis", basis, "--function", "3", "9"});
    EXPECT_FALSE(nodal.only("mesh").array<std::uint32_t>("segments").empty());
    EXPECT_EQ(nodal.only("mesh").array<std::uint32_t>("triangles").size(), 3U * 1280U) << "under the lines";
    const std::vector<float> function = nodal.field("function-9").array<float>("values");
    EXPECT_TRUE(std::isfinite(function.at(641)));
    EXPECT_TRUE(std::isnan(function.at(642))) << "on the lines";
    EXPECT_EQ(nodal.charts(), (std::vector<std::string>{"nodal domains", "length of the lines"}));
    // Of many columns some, each a field of its own with the column's own values.
    ASSERT_EQ(run_beltrami({"signature", sphere, "--basis", basis, "--kind", "hks", "-o", scratch / "h.vtu",
                            "--report", scratch / "h.html"})
                  .status,
              0);
    const Page hks = read_page(scratch / "h.html");
    EXPECT_EQ(hks.of("field").size(), 16U);
    const Block all = read_mesh(scratch / "h.vtu").field("hks").values;
    EXPECT_EQ(hks.field("hks_99").array<float>("values").at(7), static_cast<float>(all(7, 99)));
}

TEST(ProgramReport, OfOtherCellsThanTriangles) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    const Message ball =
        report_of(scratch, {"heat", "shape:tetrahedral-ball:5", "--source", "0=1"}).only("mesh");
    EXPECT_EQ(ball.header["cells"], "tetrahedra");
    EXPECT_EQ(ball.array<std::uint32_t>("triangles").size(), 3U * 2U * 6U * 25U) << "the skin";
    const Message circle = report_of(scratch, {"heat", "shape:circle:50", "--source", "0=1"}).only("mesh");
    EXPECT_EQ(circle.array<std::uint32_t>("segments").size(), 100U);
    write_mesh(scratch / "cloud.ply", Mesh(shapes::icosphere(1).points()));
    const Message cloud = report_of(scratch, {"info", scratch / "cloud.ply"}).only("mesh");
    EXPECT_EQ(cloud.array<std::uint32_t>("points").size(), 42U);
}

TEST(ProgramReport, LargeMeshesAreDecimatedAndSaySo) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    for (const std::string& shape :
         {std::string("shape:bumpy-sphere:5000"), std::string("shape:tetrahedral-ball:12")}) {
        ASSERT_EQ(run_beltrami({"heat", shape, "--source", "0=1", "-o", scratch / "u.vtu", "--report",
                                scratch / "u.html", "--report-vertices", "800"})
                      .status,
                  0);
        const Page page = read_page(scratch / "u.html");
        const Message mesh = page.only("mesh");
        EXPECT_EQ(mesh.header["decimated"], true);
        EXPECT_NE(mesh.header["decimation"], "");
        EXPECT_EQ(page.only("report").header["summary"]["report"]["decimation"], mesh.header["decimation"]);
        const auto vertices = mesh.header["vertices"].get<std::size_t>();
        EXPECT_LE(vertices, 800U);
        EXPECT_GT(vertices, 500U);
        // Where vertices are shown, values are exact.
        const Mesh written = read_mesh(scratch / "u.vtu");
        const std::vector<float> u = page.field("u").array<float>("values");
        const std::vector<float> positions = mesh.array<float>("positions");
        const std::vector<std::uint32_t> vertex_of = mesh.array<std::uint32_t>("vertex_of");
        ASSERT_EQ(u.size(), vertices);
        ASSERT_EQ(vertex_of.size(), vertices);
        for (std::size_t v = 0; v < vertices; ++v) {
            const auto original = static_cast<Index>(vertex_of[v]);
            ASSERT_EQ(u[v], static_cast<float>(written.field("u").values(original, 0)));
            ASSERT_EQ(positions[3 * v], static_cast<float>(written.points()(original, 0)));
        }
        EXPECT_EQ(page.of("moment").back().array<float>("values"), u);
        EXPECT_TRUE(mesh.array<std::uint32_t>("boundary").empty()) << "clusters make no boundary";
        EXPECT_TRUE(mesh.array<std::uint32_t>("non_manifold").empty());
    }
}

TEST(ProgramReport, RefusesNamesThatCannotBe) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    const auto refused = [&](const Arguments& more, std::initializer_list<std::string> parts) {
        expect_refused(scratch, Arguments{"heat", sphere, "--source", "0=1"} + more, parts);
    };
    refused({"--report", scratch / "r.txt"}, {"--report", "not a .html", "FILE.html"});
    refused({"--report", scratch / "none/r.html"}, {"there is no folder"});
    fs::create_directory(scratch / "folder.html");
    refused({"--report", scratch / "folder.html"}, {"this is a folder"});
    refused({"--report", scratch / "r.html", "--summary", scratch / "r.html"}, {"the same file"});
    refused({"--report", scratch / "r.html", "--report-vertices", "0"}, {"--report-vertices"});
    EXPECT_FALSE(fs::exists(scratch / "r.html"));
}

TEST(ProgramReport, IsNotLeftByARunThatFails) {
    SKIP_WITHOUT_PAGE;
    const Scratch scratch;
    const Outcome failed = run_beltrami({"interpolate", sphere, "--fix", "0=0", "--fix", "9=1", "--solver",
                                         "cg", "--max-iterations", "2", "--report", scratch / "r.html"});
    EXPECT_EQ(failed.status, 3) << failed.err;
    const Outcome cancelled =
        run_beltrami({"wave", "shape:icosphere:6", "--impulse", "0=1", "--steps", "100000", "--series",
                      scratch / "w.pvd", "--report", scratch / "r.html"},
                     scratch / "w_0002.vtu");
    EXPECT_EQ(cancelled.status, 130) << cancelled.err;
    EXPECT_FALSE(fs::exists(scratch / "r.html"));
}

}  // namespace
}  // namespace beltrami::testing
