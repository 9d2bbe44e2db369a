#include "process.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "expect_text.hpp"

extern char** environ;

namespace beltrami::testing {

namespace {

std::string content_and_remove(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    std::filesystem::remove(path);
    return text.str();
}

}  // namespace

Outcome run_beltrami(const Arguments& arguments, const std::string& interrupt_when) {
    const std::string name =
        std::filesystem::temp_directory_path() / ("beltrami_run_" + std::to_string(getpid()));
    const std::string out = name + ".out";
    const std::string err = name + ".err";
    std::vector<std::string> words = {BELTRAMI_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words)
        argv.push_back(word.data());
    argv.push_back(nullptr);

    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    pid_t child = 0;
    const int failed = posix_spawn(&child, BELTRAMI_PROGRAM, &files, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (failed != 0) throw std::runtime_error("cannot start " BELTRAMI_PROGRAM);

    int state = 0;
    if (!interrupt_when.empty()) {
        using namespace std::chrono_literals;
        while (!std::filesystem::exists(interrupt_when) && waitpid(child, &state, WNOHANG) == 0) {
            std::this_thread::sleep_for(5ms);
        }
        kill(child, SIGINT);
    }
    waitpid(child, &state, 0);
    return {WIFEXITED(state) ? WEXITSTATUS(state) : -1, content_and_remove(out), content_and_remove(err)};
}

void write_text(const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path) << text;
}

nlohmann::json read_json(const std::filesystem::path& path) {
    return nlohmann::json::parse(std::ifstream(path));
}

void expect_refused(const Scratch& scratch, const Arguments& arguments,
                    std::initializer_list<std::string> parts) {
    const std::filesystem::path out = scratch / "refused.ply";
    const Outcome outcome = run_beltrami(arguments + Arguments{"-o", out});
    const std::string line = fmt::format("{}", fmt::join(arguments, " "));
    EXPECT_EQ(outcome.status, 2) << line << "\n" << outcome.out << outcome.err;
    EXPECT_TRUE(contains(outcome.err, {"error: ", "hint: "})) << line;
    EXPECT_TRUE(contains(outcome.err, parts)) << line;
    EXPECT_FALSE(std::filesystem::exists(out)) << line;
}

}  // namespace beltrami::testing
