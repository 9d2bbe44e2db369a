// VTK's XML files of unstructured grids (.vtu) and polygons (.vtp). pugixml reads the XML, zlib the
// compressed arrays.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <pugixml.hpp>
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

/// Bytes in order, from raw data or from base64; padding may end a part in the middle of a stream.
class ByteStream {
  public:
    ByteStream(const Source& source, std::string place, std::string_view data, bool base64)
        : source_(source), place_(std::move(place)), data_(data), base64_(base64) {}

    std::string_view take(std::size_t size) {
        if (size > room()) fail("the data end too early");
        if (!base64_) {
            const std::string_view taken = data_.substr(0, size);
            data_.remove_prefix(size);
            return taken;
        }
        decoded_.erase(0, used_);
        while (decoded_.size() < size)
            decode_group();
        used_ = size;
        return std::string_view(decoded_).substr(0, size);
    }

    /// At least as many bytes as are left.
    [[nodiscard]] std::size_t room() const {
        return base64_ ? decoded_.size() - used_ + data_.size() / 4 * 3 + 3 : data_.size();
    }

    [[noreturn]] void fail(std::string_view reason, std::string_view hint = damaged_hint) const {
        source_.fail(place_, reason, hint);
    }
    [[nodiscard]] const Source& source() const { return source_; }
    [[nodiscard]] const std::string& place() const { return place_; }

  private:
    void decode_group() {
        std::uint32_t bits = 0;
        int letters = 0;
        int padding = 0;
        while (letters + padding < 4) {
            if (data_.empty()) fail("the data end too early");
            const char c = data_.front();
            data_.remove_prefix(1);
            if (c == ' ' || (c >= '\t' && c <= '\r')) continue;
            if (c == '=') {
                ++padding;
                continue;
            }
            const int digit = value(c);
            if (digit < 0 || padding > 0) fail("the data are not base64");
            bits = bits << 6U | static_cast<std::uint32_t>(digit);
            ++letters;
        }
        if (letters < 2) fail("the data are not base64");
        bits <<= 6U * static_cast<unsigned>(padding);
        for (int i = 0; i < 3 - padding; ++i)
            decoded_ += static_cast<char>(bits >> (16U - 8U * static_cast<unsigned>(i)) & 0xFFU);
    }

    static int value(char c) {
        if (c >= 'A' && c <= 'Z') return c - 'A';
        if (c >= 'a' && c <= 'z') return c - 'a' + 26;
        if (c >= '0' && c <= '9') return c - '0' + 52;
        return c == '+' ? 62 : c == '/' ? 63 : -1;
    }

    const Source& source_;
    std::string place_;
    std::string_view data_;
    bool base64_;
    std::string decoded_;
    std::size_t used_ = 0;  ///< of decoded_
};

class XmlReader {
  public:
    explicit XmlReader(const Source& source) : source_(source) {}

    Contents run() {
        parse();
        const pugi::xml_node root = document_.child("VTKFile");
        const std::string type = root.attribute("type").value();
        if (type != "UnstructuredGrid" && type != "PolyData") {
            fail(root, fmt::format("the file holds '{}', neither an UnstructuredGrid nor PolyData", type),
                 "check that its ending is right, or turn it into an unstructured grid first");
        }
        read_encoding(root);
        const pugi::xml_node data = root.child(type.c_str());
        for (const pugi::xml_node piece : data.children("Piece"))
            read_piece(piece, type == "PolyData");
        finish_fields();
        return std::move(contents_);
    }

  private:
    // Appended raw data may hold anything, so they are cut off before the XML is parsed.
    void parse() {
        const std::string_view bytes = source_.bytes();
        const std::size_t appended = bytes.find("<AppendedData");
        std::string xml;
        if (appended != std::string_view::npos) {
            const std::size_t close = bytes.find('>', appended);
            const std::size_t underscore = bytes.find('_', close);
            if (close == std::string_view::npos || underscore == std::string_view::npos) {
                source_.fail(place_of(appended), "the appended data do not start with '_'");
            }
            appended_ = bytes.substr(underscore + 1);
            xml = std::string(bytes.substr(0, close + 1)) + "</AppendedData></VTKFile>";
        } else {
            xml = bytes;
        }
        const auto result =
            document_.load_buffer(xml.data(), xml.size(), pugi::parse_default, pugi::encoding_utf8);
        if (!result) {
            source_.fail(place_of(static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0))),
                         fmt::format("the file is not well-formed XML ({})", result.description()));
        }
        if (!document_.child("VTKFile"))
            source_.fail("", "the file is XML without an element VTKFile", "check that its ending is right");
    }

    void read_encoding(const pugi::xml_node& root) {
        order_ = std::string_view(root.attribute("byte_order").value()) == "BigEndian" ? std::endian::big
                                                                                       : std::endian::little;
        const std::string_view header = root.attribute("header_type").as_string("UInt32");
        if (header != "UInt32" && header != "UInt64") fail(root, "header_type is neither UInt32 nor UInt64");
        header_ = header == "UInt64" ? NumberType::uint64 : NumberType::uint32;
        const std::string_view compressor = root.attribute("compressor").value();
        compressed_ = !compressor.empty();
        if (compressed_ && compressor != "vtkZLibDataCompressor") {
            fail(root, fmt::format("the arrays are compressed by {}, which is not read", compressor),
                 "save the file with zlib or uncompressed");
        }
        const std::string_view encoding = root.child("AppendedData").attribute("encoding").as_string("raw");
        if (encoding != "raw" && encoding != "base64")
            fail(root, "the appended data are neither raw nor base64");
        appended_base64_ = encoding == "base64";
    }

    void read_piece(const pugi::xml_node& piece, bool polydata) {
        const std::int64_t vertices = piece.attribute("NumberOfPoints").as_llong(-1);
        if (vertices < 0) fail(piece, "a piece does not say its NumberOfPoints");
        const std::int64_t before = contents_.vertex_count();
        const auto positions = vertices == 0 ? std::vector<double>{}
                                             : read_array<double>(piece.child("Points").child("DataArray"));
        if (static_cast<std::int64_t>(positions.size() / 3) != vertices || positions.size() % 3 != 0) {
            fail(piece.child("Points"), fmt::format("{} points are announced, but {} coordinates are there",
                                                    vertices, positions.size()));
        }
        contents_.positions.insert(contents_.positions.end(), positions.begin(), positions.end());
        if (polydata) {
            for (const auto& [name, type] :
                 {std::pair{"Lines", VtkCell::poly_line}, std::pair{"Polys", VtkCell::polygon},
                  std::pair{"Strips", VtkCell::strip}}) {
                add_vtk_cells(source_, contents_, read_cells(piece.child(name)),
                              {static_cast<std::int64_t>(type)}, vertices, before);
            }
        } else {
            const pugi::xml_node cells = piece.child("Cells");
            const VtkCells list = read_cells(cells);
            const auto types = list.ends.empty() ? std::vector<std::int64_t>{0}
                                                 : read_array<std::int64_t>(named(cells, "types"));
            if (!list.ends.empty() && types.size() != list.ends.size()) {
                fail(cells,
                     fmt::format("there are {} cells but {} cell types", list.ends.size(), types.size()));
            }
            add_vtk_cells(source_, contents_, list, types, vertices, before);
        }
        read_fields(piece.child("PointData"), vertices);
        ++pieces_;
    }

    VtkCells read_cells(const pugi::xml_node& node) {
        VtkCells cells;
        if (!node || !named(node, "offsets")) return cells;
        cells.ends = read_array<std::int64_t>(named(node, "offsets"));
        cells.connectivity = cells.ends.empty() ? std::vector<std::int64_t>{}
                                                : read_array<std::int64_t>(named(node, "connectivity"));
        return cells;
    }

    static pugi::xml_node named(const pugi::xml_node& node, const char* name) {
        return node.find_child_by_attribute("DataArray", "Name", name);
    }

    void read_fields(const pugi::xml_node& data, std::int64_t vertices) {
        for (const pugi::xml_node array : data.children("DataArray")) {
            if (std::string_view(array.attribute("type").value()) == "String") continue;
            const std::int64_t columns = array.attribute("NumberOfComponents").as_llong(1);
            auto values = read_array<double>(array);
            if (columns < 1 || static_cast<std::size_t>(columns) > std::max<std::size_t>(values.size(), 1) ||
                values.size() != static_cast<std::size_t>(vertices) * static_cast<std::size_t>(columns)) {
                fail(array, fmt::format("the array '{}' has {} values for {} points of {} components",
                                        array.attribute("Name").value(), values.size(), vertices, columns));
            }
            Parts& parts = fields_[array.attribute("Name").value()];
            if (parts.pieces == 0) {
                parts.columns = static_cast<std::size_t>(columns);
                order_of_fields_.emplace_back(array.attribute("Name").value());
            }
            if (parts.pieces == pieces_ && parts.columns == static_cast<std::size_t>(columns)) {
                ++parts.pieces;
                parts.values.insert(parts.values.end(), values.begin(), values.end());
            }
        }
    }

    void finish_fields() {
        for (const std::string& name : order_of_fields_) {
            const Parts& parts = fields_[name];
            if (parts.pieces == pieces_) {
                add_field(contents_, name, parts.columns, parts.values);
            } else {
                contents_.notes.push_back(
                    fmt::format("the array '{}', which not every piece has, was left out", name));
            }
        }
    }

    template <class T>
    std::vector<T> read_array(const pugi::xml_node& node) {
        if (!node) source_.fail("", "an array is missing");
        const std::string_view format = node.attribute("format").as_string("ascii");
        if (format == "ascii") return read_ascii<T>(node);
        const NumberType type = number_type(node);
        const std::string place = place_of(node);
        if (format == "binary") {
            ByteStream stream(source_, place, node.child_value(), true);
            return decode<T>(stream, type);
        }
        if (format != "appended") fail(node, fmt::format("an array's format '{}' is not known", format));
        const auto offset = node.attribute("offset").as_ullong(~0ULL);
        if (offset >= appended_.size()) fail(node, "an array's offset lies behind the appended data");
        ByteStream stream(source_, place, appended_.substr(offset), appended_base64_);
        return decode<T>(stream, type);
    }

    template <class T>
    std::vector<T> read_ascii(const pugi::xml_node& node) {
        TextScanner scanner(source_, node.child_value(), '\0', line_of(node));
        std::vector<T> values;
        for (std::string_view word = scanner.word(); !word.empty(); word = scanner.word()) {
            const auto number = static_cast<std::int64_t>(values.size());
            const Item item{"value", number, number + 1};
            if constexpr (std::is_same_v<T, double>) {
                values.push_back(scanner.to_number(word, item));
            } else {
                values.push_back(scanner.to_integer(word, item));
            }
        }
        return values;
    }

    template <class T>
    std::vector<T> decode(ByteStream& stream, NumberType type) {
        if (compressed_) {
            const std::string bytes = inflated(stream);
            return load_all<T>(whole_numbers(stream, bytes, type), type, order_);
        }
        const std::size_t size = header_value(stream.take(byte_size(header_)), 0);
        return load_all<T>(whole_numbers(stream, stream.take(size), type), type, order_);
    }

    static std::string_view whole_numbers(const ByteStream& stream, std::string_view bytes, NumberType type) {
        if (bytes.size() % byte_size(type) != 0)
            stream.fail("an array's size is not a multiple of its numbers'");
        return bytes;
    }

    [[nodiscard]] std::size_t header_value(std::string_view bytes, std::size_t i) const {
        const std::size_t size = byte_size(header_);
        return header_ == NumberType::uint64 ? load<std::uint64_t>(bytes.data() + i * size, order_)
                                             : load<std::uint32_t>(bytes.data() + i * size, order_);
    }

    // Number of blocks, size of a block, size of the last if it is smaller, compressed size of each; then the
    // blocks.
    std::string inflated(ByteStream& stream) {
        const std::size_t word = byte_size(header_);
        const std::string start(stream.take(3 * word));
        const std::size_t blocks = header_value(start, 0);
        const std::size_t full = header_value(start, 1);
        const std::size_t last = header_value(start, 2);
        // zlib packs 1032 to 1 at best, so larger claims are false. A lone block may be smaller than a
        // block's size says.
        const std::size_t most = 1040 * stream.room();
        const std::size_t tail = last > 0 ? last : full;
        const bool possible =
            blocks <= stream.room() / word && tail <= most && (blocks < 2 || full <= most / blocks);
        if (!possible) stream.fail("the sizes of the compressed blocks are out of range");
        const std::string sizes(stream.take(blocks * word));
        std::string bytes;
        for (std::size_t b = 0; b < blocks; ++b) {
            const std::string_view packed = stream.take(header_value(sizes, b));
            const std::size_t before = bytes.size();
            uLongf size = b + 1 == blocks ? tail : full;
            const uLongf due = size;
            bytes.resize(before + size);
            const int status = uncompress(reinterpret_cast<Bytef*>(bytes.data() + before), &size,
                                          reinterpret_cast<const Bytef*>(packed.data()), packed.size());
            if (status != Z_OK || size != due) stream.fail("a compressed block cannot be unpacked");
        }
        return bytes;
    }

    NumberType number_type(const pugi::xml_node& node) {
        static const std::map<std::string_view, NumberType> types{
            {"Int8", NumberType::int8},      {"UInt8", NumberType::uint8},   {"Int16", NumberType::int16},
            {"UInt16", NumberType::uint16},  {"Int32", NumberType::int32},   {"UInt32", NumberType::uint32},
            {"Int64", NumberType::int64},    {"UInt64", NumberType::uint64}, {"Float32", NumberType::float32},
            {"Float64", NumberType::float64}};
        const auto found = types.find(node.attribute("type").value());
        if (found == types.end())
            fail(node, fmt::format("an array's type '{}' is not known", node.attribute("type").value()));
        return found->second;
    }

    [[nodiscard]] std::int64_t line_of(std::size_t offset) const {
        const std::string_view before = source_.bytes().substr(0, offset);
        return 1 + std::count(before.begin(), before.end(), '\n');
    }
    [[nodiscard]] std::int64_t line_of(const pugi::xml_node& node) const {
        return line_of(static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0)));
    }
    template <class Where>
    [[nodiscard]] std::string place_of(const Where& where) const {
        return fmt::format("line {}", line_of(where));
    }
    [[noreturn]] void fail(const pugi::xml_node& node, std::string_view reason,
                           std::string_view hint = damaged_hint) const {
        source_.fail(place_of(node), reason, hint);
    }

    struct Parts {
        std::size_t columns = 0;
        std::size_t pieces = 0;
        std::vector<double> values;
    };

    const Source& source_;
    pugi::xml_document document_;
    std::string_view appended_;
    bool appended_base64_ = false, compressed_ = false;
    std::endian order_ = std::endian::little;
    NumberType header_ = NumberType::uint32;
    Contents contents_;
    std::size_t pieces_ = 0;
    std::map<std::string, Parts> fields_;
    std::vector<std::string> order_of_fields_;
};

}  // namespace

Contents read_vtk_xml(const Source& source) {
    return XmlReader(source).run();
}

}  // namespace beltrami::formats
