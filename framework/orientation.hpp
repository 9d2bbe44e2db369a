// Which triangles of a surface to turn over so that neighbours run alike.
#pragma once

#include <vector>

#include "beltrami/framework/sides.hpp"

namespace beltrami {

struct Orientation {
    /// +1 keeps the triangle as it is, -1 turns it over. The first triangle of every patch is kept.
    std::vector<signed char> sense;
    /// No choice makes all neighbours run alike, as on a Moebius strip.
    bool one_sided = false;
};

/// Neighbours share an edge that no third triangle has; patches that meet along other edges only are oriented each by
/// itself. `sides` are those of `triangles` (m x 3).
Orientation orientation(const Cells& triangles, const Sides& sides);

}  // namespace beltrami
