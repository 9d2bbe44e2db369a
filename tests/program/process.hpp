// Runs the program `beltrami` as a person would, and tells what it printed and how it ended.
#pragma once

#include <string>
#include <vector>

namespace beltrami::testing {

struct Outcome {
    int status = -1;  ///< exit status
    std::string out;
    std::string err;
};

/// Runs the program with these arguments; with `interrupt_when` not empty, sends Ctrl-C once that file exists.
Outcome run_beltrami(const std::vector<std::string>& arguments, const std::string& interrupt_when = {});

}  // namespace beltrami::testing
