// Runs of consecutive rows.
#pragma once

#include <cstddef>

#include "beltrami/framework/types.hpp"

namespace beltrami {

/// Rows first ... end - 1.
struct RowRange {
    Index first;
    Index end;
};

/// Part s of `count` even parts of n rows.
inline RowRange even_part(Index n, int s, int count) {
    const auto bound = [&](int i) { return static_cast<Index>(static_cast<std::ptrdiff_t>(n) * i / count); };
    return {bound(s), bound(s + 1)};
}

}  // namespace beltrami
