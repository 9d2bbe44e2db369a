#include "worker.hpp"

#include <omp.h>

#include <algorithm>
#include <utility>

namespace beltrami::view {

Worker::Worker(std::function<void(const std::string&, const ProgressReport&)> on_progress)
    : on_progress_(std::move(on_progress)),
      threads_(omp_get_max_threads()),
      progress_([this](const ProgressReport& report) {
          const auto now = std::chrono::steady_clock::now();
          if (!on_progress_ || now - last_report_ < std::chrono::milliseconds(50)) return;
          last_report_ = now;
          on_progress_(*running_, report);
      }),
      thread_([this] { run(); }) {}

Worker::~Worker() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
        waiting_.clear();
        progress_.cancel();
    }
    changed_.notify_all();
    thread_.join();
}

void Worker::post(const std::string& kind, Work work) {
    {
        const std::lock_guard lock(mutex_);
        const auto same =
            std::find_if(waiting_.begin(), waiting_.end(), [&](const Job& job) { return job.kind == kind; });
        if (same != waiting_.end()) {
            same->work = std::move(work);
            same->cancelled = false;
        } else {
            waiting_.push_back({kind, std::move(work)});
        }
    }
    changed_.notify_all();
}

void Worker::cancel(const std::string& kind) {
    {
        const std::lock_guard lock(mutex_);
        if (running_ == kind) {
            paused_ = false;
            progress_.cancel();
        }
        for (Job& job : waiting_)
            job.cancelled = job.cancelled || job.kind == kind;
    }
    changed_.notify_all();
}

void Worker::pause(const std::string& kind) {
    const std::lock_guard lock(mutex_);
    if (running_ == kind && !progress_.cancelled()) paused_ = true;
}

void Worker::resume() {
    {
        const std::lock_guard lock(mutex_);
        paused_ = false;
    }
    changed_.notify_all();
}

void Worker::wait_while_paused(const Progress& progress) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !paused_ || progress.cancelled(); });
    progress.check();
}

void Worker::run() {
    omp_set_num_threads(threads_);
    for (;;) {
        Job job;
        {
            std::unique_lock lock(mutex_);
            running_.reset();
            paused_ = false;
            changed_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
            if (ending_) return;
            job = std::move(waiting_.front());
            waiting_.pop_front();
            running_ = job.kind;
            progress_.restart();
            if (job.cancelled) progress_.cancel();
        }
        job.work(progress_);
    }
}

}  // namespace beltrami::view
