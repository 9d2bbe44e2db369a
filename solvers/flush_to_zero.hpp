// For sweeps in floats.
#pragma once

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace beltrami {

/// While one lives, what its thread computes is zero where it would be denormal: far from its load a sweep has little else,
/// and the processor takes a hundred times as long over it.
class FlushToZero {
  public:
#if defined(__SSE__)
    FlushToZero() {
        _mm_setcsr(before_ | 0x8040U);
    }
    ~FlushToZero() {
        _mm_setcsr(before_);
    }
#else
    FlushToZero() = default;
    ~FlushToZero() = default;
#endif
    FlushToZero(const FlushToZero&) = delete;
    FlushToZero& operator=(const FlushToZero&) = delete;

  private:
#if defined(__SSE__)
    unsigned before_ = _mm_getcsr();
#endif
};

}  // namespace beltrami
