// What stands around the drawing: its title and the colour bar.
#pragma once

#include <string>

#include "beltrami/apps/picture/colour_map.hpp"
#include "beltrami/apps/picture/image.hpp"

namespace beltrami {

/// One line of text on white, written smaller, to half the size, where it is too long for the width. text:
/// UTF-8, otherwise InputError. font: height of the letters with their line in pixels.
Image draw_title(const std::string& text, int width, double font);

/// A bar of the scale's colours with round numbers beside it, on white; as wide as it needs.
Image draw_colour_bar(const ColourScale& scale, int height, double font);

}  // namespace beltrami
