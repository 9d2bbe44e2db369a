// What the commands fair and membrane share: a mesh that moves, as a series, a picture and a file.
#pragma once

#include "run.hpp"

namespace beltrami::program {

struct SeriesOptions {
    std::string path;
    int every = 1;
};

/// Declares --series and --every.
void add_series_options(CLI::App& command, SeriesOptions& options);

/// Runs `work` as the phase "solve", giving it what takes its frames, whose u are positions: they become the steps of
/// the series, each with the displacement since the start. A cancel keeps the steps written, and says so.
void run_moving(Run& run, const SeriesOptions& options, const Mesh& mesh,
                const std::function<void(const std::function<void(const Frame&)>& on_frame)>& work);

/// Writes the mesh at its new positions with the field `displacement`. The picture shows it before and after.
void write_moved(Run& run, const Mesh& mesh, const Points& points);

}  // namespace beltrami::program
