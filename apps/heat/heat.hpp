// Heat over a mesh: u_t = Laplacian of u, with vertices held at a temperature.
//
//     const Constraints sources{{120, 100.0}};
//     Evolution result = heat(laplacian, initial, sources, {.time = 0.01, .steps = 50});
//
// beta_1 = 1, gamma_1 = 1 in the general PDE: section 5.1 of Kim & Rossignac. Time is in length^2, since the
// diffusivity is 1: heat reaches a distance of about sqrt(4 t).
#pragma once

#include "beltrami/apps/evolve.hpp"

namespace beltrami {

/// initial: n x k, sources: k columns, both in the user's order. Isolated vertices keep their initial value. Throws
/// InputError as evolve() does; SolveError without convergence.
Evolution heat(const Laplacian& laplacian, const Block& initial, const Constraints& sources,
               const EvolveOptions& options);

/// A time in which heat crosses a good part of the mesh: it reaches about sqrt(4 t).
inline double usual_heat_time(const Mesh& mesh) {
    return 0.25 * extent(mesh) * extent(mesh);
}

}  // namespace beltrami
