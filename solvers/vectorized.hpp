// For the few kernels that are written for vector registers: a function is compiled for several instruction sets, and
// the one that this machine has is taken when the program starts.
//
//     BELTRAMI_VECTORIZED void kernel(...) { ... }
//
// Everything that such a function calls must be inlined into it.
#pragma once

// Not under sanitizers: what chooses runs before they have started.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define BELTRAMI_VECTORIZED __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define BELTRAMI_VECTORIZED
#endif

namespace beltrami {

/// Eight numbers that are computed with at once; loads and stores need no alignment.
struct Lanes {
    // NOLINTNEXTLINE(modernize-use-using): an alias cannot carry both attributes
    typedef double Register __attribute__((vector_size(64), aligned(8)));
    Register v;
};
constexpr int lane_count = 8;

/// The eight numbers from p on.
__attribute__((always_inline)) inline const Lanes& lanes_at(const double* p) {
    return *reinterpret_cast<const Lanes*>(p);
}
__attribute__((always_inline)) inline Lanes& lanes_at(double* p) {
    return *reinterpret_cast<Lanes*>(p);
}

}  // namespace beltrami
