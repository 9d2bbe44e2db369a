// For tests of what runs on threads.
#pragma once

#include <omp.h>

namespace beltrami::testing {

/// As many threads as asked for, until the end of the scope.
class Threads {
  public:
    explicit Threads(int count) : before_(omp_get_max_threads()) { omp_set_num_threads(count); }
    Threads(const Threads&) = delete;
    Threads& operator=(const Threads&) = delete;
    ~Threads() { omp_set_num_threads(before_); }

  private:
    int before_;
};

}  // namespace beltrami::testing
