// One run of the program: the options every command has, the mesh, phases with their seconds, progress and cancel,
// outputs, and the summary.
#pragma once

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "beltrami/framework/stopwatch.hpp"
#include "report.hpp"

namespace beltrami::program {

/// What a command has besides MESH, --summary, --report, --threads, --quiet and --verbose.
struct Wants {
    bool output = true;    ///< -o with fields, and a picture
    bool solver = true;    ///< which, and its tolerance
    bool picture = false;  ///< a picture, where -o is something else or nothing
    bool report = true;
};

class Run {
  public:
    /// words: the command line as typed, the program's name first.
    explicit Run(const std::vector<std::string>& words);
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;
    ~Run();

    /// Declares the common options on a command.
    void add_options(CLI::App& command, Wants wants);

    /// Checks every output name, then reads or makes the mesh and says what it is.
    Mesh load_mesh();
    /// As the user wrote it.
    [[nodiscard]] const std::string& mesh_argument() const { return mesh_argument_; }
    /// Of the mesh that was loaded.
    [[nodiscard]] const MeshReport& mesh_report() const { return mesh_report_; }
    /// Builds the operators and warns of what they leave out.
    Laplacian build(const Mesh& mesh);
    /// The same with an operator of the command's own; `isolated`: what becomes of isolated vertices.
    Laplacian build(const Mesh& mesh, const std::function<Laplacian()>& make, const std::string& isolated);

    [[nodiscard]] LinearSolverOptions linear_options() const;
    [[nodiscard]] const Progress* progress() const { return progress_.get(); }
    [[nodiscard]] Progress& cancellable() { return *progress_; }

    /// A line "title  text" on standard output, unless --quiet.
    void say(const std::string& title, const std::string& text) const;
    /// A line on standard error, and an entry in the summary.
    void warn(const std::string& text);
    void record(const LinearSummary& solver);
    nlohmann::json& result() { return summary_["result"]; }

    /// An output besides -o that is checked before any work, such as a series; `option`: which says so.
    void also_writes(const std::filesystem::path& path, const std::string& option = "--series");
    void wrote(const std::filesystem::path& path);

    using Drawing = std::function<Image(const PictureOptions&)>;

    /// Records the least and greatest value of each field, writes -o and --picture (of the first field, unless
    /// `drawing` makes another), and says so. Throws SolveError, with nothing written, for a value that is not finite.
    void write(const Mesh& mesh, const Fields& fields, const Drawing& drawing = {});
    [[nodiscard]] bool wants_picture() const { return !picture_.empty(); }
    [[nodiscard]] bool wants_report() const { return !report_file_.empty(); }
    /// What to gather for --report, once the mesh is loaded; nullptr without it. write() and record() do their part.
    [[nodiscard]] Report* for_report() { return report_.get(); }
    /// Writes --report and --summary. The last thing a command does.
    void finish();

    [[nodiscard]] bool verbose() const { return verbose_; }
    /// As --quiet: for commands whose standard output is data.
    void be_quiet() { quiet_ = true; }

    /// work(), with its seconds added to those of the phase; first a cancelled run stops here.
    template <class Work>
    auto timed(const std::string& phase, Work work) {
        progress_->check();
        const Stopwatch watch;
        if constexpr (std::is_void_v<decltype(work())>) {
            work();
            add_seconds(phase, watch.seconds());
        } else {
            auto result = work();
            add_seconds(phase, watch.seconds());
            return result;
        }
    }

    /// Warns where a result leaves the range of what was given (rows of `given`, NaN where nothing was): the maximum
    /// principle fails. All in the user's order; isolated vertices do not count.
    void warn_outside(const Laplacian& laplacian, const Block& values, const Block& given);

  private:
    void add_seconds(const std::string& phase, double more);
    void check_outputs() const;

    std::string command_;
    std::string mesh_argument_;
    std::string output_;
    std::string picture_;
    PictureOptions view_;
    std::vector<double> range_;
    std::string summary_file_;
    std::string report_file_;
    Index report_vertices_ = 200000;
    std::string command_line_;
    std::string solver_ = "auto";
    double tolerance_ = 1e-10;
    int max_iterations_ = 0;
    int threads_ = 0;
    bool quiet_ = false;
    bool verbose_ = false;
    bool wants_output_ = false;

    class ProgressDisplay;
    std::unique_ptr<ProgressDisplay> display_;
    std::unique_ptr<Progress> progress_;
    struct OtherOutput {
        std::filesystem::path path;
        std::string option;
    };
    std::vector<OtherOutput> other_outputs_;
    Stopwatch watch_;
    MeshReport mesh_report_;
    std::unique_ptr<Report> report_;
    nlohmann::json summary_;
};

/// Cancels `progress` at the first Ctrl-C or SIGTERM; a second one ends the program at once.
void cancel_on_signal(Progress& progress);

/// Throws InputError for a name that cannot be written or does not end in .png. option: that it was given to; as: what its help
/// calls it.
void check_picture_name(const std::string& path, const std::string& option, const std::string& as);
/// Throws InputError for a --range that is not LOW < HIGH; none at all is fine.
void check_range(const std::vector<double>& range);

/// --laplacian and --bilaplacian: one that is not given is 0, but the Laplacian is 1 where neither is.
struct TermWeights {
    std::optional<double> laplacian = {};
    std::optional<double> bilaplacian = {};
    [[nodiscard]] double of_laplacian() const { return laplacian.value_or(bilaplacian ? 0.0 : 1.0); }
    [[nodiscard]] double of_bilaplacian() const { return bilaplacian.value_or(0.0); }
};
void add_term_weights(CLI::App& command, TermWeights& weights);

/// Declares --free-components refuse|keep.
void add_free_components(CLI::App& command, bool& keep);
inline FreeComponents free_components(bool keep) {
    return keep ? FreeComponents::keep_at_zero : FreeComponents::refuse;
}

// Every command in a line.
void add_info(CLI::App& program, Run& run);
void add_heat(CLI::App& program, Run& run);
void add_wave(CLI::App& program, Run& run);
void add_interpolate(CLI::App& program, Run& run);
void add_vectors(CLI::App& program, Run& run);
void add_poisson(CLI::App& program, Run& run);
void add_curvature(CLI::App& program, Run& run);
void add_fair(CLI::App& program, Run& run);
void add_membrane(CLI::App& program, Run& run);
void add_poke(CLI::App& program, Run& run);
void add_harmonics(CLI::App& program, Run& run);
void add_filter(CLI::App& program, Run& run);
void add_spectrum(CLI::App& program, Run& run);
void add_signature(CLI::App& program, Run& run);
void add_nodal(CLI::App& program, Run& run);
void add_view(CLI::App& program, Run& run);

}  // namespace beltrami::program
