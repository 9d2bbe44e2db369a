// Wavefront OBJ. Our own: faces of any size, per-vertex colours and line numbers in messages.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "beltrami/framework/formats/readers.hpp"
#include "beltrami/framework/formats/text_scanner.hpp"

namespace beltrami::formats {

namespace {

// Statements that hold nothing a Mesh keeps: texture and normal lists, groups, materials, curves and
// surfaces.
constexpr std::string_view ignored_statements[] = {
    "vt",     "vn",     "vp",     "vc",     "p",          "g",        "o",        "s",    "mg",
    "usemtl", "mtllib", "usemap", "maplib", "cstype",     "deg",      "bmat",     "step", "curv",
    "curv2",  "surf",   "parm",   "trim",   "hole",       "scrv",     "sp",       "end",  "con",
    "bevel",  "lod",    "ctech",  "stech",  "c_interp",   "d_interp", "call",     "csh",  "trace_obj",
    "bsp",    "bzp",    "cdc",    "cdp",    "shadow_obj", "res",      "g_interp", "usmtl"};

class ObjReader {
  public:
    explicit ObjReader(const Source& source) : source_(source), scanner_(source) {}

    Contents run() {
        while (scanner_.next_line()) {
            const std::string_view key = scanner_.word_on_line();
            if (key == "v") {
                read_vertex();
            } else if (key == "f" || key == "fo") {
                read_corners();
                contents_.polygons.add(corners_);
            } else if (key == "l") {
                read_corners();
                add_polyline(contents_.segments, corners_);
            } else if (std::find(std::begin(ignored_statements), std::end(ignored_statements), key) ==
                       std::end(ignored_statements)) {
                if (unknown_lines_++ == 0) first_unknown_ = scanner_.line();
            }
        }
        check_forward_reference();
        finish_colors();
        if (unknown_lines_ > 0) {
            contents_.notes.push_back(
                fmt::format("{} lines that are not OBJ statements were skipped, the first is line {}",
                            unknown_lines_, first_unknown_));
        }
        return std::move(contents_);
    }

  private:
    void read_vertex() {
        const std::int64_t number = contents_.vertex_count();
        const Item item{"vertex", number, number + 1};
        std::array<double, 7> values{};
        std::size_t count = 0;
        for (auto word = scanner_.word_on_line(); !word.empty() && count < values.size();
             word = scanner_.word_on_line()) {
            values[count] =
                count < 3 ? scanner_.to_finite_number(word, item) : scanner_.to_number(word, item);
            ++count;
        }
        if (count < 3) scanner_.fail(fmt::format("a vertex has {} coordinates, not 3", count));
        contents_.positions.insert(contents_.positions.end(), values.begin(), values.begin() + 3);
        // 4 numbers: a weight. 6 or 7: a colour, with opacity.
        if (count >= 6) colors_.insert(colors_.end(), values.begin() + 3, values.begin() + 6);
    }

    void read_corners() {
        corners_.clear();
        for (auto word = scanner_.word_on_line(); !word.empty(); word = scanner_.word_on_line()) {
            corners_.push_back(corner(word));
        }
    }

    // "7", "7/3", "7//2", "7/3/2" or with negative numbers, which count back from the last vertex.
    Index corner(std::string_view word) {
        const auto number = parse_integer(word.substr(0, word.find('/')));
        const std::int64_t count = contents_.vertex_count();
        const auto polygon = static_cast<std::int64_t>(contents_.polygons.count());
        if (!number) {
            return static_cast<Index>(scanner_.to_integer(word, {"face or line", polygon, polygon + 1}));
        }
        if (*number < 0) {
            if (-count > *number) fail_vertex(*number, scanner_.line());
            return static_cast<Index>(count + *number);
        }
        if (*number == 0 || *number > INT32_MAX) fail_vertex(*number, scanner_.line());
        // Vertices may come after the faces, so what is too large is known at the end only.
        if (*number > largest_) {
            largest_ = *number;
            largest_line_ = scanner_.line();
        }
        return static_cast<Index>(*number - 1);
    }

    void check_forward_reference() const {
        if (largest_ > contents_.vertex_count()) fail_vertex(largest_, largest_line_);
    }

    [[noreturn]] void fail_vertex(std::int64_t number, std::int64_t line) const {
        const std::int64_t count = contents_.vertex_count();
        const std::string reason =
            count == 0
                ? fmt::format("a face or line names vertex {}, but there are no vertices", number)
                : fmt::format("a face or line names vertex {}, but the vertices are 1 to {}", number, count);
        source_.fail(fmt::format("line {}", line), reason,
                     "the file is damaged, or its numbers do not start at 1 as OBJ wants");
    }

    void finish_colors() {
        if (colors_.empty()) return;
        if (colors_.size() != contents_.positions.size()) {
            contents_.notes.push_back(fmt::format("colours on only {} of {} vertices were left out",
                                                  colors_.size() / 3, contents_.vertex_count()));
            return;
        }
        if (*std::max_element(colors_.begin(), colors_.end()) > 1.0) {
            scale_byte_colors(colors_);
            contents_.notes.emplace_back("colours in 0..255 were scaled to 0..1");
        }
        add_field(contents_, "color", 3, colors_);
    }

    const Source& source_;
    TextScanner scanner_;
    Contents contents_;
    std::vector<double> colors_;
    std::vector<Index> corners_;
    std::int64_t largest_ = 0, largest_line_ = 0, unknown_lines_ = 0, first_unknown_ = 0;
};

}  // namespace

Contents read_obj(const Source& source) {
    source.require_text("an OBJ file");
    return ObjReader(source).run();
}

}  // namespace beltrami::formats
