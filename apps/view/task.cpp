#include "task.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <utility>

namespace beltrami::view {

namespace {

nlohmann::json done(const std::string& task, long id) {
    return {{"kind", "done"},     {"task", task}, {"id", id},  {"text", ""},
            {"cancelled", false}, {"error", ""},  {"hint", ""}};
}

}  // namespace

void Stage::post(const std::string& task, long id, bool announced,
                 std::function<std::string(const Progress&)> work) {
    worker->post(task, [this, task, id, announced, work = std::move(work)](const Progress& progress) {
        if (announced) {
            const std::lock_guard lock(mutex);
            running = task;
            state_changed();
        }
        nlohmann::json message = done(task, id);
        bool tell = announced;
        try {
            message["text"] = work(progress);
        } catch (const Cancelled&) {
            message["cancelled"] = true;
            message["text"] = "cancelled";
        } catch (const Error& error) {
            message["error"] = error.what();
            message["hint"] = error.hint();
            tell = true;
        } catch (const std::bad_alloc&) {
            message["error"] = "this machine's memory does not suffice";
            message["hint"] = "use a smaller mesh";
            tell = true;
        } catch (const std::exception& error) {
            message["error"] = error.what();
            message["hint"] = "this is a defect of beltrami; please report it with what you did";
            tell = true;
        }
        const std::lock_guard lock(mutex);
        if (tell) broadcast(text_message(message));
        if (!announced) return;
        running.reset();
        state_changed();
    });
}

const Laplacian& Stage::laplacian() const {
    if (made_laplacian) return *made_laplacian;
    throw InputError(why_no_laplacian, "it can be looked at, and no more");
}

nlohmann::json frame_header(const std::string& task, long id, double seconds, const std::string& note) {
    return {{"kind", "frame"}, {"task", task}, {"id", id}, {"seconds", seconds}, {"note", note}};
}

Outgoing text_message(const nlohmann::json& json, std::string replaces) {
    return {std::make_shared<const std::string>(
                json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)),
            false, std::move(replaces)};
}

Outgoing parcel_message(std::string bytes, std::string replaces) {
    return {std::make_shared<const std::string>(std::move(bytes)), true, std::move(replaces)};
}

void Task::run(const Request&) {
    throw InputError(fmt::format("there is nothing to run in the task {}", name()), "choose heat or wave");
}

}  // namespace beltrami::view
