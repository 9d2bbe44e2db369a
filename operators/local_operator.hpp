// A PdeOperator on an active domain: its numbers copied beside each other, so that a product touches nothing else.
//
//     ActiveDomain domain(laplacian.graph(), A.order());
//     LocalOperator local(A);                          // a PdeOperator
//     SlotField u(3), y(3);
//     domain.activate(vertices);
//     domain.replay(together(local, u, y));            // the numbers of new vertices are fetched once
//     local.apply(domain, {.mass = 1.0, .stiffness = dt}, u, y, 0);       // y = (M + dt K~) u at the active vertices
//
// A field over slots that is zero outside the active vertices stands for one over the whole mesh. Products with it are
// exact: rows up to `rings` edges away are those of the product over the whole mesh (A_1 of Figure 4 of Kim & Rossignac is
// the ring that K D K needs).
#pragma once

#include <algorithm>
#include <tuple>
#include <type_traits>
#include <vector>

#include "beltrami/framework/active_domain.hpp"
#include "beltrami/operators/pde_operator.hpp"

namespace beltrami {

/// k numbers for each slot of a domain, zero in slot 0. Rows are as wide as vector instructions like: width() >= k
/// numbers apart, the rest zeros.
class SlotField {
  public:
    explicit SlotField(Index columns)
        : columns_(columns), width_(columns == 3 ? 4 : columns), values_(width_, 0.0) {}

    [[nodiscard]] Index columns() const { return columns_; }
    [[nodiscard]] Index width() const { return width_; }
    [[nodiscard]] Index slot_count() const { return static_cast<Index>(values_.size()) / width_; }
    [[nodiscard]] double* data() { return values_.data(); }
    [[nodiscard]] const double* data() const { return values_.data(); }
    [[nodiscard]] double* operator[](Index slot) { return data() + offset(slot); }
    [[nodiscard]] const double* operator[](Index slot) const { return data() + offset(slot); }
    void fill_zero(Index first_slot, Index end_slot) {
        std::fill(data() + offset(first_slot), data() + offset(end_slot), 0.0);
    }

    void resize(Index slots) {
        values_.resize(static_cast<std::size_t>(slots) * static_cast<std::size_t>(width_), 0.0);
    }

    // ActiveDomain::replay.
    void push(Index, Index, Index) { values_.resize(values_.size() + static_cast<std::size_t>(width_), 0.0); }
    void swap(Index a, Index b) { std::swap_ranges((*this)[a], (*this)[a] + width_, (*this)[b]); }
    void pop() { values_.resize(values_.size() - static_cast<std::size_t>(width_)); }

    [[nodiscard]] std::size_t memory_bytes() const { return values_.capacity() * sizeof(double); }

  private:
    [[nodiscard]] std::ptrdiff_t offset(Index slot) const {
        return static_cast<std::ptrdiff_t>(slot) * width_;
    }

    Index columns_;
    Index width_;
    std::vector<double> values_;
};

/// body(w) with w() the width of a row where it is a usual one, known to the compiler, and 0 for others.
template <class Body>
auto with_width(Index width, Body body) {
    switch (width) {
        case 1:
            return body(std::integral_constant<int, 1>());
        case 2:
            return body(std::integral_constant<int, 2>());
        case 4:
            return body(std::integral_constant<int, 4>());
        default:
            return body(std::integral_constant<int, 0>());
    }
}

/// One follower of ActiveDomain::replay made of several.
template <class... Followers>
auto together(Followers&... followers) {
    struct All {
        std::tuple<Followers&...> followers;
        void push(Index slot, Index vertex, Index row_begin) {
            std::apply([&](auto&... f) { (f.push(slot, vertex, row_begin), ...); }, followers);
        }
        void swap(Index a, Index b) {
            std::apply([&](auto&... f) { (f.swap(a, b), ...); }, followers);
        }
        void pop() {
            std::apply([&](auto&... f) { (f.pop(), ...); }, followers);
        }
    };
    return All{{followers...}};
}

/// K~ = foundation M + gamma_1 K + gamma_2 K D K + ... over the slots of a domain.
class LocalOperator {
  public:
    /// K~: a PdeOperator whose sigma is the foundation. Its numbers are read when vertices enter the domain.
    explicit LocalOperator(PdeOperator stiffness);

    /// `mass` M + `stiffness` K~.
    struct Weights {
        double mass = 0.0;
        double stiffness = 1.0;
    };

    /// y = (mass M + stiffness K~) u for slots of levels <= to_level; the others of y are not defined. u is zero above
    /// level 0. The domain has order() rings at least, and everything has followed it. y is not u.
    void apply(const ActiveDomain& domain, Weights weights, const SlotField& u, SlotField& y, int to_level);

    /// mass M + stiffness K~ over the active vertices, both triangles; row s - 1 is slot s.
    [[nodiscard]] Eigen::SparseMatrix<double> to_sparse(const ActiveDomain& domain, Weights weights) const;

    [[nodiscard]] const PdeOperator& op() const { return stiffness_; }
    /// The rings that a product to that level reaches: what the domain must have.
    [[nodiscard]] int order() const { return stiffness_.order(); }

    // Of each slot; slot 0 holds zeros.
    [[nodiscard]] const std::vector<double>& mass() const { return mass_; }
    [[nodiscard]] const std::vector<double>& inverse_mass() const { return inverse_mass_; }
    /// The diagonal of K~.
    [[nodiscard]] const std::vector<double>& diagonal() const { return diagonal_; }

    // ActiveDomain::replay.
    void push(Index slot, Index vertex, Index row_begin);
    void swap(Index a, Index b);
    void pop();

    /// Products with K so far, and the bytes of compact storage that they streamed through (numbers of the operator once,
    /// fields once for each pass over them).
    [[nodiscard]] long products() const { return products_; }
    [[nodiscard]] double bytes() const { return bytes_; }
    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    PdeOperator stiffness_;
    Vector full_diagonal_;
    std::vector<double> K_diagonal_;
    std::vector<double> diagonal_;
    std::vector<double> mass_;
    std::vector<double> inverse_mass_;
    std::vector<double> edges_;  // parallel to ActiveDomain::entries
    std::vector<SlotField> between_;
    long products_ = 0;
    double bytes_ = 0.0;
};

}  // namespace beltrami
