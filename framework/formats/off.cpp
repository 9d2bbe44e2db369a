// Object File Format: OFF, COFF (colours), NOFF (normals), CNOFF. Our own for the same reasons as OBJ.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "beltrami/framework/formats/readers.hpp"
#include "beltrami/framework/formats/text_scanner.hpp"

namespace beltrami::formats {

namespace {

class OffReader {
  public:
    explicit OffReader(const Source& source) : scanner_(source) {}

    Contents run() {
        read_header();
        read_vertices();
        read_faces();
        return std::move(contents_);
    }

  private:
    // The word is optional, and the counts may follow it on its line.
    void read_header() {
        const std::string_view first = scanner_.word();
        if (parse_integer(first)) {
            vertices_ = *parse_integer(first);
        } else {
            read_kind(first);
            vertices_ = scanner_.integer({"count", 0, 2});
        }
        faces_ = scanner_.integer({"count", 1, 2});
        skip_rest_of_line();  // the number of edges, which nobody needs
        scanner_.require_room("vertex", vertices_, normals_ ? 6 : 3);
        scanner_.require_room("face", faces_, 1);
    }

    void read_kind(std::string_view word) {
        const std::string_view prefix = word.substr(0, word.size() < 3 ? 0 : word.size() - 3);
        const bool known =
            word.ends_with("OFF") && prefix.find_first_not_of("STCN") == std::string_view::npos;
        if (!known) {
            scanner_.fail("the file does not start with OFF, COFF or NOFF",
                          "check that its ending is right; 4OFF and nOFF are not read");
        }
        normals_ = prefix.find('N') != std::string_view::npos;
        colors_ = prefix.find('C') != std::string_view::npos;
        TextScanner ahead = scanner_;
        if (ahead.word_on_line() == "BINARY") {
            scanner_.fail("binary OFF files are not read", "save it as ASCII OFF or as PLY");
        }
    }

    void read_vertices() {
        contents_.positions.reserve(3 * static_cast<std::size_t>(vertices_));
        for (std::int64_t v = 0; v < vertices_; ++v) {
            const Item item{"vertex", v, vertices_};
            for (int axis = 0; axis < 3; ++axis)
                contents_.positions.push_back(scanner_.finite_number(item));
            if (normals_) {
                for (int axis = 0; axis < 3; ++axis)
                    normal_.push_back(scanner_.number(item));
            }
            if (colors_) read_color(item);
            skip_rest_of_line();  // opacity, texture coordinates
        }
        if (normals_) add_field(contents_, "normal", 3, normal_);
        if (color_.empty()) return;
        if (whole_numbers_ && *std::max_element(color_.begin(), color_.end()) > 1.0)
            scale_byte_colors(color_);
        add_field(contents_, "color", 3, color_);
    }

    void read_color(const Item& item) {
        for (int channel = 0; channel < 3; ++channel) {
            const std::string_view word = scanner_.word_on_line();
            if (word.empty())
                scanner_.fail(fmt::format("{} has no colour, which COFF demands", describe(item)));
            color_.push_back(scanner_.to_number(word, item));
            whole_numbers_ = whole_numbers_ && parse_integer(word).has_value();
        }
    }

    void read_faces() {
        contents_.polygons.reserve(static_cast<std::size_t>(faces_));
        for (std::int64_t f = 0; f < faces_; ++f) {
            const Item item{"face", f, faces_};
            const std::int64_t corners = scanner_.integer(item);
            scanner_.require_room("corner", corners, 1);
            for (std::int64_t c = 0; c < corners; ++c) {
                contents_.polygons.add_corner(scanner_.to_vertex(scanner_.integer(item), 0, vertices_, item));
            }
            contents_.polygons.close();
            skip_rest_of_line();  // a colour
        }
    }

    void skip_rest_of_line() {
        while (!scanner_.word_on_line().empty()) {
        }
    }

    TextScanner scanner_;
    Contents contents_;
    std::int64_t vertices_ = 0, faces_ = 0;
    bool normals_ = false, colors_ = false, whole_numbers_ = true;
    std::vector<double> normal_, color_;
};

}  // namespace

Contents read_off(const Source& source) {
    source.require_text("an OFF file");
    return OffReader(source).run();
}

}  // namespace beltrami::formats
