// Heat and waves: sources and impulses are placed, then the whole simulation runs while its moments go to the pages.

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "beltrami/framework/stopwatch.hpp"
#include "parcel.hpp"
#include "task.hpp"

namespace beltrami::view {

namespace {

constexpr std::size_t most_placed = 1000;

class SimulationTask : public Task {
  public:
    SimulationTask(Stage& stage, bool wave)
        : Task(stage),
          wave_(wave),
          usual_time_(wave ? usual_wave_time(stage.mesh) : usual_heat_time(stage.mesh)),
          time_(usual_time_),
          steps_(wave ? 200 : 50),
          beta_2_(wave ? 1e-3 * time_ : 0.0) {}

    [[nodiscard]] std::string name() const override { return wave_ ? "wave" : "heat"; }

    bool handle(const Request& request) override {
        if (request.name() == (wave_ ? "wave.impulse" : "heat.source")) {
            const Index v = request.integer("vertex", 0, stage_.vertex_count() - 1);
            if (request.is_null("value")) {
                placed_.erase(v);
            } else {
                if (placed_.size() >= most_placed && !placed_.contains(v)) {
                    throw InputError(fmt::format("{} vertices are chosen already", most_placed),
                                     "more can be given on the command line");
                }
                placed_[v] = request.number("value", -1e12, 1e12);
            }
            return true;
        }
        if (request.name() != name() + ".set") return false;
        if (request.has("time")) time_ = request.number("time", 1e-12 * usual_time_, 1e12 * usual_time_);
        if (request.has("steps")) steps_ = request.integer("steps", 1, most_steps);
        if (wave_ && request.has("beta_2")) beta_2_ = request.number("beta_2", 0.0, 1e6);
        return true;
    }

    void run(const Request& request) override {
        if (placed_.empty()) {
            throw InputError(
                wave_ ? "nothing moves: no vertex is struck" : "there is no heat: no source is placed",
                "click on the surface");
        }
        Constraints given;
        for (const auto& [v, value] : placed_)
            given.fix(v, value);
        ran_ = {placed_, time_, steps_, beta_2_};
        moments_.clear();
        stride_ = 1;
        last_ = Block();
        stage_.post(name(), request.id(), true,
                    [this, given, ran = ran_, id = request.id()](const Progress& progress) {
                        return simulate(given, ran, id, progress);
                    });
    }

    void clear(const Request&) override {
        placed_.clear();
        moments_.clear();
        last_ = Block();
    }

    [[nodiscard]] nlohmann::json state() const override {
        nlohmann::json placed = nlohmann::json::array();
        for (const auto& [v, value] : placed_)
            placed.push_back({v, value});
        nlohmann::json json = {{wave_ ? "impulses" : "sources", placed}, {"time", time_}, {"steps", steps_}};
        if (wave_) json["beta_2"] = beta_2_;
        return json;
    }

    [[nodiscard]] std::vector<std::string> command() const override {
        if (placed_.empty()) return {};
        std::string line = fmt::format("beltrami {} {}", name(), shell_word(stage_.argument));
        for (const auto& [v, value] : placed_)
            line += fmt::format(" {} {}={}", wave_ ? "--impulse" : "--source", v, value);
        line += fmt::format(" --time {} --steps {}", time_, steps_);
        if (beta_2_ > 0.0) line += fmt::format(" --damping 0,{}", beta_2_);
        return {line + fmt::format(" -o {}.ply", name())};
    }

    [[nodiscard]] std::vector<Outgoing> newest() const override {
        std::vector<Outgoing> messages;
        for (const Moment& moment : moments_)
            messages.push_back(moment.message);
        return messages;
    }

    [[nodiscard]] Saved saved() const override {
        if (last_.size() == 0) throw InputError("nothing was simulated yet", "press Run first");
        std::string csv = "vertex,value\n";
        for (const auto& [v, value] : ran_.placed)
            csv += fmt::format("{},{}\n", v, value);
        const std::string moment = last_step_ == ran_.steps ? "" : std::to_string(last_step_);
        return {stage_.mesh, {{"u", last_}}, csv, moment};
    }

    [[nodiscard]] Saved saved_at(Index step) const override {
        Saved saved = this->saved();
        if (step == last_step_) return saved;
        const auto found = std::find_if(moments_.begin(), moments_.end(),
                                        [step](const Moment& moment) { return moment.step == step; });
        if (found == moments_.end()) {
            throw InputError(fmt::format("the moment of step {} is not kept", step),
                             "choose another moment on the time line");
        }
        const std::vector<float> values = floats_of(*found->message.bytes, "values");
        saved.fields[0].values =
            Eigen::Map<const Eigen::VectorXf>(values.data(), static_cast<Eigen::Index>(values.size()))
                .cast<double>();
        saved.moment = std::to_string(step);
        return saved;
    }

  private:
    struct Moment {
        int step;
        Outgoing message;
    };
    struct Settings {
        std::map<Index, double> placed;
        double time = 0.0;
        int steps = 0;
        double beta_2 = 0.0;
    };

    std::string simulate(const Constraints& given, const Settings& ran, long id, const Progress& progress) {
        progress.check();
        const Stopwatch watch;
        EvolveOptions options{.time = ran.time,
                              .steps = ran.steps,
                              .method = wave_ ? TimeMethod::implicit_midpoint : TimeMethod::backward_euler,
                              .progress = &progress};
        options.on_frame = [&](const Frame& frame) {
            stage_.worker->wait_while_paused(progress);
            keep(frame, ran.steps, id, watch.seconds(), progress);
        };
        const Block zero = Block::Zero(stage_.vertex_count(), 1);
        const Evolution evolution =
            wave_ ? wave(stage_.laplacian(), zero, given, options, {.beta_2 = ran.beta_2})
                  : heat(stage_.laplacian(), zero, given, options);
        return fmt::format("{} steps in {:.3g} s; {}", ran.steps, watch.seconds(), evolution.summary.brief());
    }

    void keep(const Frame& frame, int steps, long id, double seconds, const Progress& progress) {
        const std::lock_guard lock(stage_.mutex);
        progress.check();  // whoever cleared the moments of this run has cancelled it under the lock
        last_ = frame.u;
        last_step_ = frame.step;
        if (frame.step % stride_ != 0 && frame.step != steps) return;
        thin(frame.step);
        nlohmann::json header = frame_header(name(), id, seconds, "");
        header["step"] = frame.step;
        header["steps"] = steps;
        header["time"] = frame.time;
        header["energy"] = frame.energy;
        header["every"] = stride_;
        Parcel parcel(std::move(header));
        parcel.add("values", frame.u);
        moments_.push_back({frame.step, parcel_message(parcel.bytes())});
        stage_.broadcast(moments_.back().message);
    }

    // Too many moments: every other one is given up, here and, told by `every`, on the pages. It waits for a step that stays,
    // whose message tells them at once: what a page shows can be saved.
    void thin(int step) {
        if (moments_.empty() || step % (2 * stride_) != 0) return;
        if (moments_.size() * moments_.back().message.bytes->size() < stage_.most_bytes_of_moments) return;
        stride_ *= 2;
        std::erase_if(moments_, [&](const Moment& moment) { return moment.step % stride_ != 0; });
    }

    bool wave_;
    double usual_time_;
    std::map<Index, double> placed_;
    double time_;
    int steps_;
    double
        beta_2_;  // an impulse at a vertex is mostly waves as short as edges, which are damped to see the others
    Settings ran_;  // of the moments
    std::vector<Moment> moments_;
    int stride_ = 1;
    Block last_;  // in double precision, also where it is not among the moments
    int last_step_ = 0;
};

}  // namespace

std::unique_ptr<Task> make_heat_task(Stage& stage) {
    return std::make_unique<SimulationTask>(stage, false);
}

std::unique_ptr<Task> make_wave_task(Stage& stage) {
    return std::make_unique<SimulationTask>(stage, true);
}

}  // namespace beltrami::view
