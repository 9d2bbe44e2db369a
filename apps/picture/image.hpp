// A picture in memory.
#pragma once

#include <cstdint>
#include <vector>

namespace beltrami {

/// RGB, row-major from the top left, 3 bytes a pixel.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgb;
};

/// White all over.
Image blank_image(int width, int height);

/// Copies all of `part`, which must lie inside, to where its top left corner is at (left, top).
void place(const Image& part, Image& whole, int left, int top);

}  // namespace beltrami
