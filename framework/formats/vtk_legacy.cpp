// Legacy VTK files. Our own: the VTK library is a hundred megabytes for a format of two pages.
#include <fmt/format.h>

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "beltrami/framework/formats/numbers.hpp"
#include "beltrami/framework/formats/readers.hpp"
#include "beltrami/framework/formats/text_scanner.hpp"
#include "beltrami/framework/formats/vtk_cells.hpp"

namespace beltrami::formats {

namespace {

// Names are written with %20 for a blank.
std::string decoded(std::string_view name) {
    std::string text;
    for (std::size_t i = 0; i < name.size(); ++i) {
        unsigned code = 0;
        const char* digits = name.data() + i + 1;
        if (name[i] == '%' && i + 2 < name.size() &&
            std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2) {
            text += static_cast<char>(code);
            i += 2;
        } else {
            text += name[i];
        }
    }
    return text;
}

class LegacyReader {
  public:
    explicit LegacyReader(const Source& source) : source_(source), scanner_(source, '\0') {}

    Contents run() {
        read_header();
        for (std::string_view word = scanner_.word(); !word.empty(); word = scanner_.word()) {
            read_section(lower(word));
        }
        add_unstructured_cells();
        return std::move(contents_);
    }

  private:
    void read_header() {
        if (!scanner_.rest_of_line().starts_with("# vtk DataFile Version")) {
            source_.fail("line 1", "the file does not start with '# vtk DataFile Version'",
                         "check that its ending is right");
        }
        scanner_.rest_of_line();  // a title
        const std::string encoding = lower(scanner_.word());
        if (encoding != "ascii" && encoding != "binary")
            scanner_.fail("the file is neither ASCII nor BINARY");
        binary_ = encoding == "binary";
    }

    void read_section(const std::string& key) {
        if (key == "dataset") {
            read_dataset_kind();
        } else if (key == "points") {
            read_points();
        } else if (key == "cells") {
            cells_ = read_cells();
            has_cells_ = true;
        } else if (key == "cell_types") {
            const std::int64_t count = scanner_.integer({"count", 0, 1});
            types_ = values<std::int64_t>("int", count, "cell type");
        } else if (key == "vertices") {
            read_cells();
        } else if (key == "lines") {
            add_cells(VtkCell::poly_line);
        } else if (key == "polygons") {
            add_cells(VtkCell::polygon);
        } else if (key == "triangle_strips") {
            add_cells(VtkCell::strip);
        } else if (key == "point_data") {
            const std::int64_t count = scanner_.integer({"count", 0, 1});
            if (count != contents_.vertex_count()) {
                scanner_.fail(fmt::format("there are point data for {} points, but {} points", count,
                                          contents_.vertex_count()));
            }
            tuples_ = count;
            keep_ = true;
        } else if (key == "cell_data") {
            tuples_ = scanner_.integer({"count", 0, 1});
            source_.require_room(scanner_.place(), "cell", tuples_, 0, 0);
            keep_ = false;
        } else if (key == "metadata") {
            skip_metadata();
        } else {
            read_attribute(key);
        }
    }

    void read_dataset_kind() {
        const std::string kind = lower(scanner_.word());
        if (kind != "polydata" && kind != "unstructured_grid") {
            scanner_.fail("the dataset is neither POLYDATA nor UNSTRUCTURED_GRID",
                          "only meshes are read; turn a grid into an unstructured one first");
        }
    }

    void read_points() {
        if (contents_.vertex_count() > 0) scanner_.fail("there is a second list of points");
        const std::int64_t count = scanner_.integer({"count", 0, 1});
        source_.require_room(scanner_.place(), "point", count, 0, 0);
        const std::string_view type = scanner_.word();
        contents_.positions = values<double>(type, 3 * count, "coordinate");
    }

    /// Both layouts: "n size" with sizes among the corners, and 5.1's OFFSETS and CONNECTIVITY.
    VtkCells read_cells() {
        const std::int64_t first = scanner_.integer({"count", 0, 2});
        const std::int64_t second = scanner_.integer({"count", 1, 2});
        TextScanner ahead = scanner_;
        VtkCells cells;
        if (lower(ahead.word()) == "offsets") {
            scanner_ = ahead;
            cells.ends = values<std::int64_t>(scanner_.word(), first, "offset");
            if (!cells.ends.empty()) cells.ends.erase(cells.ends.begin());  // the start of the first, 0
            if (lower(scanner_.word()) != "connectivity")
                scanner_.fail("OFFSETS are not followed by CONNECTIVITY");
            cells.connectivity = values<std::int64_t>(scanner_.word(), second, "corner");
            return cells;
        }
        const std::vector<std::int64_t> list = values<std::int64_t>("int", second, "corner");
        source_.require_room(scanner_.place(), "cell", first, 1, list.size());
        std::size_t at = 0;
        for (std::int64_t c = 0; c < first; ++c) {
            const std::int64_t size = at < list.size() ? list[at++] : -1;
            if (size < 0 || static_cast<std::size_t>(size) > list.size() - at) {
                scanner_.fail(fmt::format("{} does not fit the announced size of the list",
                                          describe({"cell", c, first})));
            }
            for (std::int64_t k = 0; k < size; ++k)
                cells.connectivity.push_back(list[at++]);
            cells.ends.push_back(static_cast<std::int64_t>(cells.connectivity.size()));
        }
        return cells;
    }

    void add_cells(VtkCell type) {
        add_vtk_cells(source_, contents_, read_cells(), {static_cast<std::int64_t>(type)},
                      contents_.vertex_count(), 0);
    }

    void add_unstructured_cells() {
        if (!has_cells_) return;
        if (types_.size() != cells_.ends.size()) {
            scanner_.fail(
                fmt::format("there are {} cells but {} cell types", cells_.ends.size(), types_.size()));
        }
        if (!types_.empty()) add_vtk_cells(source_, contents_, cells_, types_, contents_.vertex_count(), 0);
    }

    void read_attribute(const std::string& key) {
        if (key == "scalars") {
            read_scalars();
        } else if (key == "color_scalars") {
            const std::string name = decoded(scanner_.word());
            const std::int64_t columns = read_columns();
            auto colors = values<double>(binary_ ? "unsigned_char" : "float", tuples_ * columns, "colour");
            if (binary_) scale_byte_colors(colors);
            keep(name, columns, colors);
        } else if (key == "lookup_table") {
            scanner_.word();
            const std::int64_t size = scanner_.integer({"count", 0, 1});
            source_.require_room(scanner_.place(), "colour", size, 0, 0);
            values<double>(binary_ ? "unsigned_char" : "float", 4 * size, "colour");
        } else if (key == "vectors" || key == "normals") {
            read_array(3);
        } else if (key == "texture_coordinates") {
            const std::string name = decoded(scanner_.word());
            const std::int64_t columns = read_columns();
            keep(name, columns, values<double>(scanner_.word(), tuples_ * columns, "value"));
        } else if (key == "tensors") {
            read_array(9);
        } else if (key == "tensors6") {
            read_array(6);
        } else if (key == "global_ids" || key == "pedigree_ids" || key == "edge_flags") {
            scanner_.word();
            skip_array(scanner_.word(), tuples_);
        } else if (key == "field") {
            read_field();
        } else {
            scanner_.fail("this is not the start of a section of a legacy VTK file");
        }
    }

    void read_scalars() {
        const std::string name = decoded(scanner_.word());
        const std::string type = lower(scanner_.word());
        std::int64_t columns = 1;
        if (TextScanner ahead = scanner_; parse_integer(ahead.word_on_line())) columns = read_columns();
        if (TextScanner ahead = scanner_; lower(ahead.word()) == "lookup_table") {
            scanner_ = ahead;
            scanner_.word();
        }
        keep(name, columns, values<double>(type, tuples_ * columns, "value"));
    }

    void read_array(std::int64_t columns) {
        const std::string name = decoded(scanner_.word());
        keep(name, columns, values<double>(scanner_.word(), tuples_ * columns, "value"));
    }

    void read_field() {
        scanner_.word();
        const std::int64_t arrays = scanner_.integer({"count", 0, 1});
        for (std::int64_t a = 0; a < arrays; ++a) {
            std::string_view name = scanner_.word();
            if (lower(name) == "metadata") {
                skip_metadata();
                name = scanner_.word();
            }
            const std::int64_t columns = read_columns();
            const std::int64_t rows = scanner_.integer({"array", a, arrays});
            source_.require_room(scanner_.place(), "row", rows, 0, 0);
            const std::string type = lower(scanner_.word());
            const bool fits = keep_ && columns > 0 && rows == contents_.vertex_count();
            if (!fits || type == "string" || type == "bit") {
                skip_array(type, rows * columns);
            } else {
                keep(decoded(name), columns, values<double>(type, rows * columns, "value"));
            }
        }
    }

    std::int64_t read_columns() {
        const std::int64_t columns = scanner_.integer({"count of components", 0, 1});
        if (columns < 0 || columns > 1000000)
            scanner_.fail(fmt::format("an array of {} components", columns));
        return columns;
    }

    void keep(const std::string& name, std::int64_t columns, const std::vector<double>& values) {
        if (keep_ && columns > 0) add_field(contents_, name, static_cast<std::size_t>(columns), values);
    }

    // Up to an empty line.
    void skip_metadata() {
        scanner_.rest_of_line();
        while (scanner_.bytes_left() > 0 && !scanner_.rest_of_line().empty()) {
        }
    }

    NumberType number_type(std::string_view word) {
        // vtkIdType is written as int.
        static const std::map<std::string, NumberType, std::less<>> types{
            {"char", NumberType::int8},
            {"signed_char", NumberType::int8},
            {"unsigned_char", NumberType::uint8},
            {"short", NumberType::int16},
            {"unsigned_short", NumberType::uint16},
            {"int", NumberType::int32},
            {"unsigned_int", NumberType::uint32},
            {"long", NumberType::int64},
            {"unsigned_long", NumberType::uint64},
            {"vtkidtype", NumberType::int32},
            {"vtktypeint64", NumberType::int64},
            {"vtktypeuint64", NumberType::uint64},
            {"vtktypeint32", NumberType::int32},
            {"float", NumberType::float32},
            {"double", NumberType::float64}};
        const auto found = types.find(lower(word));
        if (found == types.end()) scanner_.fail("this array's type is not one of VTK's numbers");
        return found->second;
    }

    template <class T>
    std::vector<T> values(std::string_view type_name, std::int64_t count, std::string_view kind) {
        const NumberType type = number_type(type_name);
        if (count < 0) scanner_.fail(fmt::format("a {} count of {}", kind, count));
        const Item all{kind, count - 1, count};
        const auto size = static_cast<std::size_t>(count);
        if (binary_) {
            if (size > scanner_.bytes_left()) scanner_.fail_end(all);
            return load_all<T>(scanner_.bytes_after_line(size * byte_size(type), all), type,
                               std::endian::big);
        }
        if (2 * size > scanner_.bytes_left() + 1) {
            scanner_.fail(
                fmt::format("a {} count of {} is announced, but the rest of the file has room for {} at most",
                            kind, count, (scanner_.bytes_left() + 1) / 2));
        }
        std::vector<T> numbers(size);
        for (std::size_t i = 0; i < size; ++i) {
            const Item item{kind, static_cast<std::int64_t>(i), count};
            if constexpr (std::is_same_v<T, double>) {
                numbers[i] = scanner_.number(item);
            } else {
                numbers[i] = scanner_.integer(item);
            }
        }
        return numbers;
    }

    void skip_array(std::string_view type_name, std::int64_t count) {
        const std::string type = lower(type_name);
        const Item all{"value", count - 1, count};
        if (type == "string") {
            skip_strings(count);
        } else if (type == "bit" && binary_) {
            scanner_.bytes_after_line((static_cast<std::size_t>(count) + 7) / 8, all);
        } else {
            values<double>(type == "bit" ? "int" : type, count, "value");
        }
    }

    // ASCII: a line each. Binary: the two highest bits of the first byte tell how many bytes hold the length.
    void skip_strings(std::int64_t count) {
        scanner_.rest_of_line();
        for (std::int64_t i = 0; i < count; ++i) {
            const Item item{"string", i, count};
            if (scanner_.bytes_left() == 0) scanner_.fail_end(item);
            if (!binary_) {
                scanner_.rest_of_line();
                continue;
            }
            const auto head = static_cast<unsigned char>(scanner_.bytes(1, item)[0]);
            const int more[] = {7, 3, 1, 0};
            std::uint64_t size = head & 0x3FU;
            for (const char c : scanner_.bytes(static_cast<std::size_t>(more[head >> 6U]), item)) {
                size = size << 8U | static_cast<unsigned char>(c);
            }
            scanner_.bytes(size, item);
        }
    }

    const Source& source_;
    TextScanner scanner_;
    Contents contents_;
    bool binary_ = false;
    VtkCells cells_;
    bool has_cells_ = false;
    std::vector<std::int64_t> types_;
    std::int64_t tuples_ = 0;  ///< of the attributes that follow
    bool keep_ = false;        ///< they belong to points
};

}  // namespace

Contents read_vtk_legacy(const Source& source) {
    return LegacyReader(source).run();
}

}  // namespace beltrami::formats
