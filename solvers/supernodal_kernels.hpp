// The inner loops of SupernodalLdlt, compiled for several instruction sets and chosen when the program runs.
//
// Of a matrix P A P^T = L D L^T a *front* is the dense part that belongs to some successive columns (a supernode): those
// columns and the rows below in which they have entries. Fronts are upper triangles by rows, so that all loops run along
// rows: the rows of the own columns hold D L^T once they are eliminated, those behind them the update for the parent.
//
// The factor is kept in *panels* of at most `panel_columns` columns. A panel's numbers, in the order in which sweeps
// read them: the unit lower triangle in blocks of four rows, [column][row], block b with 4 b + 4 columns and 1 / D on the
// diagonal; then the rows below in blocks of four, [column][row], the last one filled up with zeros.
#pragma once

#include <cstddef>
#include <span>

#include "beltrami/framework/types.hpp"

namespace beltrami::supernodal {

/// Columns that are eliminated together. A multiple of 8.
inline constexpr int panel_columns = 64;
/// Columns of a front that are worked on at a time. A multiple of 8.
inline constexpr int chunk_columns = 32;

inline constexpr int round_up(int i, int to) {
    return (i + to - 1) / to * to;
}

/// Numbers of the triangle of a panel.
inline constexpr std::ptrdiff_t triangle_size(int columns) {
    const std::ptrdiff_t blocks = (columns + 3) / 4;
    return 8 * blocks * (blocks + 1);
}
/// Numbers of a panel with so many rows below.
inline constexpr std::ptrdiff_t panel_size(int columns, int below) {
    return triangle_size(columns) + static_cast<std::ptrdiff_t>(columns) * round_up(below, 4);
}

struct Panel {
    std::size_t values;  ///< where its numbers begin
    std::size_t rows;    ///< where the list of the rows below begins, filled up to a multiple of four
    Index first;         ///< row of its first column
    Index columns;
    Index below;  ///< rows below
};

/// The upper triangle of rows x rows numbers. Row i begins at column 8 (i / 8) or earlier, and can be written to the next
/// multiple of 8 after its end.
struct Front {
    double* panel = nullptr;   ///< the first `columns` rows, in full, `stride` apart
    double* update = nullptr;  ///< the others: see row()
    std::ptrdiff_t stride = 0;
    int columns = 0;
    int rows = 0;

    /// An odd number of cache lines: rows do not compete for the same places in a cache.
    static constexpr std::ptrdiff_t stride_of(int rows) { return 8 * (((rows + 3 + 7) / 8) | 1); }

    /// The update is kept in groups of eight rows, each group beginning eight columns before its diagonal, as a tile that
    /// begins in the group before may reach into it.
    [[nodiscard]] static constexpr std::ptrdiff_t update_size(int columns, int rows) {
        if (columns == rows) return 0;
        const std::ptrdiff_t groups = round_up(rows, 8) / 8 - columns / 8;
        return 8 * (groups * group_length(columns, rows) - 4 * groups * (groups - 1));
    }
    /// Where entry (i, j) lies in the update: i >= columns, j from 8 (i / 8) - 8.
    [[nodiscard]] std::ptrdiff_t update_at(int i, int j) const {
        const std::ptrdiff_t group = i / 8 - columns / 8;
        const std::ptrdiff_t length = group_length(columns, rows);
        return 8 * (group * length - 4 * group * (group - 1)) + (i % 8) * (length - 8 * group) +
               (j - (8 * (i / 8) - 8));
    }
    [[nodiscard]] double* at(int i, int j) const {
        return i < columns ? panel + i * stride + j : update + update_at(i, j);
    }

  private:
    [[nodiscard]] static constexpr std::ptrdiff_t group_length(int columns, int rows) {
        return round_up(rows, 8) - 8 * (columns / 8) + 8;
    }
};

struct Kernels {
    const char* name;

    /// x <- L^-1 x and x <- L^-T D^-1 x of panels in ascending and in descending order. Row r of x is the `width` numbers
    /// from r * stride on; width: 4 or a multiple of 8.
    void (*forward)(const Panel* panels, std::size_t count, const double* values, const Index* rows,
                    double* x, std::ptrdiff_t stride, int width);
    void (*backward)(const Panel* panels, std::size_t count, const double* values, const Index* rows,
                     double* x, std::ptrdiff_t stride, int width);

    /// Eliminates `columns` columns of a front from `first` on (a multiple of 8), in this order. L: the panel's numbers.
    /// The number of negative pivots, or -1 where one is zero or not finite. Columns from
    /// first + round_up(columns, 8) on are left to solve().
    int (*eliminate)(const Front& front, int first, int columns, double* L);
    /// D L^T at front columns begin ... end, multiples of 8.
    void (*solve)(const Front& front, int first, int columns, const double* L, int begin, int end);
    /// The panel's rows below, in blocks of four.
    void (*fill)(const Front& front, int first, int columns, double* L, int begin, int end);
    /// The rows behind the panel at front columns begin ... end, multiples of 8, less L D L^T; `fresh`: rows of the
    /// update are not read.
    void (*update)(const Front& front, int first, int columns, const double* L, int begin, int end,
                   bool fresh);
    /// Adds rows begin ... end of a child's update to its parent's front. place: where each row of the update lies there.
    void (*add)(const Front& child, const Index* place, const Front& parent, int begin, int end);
};

/// What this machine can run, the best first, and "any" last.
std::span<const Kernels* const> available_kernels();

}  // namespace beltrami::supernodal
