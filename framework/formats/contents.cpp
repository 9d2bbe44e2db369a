#include "beltrami/framework/formats/contents.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/formats/polygons.hpp"

namespace beltrami::formats {

namespace {

void check_positions(const Source& source, const Contents& contents) {
    const auto bad = std::find_if(contents.positions.begin(), contents.positions.end(),
                                  [](double x) { return !std::isfinite(x); });
    if (bad == contents.positions.end()) return;
    source.fail(describe({"vertex", (bad - contents.positions.begin()) / 3, contents.vertex_count()}),
                "a coordinate is not a finite number", "remove the vertex or mend its position in the file");
}

// Readers check where they know the line; this catches cells that come before their vertices.
void check_corners(const Source& source, std::string_view kind, std::span<const Index> corners,
                   std::int64_t vertex_count) {
    for (const Index v : corners) {
        if (v >= 0 && v < vertex_count) continue;
        source.fail("", fmt::format("a {} names vertex {} (counted from 0), but there are {} vertices", kind,
                                    v, vertex_count));
    }
}

Cells to_cells(const std::vector<Index>& corners, int per_cell) {
    return Eigen::Map<const Cells>(corners.data(), static_cast<Eigen::Index>(corners.size()) / per_cell,
                                   per_cell);
}

std::string free_name(const Fields& fields, const std::string& wanted) {
    const auto taken = [&](const std::string& name) {
        return std::any_of(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
    };
    std::string name = wanted;
    for (int i = 2; taken(name); ++i)
        name = fmt::format("{}_{}", wanted, i);
    return name;
}

Fields usable_fields(Contents& contents) {
    Fields usable;
    for (Field& field : contents.fields) {
        if (!field.values.allFinite()) {
            contents.notes.push_back(fmt::format(
                "field '{}' has values that are not finite numbers and was left out", field.name));
            continue;
        }
        std::string name = free_name(usable, field.name.empty() ? "unnamed" : field.name);
        if (name != field.name) {
            contents.notes.push_back(fmt::format("a field '{}' is named '{}' here", field.name, name));
        }
        usable.push_back({std::move(name), std::move(field.values)});
    }
    return usable;
}

Mesh with_highest_cells(Contents& contents, Points points, Fields fields) {
    const std::size_t segments = contents.segments.size() / 2;
    const auto left_out = [&](std::size_t polygons, std::string_view kept) {
        if (polygons > 0) {
            contents.notes.push_back(fmt::format("{} polygons beside the {} were left out", polygons, kept));
        }
        if (segments > 0) {
            contents.notes.push_back(fmt::format("{} segments beside the {} were left out", segments, kept));
        }
    };
    if (!contents.tetrahedra.empty()) {
        left_out(contents.polygons.count(), "tetrahedra");
        return {std::move(points), to_cells(contents.tetrahedra, 4), std::move(fields)};
    }
    Triangulation triangulation = triangulate(contents.polygons, contents.positions);
    contents.notes.insert(contents.notes.end(), triangulation.notes.begin(), triangulation.notes.end());
    if (triangulation.triangles.rows() > 0) {
        left_out(0, "triangles");
        return {std::move(points), std::move(triangulation.triangles), std::move(fields)};
    }
    if (segments > 0) return {std::move(points), to_cells(contents.segments, 2), std::move(fields)};
    return Mesh(std::move(points), std::move(fields));
}

}  // namespace

void Polygons::add(std::span<const Index> corners) {
    corners_.insert(corners_.end(), corners.begin(), corners.end());
    close();
}

void Polygons::reserve(std::size_t polygons) {
    ends_.reserve(ends_.size() + polygons);
    corners_.reserve(corners_.size() + 3 * polygons);
}

void add_strip(Polygons& polygons, std::span<const Index> strip) {
    for (std::size_t i = 0; i + 2 < strip.size(); ++i) {
        std::array<Index, 3> triangle{strip[i], strip[i + 1], strip[i + 2]};
        if (i % 2 == 1) std::swap(triangle[0], triangle[1]);
        const bool steers =
            triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
        if (!steers) polygons.add(triangle);
    }
}

void add_polyline(std::vector<Index>& segments, std::span<const Index> vertices) {
    for (std::size_t i = 0; i + 1 < vertices.size(); ++i) {
        segments.insert(segments.end(), {vertices[i], vertices[i + 1]});
    }
}

void add_field(Contents& contents, std::string name, std::size_t columns, std::span<const double> values) {
    const auto rows = static_cast<Eigen::Index>(values.size() / columns);
    contents.fields.push_back(
        {std::move(name), Eigen::Map<const Block>(values.data(), rows, static_cast<Eigen::Index>(columns))});
}

void scale_byte_colors(std::span<double> values) {
    for (double& value : values)
        value /= 255.0;
}

Mesh to_mesh(const Source& source, Contents contents) {
    const std::int64_t count = contents.vertex_count();
    if (count == 0)
        source.fail("", "the file has no vertices", "check that it is a mesh and was exported whole");
    check_positions(source, contents);
    check_corners(source, "polygon", contents.polygons.corners(), count);
    check_corners(source, "segment", contents.segments, count);
    check_corners(source, "tetrahedron", contents.tetrahedra, count);

    Fields fields = usable_fields(contents);
    Points points = Eigen::Map<const Points>(contents.positions.data(), count, 3);
    const Mesh mesh = with_highest_cells(contents, std::move(points), std::move(fields));
    return mesh.with_notes(std::move(contents.notes));
}

}  // namespace beltrami::formats
