// Which vertices are held, and at what: a mask over the vertices that can change at any time.
//
//     Constraints fixed{{120, 0.0}, {8999, 1.0}};     // one column
//     fixed.fix(42, 0.5);                             // O(1): sets or moves; operators know nothing of it
//     fixed.free(120);                                // O(1)
//
// Nothing is rebuilt when constraints change: solvers read the mask when they solve.
#pragma once

#include <initializer_list>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "beltrami/framework/types.hpp"

namespace beltrami {

class Constraints {
  public:
    /// None yet; every value will have `columns` numbers.
    explicit Constraints(Index columns = 1);

    /// One column. Throws InputError for a vertex named twice with different values.
    Constraints(std::initializer_list<std::pair<Index, double>> values);

    /// Holds v at a value, whether it was held before or not. Throws InputError for a negative vertex, a value that is
    /// not finite and a wrong number of columns.
    void fix(Index v, std::span<const double> value);
    void fix(Index v, double value) { fix(v, std::span(&value, 1)); }

    /// As fix(), but throws InputError where v is already held at another value.
    void add(Index v, std::span<const double> value);
    void add(Index v, double value) { add(v, std::span(&value, 1)); }

    /// Lets v go; nothing happens where it was free.
    void free(Index v);

    [[nodiscard]] bool is_fixed(Index v) const { return slot_of_vertex_.contains(v); }
    /// The columns() numbers of a held vertex; valid until constraints change. Throws InputError for a free
    /// one.
    [[nodiscard]] std::span<const double> value(Index v) const;

    /// The held vertices, in no particular order.
    [[nodiscard]] const std::vector<Index>& vertices() const { return vertices_; }
    [[nodiscard]] Index size() const { return static_cast<Index>(vertices_.size()); }
    [[nodiscard]] bool empty() const { return vertices_.empty(); }
    [[nodiscard]] Index columns() const { return columns_; }

    /// Throws InputError that names the first held vertex >= vertex_count.
    void check_range(Index vertex_count) const;

    /// Writes the held values into the rows of a field (n x columns). Throws InputError for another number of
    /// columns and for held vertices that are not rows of the field.
    void impose(Block& field) const;

  private:
    Index columns_;
    std::unordered_map<Index, Index> slot_of_vertex_;
    std::vector<Index> vertices_;  // of slot
    std::vector<double> values_;   // of slot, columns_ each
};

}  // namespace beltrami
