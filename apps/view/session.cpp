#include "session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <fstream>
#include <iterator>
#include <map>
#include <thread>
#include <utility>

#include "parcel.hpp"
#include "scene.hpp"
#include "task.hpp"

namespace beltrami::view {

namespace {

using Clock = std::chrono::steady_clock;

// Of files that were asked for and wait to be fetched.
constexpr std::size_t most_files = 4;
// A state that takes longer to write than `quick` is told at most during a fifth of the time: with many painted vertices it
// takes longer than a stroke of the brush.
constexpr std::chrono::milliseconds quick{5};
constexpr int rest_between_states = 4;

nlohmann::json refused(const Error& error) {
    return {{"kind", "refused"}, {"what", error.what()}, {"hint", error.hint()}};
}

std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

class Session::Implementation {
  public:
    Implementation(const Mesh& mesh, const MeshReport& report, const std::optional<Laplacian>& laplacian,
                   SessionOptions options)
        : options_(std::move(options)),
          stage_{.mesh = mesh,
                 .report = report,
                 .made_laplacian = laplacian,
                 .why_no_laplacian = options_.why_no_laplacian,
                 .argument = options_.argument,
                 .most_bytes_of_moments = options_.most_bytes_of_moments,
                 .scratch = options_.scratch},
          shown_(shown(mesh, mesh.vertex_count())),
          worker_([this](const std::string& task, const ProgressReport& report) {
              tell_progress(task, report);
          }) {
        stage_.worker = &worker_;
        stage_.broadcast = [this](Outgoing message) {
            if (voice_.broadcast) voice_.broadcast(std::move(message));
        };
        stage_.state_changed = [this] { tell_state(); };
        for (const auto make :
             {make_heat_task, make_wave_task, make_paint_task, make_poke_task, make_harmonics_task})
            tasks_.push_back(make(stage_));
        mesh_message_ = parcel_message(mesh_parcel(shown_, name_of_mesh(options_.argument), mesh, report));
    }

    [[nodiscard]] ServerHandlers handlers() {
        ServerHandlers handlers;
        handlers.opened = [this](ClientId client) { opened(client); };
        handlers.closed = [this](ClientId client) { closed(client); };
        handlers.text = [this](ClientId client, std::string_view text) { take(client, text); };
        handlers.file = [this](std::string_view name) { return file(name); };
        if (options_.binary)
            handlers.binary = [this](ClientId, std::string_view bytes) { options_.binary(bytes); };
        return handlers;
    }

    void speak_through(Voice voice) { voice_ = std::move(voice); }

  private:
    void opened(ClientId client) {
        const std::lock_guard lock(stage_.mutex);
        pages_[client] = 0;
        voice_.send(client, mesh_message_);
        if (!options_.greeting.empty()) {
            voice_.send(client, {std::make_shared<const std::string>(options_.greeting)});
            return;
        }
        voice_.send(client, text_message(state(), "state"));
        for (const auto& task : tasks_) {
            for (const Outgoing& message : task->newest())
                voice_.send(client, message);
        }
    }

    // A finger does not stay on the surface when its page is gone.
    void closed(ClientId client) {
        const std::lock_guard lock(stage_.mutex);
        pages_.erase(client);
        if (pages_.empty() || client == holder_) {
            holder_.reset();
            for (const auto& task : tasks_)
                task->leave();
        }
        if (pages_.empty()) worker_.resume();
    }

    void take(ClientId client, std::string_view text) {
        const std::lock_guard lock(stage_.mutex);
        try {
            const Request request(text);
            pages_[client] = request.id();
            dispatch(client, request);
            if (request.name() == "poke.hold") holder_ = client;
            // A finger moves sixty times a second and changes nothing that a page must know before it lets go.
            if (request.name() != "poke.hold") stage_.state_changed();
        } catch (const Error& error) {
            voice_.send(client, text_message(refused(error)));
        }
    }

    void dispatch(ClientId client, const Request& request) {
        const std::string& name = request.name();
        if (name == "task") {
            turn_to(task_words_[request.word("task", task_words_)]);
        } else if (name == "field") {
            const Field& field = stage_.mesh.field(request.text("name"));
            voice_.send(client, parcel_message(field_parcel(field, shown_, meaning_of(field))));
        } else if (name == "pause") {
            for (const char* const simulation : simulations)
                worker_.pause(simulation);
        } else if (name == "resume") {
            worker_.resume();
        } else if (name == "cancel") {
            if (stage_.running) worker_.cancel(*stage_.running);
        } else if (name == "run") {
            make_room(task_);
            current().run(request);
        } else if (name == "clear") {
            make_room(task_);
            current().clear(request);
        } else if (name == "save") {
            save(client, request);
        } else {
            const std::string task = name.substr(0, name.find('.'));
            for (const auto& candidate : tasks_) {
                if (candidate->name() != task) continue;
                make_room(task);
                if (candidate->handle(request)) return;
            }
            throw InputError(fmt::format("there is no request '{}'", printable(name)), "reload the page");
        }
    }

    // The solver takes the newest request: what runs for another task ends. Harmonics are not lost for a click.
    void make_room(const std::string& task) {
        static_cast<void>(stage_.laplacian());  // throws where nothing can be solved
        if (stage_.running == "harmonics") {
            throw InputError("harmonics are being computed", "wait for them, or cancel them");
        }
        for (const char* const simulation : simulations)
            worker_.cancel(simulation);
        if (task != "poke") worker_.cancel("poke");
    }

    void turn_to(const std::string& task) {
        if (task == task_) return;
        if (task != "look") static_cast<void>(stage_.laplacian());
        for (const auto& each : tasks_) {
            if (each->name() == task_) each->leave();
        }
        task_ = task;
        for (const auto& each : tasks_) {
            if (each->name() == task_) each->enter();
        }
    }

    Task& current() {
        for (const auto& task : tasks_) {
            if (task->name() == task_) return *task;
        }
        throw InputError("no task is chosen", "choose heat, wave, paint, poke or harmonics");
    }

    [[nodiscard]] nlohmann::json state() const {
        nlohmann::json json = {{"kind", "state"},
                               {"id", 0},
                               {"task", task_},
                               {"running", nullptr},
                               {"command", nlohmann::json::array()}};
        for (const auto& task : tasks_) {
            json[task->name()] = task->state();
            if (task->name() == task_) json["command"] = task->command();
        }
        if (task_ == "look") json["command"].push_back("beltrami view " + shell_word(stage_.argument));
        if (stage_.running) json["running"] = {{"task", *stage_.running}, {"paused", worker_.paused()}};
        return json;
    }

    void tell_state() {
        if (state_waits_) return;
        if (Clock::now() >= next_state_) return tell_state_now();
        state_waits_ = true;
        teller_.post("state", [this](const Progress& progress) {
            while (!progress.cancelled()) {
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
                const std::lock_guard lock(stage_.mutex);
                if (Clock::now() >= next_state_) return tell_state_now();
            }
        });
    }

    void tell_state_now() {
        state_waits_ = false;
        const auto start = Clock::now();
        nlohmann::json told = state();
        for (const auto& [client, newest] : pages_) {
            told["id"] = newest;  // each page counts its own requests
            voice_.send(client, text_message(told, "state"));
        }
        const auto end = Clock::now();
        next_state_ = end - start > quick ? end + rest_between_states * (end - start) : end;
    }

    // To the page that asked for it: the others would fetch it too.
    void save(ClientId client, const Request& request) {
        static const std::vector<std::string> formats = {"ply", "obj", "vtu", "csv"};
        const std::string& format = formats[request.word("format", formats)];
        Saved saved = task_ == "look"       ? Saved{stage_.mesh, {}, {}}
                      : request.has("step") ? current().saved_at(request.integer("step", 0, most_steps))
                                            : current().saved();
        const std::string moment = format == "csv" || saved.moment.empty() ? "" : "-" + saved.moment;
        const std::string name = fmt::format("{}{}.{}", task_ == "look" ? "mesh" : task_, moment, format);
        if (format == "csv" && saved.csv.empty())
            throw InputError("nothing was placed", "click on the surface");
        saver_.post(fmt::format("{} {}", client, name), [this, client, name, format,
                                                         saved = std::move(saved)](const Progress&) {
            nlohmann::json message = {{"kind", "saved"}, {"name", name}, {"path", "files/" + name}};
            std::string body = saved.csv;
            try {
                if (format != "csv") {
                    const std::filesystem::path path = stage_.scratch / name;
                    // OBJ has room for a colour only.
                    const bool holds =
                        format != "obj" || (saved.fields.size() == 1 && saved.fields[0].name == "color");
                    write_mesh(path, saved.mesh, holds ? saved.fields : Fields{});
                    body = bytes_of(path);
                    std::filesystem::remove(path);
                }
            } catch (const Error& error) {
                message = refused(error);
            } catch (const std::exception& error) {  // such as bad_alloc
                message = refused(SolveError(fmt::format("{} could not be made: {}", name, error.what()),
                                             "see whether memory and the disk suffice"));
            }
            const std::lock_guard lock(stage_.mutex);
            if (message["kind"] == "saved") keep_file(name, std::move(body));
            voice_.send(client, text_message(message));
        });
    }

    void keep_file(const std::string& name, std::string body) {
        std::erase_if(files_, [&](const auto& file) { return file.first == name; });
        if (files_.size() >= most_files) files_.pop_front();
        files_.emplace_back(name, std::move(body));
    }

    std::optional<Download> file(std::string_view name) {
        const std::lock_guard lock(stage_.mutex);
        const auto found =
            std::find_if(files_.begin(), files_.end(), [&](const auto& file) { return file.first == name; });
        if (found == files_.end()) return std::nullopt;
        return Download{name.ends_with(".csv") ? "text/csv" : "application/octet-stream", found->second};
    }

    // From the solver thread; of long work only.
    void tell_progress(const std::string& task, const ProgressReport& report) {
        const std::lock_guard lock(stage_.mutex);
        if (stage_.running != task) return;
        stage_.broadcast(text_message(
            {{"kind", "progress"}, {"task", task}, {"phase", report.phase}, {"fraction", report.fraction}},
            "progress"));
    }

    static std::string printable(const std::string& text) {
        std::string result = text.substr(0, 40);
        for (char& c : result) {
            if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
        }
        return result;
    }

    static constexpr std::array simulations{"heat", "wave"};
    inline static const std::vector<std::string> task_words_ = {"look",  "heat", "wave",
                                                                "paint", "poke", "harmonics"};

    SessionOptions options_;
    Stage stage_;
    Shown shown_;
    Outgoing mesh_message_;
    std::vector<std::unique_ptr<Task>> tasks_;
    std::string task_ = "look";
    std::map<ClientId, long> pages_;                         // and the newest request of each
    std::optional<ClientId> holder_;                         // whose finger was the last on the surface
    std::deque<std::pair<std::string, std::string>> files_;  // the oldest first
    Voice voice_;
    bool state_waits_ = false;  // the teller is about to tell it
    Clock::time_point next_state_ = {};
    // Their threads use all of the above.
    Worker teller_;
    Worker saver_;
    Worker worker_;
};

Session::Session(const Mesh& mesh, const MeshReport& report, const std::optional<Laplacian>& laplacian,
                 SessionOptions options)
    : implementation_(std::make_unique<Implementation>(mesh, report, laplacian, std::move(options))) {}

Session::~Session() = default;

ServerHandlers Session::handlers() {
    return implementation_->handlers();
}

void Session::speak_through(Voice voice) {
    implementation_->speak_through(std::move(voice));
}

}  // namespace beltrami::view
