// So many threads for BLAS while it lives. The dense blocks of a mesh's factor are small, and OpenBLAS's threads and
// OpenMP's wait for each other by spinning: on two cores that made solves ten times slower than one BLAS thread.
#pragma once

// Present when the BLAS is OpenBLAS, whose threads are its own.
extern "C" int openblas_get_num_threads() __attribute__((weak));
extern "C" void openblas_set_num_threads(int) __attribute__((weak));

namespace beltrami {

class BlasThreads {
  public:
    explicit BlasThreads(int wanted)
        : before_(openblas_set_num_threads != nullptr ? openblas_get_num_threads() : 0) {
        if (before_ > 0) openblas_set_num_threads(wanted);
    }
    BlasThreads(const BlasThreads&) = delete;
    BlasThreads& operator=(const BlasThreads&) = delete;
    ~BlasThreads() {
        if (before_ > 0) openblas_set_num_threads(before_);
    }

    /// Floating-point operations from which a factorization gains by threads.
    static constexpr double worth_threads = 2e10;

  private:
    int before_;
};

}  // namespace beltrami
