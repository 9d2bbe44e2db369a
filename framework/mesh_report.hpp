// What is in a mesh: counts, topology, and everything about it that can trouble a solver.
//
//     fmt::print("{}", full_report(report(mesh)));
//
// A cell that names a vertex twice counts as a cell and as degenerate; everything else is said of the cells
// without it.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

struct MeshReport {
    CellKind kind = CellKind::point;
    Index vertices = 0;  ///< all in the file, isolated ones too
    Index edges = 0;     ///< different undirected edges of the cells
    Index faces = 0;     ///< triangles; for tetrahedra their different faces; 0 for segments and points
    Index cells = 0;
    Index components = 0;         ///< of the cells, by shared vertices
    Index isolated_vertices = 0;  ///< in no cell (0 for a mesh of points alone)

    Index boundary_edges = 0;     ///< triangles: edges of one face. Tetrahedra: edges of boundary faces
    Index boundary_loops = 0;     ///< triangles: connected pieces of the boundary
    Index boundary_faces = 0;     ///< tetrahedra: faces of one cell
    Index boundary_vertices = 0;  ///< vertices of boundary edges or faces; segments: ends
    Index non_manifold_edges =
        0;  ///< triangles: three faces or more. Tetrahedra: faces of three cells or more
    Index non_manifold_vertices = 0;  ///< off those edges (faces), with several fans of cells, not joined by
                                      ///< edges (faces). Segments: ends of three or more
    Index turned_edges = 0;           ///< two-face edges that both faces run through in the same direction
    Index duplicate_cells = 0;        ///< with the vertex set of an earlier cell
    Index repeated_positions = 0;     ///< vertices at exactly the place of an earlier one
    Index degenerate_cells = 0;       ///< is_degenerate()
    Index sliver_cells =
        0;  ///< triangles with an angle, tetrahedra with a dihedral angle < 1 or > 178 degrees
    Index inverted_cells = 0;  ///< tetrahedra of negative volume
    Index non_delaunay_edges =
        0;  ///< two-face edges with opposite angles of more than 180.0001 degrees together
            ///< (rounding in files puts split rectangles near 180); no degenerate face

    bool manifold = false;           ///< no non-manifold edges or vertices
    bool orientable = false;         ///< triangles: they can be turned so that no edge is turned
    Index euler_characteristic = 0;  ///< used vertices - edges + faces (- tetrahedra)
    std::optional<Index> genus;  ///< summed over the components, where manifold and orientable (triangles)

    double smallest_angle =
        0.0;  ///< degrees; corner angles, dihedral for tetrahedra; over non-degenerate cells
    double largest_angle = 0.0;                                       ///< degrees
    double shortest_edge = 0.0, mean_edge = 0.0, longest_edge = 0.0;  ///< in the file's unit
    double measure = 0.0;                          ///< total length, area or (unsigned) volume
    std::array<double, 3> lower = {}, upper = {};  ///< corners of the bounding box
    std::vector<std::string> field_names;
    std::vector<std::string> notes;  ///< what the reader did
    std::size_t memory_bytes = 0;    ///< of the mesh in memory
};

/// Every count of it, in time a little more than proportional to the mesh: about two seconds for a million
/// vertices.
MeshReport report(const Mesh& mesh);

/// One line: "34835 vertices, 69666 triangles, 1 component, closed, genus 0".
std::string brief_report(const MeshReport& report);

/// A line for each fact; troubles (non-manifold edges, slivers, ...) only where there are any.
std::string full_report(const MeshReport& report);

}  // namespace beltrami
