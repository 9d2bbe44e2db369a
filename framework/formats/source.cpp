#include "beltrami/framework/formats/source.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <system_error>

#include "beltrami/framework/error.hpp"

namespace beltrami::formats {

namespace fs = std::filesystem;

std::string describe(const Item& item) {
    return fmt::format("{} {} of {}", item.kind, item.index + 1, item.total);
}

Source::Source(const fs::path& path) : name_(path.string()) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::not_found) {
        fail("", "there is no such file", "check the spelling and the folder");
    }
    if (error)
        fail("", fmt::format("the file cannot be reached ({})", error.message()), "check its permissions");
    if (fs::is_directory(status)) fail("", "this is a folder", "give a mesh file");
    if (!fs::is_regular_file(status))
        fail("", "this is not an ordinary file", "copy the mesh to a file first");

    const std::uintmax_t size = fs::file_size(path, error);
    std::ifstream stream(path, std::ios::binary);
    if (error || !stream) {
        fail("", fmt::format("the file cannot be opened ({})", std::strerror(errno)),
             "check its permissions");
    }
    if (size == 0) fail("", "the file is empty", damaged_hint);
    bytes_.resize(size);
    stream.read(bytes_.data(), static_cast<std::streamsize>(size));
    if (stream.gcount() != static_cast<std::streamsize>(size)) {
        fail(fmt::format("byte {}", stream.gcount()), "the file cannot be read to its end",
             "check the disk or copy the file again");
    }
    view_ = bytes_;
    if (view_.starts_with("\xEF\xBB\xBF")) view_.remove_prefix(3);
}

void Source::fail(std::string_view place, std::string_view reason, std::string_view hint) const {
    throw InputError(fmt::format("{}{}{}: {}", name_, place.empty() ? "" : ", ", place, reason),
                     std::string(hint));
}

void Source::require_text(std::string_view format) const {
    const std::size_t zero = view_.substr(0, 4096).find('\0');
    if (zero == std::string_view::npos) return;
    fail(fmt::format("byte {}", zero), fmt::format("this is not {}: it holds binary data", format),
         "check that the file has the ending of its real format");
}

void Source::require_room(std::string_view place, std::string_view kind, std::int64_t count,
                          std::size_t bytes_each, std::size_t bytes_left) const {
    if (count < 0 || count > std::numeric_limits<Index>::max()) {
        fail(place, fmt::format("a {} count of {} is out of range", kind, count),
             "counts go from 0 to 2147483647; the file is damaged");
    }
    const auto most = bytes_each == 0 ? static_cast<std::size_t>(count) : bytes_left / bytes_each;
    if (static_cast<std::size_t>(count) > most) {
        fail(place,
             fmt::format("a {} count of {} is announced, but the rest of the file has room for {} at most",
                         kind, count, most));
    }
}

void Source::fail_vertex(std::string_view place, const Item& item, std::int64_t vertex, std::int64_t first,
                         std::int64_t vertex_count) const {
    fail(place,
         vertex_count == 0
             ? fmt::format("{} names vertex {}, but no vertices come before it", describe(item), vertex)
             : fmt::format("{} names vertex {}, but the vertices are {} to {}", describe(item), vertex, first,
                           first + vertex_count - 1),
         "the file is damaged, or its numbering does not start where its format says");
}

}  // namespace beltrami::formats
