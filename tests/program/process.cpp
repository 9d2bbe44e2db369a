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

namespace {

// A run whose output goes to files.
class Child {
  public:
    explicit Child(const Arguments& arguments) {
        const std::string name =
            std::filesystem::temp_directory_path() / ("beltrami_run_" + std::to_string(getpid()));
        out_ = name + ".out";
        err_ = name + ".err";
        std::vector<std::string> words = {BELTRAMI_PROGRAM};
        words.insert(words.end(), arguments.begin(), arguments.end());
        std::vector<char*> argv;
        for (std::string& word : words)
            argv.push_back(word.data());
        argv.push_back(nullptr);

        posix_spawn_file_actions_t files;
        posix_spawn_file_actions_init(&files);
        posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                         0600);
        posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err_.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                         0600);
        const int failed = posix_spawn(&process_, BELTRAMI_PROGRAM, &files, nullptr, argv.data(), environ);
        posix_spawn_file_actions_destroy(&files);
        if (failed != 0) throw std::runtime_error("cannot start " BELTRAMI_PROGRAM);
    }

    /// Sends the signal once ready() is true, unless the run ends before.
    template <class Ready>
    void signal_when(int signal, Ready ready) {
        using namespace std::chrono_literals;
        while (!ended_ && !ready()) {
            std::this_thread::sleep_for(5ms);
            ended_ = waitpid(process_, &state_, WNOHANG) != 0;
        }
        if (!ended_) kill(process_, signal);
    }

    Outcome wait() {
        if (!ended_) waitpid(process_, &state_, 0);
        ended_ = true;
        return {WIFEXITED(state_) ? WEXITSTATUS(state_) : -1, content_and_remove(out_),
                content_and_remove(err_)};
    }
    [[nodiscard]] bool killed() const { return WIFSIGNALED(state_); }

  private:
    std::string out_;
    std::string err_;
    pid_t process_ = 0;
    int state_ = 0;
    bool ended_ = false;
};

}  // namespace

Outcome run_beltrami(const Arguments& arguments, const std::string& interrupt_when) {
    Child child(arguments);
    if (!interrupt_when.empty())
        child.signal_when(SIGINT, [&] { return std::filesystem::exists(interrupt_when); });
    return child.wait();
}

bool kill_beltrami_after(double seconds, const Arguments& arguments) {
    const auto start = std::chrono::steady_clock::now();
    Child child(arguments);
    child.signal_when(SIGKILL, [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > seconds;
    });
    child.wait();
    return child.killed();
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
