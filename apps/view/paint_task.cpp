// Painting: values are fixed at vertices, and the smoothest field through them follows.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <future>
#include <map>
#include <set>
#include <utility>

#include "beltrami/framework/stopwatch.hpp"
#include "parcel.hpp"
#include "task.hpp"

namespace beltrami::view {

namespace {

enum class Mode : std::size_t { scalar, colors, displacement };
const std::vector<std::string> mode_words = {"scalar", "colors", "displacement"};
constexpr std::size_t most_fixed = 200000;
// More than these are written to a file that the command line names.
constexpr std::size_t most_on_command_line = 40;
constexpr int expected_solves = 1000;
constexpr Index most_foreseen =
    300000;  // vertices; of more an analysis takes longer than the program's end should

using FixedValues = std::map<Index, std::vector<double>>;

// What a solver is made for.
struct Weights {
    double laplacian = 1.0;
    double bilaplacian = 0.0;
    bool bounded = false;
    friend bool operator==(const Weights&, const Weights&) = default;

    [[nodiscard]] std::size_t order() const { return bilaplacian > 0.0 ? 2 : 1; }
    // With K D K it is of the last refinement: what is left is far smaller, and a picture shows less. A search for what lies at
    // the bounds needs exact values.
    [[nodiscard]] double tolerance() const { return order() == 2 && !bounded ? 1e-6 : 1e-10; }
};

class PaintTask : public Task {
  public:
    using Task::Task;

    [[nodiscard]] std::string name() const override { return "paint"; }

    bool handle(const Request& request) override {
        if (request.name() == "paint.fix") {
            fix(request);
        } else if (request.name() == "paint.set") {
            set(request);
        } else {
            return false;
        }
        solve(request.id());
        return true;
    }

    void clear(const Request& request) override {
        fixed().clear();
        solve(request.id());
    }

    [[nodiscard]] nlohmann::json state() const override {
        nlohmann::json list = nlohmann::json::array();
        for (const auto& [v, value] : fixed()) {
            nlohmann::json row = {v};
            for (const double x : value)
                row.push_back(x);
            list.push_back(std::move(row));
        }
        return {{"mode", mode_words[static_cast<std::size_t>(mode_)]},
                {"fixed", std::move(list)},
                {"gamma_1", weights_.laplacian},
                {"gamma_2", weights_.bilaplacian},
                {"bounded", weights_.bounded}};
    }

    [[nodiscard]] std::vector<std::string> command() const override {
        if (fixed().empty()) return {};
        std::string line = "beltrami interpolate " + shell_word(stage_.argument);
        if (fixed().size() > most_on_command_line) {
            line += " --fix-file paint.csv";
        } else {
            for (const auto& [v, value] : fixed())
                line += fmt::format(" --fix {}={}", v, fmt::join(value, ","));
        }
        line += fmt::format(" --laplacian {} --bilaplacian {}", weights_.laplacian, weights_.bilaplacian);
        if (weights_.bounded) line += " --bounded";
        if (mode_ == Mode::colors) line += " --colours 1";
        if (mode_ == Mode::displacement) line += " --displace";
        return {line + " --free-components keep -o paint.ply"};
    }

    [[nodiscard]] std::vector<Outgoing> newest() const override {
        if (!newest_) return {};
        return {*newest_};
    }

    [[nodiscard]] Saved saved() const override {
        if (value_.size() == 0) throw InputError("nothing is painted yet", "click on the surface");
        std::string csv = fixed_columns() == 1 ? "vertex,value\n" : "vertex,x,y,z\n";
        for (const auto& [v, value] : fixed())
            csv += fmt::format("{},{}\n", v, fmt::join(value, ","));
        if (value_mode_ == Mode::displacement)
            return {displaced(stage_.mesh, value_), {{"displacement", value_}}, csv};
        if (value_mode_ == Mode::colors) return {stage_.mesh, {{"color", value_}}, csv};
        return {stage_.mesh, {{"value", value_}}, csv};
    }

    // The first click should not wait for the first factor: one is made with any vertex held, and corrected for others.
    void enter() override {
        if (fixed().empty()) prepare();
    }

  private:
    void prepare() {
        stage_.post(name() + " solver", 0, false, [this](const Progress& progress) {
            Weights weights;
            {
                const std::lock_guard lock(stage_.mutex);
                weights = weights_;
            }
            solver_for(weights, progress)({{0, 0.0}});
            foresee();
            return std::string();
        });
    }

    [[nodiscard]] FixedValues& fixed() { return fixed_of_mode_[static_cast<std::size_t>(mode_)]; }
    [[nodiscard]] const FixedValues& fixed() const { return fixed_of_mode_[static_cast<std::size_t>(mode_)]; }
    [[nodiscard]] std::size_t fixed_columns() const { return mode_ == Mode::scalar ? 1 : 3; }

    void fix(const Request& request) {
        const std::vector<Index> vertices = request.vertices("vertices", stage_.vertex_count());
        if (request.is_null("value")) {
            for (const Index v : vertices)
                fixed().erase(v);
            return;
        }
        const std::vector<double> value = request.numbers("value", fixed_columns());
        if (mode_ == Mode::colors &&
            std::any_of(value.begin(), value.end(), [](double c) { return c < 0.0 || c > 1.0; })) {
            throw InputError("a colour is not within 0 to 1", "give red, green and blue from 0 to 1");
        }
        std::set<Index> more;
        for (const Index v : vertices) {
            if (!fixed().contains(v)) more.insert(v);
        }
        const std::size_t count = fixed().size() + more.size();
        if (count > most_fixed) {
            throw InputError(
                fmt::format("{} vertices would be fixed; the viewer takes {}", count, most_fixed),
                "use a smaller brush, or beltrami interpolate --fix-file");
        }
        for (const Index v : vertices)
            fixed().insert_or_assign(v, value);
    }

    void set(const Request& request) {
        Weights weights = weights_;
        if (request.has("gamma_1")) weights.laplacian = request.number("gamma_1", 0.0, 1e12);
        if (request.has("gamma_2")) weights.bilaplacian = request.number("gamma_2", 0.0, 1e12);
        if (weights.laplacian == 0.0 && weights.bilaplacian == 0.0) {
            throw InputError("gamma_1 and gamma_2 are both 0", "raise one of them");
        }
        if (request.has("bounded")) weights.bounded = request.flag("bounded");
        weights_ = weights;
        if (request.has("mode")) mode_ = static_cast<Mode>(request.word("mode", mode_words));
        if (fixed().empty()) prepare();
    }

    // With the mutex locked; work takes what is fixed when it begins, so that it answers everything up to then.
    void solve(long id) {
        asked_ = id;
        stage_.post(name(), id, false, [this](const Progress& progress) {
            update(progress);
            return std::string();
        });
    }

    void update(const Progress& progress) {
        const Stopwatch watch;
        FixedValues given;
        Weights weights;
        Mode mode{};
        long id = 0;
        {
            const std::lock_guard lock(stage_.mutex);
            given = fixed();
            weights = weights_;
            mode = mode_;
            id = asked_;
        }
        const Index columns = mode == Mode::scalar ? 1 : 3;
        Block value = Block::Zero(stage_.vertex_count(), columns);
        std::string note;
        if (!given.empty()) {
            Constraints constraints(columns);
            for (const auto& [v, x] : given)
                constraints.fix(v, x);
            Interpolator& interpolate = solver_for(weights, progress);
            InterpolateResult result = interpolate(
                constraints, weights.bounded ? std::optional(range_of(constraints)) : std::nullopt);
            note = result.summary.brief();
            value = std::move(result.value);
            if (mode == Mode::colors) value = clamped(value, 0.0, 1.0).value;
        }
        nlohmann::json header = frame_header(name(), id, watch.seconds(), note);
        header["mode"] = mode_words[static_cast<std::size_t>(mode)];
        Parcel parcel(std::move(header));
        parcel.add("values", value);
        Outgoing message = parcel_message(parcel.bytes(), name());
        const std::lock_guard lock(stage_.mutex);
        value_ = given.empty() ? Block() : std::move(value);
        value_mode_ = mode;
        newest_ = message;
        stage_.broadcast(std::move(message));
    }

    Interpolator& solver_for(Weights weights, const Progress& progress) {
        if (solver_ && solver_weights_ == weights) return *solver_;
        InterpolateOptions options{.laplacian = weights.laplacian,
                                   .bilaplacian = weights.bilaplacian,
                                   .free_components = FreeComponents::keep_at_zero};
        options.linear.expected_solves = expected_solves;
        options.linear.tolerance = weights.tolerance();
        options.linear.progress = &progress;
        if (solver_) {
            options.linear.hierarchy = solver_->solver().hierarchy();
            analyses_[solver_weights_.order() - 1] = solver_->solver().analysis();
        }
        std::shared_ptr<const CholeskyAnalysis>& analysis = analyses_[weights.order() - 1];
        if (!analysis && weights.order() == 2 && foreseen_.valid()) analysis = foreseen_.get();
        options.linear.analysis = analysis;
        solver_.emplace(stage_.laplacian(), options);
        solver_weights_ = weights;
        return *solver_;
    }

    // The pattern of K D K takes longest to analyse: it is done while nobody has asked for gamma_2 yet.
    void foresee() {
        if (foreseen_.valid() || solver_weights_.order() == 2 || stage_.vertex_count() > most_foreseen)
            return;
        foreseen_ = std::async(std::launch::async, [this] {
            setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()),
                        10);  // of this thread: the others come first
            LinearSolver smooth(PdeOperator(stage_.laplacian(), 0.0, {1.0, 1.0}),
                                {.expected_solves = expected_solves});
            smooth.analyse();
            return smooth.analysis();
        });
    }

    Mode mode_ = Mode::scalar;
    std::array<FixedValues, 3> fixed_of_mode_;
    Weights weights_;
    long asked_ = 0;  // the newest request
    Block value_;
    Mode value_mode_ = Mode::scalar;
    std::optional<Outgoing> newest_;
    // Of the solver thread alone.
    std::optional<Interpolator> solver_;
    Weights solver_weights_;
    std::array<std::shared_ptr<const CholeskyAnalysis>, 2> analyses_;  // by the order of the operator
    std::future<std::shared_ptr<const CholeskyAnalysis>> foreseen_;    // of the second
};

}  // namespace

std::unique_ptr<Task> make_paint_task(Stage& stage) {
    return std::make_unique<PaintTask>(stage);
}

}  // namespace beltrami::view
