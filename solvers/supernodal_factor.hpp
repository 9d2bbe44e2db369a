// What SupernodalLdlt and Cholesky are made of: the analysis of a symmetric pattern, and a factor L D L^T on it.
//
//     const auto symbolic = std::make_shared<const Symbolic>(pattern, quick);
//     Factor factor(symbolic, kernels);
//     factor.factor({A, nullptr, 0.0});                // entries in the order of the symbolic factor: see entry()
//     factor.solve({b, x, stride, 1, columns});
//
// METIS's or AMD's ordering and CHOLMOD's relaxed supernodes, a multifrontal factorization and blocked sweeps: see
// SupernodalLdlt for the references. Threads of OpenMP share subtrees of the elimination tree and the large fronts above
// them. Results do not depend on the number of threads.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "beltrami/solvers/large_array.hpp"
#include "beltrami/solvers/supernodal_kernels.hpp"

namespace beltrami::supernodal {

/// The upper triangle of a symmetric n x n pattern by columns: rows[starts[c]] ... are ascending and at most c.
struct UpperPattern {
    std::vector<std::size_t> starts{0};  // n + 1
    std::vector<Index> rows;
    [[nodiscard]] Index size() const { return static_cast<Index>(starts.size()) - 1; }
};

struct Node {
    Index first = 0;  // column
    Index columns = 0;
    Index rows = 0;
    Index parent = -1;
    Index child = -1;        // the first
    Index sibling = -1;      // the next
    std::size_t place = 0;   // of its rows below, in `places`
    std::size_t list = 0;    // of all its rows, in `lists`
    std::size_t panels = 0;  // the first
    bool stacked = false;    // its update lies on a stack
    Index depth = 0;
    [[nodiscard]] Index below() const { return rows - columns; }
    [[nodiscard]] std::size_t update_size() const {
        return static_cast<std::size_t>(Front::update_size(columns, rows));
    }
};
// Successive nodes of a group and the unknowns that are their columns. A whole one is made of subtrees.
struct Piece {
    std::size_t begin = 0;  // of the nodes
    std::size_t end = 0;
    std::size_t first_panel = 0;
    std::size_t last_panel = 0;
    std::size_t first_move = 0;
    std::size_t last_move = 0;
    bool whole = false;
};
struct Move {
    Index unknown;
    Index row;  // in the group's array
};
struct Group {
    std::size_t begin = 0;  // of the nodes
    std::size_t end = 0;
    std::size_t first_piece = 0;
    std::size_t last_piece = 0;
    std::size_t base = 0;                // of its array in that of all groups
    Index columns = 0;                   // rows of its array before those of the top
    std::vector<Index> touched;          // columns of the top, counted from there
    std::array<std::size_t, 2> stack{};  // numbers of updates at once, by parity of the depth
    std::size_t panel = 0;               // numbers of the largest front's own rows
};
struct Supernodes;

// Fronts are in the order of elimination: group by group, whole subtrees, and last the top, which joins them. Each group
// sweeps in an array of rows of its own: room for one piece, which is a few small subtrees; the columns of the group
// that are in no piece; those of the top that it touches; a row of zeros, which fills up blocks. The values of a piece
// come from the caller's columns when its turn comes and go back there, so that they stay in a core's cache meanwhile.
struct Symbolic {
    /// quick: AMD's ordering rather than METIS's. Throws std::bad_alloc.
    Symbolic(const UpperPattern& pattern, bool quick);

    Index n = 0;
    std::vector<Node> nodes;
    std::vector<Group> groups;  // the last is the top
    std::vector<Panel> panels;
    std::vector<Index> lists;   // rows in the group's array
    std::vector<Index> places;  // of a row below in the parent's front
    std::vector<Piece> pieces;
    std::vector<Move> moves;  // by unknown in each piece
    std::size_t array_rows = 0;
    std::size_t values_size = 0;

    // Entries at and below the diagonal by column of L.
    std::vector<std::size_t> starts;
    std::vector<Index> positions;  // in the front
    std::vector<Index> unknowns;   // row of the matrix; ascending in a column
    std::vector<Index> column;     // row of the matrix that is the column
    std::vector<Index> column_of;  // the inverse of `column`

    double nonzeros = 0.0;
    double flops = 0.0;
    std::size_t working = 0;  // bytes that a factorization takes and gives back

    static constexpr std::size_t none = ~std::size_t{0};
    [[nodiscard]] std::size_t entry_count() const { return unknowns.size(); }
    /// Which entry (row, col) or (col, row) of the matrix is; none outside the pattern.
    [[nodiscard]] std::size_t entry(Index row, Index col) const;
    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    void set_order(const Supernodes& supernodes, std::vector<std::vector<Index>>& rows);
    void set_groups(const std::vector<Index>& row_of, const std::vector<std::vector<Index>>& rows);
    std::vector<Index> set_pieces();
    void set_entries(const UpperPattern& pattern, const std::vector<std::vector<Index>>& rows);
};

/// K - shift M, or K alone where `mass` is null.
struct Entries {
    const double* stiffness;
    const double* mass;
    double shift;
    [[nodiscard]] double operator[](std::size_t e) const {
        return mass == nullptr ? stiffness[e] : stiffness[e] - shift * mass[e];
    }
};

/// Entry (i, c) of the right-hand sides lies at from[i row_stride + c column_stride], that of the solutions likewise at
/// `to`, which may be `from`.
struct RightHandSides {
    const double* from;
    double* to;
    std::ptrdiff_t row_stride;
    std::ptrdiff_t column_stride;
    Index count;
};

class Factor {
  public:
    /// Room for the factor. Throws std::bad_alloc.
    Factor(std::shared_ptr<const Symbolic> symbolic, const Kernels& kernels);

    [[nodiscard]] const Symbolic& symbolic() const { return *symbolic_; }
    [[nodiscard]] const std::shared_ptr<const Symbolic>& shared_symbolic() const { return symbolic_; }
    [[nodiscard]] const Kernels& kernels() const { return *kernels_; }

    /// L D L^T in place of an earlier factor. The number of negative pivots, or -1 where one is zero or not finite and there
    /// is no factor. Throws std::bad_alloc.
    int factor(const Entries& entries);
    /// One thread of callers at a time, as the room it works in stays here. Throws std::bad_alloc.
    void solve(const RightHandSides& b) const;

    /// Of the factor and the room for solves.
    [[nodiscard]] std::size_t memory_bytes() const { return values_.bytes() + work_.bytes(); }

  private:
    struct Room {
        LargeArray panel;
        std::array<LargeArray, 2> stacks;
        std::array<std::size_t, 2> used{};
    };
    int eliminate(const Node& node, const Front& front, bool share);
    int process(std::size_t f, const Entries& entries, Room& room, std::vector<double*>& updates,
                std::vector<LargeArray>& kept, bool share);
    void sweep(const RightHandSides& b) const;

    std::shared_ptr<const Symbolic> symbolic_;
    const Kernels* kernels_;
    LargeArray values_;
    mutable LargeArray work_;
};

}  // namespace beltrami::supernodal
