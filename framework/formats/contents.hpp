// What a file holds, before it is a Mesh: every reader fills one of these.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "beltrami/framework/formats/source.hpp"
#include "beltrami/framework/mesh.hpp"

namespace beltrami::formats {

/// Corner lists of any length, one after the other.
class Polygons {
  public:
    [[nodiscard]] std::size_t count() const { return ends_.size(); }
    [[nodiscard]] std::span<const Index> operator[](std::size_t p) const {
        const std::size_t start = p == 0 ? 0 : ends_[p - 1];
        return {corners_.data() + start, ends_[p] - start};
    }
    /// Corners are added one by one, then the polygon is closed.
    void add_corner(Index vertex) { corners_.push_back(vertex); }
    void close() { ends_.push_back(corners_.size()); }
    void add(std::span<const Index> corners);
    void reserve(std::size_t polygons);
    [[nodiscard]] const std::vector<Index>& corners() const { return corners_; }

  private:
    std::vector<Index> corners_;
    std::vector<std::size_t> ends_;
};

struct Contents {
    std::vector<double> positions;  ///< x y z of each vertex
    Polygons polygons;
    std::vector<Index> segments;    ///< 2 a segment
    std::vector<Index> tetrahedra;  ///< 4 a tetrahedron
    Fields fields;
    std::vector<std::string> notes;

    [[nodiscard]] std::int64_t vertex_count() const {
        return static_cast<std::int64_t>(positions.size() / 3);
    }
};

/// A triangle strip: every other triangle is turned, and those that name a vertex twice only steer the strip.
void add_strip(Polygons& polygons, std::span<const Index> strip);

/// The segments from each vertex to the next.
void add_polyline(std::vector<Index>& segments, std::span<const Index> vertices);

/// values: row by row, `columns` a vertex.
void add_field(Contents& contents, std::string name, std::size_t columns, std::span<const double> values);

/// Colours in 0..255 to 0..1, in place.
void scale_byte_colors(std::span<double> values);

/// Checks coordinates and vertex numbers, triangulates, chooses the cells of the highest dimension, and
/// renames or drops fields that a Mesh does not take.
Mesh to_mesh(const Source& source, Contents contents);

}  // namespace beltrami::formats
