// VTK XML with appended raw arrays: pugixml writes the XML, the arrays follow as they lie in memory.
#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <ostream>
#include <pugixml.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "beltrami/framework/formats/vtk_cells.hpp"
#include "beltrami/framework/formats/writers.hpp"

namespace beltrami::formats {

namespace {

/// The array elements of the XML, and the bytes that they point to.
class AppendedArrays {
  public:
    void add(pugi::xml_node parent, const char* type, const char* name, Eigen::Index components,
             const void* data, std::size_t bytes) {
        pugi::xml_node array = parent.append_child("DataArray");
        array.append_attribute("type") = type;
        array.append_attribute("Name") = name;
        if (components != 1)
            array.append_attribute("NumberOfComponents") = static_cast<long long>(components);
        array.append_attribute("format") = "appended";
        array.append_attribute("offset") = static_cast<unsigned long long>(offset_);
        parts_.emplace_back(static_cast<const char*>(data), bytes);
        offset_ += sizeof(std::uint64_t) + bytes;
    }

    void write(std::ostream& stream) const {
        for (const std::string_view part : parts_) {
            const std::uint64_t size = part.size();
            stream.write(reinterpret_cast<const char*>(&size), sizeof(size));
            stream.write(part.data(), static_cast<std::streamsize>(part.size()));
        }
    }

  private:
    std::vector<std::string_view> parts_;
    std::size_t offset_ = 0;
};

VtkCell cell_type(CellKind kind) {
    switch (kind) {
        case CellKind::point:
            break;
        case CellKind::segment:
            return VtkCell::line;
        case CellKind::triangle:
            return VtkCell::triangle;
        case CellKind::tetrahedron:
            return VtkCell::tetrahedron;
    }
    return VtkCell::vertex;
}

// Points alone are a vertex cell each: ParaView shows no points that no cell names.
Cells visible_cells(const Mesh& mesh) {
    if (mesh.kind() != CellKind::point) return mesh.cells();
    return Eigen::VectorX<Index>::LinSpaced(mesh.vertex_count(), 0, mesh.vertex_count() - 1);
}

}  // namespace

void write_vtu(std::ostream& stream, const Mesh& mesh, const Fields& fields) {
    const Cells cells = visible_cells(mesh);
    const auto cell_count = static_cast<std::size_t>(cells.rows());
    std::vector<std::int64_t> offsets(cell_count);
    for (std::size_t c = 0; c < cell_count; ++c)
        offsets[c] = static_cast<std::int64_t>(c + 1) * cells.cols();
    const std::vector<std::uint8_t> types(cell_count, static_cast<std::uint8_t>(cell_type(mesh.kind())));

    pugi::xml_document document;
    pugi::xml_node root = document.append_child("VTKFile");
    root.append_attribute("type") = "UnstructuredGrid";
    root.append_attribute("version") = "1.0";
    root.append_attribute("byte_order") =
        std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";
    root.append_attribute("header_type") = "UInt64";
    pugi::xml_node piece = root.append_child("UnstructuredGrid").append_child("Piece");
    piece.append_attribute("NumberOfPoints") = mesh.vertex_count();
    piece.append_attribute("NumberOfCells") = static_cast<unsigned long long>(cell_count);

    AppendedArrays arrays;
    const auto doubles = [](const auto& m) { return static_cast<std::size_t>(m.size()) * sizeof(double); };
    pugi::xml_node data = piece.append_child("PointData");
    for (const Field& field : fields) {
        arrays.add(data, "Float64", field.name.c_str(), field.values.cols(), field.values.data(),
                   doubles(field.values));
    }
    arrays.add(piece.append_child("Points"), "Float64", "Points", 3, mesh.points().data(),
               doubles(mesh.points()));
    pugi::xml_node cell_data = piece.append_child("Cells");
    arrays.add(cell_data, "Int32", "connectivity", 1, cells.data(),
               static_cast<std::size_t>(cells.size()) * sizeof(Index));
    arrays.add(cell_data, "Int64", "offsets", 1, offsets.data(), cell_count * sizeof(std::int64_t));
    arrays.add(cell_data, "UInt8", "types", 1, types.data(), cell_count);

    // The raw bytes cannot go through an XML library: the document is cut open before its last line.
    std::ostringstream xml;
    document.save(xml, " ");
    const std::string text = xml.str();
    const std::size_t end = text.rfind("</VTKFile>");
    stream << std::string_view(text).substr(0, end) << " <AppendedData encoding=\"raw\">\n_";
    arrays.write(stream);
    stream << "\n </AppendedData>\n" << std::string_view(text).substr(end);
}

}  // namespace beltrami::formats
