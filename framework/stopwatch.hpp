// How long a phase takes.
//
//     const Stopwatch watch;
//     summary.total_seconds = watch.seconds();
//
//     const PhaseTimer timer(summary.factor_seconds);   // adds what passes until the end of the scope
#pragma once

#include <chrono>

namespace beltrami {

class Stopwatch {
  public:
    /// Since it was made.
    [[nodiscard]] double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Adds its lifetime to a sum, also where an exception ends it.
class PhaseTimer {
  public:
    explicit PhaseTimer(double& seconds) : seconds_(seconds) {}
    PhaseTimer(const PhaseTimer&) = delete;
    PhaseTimer& operator=(const PhaseTimer&) = delete;
    ~PhaseTimer() { seconds_ += watch_.seconds(); }

  private:
    double& seconds_;
    Stopwatch watch_;
};

}  // namespace beltrami
