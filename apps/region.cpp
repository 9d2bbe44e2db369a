#include "beltrami/apps/region.hpp"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "beltrami/framework/error.hpp"

namespace beltrami {

Constraints hold_outside(std::span<const Index> region, Index vertex_count) {
    if (region.empty()) throw InputError("the region has no vertices", "name at least one that may move");
    std::vector<char> inside(static_cast<std::size_t>(vertex_count), 0);
    for (const Index v : region) {
        if (v < 0 || v >= vertex_count) {
            throw InputError(
                fmt::format("the region names vertex {}, but the vertices are 0 to {}", v, vertex_count - 1),
                "vertex numbers are those of the file, from 0");
        }
        inside[static_cast<std::size_t>(v)] = 1;
    }
    constexpr std::array<double, 3> zero{};
    Constraints held(3);
    for (Index v = 0; v < vertex_count; ++v) {
        if (inside[static_cast<std::size_t>(v)] == 0) held.fix(v, zero);
    }
    return held;
}

Index isolated_inside(const Laplacian& laplacian, const Constraints& held) {
    Index count = 0;
    for (Index v = 0; v < laplacian.vertex_count(); ++v) {
        const bool isolated = laplacian.graph().degree(laplacian.order().working(v)) == 0;
        count += isolated && !held.is_fixed(v) ? 1 : 0;
    }
    return count;
}

}  // namespace beltrami
