// Arrows on a surface, as rods for the rasterizer.
#pragma once

#include "beltrami/apps/picture/colour_map.hpp"
#include "beltrami/apps/picture/rasterizer.hpp"

namespace beltrami {

/// Points behind those of the mesh, and rods between them.
struct Arrows {
    Points ends{0, 3};  ///< k x 3
    Cells rods{0,
               2};  ///< numbers of the ends, from 0: a shaft and two barbs an arrow; a ball for a zero vector
    Block colours{0, 3};  ///< k x 3
};

/// Vectors at so many of the vertices `seen` that they fill the picture evenly without touching, and at as many of the
/// `given` ones, which are red and larger. The length of the arrow grows with that of the vector, its colour is that of
/// the length in the scale. Vectors that are not finite have none.
///
/// positions: n x 3 as Scene has them; vectors: n x 3 in the same directions, of any scale. spacing: between arrows, in
/// pixels. Arrows are lifted toward the viewer by `lift` pixels.
Arrows arrows(const Points& positions, const std::vector<Index>& seen, const Block& vectors,
              const std::vector<Index>& given, const ColourScale& scale, double spacing, double lift);

}  // namespace beltrami
