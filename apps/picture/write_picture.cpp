#include <fmt/format.h>

#include <ostream>

#include "beltrami/apps/picture/picture.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/write_mesh.hpp"

namespace beltrami {

void write_picture(const std::filesystem::path& png, const Image& image) {
    if (png.extension() != ".png") {
        throw InputError(fmt::format("pictures are PNG files, but '{}' is named otherwise", png.string()),
                         "give a name that ends in .png");
    }
    const std::string bytes = encode_png(image);
    write_whole(
        png, [&](std::ostream& out) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

}  // namespace beltrami
