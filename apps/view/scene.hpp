// What is drawn of a mesh and of the fields on it, as messages of page/src/protocol.ts: for the viewer and for reports.
//
//     const Shown drawn = shown(mesh, 200000);
//     send(mesh_parcel(drawn, "bunny.obj", mesh, report(mesh)));
//     send(field_parcel({"u", u}, drawn, "scalar"));
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "beltrami/apps/picture/chart.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/framework/mesh_report.hpp"

namespace beltrami::view {

struct Shown {
    /// The vertices that are sent and the cells that are drawn (of tetrahedra the boundary, as triangles), without fields.
    Mesh mesh;
    /// Of each vertex its number in the file, ascending; empty where all of the file's vertices are sent.
    std::vector<Index> vertex_of;
    /// Of each of the file's vertices the one that stands for it, -1 for none; empty where vertex_of is.
    std::vector<Index> shown_at;
    std::string decimation;    ///< a sentence where not all is drawn, else empty
    Cells boundary{0, 2};      ///< edges of one triangle; of surfaces only
    Cells non_manifold{0, 2};  ///< edges of three triangles or more
    Cells lines{0, 2};         ///< segments that are drawn on a surface besides
};

/// With more than most_vertices vertices (at least 1): of tetrahedra only what the boundary uses, and where that is still too
/// many, clusters of them (framework/vertex_clustering.hpp). Edges of the boundary and non-manifold ones are those of the
/// mesh itself, not of what the clusters make of it.
Shown shown(const Mesh& mesh, Index most_vertices);

/// The same with its vertices elsewhere. points: of all of the mesh's vertices, n x 3.
Shown moved(Shown shown, const Points& points);

/// The same with lines drawn on it. points: of a mesh of segments; they come after the vertices, numbered on from vertex_count,
/// that of the file.
Shown with_lines(const Shown& shown, const Mesh& lines, Index vertex_count);

/// A row for each of the file's vertices -> a row for each that is sent.
Block at_shown(const Block& values, const Shown& shown);

/// What the mesh is called on the page: a file by its name without folders, a shape as it was written. argument: MESH.
std::string name_of_mesh(const std::string& argument);

/// The message `mesh`. `original` is what `report` is of; its fields are named, not sent.
std::string mesh_parcel(const Shown& shown, const std::string& name, const Mesh& original,
                        const MeshReport& report);
/// The message `field`; field.values: a row for each of the file's vertices. as: "scalar", "vectors" or "colors".
std::string field_parcel(const Field& field, const Shown& shown, const char* as);
/// Three columns are vectors, or colours where the field has the name of colours; all else is scalar.
const char* meaning_of(const Field& field);

/// A state of a time series in a report. `values`: a row after the other, for each vertex that is sent; `displaced`: they are
/// the vertices' displacement from where the message `mesh` has them (3 columns).
std::string moment_parcel(const std::string& name, double time, Index columns, std::span<const float> values,
                          bool displaced);

/// The report as JSON, keys as the fields of MeshReport.
nlohmann::json to_json(const MeshReport& report);

/// As ChartData. Numbers that are not finite are null, and so are those not above 0 on a logarithmic axis. A line has some thousands of points at most: of more, those are left
/// that are the least and the greatest of a part of their line.
nlohmann::json to_json(const Chart& chart);

}  // namespace beltrami::view
