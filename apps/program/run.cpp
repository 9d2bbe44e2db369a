#include "run.hpp"

#include <omp.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "beltrami/apps/picture/camera.hpp"
#include "view/page.hpp"
#include "view/scene.hpp"
#include "view/shell_line.hpp"

namespace beltrami::program {

namespace {

std::size_t peak_memory_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

std::string range_text(const Field& field) {
    if (field.values.cols() == 1) {
        return fmt::format("{} from {:.6g} to {:.6g}", field.name, field.values.minCoeff(),
                           field.values.maxCoeff());
    }
    const Vector lengths = field.values.rowwise().norm();
    return fmt::format("{} of length {:.6g} to {:.6g}", field.name, lengths.minCoeff(), lengths.maxCoeff());
}

Chart convergence(const LinearSummary& solver) {
    const auto n = static_cast<Eigen::Index>(solver.history.size());
    const Vector iterations = Vector::LinSpaced(n, 1.0, static_cast<double>(n));
    return {
        .title = fmt::format("convergence of the last solve, by {}", solver.solver),
        .across = "iteration",
        .up = std::string(name(solver.norm)),
        .logarithmic = true,
        .lines = {{.name = "error", .x = iterations, .y = Eigen::Map<const Vector>(solver.history.data(), n)},
                  {.name = "tolerance",
                   .x = iterations,
                   .y = Vector::Constant(n, solver.tolerance),
                   .dashed = true}}};
}

std::atomic<Progress*> cancelled_by_signal = nullptr;

void on_signal(int signal) {
    if (Progress* const progress = cancelled_by_signal.load()) progress->cancel();
    std::signal(signal, SIG_DFL);
}

}  // namespace

void cancel_on_signal(Progress& progress) {
    cancelled_by_signal = &progress;
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
}

// A bar on a terminal, lines in a log; nothing for work that is over at once.
class Run::ProgressDisplay {
  public:
    ProgressDisplay() : terminal_(isatty(STDERR_FILENO) != 0) {}
    ProgressDisplay(const ProgressDisplay&) = delete;
    ProgressDisplay& operator=(const ProgressDisplay&) = delete;
    ~ProgressDisplay() { clear(); }

    void show(const ProgressReport& report) {
        const double now = watch_.seconds();
        if (report.fraction < 0.0 || now < 1.0) return;
        if (terminal_) {
            if (now - last_ < 0.1) return;
            const int filled = static_cast<int>(30.0 * report.fraction);
            fmt::print(stderr, "\r{} [{:<30}] {:3.0f} %  {:.0f} s ", report.phase,
                       std::string(static_cast<std::size_t>(filled), '='), 100.0 * report.fraction, now);
            std::fflush(stderr);
            drawn_ = true;
        } else {
            if (now - last_ < 5.0) return;
            fmt::print(stderr, "progress: {} {:.0f} % after {:.0f} s\n", report.phase,
                       100.0 * report.fraction, now);
        }
        last_ = now;
    }

    void clear() {
        if (drawn_) fmt::print(stderr, "\r{:<70}\r", "");
        drawn_ = false;
    }

  private:
    bool terminal_;
    bool drawn_ = false;
    double last_ = 0.0;
    Stopwatch watch_;
};

Run::Run(const std::vector<std::string>& words) : command_line_(view::shell_line(words)) {
    display_ = std::make_unique<ProgressDisplay>();
    progress_ = std::make_unique<Progress>([this](const ProgressReport& report) {
        if (!quiet_) display_->show(report);
    });
    summary_["warnings"] = nlohmann::json::array();
    summary_["outputs"] = nlohmann::json::array();
    summary_["seconds"] = nlohmann::json::object();
    summary_["result"] = nlohmann::json::object();
}

Run::~Run() {
    if (cancelled_by_signal.load() == progress_.get()) cancelled_by_signal = nullptr;
}

void Run::add_options(CLI::App& command, Wants wants) {
    command.add_option("mesh", mesh_argument_, "a mesh file, or a built-in shape such as shape:icosphere:5")
        ->required()
        ->option_text("MESH");
    if (wants.output) {
        command.add_option("-o,--output", output_, "the mesh with its fields: .ply or .vtu")
            ->option_text("OUT");
    }
    if (wants.output || wants.picture) {
        command.add_option("--picture", picture_, "a picture of the result")->option_text("FILE.png");
        command
            .add_option("--view", view_.view,
                        "from where the picture looks: front, back, left, right, top, bottom, iso or x,y,z")
            ->option_text("NAME");
        command
            .add_option("--up", view_.up, "the axis that points up in the picture: x, y or z (default: y)")
            ->option_text("AXIS");
        command
            .add_option("--range", range_, "the ends of the picture's colour scale (default: by the values)")
            ->delimiter(',')
            ->expected(2)
            ->option_text("LOW,HIGH");
    }
    command.add_option("--summary", summary_file_, "what was done, as JSON")->option_text("FILE");
    if (wants.report) {
        command
            .add_option(
                "--report", report_file_,
                "one page with the interactive mesh, its fields, charts and the summary; opens offline")
            ->option_text("FILE.html");
        command
            .add_option(
                "--report-vertices", report_vertices_,
                "the most vertices that the report draws; larger meshes are clustered (default: 200000)")
            ->check(CLI::Range(Index{1}, std::numeric_limits<Index>::max()))
            ->option_text("N");
    }
    command.add_option("--threads", threads_, "threads to use (default: all)")->option_text("N");
    if (wants.solver) {
        std::vector<std::string> solvers;
        for (const SolverKind kind : all_solver_kinds)
            solvers.emplace_back(name(kind));
        command.add_option("--solver", solver_, "auto, cg, multigrid, cholesky or green (default: auto)")
            ->check(CLI::IsMember(std::move(solvers)))
            ->option_text("NAME");
        command.add_option("--tolerance", tolerance_, "where solves stop (default: 1e-10)")->option_text("X");
        command.add_option("--max-iterations", max_iterations_, "the limit for cg (default: 50000)")
            ->option_text("N");
    }
    auto* const quiet = command.add_flag("--quiet", quiet_, "print errors and warnings only");
    command.add_flag("--verbose", verbose_, "print everything that is known of the mesh and the solve")
        ->excludes(quiet);
    command.parse_complete_callback([this, &command, wants] {
        command_ = command.get_name();
        wants_output_ = wants.output;
    });
}

void Run::also_writes(const std::filesystem::path& path, const std::string& option) {
    other_outputs_.push_back({path, option});
}

void Run::check_outputs() const {
    if (!output_.empty()) {
        check_writable_mesh(output_);
        if (!output_.ends_with(".ply") && !output_.ends_with(".vtu")) {
            throw InputError(output_ + " is a kind of file that holds no fields",
                             "name it OUT.ply or OUT.vtu");
        }
    }
    if (!picture_.empty()) {
        check_picture_name(picture_, "--picture", "FILE.png");
        camera_from(view_.view, view_.up);  // throws for a direction that is not one
    }
    if (!summary_file_.empty()) check_writable(summary_file_);
    if (wants_report()) {
        view::require_page("--report");
        check_writable(report_file_);
        if (!report_file_.ends_with(".html"))
            throw InputError("--report " + report_file_ + " is not a .html", "name it FILE.html");
    }
    for (const OtherOutput& other : other_outputs_)
        check_writable(other.path);
    check_range(range_);
    std::vector<std::pair<std::filesystem::path, std::string>> known = {{mesh_argument_, "MESH"}};
    const auto add = [&](const std::filesystem::path& path, const std::string& option) {
        if (path.empty()) return;
        for (const auto& [other, name] : known) {
            if (std::filesystem::weakly_canonical(other) == std::filesystem::weakly_canonical(path)) {
                throw InputError(fmt::format("{} and {} are the same file, {}", name, option, path.string()),
                                 "give each output a name of its own");
            }
        }
        known.emplace_back(path, option);
    };
    add(output_, "-o");
    add(picture_, "--picture");
    add(summary_file_, "--summary");
    add(report_file_, "--report");
    for (const OtherOutput& other : other_outputs_)
        add(other.path, other.option);
}

Mesh Run::load_mesh() {
    summary_["command"] = command_;
    summary_["version"] = BELTRAMI_VERSION;
    if (wants_output_ && output_.empty() && picture_.empty() && other_outputs_.empty() && !wants_report()) {
        throw InputError("nothing would be written", "say where to with -o OUT.ply or --report FILE.html");
    }
    check_outputs();
    if (threads_ < 0) throw InputError(fmt::format("{} threads", threads_), "use one or more");
    if (threads_ > 0) {
        if (threads_ > omp_get_num_procs()) {
            warn(fmt::format("{} threads on {} cores: {} are used", threads_, omp_get_num_procs(),
                             omp_get_num_procs()));
            threads_ = omp_get_num_procs();
        }
        omp_set_num_threads(threads_);
    }
    summary_["threads"] = omp_get_max_threads();

    constexpr std::string_view shape = "shape:";
    Mesh mesh = timed("read", [&] {
        return mesh_argument_.starts_with(shape)
                   ? shapes::from_name(std::string_view(mesh_argument_).substr(shape.size()))
                   : read_mesh(mesh_argument_);
    });
    mesh_report_ = timed("report", [&] { return report(mesh); });
    const MeshReport& found = mesh_report_;
    summary_["mesh"] = view::to_json(found);
    summary_["mesh"]["source"] = mesh_argument_;
    if (wants_report()) {
        report_ = timed("report", [&] {
            return std::make_unique<Report>(mesh, view::name_of_mesh(mesh_argument_), found,
                                            report_vertices_);
        });
    }
    say("mesh", fmt::format("{}: {}", mesh_argument_, brief_report(found)));
    for (const std::string& note : mesh.notes())
        say("", note);
    if (verbose_ && command_ != "info") fmt::print("{}", full_report(found));
    return mesh;
}

Laplacian Run::build(const Mesh& mesh) {
    return build(
        mesh, [&] { return Laplacian(mesh); }, "keep their initial value");
}

Laplacian Run::build(const Mesh& mesh, const std::function<Laplacian()>& make, const std::string& isolated) {
    Laplacian laplacian = timed("build", make);
    if (laplacian.left_out_cells() > 0) {
        warn(fmt::format("{} of {} {} have no {} and are left out", laplacian.left_out_cells(),
                         mesh.cell_count(), plural(mesh.kind()),
                         mesh.kind() == CellKind::tetrahedron ? "volume" : "area"));
    }
    if (laplacian.isolated_vertices() > 0) {
        warn(fmt::format("{} isolated vertices {}", laplacian.isolated_vertices(), isolated));
    }
    return laplacian;
}

LinearSolverOptions Run::linear_options() const {
    LinearSolverOptions options;
    for (const SolverKind kind : all_solver_kinds) {
        if (solver_ == name(kind)) options.kind = kind;
    }
    options.tolerance = tolerance_;
    if (max_iterations_ != 0) options.max_iterations = max_iterations_;
    options.progress = progress();
    options.check();
    return options;
}

void Run::add_seconds(const std::string& phase, double more) {
    nlohmann::json& seconds = summary_["seconds"];
    seconds[phase] = seconds.value(phase, 0.0) + more;
}

void Run::warn_outside(const Laplacian& laplacian, const Block& values, const Block& given) {
    double low = INFINITY;
    double high = -INFINITY;
    const auto is_isolated = [&](Index v) {
        return laplacian.graph().degree(laplacian.order().working(v)) == 0;
    };
    for (Index v = 0; v < laplacian.vertex_count(); ++v) {
        if (is_isolated(v) || !given.row(v).allFinite()) continue;
        low = std::min(low, given.row(v).minCoeff());
        high = std::max(high, given.row(v).maxCoeff());
    }
    const double slack = 1e-7 * std::max({high - low, std::abs(low), std::abs(high)});
    Index outside = 0;
    for (Index v = 0; v < laplacian.vertex_count(); ++v) {
        if (is_isolated(v)) continue;
        outside += values.row(v).minCoeff() < low - slack || values.row(v).maxCoeff() > high + slack ? 1 : 0;
    }
    if (outside == 0) return;
    warn(fmt::format(
        "{} of the results lie outside {:.6g} to {:.6g}, the range of what was given: obtuse cells have "
        "negative weights",
        outside, low, high));
}

void Run::say(const std::string& title, const std::string& text) const {
    display_->clear();
    if (!quiet_) fmt::print("{:<10} {}\n", title, text);
}

void Run::warn(const std::string& text) {
    display_->clear();
    spdlog::warn("{}", text);
    summary_["warnings"].push_back(text);
}

void Run::record(const LinearSummary& solver) {
    summary_["solver"] = {{"name", solver.solver},
                          {"why", solver.why},
                          {"iterations", solver.iterations},
                          {"relative_residual", solver.relative_residual},
                          {"converged", solver.converged},
                          {"error", solver.error},
                          {"norm", name(solver.norm)},
                          {"tolerance", solver.tolerance},
                          {"stopped", sentence(solver.reason)},
                          {"products", solver.products},
                          {"factorizations", solver.factorizations},
                          {"unknowns", solver.unknowns},
                          {"columns", solver.columns},
                          {"setup_seconds", solver.setup_seconds},
                          {"solve_seconds", solver.solve_seconds},
                          {"memory_bytes", solver.memory_bytes}};
    if (report_ && !solver.history.empty()) report_->chart(convergence(solver));
    say("solver", fmt::format("{}; chosen: {}", solver.brief(), solver.why));
    if (verbose_) fmt::print("{}", solver.full());
}

void Run::wrote(const std::filesystem::path& path) {
    summary_["outputs"].push_back(path.string());
    say("wrote", path.string());
}

void Run::write(const Mesh& mesh, const Fields& fields, const Drawing& drawing) {
    for (const Field& field : fields) {
        if (!field.values.allFinite()) {
            throw SolveError(fmt::format("the result {} holds values that are not finite", field.name),
                             "look at the mesh with `beltrami info`; nothing was written");
        }
        nlohmann::json& range = summary_["result"]["fields"][field.name];
        range["columns"] = field.values.cols();
        for (Eigen::Index c = 0; c < field.values.cols(); ++c) {
            range["min"].push_back(field.values.col(c).minCoeff());
            range["max"].push_back(field.values.col(c).maxCoeff());
        }
        say("result", range_text(field));
    }
    if (report_) report_->show(mesh, fields);
    if (!output_.empty()) {
        timed("write", [&] { write_mesh(output_, mesh, fields); });
        wrote(output_);
    }
    if (!picture_.empty()) {
        PictureOptions options = view_;
        options.title = fields.front().name;
        if (!range_.empty()) options.range = {range_[0], range_[1]};
        timed("write", [&] {
            write_picture(picture_, drawing ? drawing(options) : draw(mesh, &fields.front().values, options));
        });
        wrote(picture_);
    }
}

void Run::finish() {
    display_->clear();
    if (report_) {
        summary_["report"] = timed("write", [&] { return report_->pack(progress()); });
        for (const std::string& note : report_->notes())
            say("report", note);
        summary_["outputs"].push_back(report_file_);
    }
    summary_["seconds"]["total"] = watch_.seconds();
    summary_["peak_memory_bytes"] = peak_memory_bytes();
    if (!summary_file_.empty()) {
        // dump() throws on a file name that is not UTF-8 unless told to replace it.
        const std::string text = summary_.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
        write_whole(summary_file_, [&](std::ostream& out) { out << text << '\n'; });
        say("wrote", summary_file_);
    }
    if (report_) {
        progress_->check();
        report_->write(report_file_, command_line_, summary_);
        say("wrote", report_file_);
    }
}

void check_picture_name(const std::string& path, const std::string& option, const std::string& as) {
    check_writable(path);
    if (!path.ends_with(".png"))
        throw InputError(fmt::format("{} {} is not a .png", option, path), "name it " + as);
}

void check_range(const std::vector<double>& range) {
    if (range.empty() || (range[0] < range[1] && std::isfinite(range[1] - range[0]))) return;
    throw InputError(fmt::format("--range {},{} is no range", range[0], range[1]),
                     "give LOW,HIGH with LOW < HIGH");
}

void add_term_weights(CLI::App& command, TermWeights& weights) {
    command
        .add_option("--laplacian", weights.laplacian,
                    "weight of the Laplacian (default: 1 if neither is given)")
        ->option_text("G1");
    command
        .add_option("--bilaplacian", weights.bilaplacian,
                    "weight of the bi-Laplacian, in length^2 (default: 0)")
        ->option_text("G2");
}

void add_free_components(CLI::App& command, bool& keep) {
    command
        .add_option_function<std::string>(
            "--free-components", [&keep](const std::string& policy) { keep = policy == "keep"; },
            "components without a fixed vertex: refuse, or keep at zero (default: refuse)")
        ->check(CLI::IsMember({"refuse", "keep"}))
        ->option_text("POLICY");
}

}  // namespace beltrami::program
