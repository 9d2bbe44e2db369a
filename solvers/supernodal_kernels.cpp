#include "beltrami/solvers/supernodal_kernels.hpp"

#define BELTRAMI_KERNELS any_machine
#define BELTRAMI_KERNELS_NAME "any"
#define BELTRAMI_KERNELS_TARGET
#define BELTRAMI_KERNELS_LANES 2
#define BELTRAMI_KERNELS_REGISTERS 2
#include "beltrami/solvers/supernodal_kernels_body.hpp"
#undef BELTRAMI_KERNELS
#undef BELTRAMI_KERNELS_NAME
#undef BELTRAMI_KERNELS_TARGET
#undef BELTRAMI_KERNELS_LANES
#undef BELTRAMI_KERNELS_REGISTERS

#if defined(__x86_64__)
#define BELTRAMI_KERNELS with_avx2
#define BELTRAMI_KERNELS_NAME "avx2"
#define BELTRAMI_KERNELS_TARGET __attribute__((target("avx2,fma")))
#define BELTRAMI_KERNELS_LANES 4
#define BELTRAMI_KERNELS_REGISTERS 2
#include "beltrami/solvers/supernodal_kernels_body.hpp"
#undef BELTRAMI_KERNELS
#undef BELTRAMI_KERNELS_NAME
#undef BELTRAMI_KERNELS_TARGET
#undef BELTRAMI_KERNELS_LANES
#undef BELTRAMI_KERNELS_REGISTERS

#define BELTRAMI_KERNELS with_avx512
#define BELTRAMI_KERNELS_NAME "avx512"
#define BELTRAMI_KERNELS_TARGET __attribute__((target("avx512f,avx512vl,avx2,fma")))
#define BELTRAMI_KERNELS_LANES 8
#define BELTRAMI_KERNELS_REGISTERS 4
#include "beltrami/solvers/supernodal_kernels_body.hpp"
#undef BELTRAMI_KERNELS
#undef BELTRAMI_KERNELS_NAME
#undef BELTRAMI_KERNELS_TARGET
#undef BELTRAMI_KERNELS_LANES
#undef BELTRAMI_KERNELS_REGISTERS
#endif

namespace beltrami::supernodal {

const Kernels& kernels() {
#if defined(__x86_64__)
    static const Kernels& best = [&]() -> const Kernels& {
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) return with_avx512::all;
        if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return with_avx2::all;
        return any_machine::all;
    }();
    return best;
#else
    return any_machine::all;
#endif
}

}  // namespace beltrami::supernodal
