// A task of the viewer: what a user can do to the mesh in one panel of the page, on the library's app functions.
//
// Whatever a task keeps for its pages (its state, its newest results) is under Stage::mutex: requests come with it locked;
// work on the solver thread locks it when it has something to say.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "request.hpp"
#include "server.hpp"
#include "shell_line.hpp"
#include "worker.hpp"

namespace beltrami::view {

constexpr Index most_steps = 10000;  ///< of a simulation

/// What all tasks work on, and whom they tell.
struct Stage {
    Mesh mesh;
    MeshReport report;
    std::optional<Laplacian> made_laplacian;
    std::string why_no_laplacian;  ///< a sentence where there is none
    std::string argument;          ///< MESH, as the user wrote it
    std::size_t most_bytes_of_moments;
    std::filesystem::path scratch;  ///< a folder of the program's own, removed at its end

    std::mutex mutex = {};
    Worker* worker = nullptr;
    std::function<void(Outgoing)> broadcast = {};
    std::function<void()> state_changed = {};  ///< with the mutex locked
    std::optional<std::string> running = {};   ///< long work that pages show as such

    /// Gives the worker something to do. Errors become messages to the pages. `announced`: long work, of which pages are told
    /// that it runs, that it has ended, and what work() returned.
    void post(const std::string& task, long id, bool announced,
              std::function<std::string(const Progress&)> work);
    /// Throws InputError where the mesh has none: it can only be looked at.
    [[nodiscard]] const Laplacian& laplacian() const;
    [[nodiscard]] Index vertex_count() const { return mesh.vertex_count(); }
};

/// For the message `frame`.
nlohmann::json frame_header(const std::string& task, long id, double seconds, const std::string& note);

Outgoing text_message(const nlohmann::json& json, std::string replaces = {});
Outgoing parcel_message(std::string bytes, std::string replaces = {});

/// What `save` writes of a task.
struct Saved {
    Mesh mesh;
    Fields fields;
    std::string csv;  ///< what was placed; empty: nothing
    std::string moment =
        {};  ///< which one, for the name of the file; empty: there is but one, or it is the last
};

class Task {
  public:
    explicit Task(Stage& stage) : stage_(stage) {}
    Task(const Task&) = delete;
    Task& operator=(const Task&) = delete;
    virtual ~Task() = default;

    [[nodiscard]] virtual std::string name() const = 0;
    /// False where the request is none of the task's.
    virtual bool handle(const Request& request) = 0;
    /// The request `run`.
    virtual void run(const Request& request);
    /// Takes back what was placed.
    virtual void clear(const Request& request) = 0;
    /// The user has turned to this task.
    virtual void enter() {}
    /// The user has turned to another task.
    virtual void leave() {}
    [[nodiscard]] virtual nlohmann::json state() const = 0;
    /// Command lines that do what the task shows; none where there is nothing yet.
    [[nodiscard]] virtual std::vector<std::string> command() const = 0;
    /// The newest results, for a page that has just opened.
    [[nodiscard]] virtual std::vector<Outgoing> newest() const = 0;
    /// Throws InputError where there is nothing yet.
    [[nodiscard]] virtual Saved saved() const = 0;
    /// Of a simulation its moment at that step.
    [[nodiscard]] virtual Saved saved_at(Index) const { return saved(); }

  protected:
    Stage& stage_;
};

std::unique_ptr<Task> make_heat_task(Stage& stage);
std::unique_ptr<Task> make_wave_task(Stage& stage);
std::unique_ptr<Task> make_paint_task(Stage& stage);
std::unique_ptr<Task> make_poke_task(Stage& stage);
std::unique_ptr<Task> make_harmonics_task(Stage& stage);

}  // namespace beltrami::view
