#include "beltrami/solvers/supernodal_kernels.hpp"

#include <vector>

#define BELTRAMI_KERNELS any_machine
#define BELTRAMI_KERNELS_NAME "any"
#define BELTRAMI_KERNELS_TARGET
#define BELTRAMI_KERNELS_LANES 2
#define BELTRAMI_KERNELS_NARROW_LANES 2
#define BELTRAMI_KERNELS_REGISTERS 2
#include "beltrami/solvers/supernodal_kernels_body.hpp"
#undef BELTRAMI_KERNELS
#undef BELTRAMI_KERNELS_NAME
#undef BELTRAMI_KERNELS_TARGET
#undef BELTRAMI_KERNELS_LANES
#undef BELTRAMI_KERNELS_NARROW_LANES
#undef BELTRAMI_KERNELS_REGISTERS

#if defined(__x86_64__)
#define BELTRAMI_KERNELS with_avx2
#define BELTRAMI_KERNELS_NAME "avx2"
#define BELTRAMI_KERNELS_TARGET __attribute__((target("avx2,fma")))
#define BELTRAMI_KERNELS_LANES 4
#define BELTRAMI_KERNELS_NARROW_LANES 4
#define BELTRAMI_KERNELS_REGISTERS 2
#include "beltrami/solvers/supernodal_kernels_body.hpp"
#undef BELTRAMI_KERNELS
#undef BELTRAMI_KERNELS_NAME
#undef BELTRAMI_KERNELS_TARGET
#undef BELTRAMI_KERNELS_LANES
#undef BELTRAMI_KERNELS_NARROW_LANES
#undef BELTRAMI_KERNELS_REGISTERS

#define BELTRAMI_KERNELS with_avx512
#define BELTRAMI_KERNELS_NAME "avx512"
#define BELTRAMI_KERNELS_TARGET __attribute__((target("avx512f,avx512vl,avx2,fma")))
#define BELTRAMI_KERNELS_LANES 8
#define BELTRAMI_KERNELS_NARROW_LANES 4
#define BELTRAMI_KERNELS_REGISTERS 4
#include "beltrami/solvers/supernodal_kernels_body.hpp"
#undef BELTRAMI_KERNELS
#undef BELTRAMI_KERNELS_NAME
#undef BELTRAMI_KERNELS_TARGET
#undef BELTRAMI_KERNELS_LANES
#undef BELTRAMI_KERNELS_NARROW_LANES
#undef BELTRAMI_KERNELS_REGISTERS
#endif

namespace beltrami::supernodal {

std::span<const Kernels* const> available_kernels() {
    static const std::vector<const Kernels*> available = [] {
        std::vector<const Kernels*> found;
#if defined(__x86_64__)
        const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
        if (avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) {
            found.push_back(&with_avx512::all);
        }
        if (avx2) found.push_back(&with_avx2::all);
#endif
        found.push_back(&any_machine::all);
        return found;
    }();
    return available;
}

}  // namespace beltrami::supernodal
