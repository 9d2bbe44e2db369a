// The one thread that solves: what replaces what, in which order, and what ends it.

#include "view/worker.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <atomic>
#include <chrono>
#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "threads.hpp"

namespace beltrami::view {
namespace {

using std::chrono::milliseconds;

// What was done, in order; from any thread.
class Diary {
  public:
    void write(const std::string& entry) {
        const std::lock_guard lock(mutex_);
        entries_.push_back(entry);
    }
    [[nodiscard]] std::vector<std::string> read() const {
        const std::lock_guard lock(mutex_);
        return entries_;
    }
    Worker::Work entry(const std::string& text) {
        return [this, text](const Progress&) { write(text); };
    }

  private:
    mutable std::mutex mutex_;
    std::vector<std::string> entries_;
};

// Work that begins, and ends when it is told to.
class Gate {
  public:
    Worker::Work work() {
        return [this](const Progress&) {
            begun_.set_value();
            open_.get_future().wait();
        };
    }
    void wait_until_begun() { begun_.get_future().wait(); }
    void open() { open_.set_value(); }

  private:
    std::promise<void> begun_, open_;
};

void wait_until_idle(Worker& worker) {
    std::promise<void> last;
    worker.post("the last", [&](const Progress&) { last.set_value(); });
    last.get_future().wait();
}

// Until it is cancelled; then true.
bool wait_for_cancel(const Progress& progress) {
    for (int i = 0; i < 60'000 && !progress.cancelled(); ++i)
        std::this_thread::sleep_for(milliseconds(1));
    return progress.cancelled();
}

TEST(Worker, TheNewestOfAKindReplacesWhatWaitsInItsPlace) {
    Diary diary;
    Gate gate;
    Worker worker;
    worker.post("paint", gate.work());
    gate.wait_until_begun();
    for (int i = 0; i < 3; ++i) {
        for (const std::string kind : {"paint", "heat", "poke"})
            worker.post(kind, diary.entry(kind + std::to_string(i)));
    }
    gate.open();
    wait_until_idle(worker);
    EXPECT_EQ(diary.read(), (std::vector<std::string>{"paint2", "heat2", "poke2"}));
}

TEST(Worker, CancelsWhatRunsAndTheNextIsNotCancelled) {
    Worker worker;
    Gate gate;
    std::promise<void> begun;
    std::promise<bool> cancelled;
    std::promise<bool> next;
    worker.post("heat", [&](const Progress& progress) {
        begun.set_value();
        cancelled.set_value(wait_for_cancel(progress));
    });
    begun.get_future().wait();
    worker.post("heat", [&](const Progress& progress) { next.set_value(progress.cancelled()); });
    // Of another kind: nothing happens.
    worker.cancel("wave");
    worker.post("wave", gate.work());
    worker.cancel("heat");
    EXPECT_TRUE(cancelled.get_future().get());
    EXPECT_TRUE(next.get_future().get());  // it was waiting
    gate.wait_until_begun();
    gate.open();
    std::promise<bool> later;
    worker.post("heat", [&](const Progress& progress) { later.set_value(progress.cancelled()); });
    EXPECT_FALSE(later.get_future().get());
}

TEST(Worker, NewWorkInThePlaceOfCancelledWorkRuns) {
    Worker worker;
    Gate gate;
    std::promise<bool> cancelled;
    worker.post("paint", gate.work());
    gate.wait_until_begun();
    worker.post("heat", [](const Progress&) { ADD_FAILURE() << "was replaced"; });
    worker.cancel("heat");
    worker.post("heat", [&](const Progress& progress) { cancelled.set_value(progress.cancelled()); });
    gate.open();
    EXPECT_FALSE(cancelled.get_future().get());
}

TEST(Worker, PausesAndResumes) {
    Worker worker;
    std::atomic<int> steps = 0;
    std::promise<void> begun, over;
    worker.post("wave", [&](const Progress& progress) {
        begun.set_value();
        try {
            for (;;) {
                worker.wait_while_paused(progress);
                ++steps;
                std::this_thread::sleep_for(std::chrono::microseconds(100));
            }
        } catch (const Cancelled&) {
            over.set_value();
        }
    });
    begun.get_future().wait();
    worker.pause("heat");
    EXPECT_FALSE(worker.paused());
    worker.pause("wave");
    EXPECT_TRUE(worker.paused());
    std::this_thread::sleep_for(milliseconds(5));  // the step that was under way
    const int before = steps;
    std::this_thread::sleep_for(milliseconds(20));
    EXPECT_LE(steps, before + 1);
    worker.resume();
    while (steps < before + 5)
        std::this_thread::sleep_for(milliseconds(1));
    worker.pause("wave");
    worker.cancel("wave");  // wakes it
    over.get_future().wait();
    wait_until_idle(worker);
    EXPECT_FALSE(worker.paused());
    worker.pause("wave");  // nothing runs
    EXPECT_FALSE(worker.paused());
}

TEST(Worker, EndsWithWhatRunsAndDropsWhatWaits) {
    for (const bool paused : {false, true}) {
        Diary diary;
        {
            Worker worker;
            std::promise<void> begun;
            worker.post("wave", [&](const Progress& progress) {
                begun.set_value();
                try {
                    for (;;) {
                        worker.wait_while_paused(progress);
                        std::this_thread::sleep_for(milliseconds(1));
                    }
                } catch (const Cancelled&) {
                    diary.write("cancelled");
                }
            });
            begun.get_future().wait();
            if (paused) worker.pause("wave");
            worker.post("heat", diary.entry("heat"));
            worker.post("paint", diary.entry("paint"));
        }
        EXPECT_EQ(diary.read(), std::vector<std::string>{"cancelled"});
    }
}

TEST(Worker, EndsAtOnceWhenIdle) {
    const Worker worker;
    EXPECT_FALSE(worker.paused());
}

TEST(Worker, TellsProgressFromTimeToTime) {
    Diary told;
    {
        Worker worker([&](const std::string& kind, const ProgressReport& report) {
            told.write(kind + " " + std::string(report.phase));
        });
        worker.post("harmonics", [&](const Progress& progress) {
            for (int i = 0; i < 100'000; ++i)
                progress.report("bands", 0.5);
            std::this_thread::sleep_for(milliseconds(60));
            for (int i = 0; i < 10; ++i)
                progress.report("more bands", 0.6);
        });
        wait_until_idle(worker);
    }
    const std::vector<std::string> all = told.read();
    EXPECT_EQ(all.front(), "harmonics bands");
    EXPECT_EQ(all.back(), "harmonics more bands");
    EXPECT_LT(all.size(), 100U);
}

// OpenMP keeps its number of threads for each thread: --threads must hold for the one that solves.
TEST(Worker, WorksWithAsManyThreadsAsItsMaker) {
    const testing::Threads one(1);
    Worker worker;
    std::promise<int> threads;
    worker.post("heat", [&](const Progress&) { threads.set_value(omp_get_max_threads()); });
    EXPECT_EQ(threads.get_future().get(), 1);
}

}  // namespace
}  // namespace beltrami::view
