#include "beltrami/framework/formats/vtk_cells.hpp"

#include <fmt/format.h>

#include <span>
#include <utility>

namespace beltrami::formats {

namespace {

constexpr std::string_view kind = "cell";

void add_cell(const Source& source, Contents& contents, VtkCell type, std::vector<Index>& corners,
              const Item& item) {
    const auto require = [&](bool right) {
        if (!right)
            source.fail(describe(item), fmt::format("a cell of type {} has {} corners",
                                                    static_cast<int>(type), corners.size()));
    };
    switch (type) {
        case VtkCell::empty:
        case VtkCell::vertex:
        case VtkCell::poly_vertex:
            return;
        case VtkCell::line:
        case VtkCell::poly_line:
            return add_polyline(contents.segments, corners);
        case VtkCell::strip:
            return add_strip(contents.polygons, corners);
        case VtkCell::triangle:
            require(corners.size() == 3);
            return contents.polygons.add(corners);
        case VtkCell::polygon:
            return contents.polygons.add(corners);
        case VtkCell::pixel:
            require(corners.size() == 4);
            std::swap(corners[2], corners[3]);
            return contents.polygons.add(corners);
        case VtkCell::quad:
            require(corners.size() == 4);
            return contents.polygons.add(corners);
        case VtkCell::tetrahedron:
            require(corners.size() == 4);
            contents.tetrahedra.insert(contents.tetrahedra.end(), corners.begin(), corners.end());
            return;
    }
    source.fail(
        describe(item), fmt::format("cells of VTK's type {} are not read", static_cast<int>(type)),
        "turn the mesh into triangles or tetrahedra first (ParaView: filter Triangulate or Tetrahedralize)");
}

}  // namespace

void add_vtk_cells(const Source& source, Contents& contents, const VtkCells& cells,
                   const std::vector<std::int64_t>& types, std::int64_t vertex_count,
                   std::int64_t vertex_offset) {
    const auto count = static_cast<std::int64_t>(cells.ends.size());
    if (types.size() != 1 && static_cast<std::int64_t>(types.size()) != count) {
        source.fail("", fmt::format("there are {} cells but {} cell types", count, types.size()));
    }
    std::vector<Index> corners;
    std::int64_t start = 0;
    for (std::int64_t c = 0; c < count; ++c) {
        const Item item{kind, c, count};
        const std::int64_t end = cells.ends[static_cast<std::size_t>(c)];
        if (end < start || end > static_cast<std::int64_t>(cells.connectivity.size())) {
            source.fail(describe(item), fmt::format("the cell's offset {} is out of range", end));
        }
        corners.clear();
        for (; start < end; ++start) {
            const std::int64_t vertex = cells.connectivity[static_cast<std::size_t>(start)];
            if (vertex < 0 || vertex >= vertex_count) source.fail_vertex("", item, vertex, 0, vertex_count);
            corners.push_back(static_cast<Index>(vertex + vertex_offset));
        }
        const std::int64_t type = types[types.size() == 1 ? 0 : static_cast<std::size_t>(c)];
        if (type < 0 || type > 1000) source.fail(describe(item), fmt::format("{} is not a cell type", type));
        add_cell(source, contents, static_cast<VtkCell>(type), corners, item);
    }
}

}  // namespace beltrami::formats
