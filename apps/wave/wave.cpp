#include "beltrami/apps/wave/wave.hpp"

#include <fmt/format.h>

#include "beltrami/framework/error.hpp"

namespace beltrami {

Evolution wave(const Laplacian& laplacian, const Block& initial, const Constraints& impulses,
               const EvolveOptions& options, const Damping& damping) {
    impulses.check_range(laplacian.vertex_count());
    Block velocity = Block::Zero(initial.rows(), initial.cols());
    impulses.impose(velocity);
    for (const Index v : impulses.vertices()) {
        const double mass = laplacian.mass()[laplacian.order().working(v)];
        if (mass <= 0.0) {
            throw InputError(
                fmt::format("vertex {} is isolated: it has no mass that an impulse could move", v),
                "give a vertex of a cell that has an area");
        }
        velocity.row(v) /= mass;
    }
    Pde pde;
    pde.alpha = 1.0;
    pde.beta_1 = damping.beta_1;
    pde.beta_2 = damping.beta_2;
    return evolve(laplacian, pde, initial, velocity, Constraints(static_cast<Index>(initial.cols())),
                  options);
}

}  // namespace beltrami
