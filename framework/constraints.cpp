#include "beltrami/framework/constraints.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "beltrami/framework/error.hpp"

namespace beltrami {

Constraints::Constraints(Index columns) : columns_(columns) {
    if (columns < 1) throw InputError(fmt::format("constraints of {} columns", columns), "give at least one");
}

Constraints::Constraints(std::initializer_list<std::pair<Index, double>> values) : columns_(1) {
    for (const auto& [v, value] : values)
        add(v, value);
}

void Constraints::fix(Index v, std::span<const double> value) {
    if (v < 0) throw InputError(fmt::format("there is no vertex {}", v), "vertices are numbered from 0");
    if (value.size() != static_cast<std::size_t>(columns_)) {
        throw InputError(fmt::format("vertex {} is held at {} numbers, but the field has {} columns", v,
                                     value.size(), columns_),
                         "give as many numbers as the field has columns");
    }
    if (!std::all_of(value.begin(), value.end(), [](double x) { return std::isfinite(x); })) {
        throw InputError(fmt::format("vertex {} is held at a value that is not a finite number", v),
                         "give finite numbers");
    }
    // `value` may be the value of another held vertex, which growing would move.
    const std::vector<double> kept(value.begin(), value.end());
    const auto [entry, is_new] = slot_of_vertex_.try_emplace(v, size());
    if (is_new) {
        vertices_.push_back(v);
        values_.insert(values_.end(), kept.begin(), kept.end());
    } else {
        std::copy(kept.begin(), kept.end(), values_.begin() + std::ptrdiff_t{entry->second} * columns_);
    }
}

void Constraints::add(Index v, std::span<const double> value) {
    if (is_fixed(v)) {
        const auto held = this->value(v);
        if (!std::equal(held.begin(), held.end(), value.begin(), value.end())) {
            throw InputError(fmt::format("vertex {} is held twice, at {} and at {}", v, fmt::join(held, ","),
                                         fmt::join(value, ",")),
                             "name each vertex once");
        }
        return;
    }
    fix(v, value);
}

void Constraints::free(Index v) {
    const auto found = slot_of_vertex_.find(v);
    if (found == slot_of_vertex_.end()) return;
    // The last slot takes the place of the freed one.
    const Index slot = found->second;
    if (slot + 1 < size()) {
        const Index last_vertex = vertices_.back();
        std::copy(values_.end() - columns_, values_.end(), values_.begin() + std::ptrdiff_t{slot} * columns_);
        vertices_[static_cast<std::size_t>(slot)] = last_vertex;
        slot_of_vertex_[last_vertex] = slot;
    }
    slot_of_vertex_.erase(found);
    vertices_.pop_back();
    values_.resize(values_.size() - static_cast<std::size_t>(columns_));
}

std::span<const double> Constraints::value(Index v) const {
    if (!is_fixed(v))
        throw InputError(fmt::format("vertex {} is not held at any value", v), "ask is_fixed() first");
    const Index slot = slot_of_vertex_.at(v);
    return {values_.data() + std::ptrdiff_t{slot} * columns_, static_cast<std::size_t>(columns_)};
}

void Constraints::check_range(Index vertex_count) const {
    for (const Index v : vertices_) {
        if (v >= vertex_count) {
            throw InputError(
                fmt::format("there is no vertex {}: the vertices are 0 to {}", v, vertex_count - 1),
                "vertex numbers are those of the file, from 0");
        }
    }
}

void Constraints::impose(Block& field) const {
    if (empty()) return;
    check_range(static_cast<Index>(field.rows()));
    if (field.cols() != columns_) {
        throw InputError(fmt::format("vertices are held at {} numbers, but the field has {} columns",
                                     columns_, field.cols()),
                         "make both of the same width");
    }
    for (const Index v : vertices_) {
        field.row(v) = Eigen::Map<const Eigen::RowVectorXd>(value(v).data(), columns_);
    }
}

}  // namespace beltrami
