// Shared by the benchmark programs: the machine, its stream bandwidth, and a reporter that sets what was timed side by
// side: ours against an alternative, and against the bound (bytes moved / stream bandwidth).
#pragma once

#include <benchmark/benchmark.h>

#include <map>
#include <string>
#include <vector>

namespace beltrami::bench {

/// GB/s of the triad a = b + s c over arrays far larger than the caches, on `threads` threads; counts 24 bytes an entry.
double stream_bandwidth(int threads);

/// The processor's name and the number of cores.
std::string machine();

/// Names read "WHAT/METHOD"; rows with the same WHAT form a group, set against the method among `baselines` that it has. Counters used:
/// bytes (moved by one call, at least), memory (held by the method), threads.
class RatioReporter : public benchmark::ConsoleReporter {
  public:
    explicit RatioReporter(std::vector<std::string> baselines);
    bool ReportContext(const Context& context) override;
    void ReportRuns(const std::vector<Run>& runs) override;
    void Finalize() override;

  private:
    struct Row {
        std::string method;
        double milliseconds;
        double bytes;
        double memory;
        int threads;
    };
    std::vector<std::string> baselines_;
    std::vector<std::string> order_;
    std::map<std::string, std::vector<Row>> groups_;
    std::map<int, double> bandwidth_;  // GB/s of each number of threads
};

}  // namespace beltrami::bench
