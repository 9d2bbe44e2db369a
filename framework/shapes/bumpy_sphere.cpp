#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "beltrami/framework/shapes.hpp"
#include "beltrami/framework/shapes/building.hpp"
#include "beltrami/framework/shapes/sphere_triangulation.hpp"

namespace beltrami::shapes {

namespace {

/// A smooth hill on the unit sphere: polynomial, since exp and sin differ between machines in the last digit.
struct Bump {
    Vector3 centre;
    double width;
    double height;

    [[nodiscard]] double at(const Vector3& p) const {
        const double rest = std::max(0.0, 1.0 - (p - centre).squaredNorm() / (width * width));
        return height * rest * rest * rest;
    }
};

std::vector<Bump> random_bumps(Random& random, int count, double narrowest, double widest, double lowest,
                               double highest) {
    std::vector<Bump> bumps;
    for (int k = 0; k < count; ++k) {
        const Vector3 centre = random.direction();
        const double width = narrowest + (widest - narrowest) * random.uniform();
        const double height = lowest + (highest - lowest) * random.uniform();
        bumps.push_back({centre, width, height});
    }
    return bumps;
}

double sum_at(const std::vector<Bump>& bumps, const Vector3& p) {
    double sum = 0.0;
    for (const Bump& bump : bumps)
        sum += bump.at(p);
    return sum;
}

}  // namespace

Mesh bumpy_sphere(Index vertices, std::uint32_t seed) {
    require_at_least("vertices", vertices, 100);
    require_size(vertices);
    Random random(seed);
    const auto dense = random_bumps(random, 6, 0.4, 0.9, 0.5, 1.0);
    const auto hills = random_bumps(random, 24, 0.3, 0.9, -0.2, 0.2);
    const double spacing = std::sqrt(4.0 * std::numbers::pi / vertices);

    Points points(vertices, 3);
    points.row(0) << 0.0, 0.0, 1.0;
    for (Index v = 1; v < vertices;) {
        if (v % 500 == 0) {
            // So close to the last one that the triangles at both are slivers.
            const Vector3 last = points.row(v - 1).transpose();
            points.row(v++) = (last + 0.01 * spacing * random.direction()).normalized().transpose();
            continue;
        }
        const Vector3 p = random.direction();
        if (random.uniform() < 0.1 + sum_at(dense, p)) points.row(v++) = p.transpose();
    }
    sort_along_curve(points);
    Cells cells = triangulate_sphere(points);
    for (auto p : points.rowwise())
        p *= 1.0 + sum_at(hills, p.transpose());
    return {std::move(points), std::move(cells)};
}

}  // namespace beltrami::shapes
