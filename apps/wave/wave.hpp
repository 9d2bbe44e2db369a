// Waves over a mesh: u_tt + beta_1 u_t - beta_2 Laplacian of u_t = Laplacian of u.
//
//     const Constraints impulses{{120, 1.0}};
//     Evolution result = wave(laplacian, u, impulses, {.time = 1.0, .steps = 500, .method = TimeMethod::implicit_midpoint});
//
// alpha = 1, gamma_1 = 1 and Rayleigh damping in the general PDE: section 5.1 of Kim & Rossignac. Waves travel one unit
// of length in one unit of time.
#pragma once

#include "beltrami/apps/evolve.hpp"

namespace beltrami {

struct Damping {
    double beta_1 = 0.0;  ///< 1 / time, the same for all frequencies
    double beta_2 = 0.0;  ///< time, stronger for high frequencies
};

/// initial: displacement at rest, n x k. impulses: at each named vertex the momentum, in units of u length^d / time for
/// cells of dimension d: the vertex starts with velocity (impulse / its mass), which makes waves independent of the
/// mesh's resolution. Both in the user's order. Throws InputError for an impulse on an isolated vertex, and as
/// evolve() does; SolveError without convergence.
Evolution wave(const Laplacian& laplacian, const Block& initial, const Constraints& impulses,
               const EvolveOptions& options, const Damping& damping = {});

/// The time in which waves cross half the mesh.
inline double usual_wave_time(const Mesh& mesh) {
    return extent(mesh);
}

}  // namespace beltrami
