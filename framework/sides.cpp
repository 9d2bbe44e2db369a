#include "beltrami/framework/sides.hpp"

#include <algorithm>
#include <compare>

#include "beltrami/framework/cell_geometry.hpp"

namespace beltrami {

namespace {

std::size_t at(Index i) {
    return static_cast<std::size_t>(i);
}

/// Row k cell + corner holds the other corners of the cell, ascending.
Cells opposite_sides(const Cells& cells) {
    const Eigen::Index corners = cells.cols();
    Cells sides(cells.rows() * corners, corners - 1);
    for (Eigen::Index c = 0; c < cells.rows(); ++c) {
        for (Eigen::Index corner = 0; corner < corners; ++corner) {
            auto side = sides.row(c * corners + corner);
            for (Eigen::Index k = 0; k + 1 < corners; ++k)
                side[k] = cells(c, k < corner ? k : k + 1);
            std::sort(side.begin(), side.end());
        }
    }
    return sides;
}

}  // namespace

EqualRows::EqualRows(const Cells& rows, Index vertex_count) {
    // Buckets by first vertex are short, so sorting each is cheap.
    std::vector<Index> begin(at(vertex_count) + 1, 0);
    for (Eigen::Index r = 0; r < rows.rows(); ++r)
        ++begin[at(rows(r, 0)) + 1];
    for (std::size_t v = 0; v < at(vertex_count); ++v)
        begin[v + 1] += begin[v];
    members_.resize(static_cast<std::size_t>(rows.rows()));
    std::vector<Index> next(begin.begin(), begin.end() - 1);
    for (Eigen::Index r = 0; r < rows.rows(); ++r) {
        members_[at(next[at(rows(r, 0))]++)] = static_cast<Index>(r);
    }
    const auto key = [&](Index r) { return rows.data() + r * rows.cols(); };
    const auto less = [&](Index a, Index b) {
        const auto order = std::lexicographical_compare_three_way(key(a), key(a) + rows.cols(), key(b),
                                                                  key(b) + rows.cols());
        return std::is_lt(order) || (std::is_eq(order) && a < b);
    };
    for (std::size_t v = 0; v < at(vertex_count); ++v) {
        const auto first = members_.begin() + begin[v];
        const auto last = members_.begin() + begin[v + 1];
        std::sort(first, last, less);
        for (auto m = first; m != last; ++m) {
            if (m == first || !std::equal(key(*m), key(*m) + rows.cols(), key(m[-1]))) {
                offsets_.push_back(static_cast<Index>(m - members_.begin()));
            }
        }
    }
    offsets_.push_back(static_cast<Index>(members_.size()));
}

Cells proper_cells(const Mesh& mesh) {
    std::vector<Index> proper;
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (!names_a_vertex_twice(mesh, c)) proper.push_back(c);
    }
    if (at(mesh.cell_count()) == proper.size()) return mesh.cells();
    return mesh.cells()(proper, Eigen::all);
}

Sides::Sides(const Cells& cells, Index vertex_count)
    : corners_(static_cast<Index>(cells.cols())),
      vertices_(opposite_sides(cells)),
      groups_(vertices_, vertex_count) {}

}  // namespace beltrami
