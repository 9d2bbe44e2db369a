// One writer a format; write_mesh() chooses by the ending and has checked the fields.
#pragma once

#include <iosfwd>

#include "beltrami/framework/mesh.hpp"

namespace beltrami::formats {

/// Fields as double properties; cells as element face, edge or tetrahedron (ours: read_mesh reads it, other
/// programs show the points).
void write_ply(std::ostream& stream, const Mesh& mesh, const Fields& fields);

void write_vtu(std::ostream& stream, const Mesh& mesh, const Fields& fields);

/// Field `color` of three columns only; others are left out. Throws InputError for tetrahedra.
void write_obj(std::ostream& stream, const Mesh& mesh, const Fields& fields);

/// No fields. Throws InputError for segments and tetrahedra.
void write_off(std::ostream& stream, const Mesh& mesh, const Fields& fields);

bool is_color(const Field& field);

}  // namespace beltrami::formats
