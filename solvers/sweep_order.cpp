#include "beltrami/solvers/sweep_order.hpp"

#include <optional>

namespace beltrami {

namespace {

// Shorter stretches are not worth a thread, and separators must stay few: they are swept later.
constexpr Index shortest_stretch = 8000;
constexpr int most_stretches = 16;
constexpr double most_separating = 0.2;

struct Stretches {
    std::vector<Index> first;
    std::vector<Index> inner;
};

std::optional<Stretches> divided(const std::vector<Index>& reach, int rings, int count) {
    const auto n = static_cast<Index>(reach.size());
    Stretches result;
    Index separating = 0;
    for (int s = 0; s < count; ++s) {
        const auto first = static_cast<Index>(static_cast<std::ptrdiff_t>(n) * s / count);
        if (!result.inner.empty() && first < result.inner.back()) return std::nullopt;
        Index inner = first;
        for (int ring = 0; ring < rings && inner > 0; ++ring)
            inner = std::max(inner, reach[static_cast<std::size_t>(inner) - 1]);
        result.first.push_back(first);
        result.inner.push_back(inner);
        separating += inner - first;
    }
    if (result.inner.back() > n || separating > most_separating * n) return std::nullopt;
    result.first.push_back(n);
    return result;
}

}  // namespace

SweepOrder::SweepOrder(const std::vector<Index>& reach, int rings) {
    const auto n = static_cast<Index>(reach.size());
    int count = std::clamp(static_cast<int>(n / shortest_stretch), 1, most_stretches);
    for (; count > 1; --count) {
        if (auto found = divided(reach, rings, count)) {
            first_ = std::move(found->first);
            inner_ = std::move(found->inner);
            return;
        }
    }
    first_ = {0, n};
    inner_ = {0};
}

}  // namespace beltrami
