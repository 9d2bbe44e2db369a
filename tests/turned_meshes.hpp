// Surfaces whose triangles do not all run alike.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>

#include "beltrami/framework/mesh.hpp"

namespace beltrami::testing {

/// Every third triangle turned over.
inline Mesh partly_turned(const Mesh& mesh) {
    Cells cells = mesh.cells();
    for (Index c = 1; c < mesh.cell_count(); c += 3)
        std::swap(cells(c, 0), cells(c, 1));
    return {mesh.points(), cells};
}

/// n squares around, two across, with half a twist.
inline Mesh moebius_strip(int n) {
    Points points(3 * n, 3);
    Cells cells(4 * n, 3);
    for (int i = 0; i < n; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / n;
        for (int j = 0; j < 3; ++j) {
            const double radius = 1.0 + 0.3 * (j - 1) * std::cos(0.5 * angle);
            points.row(3 * i + j) << radius * std::cos(angle), radius * std::sin(angle),
                0.3 * (j - 1) * std::sin(0.5 * angle);
        }
        for (int j = 0; j < 2; ++j) {
            // After the last square the strip is upside down.
            const bool last = i + 1 == n;
            const auto next = [&](int k) { return last ? 2 - k : 3 * (i + 1) + k; };
            cells.row(4 * i + 2 * j) << 3 * i + j, next(j), next(j + 1);
            cells.row(4 * i + 2 * j + 1) << 3 * i + j, next(j + 1), 3 * i + j + 1;
        }
    }
    return {points, cells};
}

}  // namespace beltrami::testing
