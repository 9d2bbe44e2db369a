// Triangles, lines and balls to pixels: a depth buffer, 2 x 2 samples a pixel, light from near the viewer.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "beltrami/apps/picture/colour_map.hpp"
#include "beltrami/apps/picture/image.hpp"
#include "beltrami/framework/types.hpp"

namespace beltrami {

/// The colour of a surface before it is lit: the same everywhere, or mixed from the vertices', as colours or
/// as numbers whose colour is looked up after mixing.
class Paint {
  public:
    static Paint plain(const Colour& colour);
    /// rgb: n x 3, clamped to [0, 1]; no_value_colour for rows that are not finite.
    static Paint colours(const Block& rgb);
    /// values: n x 1.
    static Paint scalar(const Block& values, const ColourScale& scale);

    /// The same paint for vertices below `first`, and for the others, which are things drawn over the surface, `ink`.
    [[nodiscard]] Paint with_ink(Index first, const Colour& ink) const;

    /// The mean of the colours of k vertices with weights that add up to 1; all on the same side of with_ink().
    [[nodiscard]] Colour mix(const Index* vertices, const double* weights, int k) const;

  private:
    explicit Paint(const Colour& colour) : plain_(colour) {}

    Colour plain_;
    std::vector<Colour> colours_;
    std::vector<double> positions_;
    std::optional<ColourScale> scale_;
    Index first_ink_ = std::numeric_limits<Index>::max();
    Colour ink_{};
};

/// Unit normals at the corners of a triangle.
using CornerNormals = std::array<Eigen::Vector3f, 3>;

/// For each triangle (m x 3), normals toward the viewer (+z) that are smooth across edges bent by less than
/// 50 degrees. Which way the triangles are oriented does not matter. Zero for triangles without area.
std::vector<CornerNormals> corner_normals(const Points& positions, const Cells& triangles);

struct Scene {
    /// n x 3: pixels right from the left rim, down from the upper rim, and toward the viewer.
    const Points& positions;
    Cells triangles;  ///< m x 3
    std::vector<CornerNormals> normals;
    double edge_width = 0.0;  ///< of the triangles' edges, in pixels; 0 draws none

    Cells capsules;               ///< m x 2: round rods between vertices; a ball where both are one
    double capsule_radius = 1.5;  ///< pixels

    const Paint& paint;
    float contrast = 0.5F;  ///< of the light, 0 to 1
};

/// On white. Time in proportion to primitives and covered pixels, memory to primitives and the picture.
Image rasterize(const Scene& scene, int width, int height);

}  // namespace beltrami
