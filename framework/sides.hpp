// What cells share with their neighbours: the sides of triangles are edges, of tetrahedra faces, of segments ends.
//
//     const Sides sides(proper_cells(mesh), mesh.vertex_count());
//     const Cells rim = boundary(sides);
#pragma once

#include <span>
#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

/// Equal rows of a table, brought together in time proportional to the rows when no vertex has very many.
class EqualRows {
  public:
    /// rows: m x k of vertex numbers below vertex_count, k >= 1, ascending within each row.
    EqualRows(const Cells& rows, Index vertex_count);

    [[nodiscard]] Index group_count() const { return static_cast<Index>(offsets_.size()) - 1; }
    /// The row numbers of a group, ascending.
    [[nodiscard]] std::span<const Index> group(Index g) const {
        const auto begin = static_cast<std::size_t>(offsets_[static_cast<std::size_t>(g)]);
        const auto end = static_cast<std::size_t>(offsets_[static_cast<std::size_t>(g) + 1]);
        return {members_.data() + begin, end - begin};
    }

  private:
    std::vector<Index> offsets_;
    std::vector<Index> members_;
};

/// The cells that do not name a vertex twice: those that topology can speak of.
Cells proper_cells(const Mesh& mesh);

class Sides {
  public:
    /// cells: m x k with k = 2, 3 or 4, none of which names a vertex twice.
    Sides(const Cells& cells, Index vertex_count);

    [[nodiscard]] Index count() const { return groups_.group_count(); }

    /// A place is a cell and one of its corners in one number, k cell + corner; the side there is opposite to the
    /// corner. These are the places of a side, one for each of its cells, in ascending order.
    [[nodiscard]] std::span<const Index> places(Index side) const { return groups_.group(side); }
    [[nodiscard]] Index cell(Index place) const { return place / corners_; }
    [[nodiscard]] Index corner(Index place) const { return place % corners_; }

    /// The vertices of the sides that `wanted(number of cells)` names, as cells of one vertex less.
    template <class Wanted>
    [[nodiscard]] Cells vertices_where(Wanted wanted) const {
        std::vector<Index> first;
        for (Index s = 0; s < count(); ++s) {
            if (wanted(places(s).size())) first.push_back(places(s).front());
        }
        Cells chosen(static_cast<Eigen::Index>(first.size()), vertices_.cols());
        for (Eigen::Index i = 0; i < chosen.rows(); ++i) {
            chosen.row(i) = vertices_.row(first[static_cast<std::size_t>(i)]);
        }
        return chosen;
    }

  private:
    Index corners_;
    Cells vertices_;  // of the side at each place, ascending
    EqualRows groups_;
};

/// The sides of exactly one cell.
inline Cells boundary(const Sides& sides) {
    return sides.vertices_where([](std::size_t cells) { return cells == 1; });
}

}  // namespace beltrami
