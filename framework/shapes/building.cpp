#include "beltrami/framework/shapes/building.hpp"

#include <fmt/format.h>

#include <cmath>

#include "beltrami/framework/error.hpp"

namespace beltrami::shapes {

void require_at_least(std::string_view what, std::int64_t value, std::int64_t least) {
    if (value < least) {
        throw InputError(fmt::format("the {} of a shape cannot be {}", what, value),
                         fmt::format("give {} or more", least));
    }
}

void require_positive(std::string_view what, double value) {
    if (!(value > 0.0 && std::isfinite(value))) {
        throw InputError(fmt::format("the {} of a shape cannot be {}", what, value),
                         "give a positive number");
    }
}

void require_size(double vertices) {
    constexpr double most = 50e6;
    if (!(vertices <= most)) {
        throw InputError(fmt::format("a shape of {:.3g} vertices is too large", vertices),
                         fmt::format("ask for at most {:.0f} million", most / 1e6));
    }
}

Index MeshBuilder::vertex(const Vector3& position) {
    coordinates_.insert(coordinates_.end(), position.data(), position.data() + 3);
    return static_cast<Index>(coordinates_.size() / 3) - 1;
}

void MeshBuilder::cell(std::initializer_list<Index> vertices) {
    cells_.insert(cells_.end(), vertices.begin(), vertices.end());
}

void MeshBuilder::square(Index a, Index b, Index c, Index d, bool other) {
    if (other) {
        cell({a, b, d});
        cell({b, c, d});
    } else {
        cell({a, b, c});
        cell({a, c, d});
    }
}

Mesh MeshBuilder::mesh() const {
    return {Points(Eigen::Map<const Points>(coordinates_.data(),
                                            static_cast<Eigen::Index>(coordinates_.size() / 3), 3)),
            Cells(Eigen::Map<const Cells>(cells_.data(), static_cast<Eigen::Index>(cells_.size()) / corners_,
                                          corners_))};
}

double Random::uniform() {
    const std::uint64_t high = engine_() >> 5U;
    const std::uint64_t low = engine_() >> 6U;
    return static_cast<double>((high << 26U) + low) * 0x1p-53;
}

Index Random::below(Index count) {
    return static_cast<Index>((static_cast<std::uint64_t>(engine_()) * static_cast<std::uint64_t>(count)) >>
                              32U);
}

Vector3 Random::in_unit(int dimensions) {
    while (true) {
        // One by one: the order in which a call's arguments are evaluated is not fixed.
        Vector3 p = Vector3::Zero();
        for (int k = 0; k < dimensions; ++k)
            p[k] = 2.0 * uniform() - 1.0;
        if (p.squaredNorm() <= 1.0) return p;
    }
}

Vector3 Random::direction() {
    while (true) {
        const Vector3 p = in_ball();
        // Near the centre the direction would have few bits.
        if (p.squaredNorm() > 1e-4) return p.normalized();
    }
}

}  // namespace beltrami::shapes
