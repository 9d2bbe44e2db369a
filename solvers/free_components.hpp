// Components that nothing holds: where a Laplace, Poisson or interpolation problem has no unique answer.
#pragma once

#include <vector>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/operators/laplacian.hpp"

namespace beltrami {

enum class FreeComponents {
    refuse,       ///< an error that names them
    keep_at_zero  ///< their values are 0
};

/// The constraints (in the user's order) with every vertex of the components without any constraint held at zero;
/// with FreeComponents::refuse throws InputError that counts those components and names a vertex of each (ten at
/// most). Isolated vertices are not components: nothing is solved there.
Constraints hold_free_components(const Laplacian& laplacian, const Constraints& held, FreeComponents policy);
/// The same where connected_components(laplacian.graph()) is at hand.
Constraints hold_free_components(const Laplacian& laplacian, const Components& components,
                                 const Constraints& held, FreeComponents policy);

}  // namespace beltrami
