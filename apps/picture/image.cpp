#include "beltrami/apps/picture/image.hpp"

#include <algorithm>
#include <cstddef>

namespace beltrami {

Image blank_image(int width, int height) {
    const auto bytes = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3;
    return {width, height, std::vector<std::uint8_t>(bytes, 255)};
}

void place(const Image& part, Image& whole, int left, int top) {
    for (int y = 0; y < part.height; ++y) {
        const auto from = part.rgb.begin() + static_cast<std::ptrdiff_t>(y) * part.width * 3;
        const auto to = whole.rgb.begin() + (static_cast<std::ptrdiff_t>(top + y) * whole.width + left) * 3;
        std::copy_n(from, static_cast<std::ptrdiff_t>(part.width) * 3, to);
    }
}

}  // namespace beltrami
