#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "beltrami/framework/formats/numbers.hpp"
#include "beltrami/framework/formats/writers.hpp"

namespace beltrami::formats {

namespace {

/// A column of a field under its property's name.
struct Column {
    const Block* values;
    Eigen::Index column;
    std::string name;
    bool byte;  ///< 0..1 as uchar 0..255
};

// Property names end at a blank.
std::string property_name(std::string_view name) {
    std::string text(name);
    for (char& c : text) {
        if (static_cast<unsigned char>(c) <= ' ' || c == '\x7F') c = '_';
    }
    return text;
}

bool in_byte_range(const Field& field) {
    return (field.values.array() >= 0.0).all() && (field.values.array() <= 1.0).all();
}

// An opacity belongs to its colour, and other programs want both of one type; but `alpha` may also be what
// somebody computed, so only what loses nothing becomes bytes.
bool is_opacity(const Field& field) {
    return field.name == "alpha" && field.values.cols() == 1 && in_byte_range(field) &&
           (field.values.unaryExpr([](double v) { return std::round(255.0 * v) / 255.0; }).array() ==
            field.values.array())
               .all();
}

class ColumnNames {
  public:
    std::string unused(const std::string& wanted) {
        std::string name = wanted;
        while (!used_.insert(name).second)
            name += '_';
        return name;
    }

  private:
    std::set<std::string> used_{"x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"};
};

std::vector<Column> columns_of(const Fields& fields) {
    std::vector<Column> columns;
    ColumnNames names;
    const bool byte_colors = std::any_of(fields.begin(), fields.end(), [](const Field& field) {
        return is_color(field) && in_byte_range(field);
    });
    for (const Field& field : fields) {
        const bool channels = is_color(field) && byte_colors;
        const bool bytes = channels || (byte_colors && is_opacity(field));
        const bool normal = field.name == "normal" && field.values.cols() == 3;
        const std::string stem = property_name(field.name);
        for (Eigen::Index c = 0; c < field.values.cols(); ++c) {
            constexpr std::array axes{"x", "y", "z"};
            constexpr std::array colors{"red", "green", "blue"};
            std::string name;
            if (channels) {
                name = colors[static_cast<std::size_t>(c)];
            } else if (normal) {
                name = std::string("n") + axes[static_cast<std::size_t>(c)];
            } else if (field.values.cols() == 1) {
                name = names.unused(stem);
            } else if (field.values.cols() == 3) {
                name = names.unused(stem + "_" + axes[static_cast<std::size_t>(c)]);
            } else {
                name = names.unused(fmt::format("{}_{}", stem, c));
            }
            columns.push_back({&field.values, c, std::move(name), bytes});
        }
    }
    return columns;
}

template <class T>
void append(std::string& bytes, T value) {
    std::array<char, sizeof(T)> stored{};
    std::memcpy(stored.data(), &value, sizeof(T));
    if constexpr (std::endian::native != std::endian::little) std::reverse(stored.begin(), stored.end());
    bytes.append(stored.data(), stored.size());
}

std::string header(const Mesh& mesh, const std::vector<Column>& columns) {
    std::string text = fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment Beltrami\nelement vertex {}\n"
        "property double x\nproperty double y\nproperty double z\n",
        mesh.vertex_count());
    for (const Column& column : columns) {
        text += fmt::format("property {} {}\n", column.byte ? "uchar" : "double", column.name);
    }
    switch (mesh.kind()) {
        case CellKind::point:
            break;
        case CellKind::segment:
            text += fmt::format("element edge {}\nproperty int vertex1\nproperty int vertex2\n",
                                mesh.cell_count());
            break;
        case CellKind::triangle:
        case CellKind::tetrahedron:
            text +=
                fmt::format("element {} {}\nproperty list uchar int vertex_indices\n",
                            mesh.kind() == CellKind::triangle ? "face" : "tetrahedron", mesh.cell_count());
    }
    return text + "end_header\n";
}

}  // namespace

void write_ply(std::ostream& stream, const Mesh& mesh, const Fields& fields) {
    const std::vector<Column> columns = columns_of(fields);
    std::string bytes = header(mesh, columns);
    const auto pass_on = [&](std::size_t above) {
        if (bytes.size() <= above) return;
        stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        bytes.clear();
    };
    constexpr std::size_t piece = 1U << 16U;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        for (int axis = 0; axis < 3; ++axis)
            append(bytes, mesh.points()(v, axis));
        for (const Column& column : columns) {
            const double value = (*column.values)(v, column.column);
            if (column.byte) {
                append(bytes, static_cast<std::uint8_t>(std::lround(255.0 * value)));
            } else {
                append(bytes, value);
            }
        }
        pass_on(piece);
    }
    const Eigen::Index corners = mesh.cells().cols();
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (mesh.kind() != CellKind::segment) append(bytes, static_cast<std::uint8_t>(corners));
        for (Eigen::Index k = 0; k < corners; ++k)
            append(bytes, mesh.cells()(c, k));
        pass_on(piece);
    }
    pass_on(0);
}

}  // namespace beltrami::formats
