// What the legacy and the XML formats of VTK have in common: types, cells and arrays.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "beltrami/framework/formats/contents.hpp"
#include "beltrami/framework/formats/numbers.hpp"

namespace beltrami::formats {

/// VTK's numbers of the cell types that are read.
enum class VtkCell {
    empty = 0,
    vertex = 1,
    poly_vertex = 2,
    line = 3,
    poly_line = 4,
    triangle = 5,
    strip = 6,
    polygon = 7,
    pixel = 8,
    quad = 9,
    tetrahedron = 10
};

/// Corners of cell c: connectivity[c == 0 ? 0 : ends[c - 1]] up to ends[c].
struct VtkCells {
    std::vector<std::int64_t> connectivity;
    std::vector<std::int64_t> ends;
};

/// Adds cells that name `vertex_count` vertices counted from 0; `vertex_offset` is added to each (for
/// pieces). `types` holds a type each, or one for all. Fails for types that are not read and for numbers out
/// of range.
void add_vtk_cells(const Source& source, Contents& contents, const VtkCells& cells,
                   const std::vector<std::int64_t>& types, std::int64_t vertex_count,
                   std::int64_t vertex_offset);

}  // namespace beltrami::formats
