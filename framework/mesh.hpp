// A mesh: positions, cells of one kind, and the named vertex fields that its file carried.
//
//     Mesh mesh = read_mesh("bunny.obj");
//     mesh.vertex_count();  mesh.points().row(7);  mesh.field("color").values;
//
// Any topology is a mesh: boundaries, non-manifold edges, several components, isolated vertices. Vertices keep
// the order of the file; what is fast inside (Renumbering) is undone at every output.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "beltrami/framework/types.hpp"

namespace beltrami {

/// The value is the number of vertices in a cell.
enum class CellKind { point = 1, segment = 2, triangle = 3, tetrahedron = 4 };

/// "points", "segments", "triangles", "tetrahedra".
std::string_view plural(CellKind kind);

class Mesh {
  public:
    /// Points alone.
    explicit Mesh(Points points, Fields fields = {});

    /// cells: m x 2, 3 or 4. Throws InputError for a vertex number out of range, a coordinate that is not finite,
    /// a field whose length is not the number of vertices or whose name comes twice.
    Mesh(Points points, Cells cells, Fields fields = {});

    [[nodiscard]] Index vertex_count() const { return static_cast<Index>(points_.rows()); }
    [[nodiscard]] Index cell_count() const { return static_cast<Index>(cells_.rows()); }
    [[nodiscard]] CellKind kind() const { return kind_; }
    [[nodiscard]] const Points& points() const { return points_; }
    [[nodiscard]] const Cells& cells() const { return cells_; }

    [[nodiscard]] const Fields& fields() const { return fields_; }
    /// nullptr where there is no field of that name.
    [[nodiscard]] const Field* find_field(std::string_view name) const;
    /// Throws InputError that lists the names there are.
    [[nodiscard]] const Field& field(std::string_view name) const;

    /// What a reader did to the file's content (polygons triangulated, vertices welded), a sentence each.
    [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
    [[nodiscard]] Mesh with_notes(std::vector<std::string> notes) const;

    /// The same cells and fields at other positions (n x 3).
    [[nodiscard]] Mesh with_points(Points points) const;

    /// Bytes held by positions, cells and fields.
    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    void validate() const;

    Points points_;
    Cells cells_;
    Fields fields_;
    CellKind kind_;
    std::vector<std::string> notes_;
};

}  // namespace beltrami
