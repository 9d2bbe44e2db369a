// One writer a format; write_mesh() chooses by the ending and has checked that cells and fields fit.
#pragma once

#include <iosfwd>

#include "beltrami/framework/mesh.hpp"

namespace beltrami::formats {

/// Fields as double properties; cells as element face, edge or tetrahedron (ours: read_mesh reads it, other
/// programs show the points).
void write_ply(std::ostream& stream, const Mesh& mesh, const Fields& fields);

void write_vtu(std::ostream& stream, const Mesh& mesh, const Fields& fields);

/// Points, segments or triangles, and a field `color` of three columns; other fields are left out.
void write_obj(std::ostream& stream, const Mesh& mesh, const Fields& fields);

/// Points or triangles, no fields.
void write_off(std::ostream& stream, const Mesh& mesh, const Fields& fields);

bool is_color(const Field& field);

}  // namespace beltrami::formats
