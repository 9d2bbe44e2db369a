// Runs the program `beltrami` as a person would, and tells what it printed and how it ended.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "meshes.hpp"

namespace beltrami::testing {

struct Outcome {
    int status = -1;  ///< exit status
    std::string out;
    std::string err;
};

/// A mesh that the program makes itself: 642 vertices.
inline const std::string sphere = "shape:icosphere:3";

using Arguments = std::vector<std::string>;
inline Arguments operator+(Arguments a, const Arguments& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// Runs the program with these arguments; with `interrupt_when` not empty, sends Ctrl-C once that file exists.
Outcome run_beltrami(const Arguments& arguments, const std::string& interrupt_when = {});
/// Runs it and kills it (SIGKILL) after so many seconds; false where it ended before.
bool kill_beltrami_after(double seconds, const Arguments& arguments);

void write_text(const std::filesystem::path& path, const std::string& text);
nlohmann::json read_json(const std::filesystem::path& path);

/// Exit status 2, an error and a hint that hold all of `parts`, and no output.
void expect_refused(const Scratch& scratch, const Arguments& arguments,
                    std::initializer_list<std::string> parts = {});

}  // namespace beltrami::testing
