// Meshes from files.
//
//     Mesh mesh = read_mesh("bunny.obj");
//
// | ending           | what is read                                                                             |
// | .obj             | v (with colours `v x y z r g b` as field `color`, n x 3), f (any polygon), l (segments)  |
// | .off             | OFF, COFF (field `color`) and NOFF (field `normal`), ASCII; polygons                     |
// | .ply             | ASCII and both binary orders; every scalar vertex property; faces, triangle strips       |
// |                  | (`tristrips`), edges, tetrahedra                                                         |
// | .stl             | ASCII and binary; equal positions are welded                                             |
// | .vtk, .vtu, .vtp | legacy (ASCII, binary) and XML (ASCII, base64, appended, zlib): points, lines,           |
// |                  | triangles, quads, polygons, strips, tetrahedra; every numeric point-data array           |
// | .mesh            | Medit ASCII: tetrahedra if there are any, else triangles and quadrilaterals              |
// | .xyz             | points, `x y z` or `x y z nx ny nz` (field `normal`)                                     |
//
// Where a file mixes kinds of cells, those of the highest dimension are the mesh and a note counts the rest;
// solid cells other than tetrahedra are an error, since a solid without them has holes. Polygons are
// triangulated and a note counts them; triangles stay as they are, degenerate ones too. Property groups of
// PLY become vectors: x y z -> positions; nx ny nz -> `normal`; red green blue (bytes are scaled to [0, 1],
// as is alpha) -> `color`; NAME_x NAME_y NAME_z -> `NAME`. A field with values that are not finite is left
// out with a note.
#pragma once

#include <filesystem>

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

/// Throws InputError with the file, the place (line, or element and byte) and the reason for a file that is
/// missing, empty, truncated, not of the kind its ending says, or of an unknown kind; for coordinates that
/// are not finite and vertex numbers out of range.
Mesh read_mesh(const std::filesystem::path& path);

}  // namespace beltrami
