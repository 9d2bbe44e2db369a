#include "beltrami/apps/heat/heat.hpp"

namespace beltrami {

Evolution heat(const Laplacian& laplacian, const Block& initial, const Constraints& sources,
               const EvolveOptions& options) {
    Pde pde;
    pde.beta_1 = 1.0;
    return evolve(laplacian, pde, initial, Block::Zero(initial.rows(), initial.cols()), sources, options);
}

}  // namespace beltrami
