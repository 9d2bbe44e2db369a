#include "beltrami/solvers/sweep_order.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace beltrami {

namespace {

// Shorter stretches are not worth a thread, and separators must stay few: they are swept later.
constexpr Index shortest_stretch = 8000;
constexpr int most_stretches = 16;
constexpr double most_separating = 0.2;

struct Stretches {
    std::vector<RowRange> inner;
    std::vector<RowRange> separators;
};

std::optional<Stretches> divided(const std::vector<Index>& reach, int rings, int count) {
    const auto n = static_cast<Index>(reach.size());
    Stretches result;
    Index separating = 0;
    for (int s = 0; s < count; ++s) {
        const auto [first, end] = even_part(n, s, count);
        Index inner = first;
        for (int ring = 0; ring < rings && inner > 0; ++ring)
            inner = std::max(inner, reach[static_cast<std::size_t>(inner) - 1]);
        // Otherwise separators touch.
        if (inner > end) return std::nullopt;
        result.separators.push_back({first, inner});
        result.inner.push_back({inner, end});
        separating += inner - first;
    }
    if (separating > most_separating * n) return std::nullopt;
    return result;
}

}  // namespace

SweepOrder::SweepOrder(const std::vector<Index>& reach, int rings) {
    const auto n = static_cast<Index>(reach.size());
    for (int count = std::clamp(static_cast<int>(n / shortest_stretch), 1, most_stretches); count > 1;
         --count) {
        if (auto found = divided(reach, rings, count)) {
            inner_rows_ = std::move(found->inner);
            separators_ = std::move(found->separators);
            return;
        }
    }
    inner_rows_ = {{0, n}};
    separators_ = {{0, 0}};
}

}  // namespace beltrami
