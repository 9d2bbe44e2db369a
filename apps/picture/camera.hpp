// From where a mesh is looked at.
#pragma once

#include <string_view>

#include "beltrami/framework/types.hpp"

namespace beltrami {

/// Directions of unit length in the mesh's coordinates: right and up in the picture, and toward whoever
/// looks.
struct Camera {
    Vector3 right, up, toward;
};

/// view: front, back, left, right, top, bottom, iso, or the direction from which to look as "x,y,z". up: x, y
/// or z. With y up, front looks from +z and right from +x; with z up, front looks from -y; with x up, front
/// looks from +z. Throws InputError for anything else.
Camera camera_from(std::string_view view, std::string_view up);

/// Where the vertices `seen` (of all points) fall when they fill a picture of width x height pixels up to a
/// margin (pixels): n x 3 of pixels right, pixels down, and pixels toward the viewer; scaled alike in all
/// three.
Points fit(const Points& points, const std::vector<Index>& seen, const Camera& camera, double width,
           double height, double margin);

}  // namespace beltrami
