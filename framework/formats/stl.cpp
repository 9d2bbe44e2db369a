// STL, ASCII and binary. CGAL's reader obeys the locale, takes a binary file that starts with "solid" for
// text and says no more than "failed"; a binary STL is 50 bytes a triangle.
#include <fmt/format.h>

#include <array>
#include <cstring>
#include <string>
#include <unordered_map>

#include "beltrami/framework/formats/numbers.hpp"
#include "beltrami/framework/formats/readers.hpp"
#include "beltrami/framework/formats/text_scanner.hpp"

namespace beltrami::formats {

namespace {

constexpr std::size_t head_bytes = 84;
constexpr std::size_t triangle_bytes = 50;

using Position = std::array<double, 3>;
struct PositionHash {
    std::size_t operator()(const Position& p) const {
        return std::hash<std::string_view>()({reinterpret_cast<const char*>(p.data()), sizeof(p)});
    }
};

/// Gives corners at the same place the same number.
class Welder {
  public:
    explicit Welder(Contents& contents) : contents_(contents) {}

    void add_corner(Position p) {
        for (double& x : p)
            x += 0.0;  // -0 is the same place as 0
        const auto [found, is_new] = numbers_.try_emplace(p, static_cast<Index>(numbers_.size()));
        if (is_new) contents_.positions.insert(contents_.positions.end(), p.begin(), p.end());
        contents_.polygons.add_corner(found->second);
        ++corners_;
    }

    void note() const {
        contents_.notes.push_back(fmt::format("{} corners of triangles were welded to {} vertices", corners_,
                                              contents_.vertex_count()));
    }

  private:
    Contents& contents_;
    std::unordered_map<Position, Index, PositionHash> numbers_;
    std::size_t corners_ = 0;
};

std::size_t announced_triangles(std::string_view bytes) {
    return load<std::uint32_t>(bytes.data() + 80, std::endian::little);
}

// "solid" starts many binary files too, so the size decides first.
bool is_binary(std::string_view bytes) {
    if (bytes.size() >= head_bytes &&
        bytes.size() == head_bytes + triangle_bytes * announced_triangles(bytes))
        return true;
    return bytes.substr(0, 1024).find('\0') != std::string_view::npos;
}

Contents read_binary(const Source& source) {
    const std::string_view bytes = source.bytes();
    if (bytes.size() < head_bytes)
        source.fail(fmt::format("byte {}", bytes.size()), "the file ends inside the header");
    const std::size_t count = announced_triangles(bytes);
    source.require_room("byte 80", "triangle", static_cast<std::int64_t>(count), triangle_bytes,
                        bytes.size() - head_bytes);
    Contents contents;
    Welder welder(contents);
    for (std::size_t t = 0; t < count; ++t) {
        const char* corner = bytes.data() + head_bytes + t * triangle_bytes + 12;  // after the normal
        for (int c = 0; c < 3; ++c, corner += 12) {
            Position p{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                p[axis] = load<float>(corner + 4 * axis, std::endian::little);
            welder.add_corner(p);
        }
        contents.polygons.close();
    }
    welder.note();
    return contents;
}

Contents read_ascii(const Source& source) {
    TextScanner scanner(source, '\0');
    if (lower(scanner.word()) != "solid") {
        scanner.fail(
            "this is neither an ASCII STL file (it does not start with 'solid') nor a binary one (its size "
            "does "
            "not fit its count of triangles)");
    }
    scanner.rest_of_line();
    Contents contents;
    Welder welder(contents);
    std::size_t corners = 0;
    while (scanner.next_line()) {
        const std::string key = lower(scanner.word_on_line());
        const auto number = static_cast<std::int64_t>(contents.polygons.count());
        const Item item{"triangle", number, number + 1};
        if (key == "vertex") {
            Position p{};
            for (double& x : p)
                x = scanner.finite_number(item);
            welder.add_corner(p);
            ++corners;
        } else if (key == "endfacet") {
            if (corners != 3) scanner.fail(fmt::format("a facet has {} vertices, not 3", corners));
            contents.polygons.close();
            corners = 0;
        } else if (key != "facet" && key != "outer" && key != "endloop" && key != "endsolid" &&
                   key != "solid") {
            scanner.fail("this line is not one of an STL file");
        }
    }
    if (corners != 0) scanner.fail("the file ends inside a facet");
    welder.note();
    return contents;
}

}  // namespace

Contents read_stl(const Source& source) {
    return is_binary(source.bytes()) ? read_binary(source) : read_ascii(source);
}

}  // namespace beltrami::formats
