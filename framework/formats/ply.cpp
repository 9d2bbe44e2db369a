// Stanford PLY. Our own: CGAL's reader keeps neither unknown vertex properties nor triangle strips.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "beltrami/framework/formats/numbers.hpp"
#include "beltrami/framework/formats/readers.hpp"
#include "beltrami/framework/formats/text_scanner.hpp"

namespace beltrami::formats {

namespace {

struct Property {
    std::string name;
    NumberType type = NumberType::float32;
    std::optional<NumberType> count_type;  ///< of a list
};

struct Element {
    std::string name;
    std::int64_t count = 0;
    std::vector<Property> properties;
};

enum class Encoding { ascii, little, big };

struct Header {
    Encoding encoding = Encoding::ascii;
    std::vector<Element> elements;
};

class HeaderReader {
  public:
    explicit HeaderReader(TextScanner& scanner) : scanner_(scanner) {}

    Header run() {
        scanner_.next_line();
        if (scanner_.word_on_line() != "ply") {
            scanner_.fail("the file does not start with 'ply'", "check that its ending is right");
        }
        while (scanner_.next_line()) {
            const std::string_view key = scanner_.word_on_line();
            if (key == "format") {
                read_encoding();
            } else if (key == "element") {
                read_element();
            } else if (key == "property") {
                read_property();
            } else if (key == "end_header") {
                if (!has_format_) scanner_.fail("the header has no 'format' line");
                scanner_.rest_of_line();
                return std::move(header_);
            } else if (key != "comment" && key != "obj_info") {
                scanner_.fail("this is not a line of a PLY header");
            }
        }
        scanner_.fail("the file ends inside the header, before 'end_header'");
    }

  private:
    void read_encoding() {
        const std::string_view word = scanner_.word_on_line();
        if (word == "ascii") {
            header_.encoding = Encoding::ascii;
        } else if (word == "binary_little_endian") {
            header_.encoding = Encoding::little;
        } else if (word == "binary_big_endian") {
            header_.encoding = Encoding::big;
        } else {
            scanner_.fail("the format is not ascii, binary_little_endian or binary_big_endian");
        }
        has_format_ = true;
    }

    void read_element() {
        Element element;
        element.name = scanner_.word_on_line();
        element.count = scanner_.to_integer(scanner_.word_on_line(),
                                            {"element", number_of_elements(), number_of_elements() + 1});
        // Whether the file is long enough is asked when the size of a row is known.
        scanner_.require_room(element.name, element.count, 0);
        header_.elements.push_back(std::move(element));
    }

    void read_property() {
        if (header_.elements.empty()) scanner_.fail("a property comes before any element");
        Property property;
        std::string_view word = scanner_.word_on_line();
        if (word == "list") {
            property.count_type = number_type(scanner_.word_on_line());
            word = scanner_.word_on_line();
        }
        property.type = number_type(word);
        property.name = scanner_.word_on_line();
        if (property.name.empty()) scanner_.fail("a property has no name");
        header_.elements.back().properties.push_back(std::move(property));
    }

    NumberType number_type(std::string_view word) {
        static const std::map<std::string_view, NumberType> types{
            {"char", NumberType::int8},      {"int8", NumberType::int8},
            {"uchar", NumberType::uint8},    {"uint8", NumberType::uint8},
            {"short", NumberType::int16},    {"int16", NumberType::int16},
            {"ushort", NumberType::uint16},  {"uint16", NumberType::uint16},
            {"int", NumberType::int32},      {"int32", NumberType::int32},
            {"uint", NumberType::uint32},    {"uint32", NumberType::uint32},
            {"int64", NumberType::int64},    {"uint64", NumberType::uint64},
            {"float", NumberType::float32},  {"float32", NumberType::float32},
            {"double", NumberType::float64}, {"float64", NumberType::float64}};
        const auto found = types.find(word);
        if (found == types.end()) scanner_.fail("a property has a type that PLY does not know");
        return found->second;
    }

    [[nodiscard]] std::int64_t number_of_elements() const {
        return static_cast<std::int64_t>(header_.elements.size());
    }

    TextScanner& scanner_;
    Header header_;
    bool has_format_ = false;
};

/// Numbers of the ASCII encoding: a row starts on a line of its own, and only lists may go on to the next.
class AsciiValues {
  public:
    explicit AsciiValues(TextScanner& scanner) : scanner_(scanner) {}

    void start_row(const Item& item) {
        if (!scanner_.next_line()) scanner_.fail_end(item);
    }
    double number(const Property& property, const Item& item) {
        const std::string_view word = scanner_.word_on_line();
        if (word.empty())
            scanner_.fail(fmt::format("{} has no value of '{}'", describe(item), property.name));
        return scanner_.to_number(word, item);
    }
    std::int64_t list_size(const Property& property, const Item& item) {
        return whole(number(property, item));
    }
    std::int64_t list_value(NumberType, const Item& item) { return whole(scanner_.number(item)); }

    [[nodiscard]] static std::size_t least_bytes(NumberType) { return 2; }
    [[nodiscard]] std::size_t room() const {
        return scanner_.bytes_left() + 1;
    }  // no blank after the last word
    [[nodiscard]] TextScanner& scanner() { return scanner_; }

  private:
    TextScanner& scanner_;
};

class BinaryValues {
  public:
    BinaryValues(TextScanner& scanner, std::endian order) : scanner_(scanner), order_(order) {}

    void start_row(const Item&) {}
    double number(const Property& property, const Item& item) { return read<double>(property.type, item); }
    std::int64_t list_size(const Property& property, const Item& item) {
        return read<std::int64_t>(*property.count_type, item);
    }
    std::int64_t list_value(NumberType type, const Item& item) { return read<std::int64_t>(type, item); }

    [[nodiscard]] static std::size_t least_bytes(NumberType type) { return byte_size(type); }
    [[nodiscard]] std::size_t room() const { return scanner_.bytes_left(); }
    [[nodiscard]] TextScanner& scanner() { return scanner_; }

  private:
    template <class T>
    T read(NumberType type, const Item& item) {
        return load_as<T>(scanner_.bytes(byte_size(type), item).data(), type, order_);
    }

    TextScanner& scanner_;
    std::endian order_;
};

/// Reads the elements after the header; Values is one of the two above.
template <class Values>
class BodyReader {
  public:
    BodyReader(const Header& header, Values values) : header_(header), values_(values) {
        for (const Element& element : header.elements) {
            if (element.name == "vertex") vertices_ = element.count;
        }
    }

    Contents run() {
        for (const Element& element : header_.elements) {
            if (element.properties.empty()) continue;
            require_room(element);
            if (element.name == "vertex") {
                read_vertices(element);
            } else if (element.name == "face") {
                read_lists(element, [&] { contents_.polygons.add(corners()); });
            } else if (element.name == "tristrips") {
                read_lists(element, [&] { add_strips(); });
            } else if (element.name == "tetrahedron") {
                read_lists(element, [&] { add_tetrahedron(); });
            } else if (element.name == "edge") {
                read_edges(element);
            } else {
                read_rows(element, nullptr, [](std::int64_t) {});
            }
        }
        return std::move(contents_);
    }

  private:
    void require_room(const Element& element) {
        std::size_t bytes = 0;
        for (const Property& property : element.properties) {
            bytes += Values::least_bytes(property.count_type.value_or(property.type));
        }
        const TextScanner& scanner = values_.scanner();
        scanner.source().require_room(scanner.place(), element.name, element.count, bytes, values_.room());
    }

    /// Leaves a row's scalars in row_ and the values of its list `wanted` in list_, and calls use(row
    /// number).
    template <class Use>
    void read_rows(const Element& element, const Property* wanted, Use&& use) {
        for (item_ = {element.name, 0, element.count}; item_.index < element.count; ++item_.index) {
            values_.start_row(item_);
            row_.clear();
            for (const Property& property : element.properties) {
                if (!property.count_type) {
                    row_.push_back(values_.number(property, item_));
                } else {
                    read_list(property, &property == wanted);
                }
            }
            use(item_.index);
        }
    }

    void read_list(const Property& property, bool keep) {
        const std::int64_t size = values_.list_size(property, item_);
        if (size < 0)
            values_.scanner().fail(fmt::format("{} has a list of {} values", describe(item_), size));
        if (static_cast<std::size_t>(size) > values_.room()) values_.scanner().fail_end(item_);
        if (keep) list_.clear();
        for (std::int64_t i = 0; i < size; ++i) {
            const std::int64_t value = values_.list_value(property.type, item_);
            if (keep) list_.push_back(value);
        }
    }

    void read_vertices(const Element& element) {
        if (contents_.vertex_count() > 0) values_.scanner().fail("there is a second element 'vertex'");
        std::vector<const Property*> columns;
        for (const Property& property : element.properties) {
            if (!property.count_type) columns.push_back(&property);
        }
        std::vector<double> table;
        table.reserve(static_cast<std::size_t>(element.count) * columns.size());
        read_rows(element, nullptr,
                  [&](std::int64_t) { table.insert(table.end(), row_.begin(), row_.end()); });
        add_fields(columns, table);
    }

    /// Merges the columns of a group, at the place of the group's first.
    void add_fields(const std::vector<const Property*>& columns, const std::vector<double>& table) {
        const auto find = [&](std::string_view name) -> std::optional<std::size_t> {
            for (std::size_t c = 0; c < columns.size(); ++c) {
                if (columns[c]->name == name) return c;
            }
            return std::nullopt;
        };
        const auto take = [&](const std::vector<std::size_t>& wanted) {
            std::vector<double> values;
            const std::size_t rows = columns.empty() ? 0 : table.size() / columns.size();
            values.reserve(rows * wanted.size());
            for (std::size_t r = 0; r < rows; ++r) {
                for (const std::size_t c : wanted)
                    values.push_back(table[r * columns.size() + c] / full(columns[c]));
            }
            return values;
        };
        const auto group_of = [&](const std::array<std::string, 3>& names) {
            std::vector<std::size_t> group;
            for (const std::string& name : names) {
                if (const auto c = find(name)) group.push_back(*c);
            }
            return group.size() == 3 ? group : std::vector<std::size_t>{};
        };

        std::vector<bool> used(columns.size(), false);
        const auto add = [&](const std::string& name, const std::vector<std::size_t>& group) {
            for (const std::size_t c : group)
                used[c] = true;
            if (name.empty()) {
                contents_.positions = take(group);
            } else {
                add_field(contents_, name, group.size(), take(group));
            }
        };
        const auto positions = group_of({"x", "y", "z"});
        if (positions.empty()) {
            values_.scanner().fail("the vertices lack one of the properties x, y, z",
                                   "export the mesh with positions");
        }
        add("", positions);
        for (std::size_t c = 0; c < columns.size(); ++c) {
            if (used[c]) continue;
            const auto [name, parts] = group_around(columns[c]->name);
            const auto group = name.empty() ? std::vector<std::size_t>{} : group_of(parts);
            const bool free =
                std::none_of(group.begin(), group.end(), [&](std::size_t g) { return used[g]; });
            if (!group.empty() && free) {
                add(name, group);
            } else {
                add(columns[c]->name, {c});
            }
        }
    }

    static std::pair<std::string, std::array<std::string, 3>> group_around(const std::string& name) {
        if (name == "nx" || name == "ny" || name == "nz") return {"normal", {"nx", "ny", "nz"}};
        if (name == "red" || name == "green" || name == "blue") return {"color", {"red", "green", "blue"}};
        if (name.size() > 2 && name[name.size() - 2] == '_' && name.back() >= 'x' && name.back() <= 'z') {
            const std::string stem = name.substr(0, name.size() - 2);
            return {stem, {stem + "_x", stem + "_y", stem + "_z"}};
        }
        return {};
    }

    /// What a colour channel is divided by to come into 0..1.
    static double full(const Property* property) {
        const auto& name = property->name;
        if (name != "red" && name != "green" && name != "blue" && name != "alpha") return 1.0;
        if (property->type == NumberType::uint8) return 255.0;
        if (property->type == NumberType::uint16) return 65535.0;
        return 1.0;
    }

    template <class Use>
    void read_lists(const Element& element, Use&& use) {
        const Property* wanted = nullptr;
        for (const Property& property : element.properties) {
            const bool named = property.name == "vertex_indices" || property.name == "vertex_index";
            if (named && property.count_type && wanted == nullptr) wanted = &property;
        }
        if (wanted == nullptr) {
            values_.scanner().fail(fmt::format("the element '{}' has no list vertex_indices", element.name),
                                   "export the mesh again");
        }
        contents_.polygons.reserve(element.name == "face" ? static_cast<std::size_t>(element.count) : 0);
        read_rows(element, wanted, [&](std::int64_t) { use(); });
    }

    Index vertex(std::int64_t number) { return values_.scanner().to_vertex(number, 0, vertices_, item_); }

    std::span<const Index> corners() {
        corners_.clear();
        for (const std::int64_t number : list_)
            corners_.push_back(vertex(number));
        return corners_;
    }

    void add_strips() {
        corners_.clear();
        for (const std::int64_t number : list_) {
            if (number != -1) {
                corners_.push_back(vertex(number));
                continue;
            }
            add_strip(contents_.polygons, corners_);
            corners_.clear();
        }
        add_strip(contents_.polygons, corners_);
    }

    void add_tetrahedron() {
        if (list_.size() != 4) {
            values_.scanner().fail(fmt::format("{} has {} corners, not 4", describe(item_), list_.size()));
        }
        const auto four = corners();
        contents_.tetrahedra.insert(contents_.tetrahedra.end(), four.begin(), four.end());
    }

    void read_edges(const Element& element) {
        std::optional<std::size_t> first, second;
        std::size_t scalars = 0;
        for (const Property& property : element.properties) {
            if (property.count_type) continue;
            if (property.name == "vertex1") first = scalars;
            if (property.name == "vertex2") second = scalars;
            ++scalars;
        }
        if (!first || !second) {
            values_.scanner().fail("the element 'edge' lacks vertex1 or vertex2", "export the mesh again");
        }
        read_rows(element, nullptr, [&](std::int64_t) {
            add_polyline(contents_.segments,
                         std::array{vertex(whole(row_[*first])), vertex(whole(row_[*second]))});
        });
    }

    const Header& header_;
    Values values_;
    Contents contents_;
    std::int64_t vertices_ = 0;
    Item item_{};
    std::vector<double> row_;
    std::vector<std::int64_t> list_;
    std::vector<Index> corners_;
};

}  // namespace

Contents read_ply(const Source& source) {
    TextScanner scanner(source, '\0');
    const Header header = HeaderReader(scanner).run();
    if (header.encoding == Encoding::ascii) return BodyReader(header, AsciiValues(scanner)).run();
    const auto order = header.encoding == Encoding::little ? std::endian::little : std::endian::big;
    return BodyReader(header, BinaryValues(scanner, order)).run();
}

}  // namespace beltrami::formats
