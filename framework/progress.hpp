// How long work tells where it is, and how it is told to stop.
//
//     Progress progress([](const ProgressReport& r) { fmt::print("{} {:.0f} %\n", r.phase, 100 * r.fraction); });
//     heat(laplacian, initial, sources, {.progress = &progress});    // throws Cancelled after progress.cancel()
#pragma once

#include <atomic>
#include <functional>
#include <string_view>
#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

struct ProgressReport {
    std::string_view phase;  ///< what is being done, a few words
    double fraction;         ///< in [0, 1] within the phase; negative where it is not known
};

/// cancel() may be called from another thread or from a signal handler; report() comes from the thread that
/// works. Work checks for a cancel at least once for each solver iteration and each time step.
class Progress {
  public:
    using Callback = std::function<void(const ProgressReport&)>;

    Progress() = default;
    explicit Progress(Callback callback) : callback_(std::move(callback)) {}
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    ~Progress() = default;

    void report(std::string_view phase, double fraction) const {
        if (callback_) callback_({phase, fraction});
    }
    void cancel() noexcept { cancelled_.store(true); }
    [[nodiscard]] bool cancelled() const noexcept { return cancelled_.load(); }
    /// Forgets a cancel: for the next piece of work under the same Progress.
    void restart() noexcept { cancelled_.store(false); }

    /// Throws Cancelled once cancel() was called.
    void check() const {
        if (cancelled()) throw Cancelled();
    }

  private:
    Callback callback_;
    std::atomic<bool> cancelled_ = false;
};

/// For a `Progress*` that may be null: reports, then throws Cancelled if asked to stop.
inline void report(const Progress* progress, std::string_view phase, double fraction) {
    if (progress == nullptr) return;
    progress->report(phase, fraction);
    progress->check();
}

}  // namespace beltrami
