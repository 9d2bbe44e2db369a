// Poking: a point of the surface is dragged, and the surface around it gives way in its active domain, in real time.

#include <fmt/format.h>

#include <chrono>
#include <span>
#include <thread>
#include <utility>

#include "beltrami/framework/stopwatch.hpp"
#include "parcel.hpp"
#include "task.hpp"

namespace beltrami::view {

namespace {

using Clock = LocalIntegrator::Clock;

// Steps in a second: the skin swings 10 times in one.
constexpr double rate = 250.0;
constexpr double frames_per_second = 60.0;
// Of a recorded path.
constexpr std::size_t most_waypoints = 100000;

class PokeTask : public Task {
  public:
    explicit PokeTask(Stage& stage) : Task(stage), farthest_(2.0 * extent(stage.mesh)) {}

    [[nodiscard]] std::string name() const override { return "poke"; }

    bool handle(const Request& request) override {
        if (request.name() == "poke.release") {
            held_.reset();
            asked_ = request.id();
            return true;
        }
        if (request.name() != "poke.hold") return false;
        const CellKind kind = stage_.mesh.kind();
        if (kind != CellKind::triangle && kind != CellKind::tetrahedron) {
            throw InputError(fmt::format("{} have no surface to touch", plural(kind)),
                             "try heat, waves, painting or harmonics");
        }
        const auto vector = [&](const char* key) {
            const std::vector<double> x = request.numbers(key, 3);
            return Vector3(x[0], x[1], x[2]);
        };
        const Contact contact{vector("point"), vector("displacement")};
        if (!(contact.displacement.norm() <= farthest_)) {
            throw InputError(fmt::format("a displacement of {:.3g} is more than the mesh is wide",
                                         contact.displacement.norm()),
                             "drag less far");
        }
        asked_ = request.id();
        if (!held_) {
            forget();
            step_of_press_ = 0;
        }
        held_ = contact;
        if (!moving_) {
            moving_ = true;
            stage_.post(name(), request.id(), false, [this](const Progress& progress) {
                move(progress);
                return std::string();
            });
        }
        return true;
    }

    void clear(const Request&) override {
        held_.reset();
        forget();
    }

    void leave() override { held_.reset(); }

    [[nodiscard]] nlohmann::json state() const override {
        return {{"rate", rate}, {"waypoints", path_.size()}};
    }

    [[nodiscard]] std::vector<std::string> command() const override {
        if (kept_steps_ == 0) return {};
        return {fmt::format("beltrami poke {} --path poke.csv --rate {} --time {} -o poke.ply",
                            shell_word(stage_.argument), rate, kept_steps_ / rate)};
    }

    [[nodiscard]] std::vector<Outgoing> newest() const override {
        if (!newest_) return {};
        return {*newest_};
    }

    [[nodiscard]] Saved saved() const override {
        if (kept_steps_ == 0) throw InputError("nothing was touched yet", "drag the surface");
        ContactPath path = path_;
        const double end = (kept_steps_ - 1) / rate;
        if (path.back().time < end) {  // it was held still
            path.push_back(path.back());
            path.back().time = end;
        }
        std::string csv = "time,x,y,z,dx,dy,dz\n";
        for (const Waypoint& w : path) {
            csv += fmt::format("{},{},{},{},{},{},{}\n", w.time, w.point.x(), w.point.y(), w.point.z(),
                               w.displacement.x(), w.displacement.y(), w.displacement.z());
        }
        Block displacement = Block::Zero(stage_.vertex_count(), 3);
        displacement(touched_, Eigen::all) = displacement_;
        return {displaced(stage_.mesh, displacement), {{"displacement", displacement}}, csv};
    }

  private:
    // On the solver thread, from the first touch until the surface is at rest.
    void move(const Progress& progress) {
        try {
            progress.check();
            if (!skin_) {
                PokeOptions options{.skin = skin_of(stage_.mesh), .rate = rate};
                skin_.emplace(stage_.mesh, stage_.laplacian(), options);
            }
            constexpr std::chrono::duration<double> dt(1.0 / rate);
            const auto step_length = std::chrono::duration_cast<Clock::duration>(dt);
            auto tick = Clock::now();
            auto next_frame = tick;
            int late = 0;
            int steps = 0;
            for (bool moving = true; moving;) {
                progress.check();
                std::optional<Contact> contact = take_contact();
                const auto deadline = std::max(tick + step_length, Clock::now() + step_length / 2);
                const LocalStep step = skin_->advance(std::span(&contact, 1), deadline);
                ++steps;
                late += step.in_time ? 0 : 1;
                const bool rests = !contact && skin_->motion().domain().empty();
                // A machine that cannot keep up shows slow motion rather than the jumps of catching up.
                tick = std::max(tick + step_length, Clock::now() - step_length);
                if (rests || Clock::now() >= next_frame) {
                    next_frame = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                    std::chrono::duration<double>(1.0 / frames_per_second));
                    moving = tell(step, contact, late, steps);
                    late = 0;
                    steps = 0;
                }
                std::this_thread::sleep_until(tick);
            }
        } catch (...) {
            skin_.reset();
            const std::lock_guard lock(stage_.mutex);
            moving_ = false;
            held_.reset();
            tell_rest();
            throw;
        }
    }

    // What is held now. The path is piecewise linear, and a contact keeps still until the next request: a waypoint goes before
    // each jump.
    std::optional<Contact> take_contact() {
        const std::lock_guard lock(stage_.mutex);
        if (held_ && path_.size() < most_waypoints) {
            const double time = static_cast<double>(step_of_press_) / rate;
            const bool moved = path_.empty() || path_.back().displacement != held_->displacement ||
                               path_.back().point != held_->point;
            if (moved) {
                if (!path_.empty() && path_.back().time < (step_of_press_ - 1) / rate) {
                    Waypoint before = path_.back();
                    before.time = (step_of_press_ - 1) / rate;
                    path_.push_back(before);
                }
                path_.push_back({time, held_->point, held_->displacement});
            }
            last_held_step_ = step_of_press_;
        } else if (!path_.empty() && kept_steps_ <= last_held_step_) {
            keep(moved());  // as it was when the finger let go
            stage_.state_changed();
        }
        ++step_of_press_;
        return held_;
    }

    // Vertices that are not at rest and outside.
    struct Moved {
        std::vector<Index> vertices;
        std::vector<Index> levels;
        Block displacement;
    };

    [[nodiscard]] Moved moved() const {
        const LocalIntegrator& motion = skin_->motion();
        const ActiveDomain& domain = motion.domain();
        Moved moved;
        moved.displacement.resize(std::max(domain.slot_count() - 1, 0), 3);
        for (Index s = 1; s < domain.slot_count(); ++s) {
            moved.vertices.push_back(stage_.laplacian().order().user(domain.vertex(s)));
            moved.levels.push_back(s < domain.end(0) ? 2 : 1);
            const auto u = motion.u(s);
            moved.displacement.row(s - 1) << u[0], u[1], u[2];
        }
        return moved;
    }

    // Of the press, after the last step in which something was held.
    void keep(Moved moved) {
        touched_ = std::move(moved.vertices);
        displacement_ = std::move(moved.displacement);
        kept_steps_ = last_held_step_ + 1;
    }

    void forget() {
        path_.clear();
        touched_.clear();
        displacement_.resize(0, 3);
        kept_steps_ = 0;
    }

    // False where the surface is at rest and nothing touches it: moving has ended, under the lock that a new touch takes.
    bool tell(const LocalStep& step, const std::optional<Contact>& contact, int late, int steps) {
        const ActiveDomain& domain = skin_->motion().domain();
        Moved now = moved();
        const auto& [vertices, levels, displacement] = now;
        const std::lock_guard lock(stage_.mutex);
        // A finger that keeps still holds a surface that does: pages are left alone, and draw it in full.
        if (contact && asked_ == told_ && !vertices.empty() && vertices == touched_ &&
            displacement.rows() == displacement_.rows() &&
            (displacement - displacement_).cwiseAbs().maxCoeff() <= 1e-3 * displacement.cwiseAbs().maxCoeff())
            return true;
        told_ = asked_;
        nlohmann::json header = frame_header(name(), asked_, step.seconds, "");
        header["time"] = skin_->motion().time();
        header["active"] = std::max(domain.end(0) - 1, 0);
        header["step_seconds"] = step.seconds;
        header["late"] = 2 * late > steps;
        header["force"] = nullptr;
        header["at"] = nullptr;
        if (contact) {
            const ContactState& state = skin_->contacts().front();
            const Vector3 at = state.at.point + state.displacement;
            header["force"] = {state.force.x(), state.force.y(), state.force.z()};
            header["at"] = {at.x(), at.y(), at.z()};
        }
        Parcel parcel(std::move(header));
        parcel.add("vertices", vertices);
        parcel.add("level", levels);
        parcel.add("displacement", displacement);
        newest_ = parcel_message(parcel.bytes(), name());
        stage_.broadcast(*newest_);
        // Not where another press has begun, nor where the path is full.
        if (contact && !path_.empty() && step_of_press_ == last_held_step_ + 1) keep(std::move(now));
        moving_ = held_ || !domain.empty();
        if (!moving_) stage_.state_changed();
        return moving_;
    }

    // With the mutex locked; after a motion that was broken off.
    void tell_rest() {
        if (!newest_) return;
        nlohmann::json header = frame_header(name(), asked_, 0.0, "");
        header.update({{"active", 0}, {"late", false}, {"force", nullptr}, {"at", nullptr}});
        Parcel parcel(std::move(header));
        parcel.add("vertices", std::span<const Index>());
        parcel.add("level", std::span<const Index>());
        parcel.add("displacement", Block(0, 3));
        newest_ = parcel_message(parcel.bytes(), name());
        stage_.broadcast(*newest_);
        stage_.state_changed();
    }

    double farthest_;  // beyond this the linear skin has left all likeness of the surface

    std::optional<Contact> held_;
    bool moving_ = false;  // a job is running or waiting
    long step_of_press_ = 0;
    long last_held_step_ = 0;
    long asked_ = 0;
    long told_ = -1;  // the request that the newest frame answers
    ContactPath path_;
    // What is saved: the newest surface that was told while something touched it, in the end that after the last step of the
    // press.
    std::vector<Index> touched_;
    Block displacement_ = Block(0, 3);  // of these
    long kept_steps_ = 0;               // that the press had taken until then; 0: nothing is kept
    std::optional<Outgoing> newest_;
    // Of the solver thread alone.
    std::optional<TouchedSurface> skin_;
};

}  // namespace

std::unique_ptr<Task> make_poke_task(Stage& stage) {
    return std::make_unique<PokeTask>(stage);
}

}  // namespace beltrami::view
