// Medit ASCII .mesh. CGAL reads it into complexes only, with neither quadrilaterals nor line numbers.
#include <fmt/format.h>

#include <string>
#include <string_view>

#include "beltrami/framework/formats/readers.hpp"
#include "beltrami/framework/formats/text_scanner.hpp"

namespace beltrami::formats {

namespace {

class MeditReader {
  public:
    explicit MeditReader(const Source& source) : scanner_(source) {}

    Contents run() {
        if (lower(scanner_.word()) != "meshversionformatted") {
            scanner_.fail("the file does not start with MeshVersionFormatted",
                          "only Medit ASCII files have the ending .mesh; binary ones are not read");
        }
        scanner_.integer({"version", 0, 1});
        for (std::string_view word = scanner_.word(); !word.empty(); word = scanner_.word()) {
            const std::string key = lower(word);
            if (key == "end") break;
            read_section(key, word);
        }
        return std::move(contents_);
    }

  private:
    void read_section(const std::string& key, std::string_view word) {
        if (key == "dimension") {
            dimension_ = scanner_.integer({"dimension", 0, 1});
            if (dimension_ != 2 && dimension_ != 3)
                scanner_.fail(fmt::format("a dimension of {}, not 2 or 3", dimension_));
        } else if (key == "vertices") {
            read_vertices();
        } else if (key == "edges") {
            read_cells("edge", 2, [&](const Index* c) { add_polyline(contents_.segments, {c, 2}); });
        } else if (key == "triangles") {
            read_cells("triangle", 3, [&](const Index* c) { contents_.polygons.add({c, 3}); });
        } else if (key == "quadrilaterals") {
            read_cells("quadrilateral", 4, [&](const Index* c) { contents_.polygons.add({c, 4}); });
        } else if (key == "tetrahedra") {
            read_cells("tetrahedron", 4, [&](const Index* c) {
                contents_.tetrahedra.insert(contents_.tetrahedra.end(), c, c + 4);
            });
        } else if (key == "hexahedra" || key == "prisms" || key == "pyramids") {
            if (scanner_.integer({"count", 0, 1}) != 0) {
                scanner_.fail(fmt::format("the file has {}, which are not read", key),
                              "split the solid into tetrahedra first");
            }
        } else {
            skip_section(word);
        }
    }

    std::int64_t read_count(std::string_view kind, std::size_t words) {
        const std::int64_t count = scanner_.integer({"count", 0, 1});
        scanner_.require_room(kind, count, words);
        return count;
    }

    void read_vertices() {
        if (contents_.vertex_count() > 0) scanner_.fail("there is a second list of vertices");
        vertices_ = read_count("vertex", static_cast<std::size_t>(dimension_) + 1);
        contents_.positions.reserve(3 * static_cast<std::size_t>(vertices_));
        for (std::int64_t v = 0; v < vertices_; ++v) {
            const Item item{"vertex", v, vertices_};
            for (std::int64_t axis = 0; axis < 3; ++axis) {
                contents_.positions.push_back(axis < dimension_ ? scanner_.finite_number(item) : 0.0);
            }
            scanner_.number(item);  // the reference, a label
        }
    }

    template <class Add>
    void read_cells(std::string_view kind, int corners, Add&& add) {
        const std::int64_t count = read_count(kind, static_cast<std::size_t>(corners) + 1);
        Index cell[4];
        for (std::int64_t i = 0; i < count; ++i) {
            const Item item{kind, i, count};
            for (int c = 0; c < corners; ++c)
                cell[c] = scanner_.to_vertex(scanner_.integer(item), 1, vertices_, item);
            scanner_.number(item);
            add(cell);
        }
    }

    // Corners, ridges, normals and the like: numbers up to the next word.
    void skip_section(std::string_view keyword) {
        if (parse_number(keyword)) {
            scanner_.fail("there is a number where a section's name is due",
                          "the count of the section before is too small, or the file is damaged");
        }
        while (true) {
            TextScanner ahead = scanner_;
            const std::string_view word = ahead.word();
            if (word.empty() || !parse_number(word)) return;
            scanner_ = ahead;
        }
    }

    TextScanner scanner_;
    Contents contents_;
    std::int64_t dimension_ = 3, vertices_ = 0;
};

}  // namespace

Contents read_medit(const Source& source) {
    source.require_text("a Medit ASCII file");
    return MeditReader(source).run();
}

}  // namespace beltrami::formats
