// The one thread that solves: it takes the newest request of each kind, and can be paused, cancelled and ended.
//
//     Worker worker;
//     worker.post("paint", [&](const Progress& progress) { ... });    // replaces a "paint" that has not begun
//     worker.cancel("paint");                                          // ends it, or will at its start: it throws Cancelled
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "beltrami/framework/progress.hpp"

namespace beltrami::view {

class Worker {
  public:
    /// Must not throw anything: whoever posts work says what becomes of its errors.
    using Work = std::function<void(const Progress&)>;

    /// `on_progress(kind, report)`: from the thread that works, at most 20 times a second.
    explicit Worker(std::function<void(const std::string&, const ProgressReport&)> on_progress = {});
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;
    /// Cancels what runs and waits for it; what waits is dropped.
    ~Worker();

    /// In the place of waiting work of the same kind, else behind all that waits.
    void post(const std::string& kind, Work work);
    /// Ends work of the kind. What waits finds itself cancelled when it begins, so that none goes without its end.
    void cancel(const std::string& kind);

    /// Where work of the kind is running.
    void pause(const std::string& kind);
    void resume();
    [[nodiscard]] bool paused() const { return paused_; }
    /// For work to call between its steps: waits while it is paused. Throws Cancelled.
    void wait_while_paused(const Progress& progress);

  private:
    struct Job {
        std::string kind;
        Work work;
        bool cancelled = false;
    };
    void run();

    std::function<void(const std::string&, const ProgressReport&)> on_progress_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Job> waiting_;
    std::optional<std::string> running_;
    std::atomic<bool> paused_ = false;
    bool ending_ = false;
    std::chrono::steady_clock::time_point last_report_;
    int threads_;  // OpenMP keeps a number for each thread
    Progress progress_;
    std::thread thread_;  // the last: it uses all the others
};

}  // namespace beltrami::view
