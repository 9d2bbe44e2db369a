// What the commands heat and wave share.
#pragma once

#include "run.hpp"

namespace beltrami::program {

struct SimulateOptions {
    std::string initial_field;
    std::optional<double> time;
    int steps = 50;
    std::string method;
    std::string series;
    int every = 1;
};

/// Declares --initial-field, --time, --steps, --method, --series and --every; the first of `methods` is the default.
void add_simulate_options(CLI::App& command, SimulateOptions& options,
                          const std::vector<std::string>& methods);

/// Runs `simulate` on the options with the series attached, then writes the outputs and the summary.
void run_simulation(Run& run, const SimulateOptions& options, const Mesh& mesh, double default_time,
                    const std::function<Evolution(const EvolveOptions&)>& simulate);

}  // namespace beltrami::program
