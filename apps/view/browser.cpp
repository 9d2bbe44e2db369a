#include "browser.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <sstream>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/write_mesh.hpp"

extern char** environ;

namespace beltrami::view {

namespace {

std::optional<std::string> in_path(const std::string& program) {
    const char* const path = std::getenv("PATH");
    std::istringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');) {
        const std::filesystem::path file = std::filesystem::path(folder) / program;
        if (!folder.empty() && access(file.c_str(), X_OK) == 0) return file.string();
    }
    return std::nullopt;
}

// In a process group of its own, with no standard streams; -1 where it cannot be started.
pid_t start(std::vector<std::string> words) {
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words)
        argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    pid_t process = -1;
    const int failed =
        posix_spawn(&process, words.front().c_str(), &files, &attributes, argv.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return failed == 0 ? process : -1;
}

}  // namespace

std::filesystem::path write_door(const std::filesystem::path& folder, const std::string& url) {
    std::filesystem::path door = folder / "open.html";
    write_whole(door, [&](std::ostream& out) {
        out << "<!doctype html><title>beltrami view</title><meta name=referrer content=no-referrer>"
            << "<meta http-equiv=refresh content=\"0; url=" << url << "\">\n";
    });
    std::filesystem::permissions(door,
                                 std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    return door;
}

bool open_in_browser(const std::filesystem::path& door) {
    if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return false;
    for (const char* const opener : {"xdg-open", "open"}) {
        const auto program = in_path(opener);
        if (program && start({*program, door.string()}) > 0) return true;
    }
    return false;
}

std::string HeadlessBrowser::find() {
    if (const char* const chosen = std::getenv("BELTRAMI_BROWSER")) return chosen;
    for (const char* const name : {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable"}) {
        if (const auto program = in_path(name)) return *program;
    }
    throw InputError("there is no Chromium to draw the picture with",
                     "install Debian's package chromium, or name a Chromium or Chrome in BELTRAMI_BROWSER; "
                     "--picture of the other commands needs none");
}

HeadlessBrowser::HeadlessBrowser(const std::filesystem::path& door, const std::filesystem::path& folder,
                                 int width, int height) {
    std::vector<std::string> words = {find(),
                                      "--headless",
                                      "--disable-gpu",
                                      "--disable-quic",
                                      "--no-first-run",
                                      "--no-default-browser-check",
                                      "--disable-background-networking",
                                      "--disable-component-update",
                                      "--disable-sync",
                                      "--disable-extensions",
                                      "--hide-scrollbars",
                                      "--enable-unsafe-swiftshader",
                                      "--remote-debugging-port=0",
                                      fmt::format("--window-size={},{}", width, height),
                                      "--user-data-dir=" + (folder / "profile").string()};
    // Chromium refuses to run as root in its sandbox.
    if (geteuid() == 0) words.emplace_back("--no-sandbox");
    words.push_back("file://" + door.string());
    const std::string program = words.front();
    process_ = start(std::move(words));
    if (process_ < 0)
        throw InputError(fmt::format("{} cannot be started", program), "see whether it runs by itself");
}

HeadlessBrowser::~HeadlessBrowser() {
    if (process_ < 0) return;
    kill(-process_, SIGKILL);
    waitpid(process_, nullptr, 0);
}

bool HeadlessBrowser::running() {
    if (process_ > 0 && waitpid(process_, nullptr, WNOHANG) != 0) process_ = -1;
    return process_ > 0;
}

}  // namespace beltrami::view
