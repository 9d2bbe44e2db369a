// What fair and membrane share: a region that moves while the rest of the mesh is held.
#pragma once

#include <span>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/operators/laplacian.hpp"

namespace beltrami {

/// Every vertex that is not in the region, held at a displacement of zero (three columns), in the user's order. A vertex
/// may be named more than once. Throws InputError for a region without vertices and a vertex out of range.
Constraints hold_outside(std::span<const Index> region, Index vertex_count);

/// How many vertices of the region (those that `held` leaves free) have no edge: they have no equation and stay.
Index isolated_inside(const Laplacian& laplacian, const Constraints& held);

}  // namespace beltrami
