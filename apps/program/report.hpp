// What --report gathers during a run, and the file it makes of it: the page with the mesh, fields, moments, charts and the
// summary in it.
//
//     if (Report* const report = run.for_report()) report->chart(energy);
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "beltrami/apps/picture/chart.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/framework/mesh_report.hpp"
#include "beltrami/framework/progress.hpp"
#include "view/scene.hpp"

namespace beltrami::program {

class Report {
  public:
    /// The mesh that the run is about, before anything is done to it. most_vertices: that are drawn.
    Report(const Mesh& mesh, std::string name, MeshReport found, Index most_vertices);

    /// What the run found. A mesh with the cells of the run's is that, moved; segments where the run's has triangles are lines
    /// on it; any other takes its place. Of fields with many columns some are shown, as fields of their own; what the mesh
    /// carries comes after the run's own fields. Where there are moments of a displacement the mesh is shown as it was at
    /// the start, and the moments move it.
    void show(const Mesh& mesh, const Fields& fields);
    /// Fields to look at besides, on the run's mesh.
    void also_show(const Fields& fields);

    void chart(Chart chart);

    /// A state of a time series, called for every one in turn: `values` is asked for those that are kept, in the file's order.
    /// Some dozens are, at equal distances. displaced: the values are displacements from where the run's mesh is at the start.
    void moment(const std::string& name, bool displaced, double time, const std::function<Block()>& values);
    /// Keeps the last state, unless moment() has: call it once, after the last moment.
    void last_moment(double time, const Block& values);

    /// What is in the report and what was left out, to be put in the summary. Makes all of the file but the summary's part:
    /// the longest work of a report. Throws Cancelled.
    nlohmann::json pack(const Progress* progress);
    /// The sentences of it.
    [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

    /// After pack(): the file, whole or not at all.
    void write(const std::filesystem::path& path, const std::string& command_line,
               const nlohmann::json& summary) const;

  private:
    struct Moment {
        double time;
        std::vector<float> values;  // of the vertices that are shown, row after row
    };

    void show_lines(const Mesh& lines, const Fields& fields);
    void keep(double time, const Block& values);
    void pack_mesh();
    nlohmann::json pack_fields();
    nlohmann::json pack_moments(const Progress* progress);

    Mesh mesh_;  // with its fields
    std::string name_;
    MeshReport found_;
    Index most_vertices_;
    view::Shown shown_;
    Fields fields_;  // rows of lines' points, where there are any, may be missing at the end
    Index points_of_lines_ = 0;
    std::vector<Chart> charts_;

    std::string series_;
    bool displaced_ = false;
    Eigen::Index columns_ = 1;
    std::vector<Moment> moments_;
    std::size_t states_ = 0;  // so far
    std::size_t stride_ = 1;  // between those that are kept

    std::vector<std::string> embedded_;
    std::vector<std::string> notes_;
};

/// A line over numbers that were gathered one by one.
ChartLine line_of(std::string name, const std::vector<double>& x, const std::vector<double>& y);

}  // namespace beltrami::program
