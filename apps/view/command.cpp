#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <thread>

#include "../program/run.hpp"
#include "beltrami/apps/picture/camera.hpp"
#include "browser.hpp"
#include "page.hpp"
#include "server.hpp"
#include "session.hpp"

namespace beltrami::program {

namespace {

constexpr Index most_vertices = 3'000'000;

// Of this run alone, readable by its user alone, and gone at its end.
class ScratchFolder {
  public:
    ScratchFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "beltrami-view-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) {
            throw InputError(
                fmt::format("no folder can be made in {}", std::filesystem::temp_directory_path().string()),
                "set TMPDIR to a folder that can be written");
        }
        path_ = name;
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    ~ScratchFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

// Starts the program anew, once, where OpenMP's idle threads would look for work in a loop, for tens of milliseconds: on a small
// machine it is the browser that needs their cores, to show what was found. libgomp reads the variable when it is loaded.
void spare_cores() {
    constexpr const char* loops = "GOMP_SPINCOUNT";
    constexpr const char* few = "2000";  // some 10 us: short of what a product with the matrix takes
    if (std::getenv(loops) != nullptr || std::getenv("OMP_WAIT_POLICY") != nullptr) return;
    std::ifstream stream("/proc/self/cmdline", std::ios::binary);
    std::vector<std::string> words;
    for (std::string word; std::getline(stream, word, '\0');)
        words.push_back(word);
    std::vector<char*> arguments;
    for (std::string& word : words)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    if (words.empty() || setenv(loops, few, 1) != 0) return;
    execv("/proc/self/exe", arguments.data());  // returns only where it fails, and then all goes on as it is
}

struct ViewOptions {
    view::ServerOptions server;
    bool no_open = false;
    std::string screenshot;
    std::string camera = "front";
    std::string up = "y";
    std::string field;
    std::vector<double> range;
    std::vector<int> size = {1200, 900};
    bool isolines = false;
    bool edges = false;
    bool dark = false;
};

void check(const ViewOptions& options) {
    view::require_page("beltrami view");
    if (options.screenshot.empty()) return;
    check_picture_name(options.screenshot, "--screenshot", "OUT.png");
    camera_from(options.camera, options.up);  // throws for a direction that is not one
    for (const int side : options.size) {
        if (side < 64 || side > 8192)
            throw InputError(fmt::format("a picture of {}x{} pixels", options.size[0], options.size[1]),
                             "give a width and a height of 64 to 8192");
    }
    check_range(options.range);
    view::HeadlessBrowser::find();
}

std::string shoot_message(const ViewOptions& options) {
    nlohmann::json message = {{"kind", "shoot"},           {"width", options.size[0]},
                              {"height", options.size[1]}, {"view", options.camera},
                              {"up", options.up},          {"field", options.field},
                              {"range", nullptr},          {"isolines", options.isolines},
                              {"edges", options.edges},    {"dark", options.dark}};
    if (!options.range.empty()) message["range"] = options.range;
    return message.dump();
}

void serve(Run& run, const ViewOptions& options, const Mesh& mesh) {
    const ScratchFolder scratch;
    view::SessionOptions session_options{.argument = run.mesh_argument(), .scratch = scratch.path()};
    std::optional<Laplacian> laplacian;
    try {
        laplacian = run.build(mesh);
    } catch (const InputError& error) {
        session_options.why_no_laplacian = error.what();
        run.warn(fmt::format("{}; it can only be looked at", error.what()));
    }
    std::string png;
    view::Server* listening = nullptr;
    if (!options.screenshot.empty()) {
        session_options.greeting = shoot_message(options);
        session_options.binary = [&](std::string_view bytes) {
            png = bytes;
            listening->stop();
        };
    }
    auto session =
        std::make_unique<view::Session>(mesh, run.mesh_report(), laplacian, std::move(session_options));
    view::ServerOptions server_options = options.server;
    if (!options.screenshot.empty()) server_options.largest_message = std::size_t{256} << 20U;
    server_options.log = [](const std::string& line) { spdlog::warn("{}", line); };
    view::Server server(server_options, view::live_page(), session->handlers());
    listening = &server;
    session->speak_through(
        {[&](view::ClientId client, view::Outgoing message) { server.send(client, std::move(message)); },
         [&](view::Outgoing message) { server.broadcast(std::move(message)); }});
    if (!server.loopback()) {
        run.warn(
            fmt::format("the viewer listens on {}: whoever reaches it and knows the address can use it, and "
                        "nothing that is sent is encrypted",
                        options.server.host));
    }
    const std::filesystem::path door = view::write_door(scratch.path(), server.url());
    std::optional<view::HeadlessBrowser> headless;
    if (!options.screenshot.empty()) {
        headless.emplace(door, scratch.path(), options.size[0], options.size[1]);
    } else {
        run.say("viewer", server.url());
        std::fflush(stdout);
        if (!options.no_open && !view::open_in_browser(door)) run.say("", "open this address in a browser");
        run.say("", "Ctrl-C ends it");
        std::fflush(stdout);
    }

    // What ends the server: Ctrl-C, and for a picture a browser that fails.
    std::string failed;
    std::jthread watch([&](const std::stop_token& stop) {
        const Stopwatch waited;
        while (!stop.stop_requested()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            if (headless && !headless->running())
                failed = "the browser ended before it had drawn the picture";
            if (headless && waited.seconds() > 120.0)
                failed = "the browser did not draw the picture in 120 s";
            if (run.progress()->cancelled() || !failed.empty()) {
                server.stop();
                return;
            }
        }
    });
    server.run();
    watch.request_stop();
    watch.join();
    session.reset();  // before the server that it speaks through
    if (options.screenshot.empty()) return;
    run.progress()->check();
    if (png.empty()) {
        throw InputError(failed, "see whether Chromium runs by itself; BELTRAMI_BROWSER names another one");
    }
    if (!png.starts_with("\x89PNG\r\n\x1a\n"))
        throw InputError("the page sent what is no picture", png.substr(0, 200));
    write_whole(options.screenshot, [&](std::ostream& out) { out << png; });
    run.wrote(options.screenshot);
}

}  // namespace

void add_view(CLI::App& program, Run& run) {
    auto* const command = program.add_subcommand(
        "view",
        "the mesh in the browser: look at it, and touch it with heat, waves, paint, fingers and filters");
    run.add_options(*command, {.output = false, .solver = false, .report = false});
    auto options = std::make_shared<ViewOptions>();
    command->add_option("--port", options->server.port, "where to listen (default: any free port)")
        ->option_text("P");
    command
        ->add_option("--host", options->server.host,
                     "the address to listen on (default: 127.0.0.1, this machine alone)")
        ->option_text("H");
    command->add_flag("--no-open", options->no_open, "print the address, and open no browser");
    auto* const screenshot = command
                                 ->add_option("--screenshot", options->screenshot,
                                              "draw a picture with headless Chromium, and end")
                                 ->option_text("OUT.png");
    command
        ->add_option("--camera", options->camera,
                     "from where: front, back, left, right, top, bottom, iso or x,y,z (default: front)")
        ->needs(screenshot)
        ->option_text("NAME");
    command->add_option("--up", options->up, "the axis that points up in the picture: x, y or z (default: y)")
        ->needs(screenshot)
        ->option_text("AXIS");
    command->add_option("--field", options->field, "the field of the file to show")
        ->needs(screenshot)
        ->option_text("NAME");
    command->add_option("--size", options->size, "of the picture in pixels (default: 1200,900)")
        ->delimiter(',')
        ->expected(2)
        ->needs(screenshot)
        ->option_text("W,H");
    command->add_option("--range", options->range, "the ends of the colour scale (default: by the values)")
        ->delimiter(',')
        ->expected(2)
        ->needs(screenshot)
        ->option_text("LOW,HIGH");
    command->add_flag("--isolines", options->isolines, "draw lines of equal value")->needs(screenshot);
    command->add_flag("--edges", options->edges, "draw the edges of the cells")->needs(screenshot);
    command->add_flag("--dark", options->dark, "on a dark ground")->needs(screenshot);
    command->callback([&run, options] {
        check(*options);
        spare_cores();
        if (!options->screenshot.empty()) run.also_writes(options->screenshot, "--screenshot");
        const Mesh mesh = run.load_mesh();
        if (mesh.vertex_count() > most_vertices) {
            throw InputError(
                fmt::format("{} vertices are more than the viewer's {}", mesh.vertex_count(), most_vertices),
                "make a picture with --picture, or a report, which is decimated for display");
        }
        if (!options->field.empty())
            static_cast<void>(mesh.field(options->field));  // throws for one that is not there
        serve(run, *options, mesh);
        run.finish();
    });
}

}  // namespace beltrami::program
