#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/framework/shapes/building.hpp"

namespace beltrami::shapes {

using std::numbers::pi;

Mesh grid(int nx, int ny, double width, double height, bool alternate) {
    require_at_least("squares along x", nx, 1);
    require_at_least("squares along y", ny, 1);
    require_positive("width", width);
    require_positive("height", height);
    require_size((nx + 1.0) * (ny + 1.0));
    MeshBuilder builder;
    for (int j = 0; j <= ny; ++j) {
        for (int i = 0; i <= nx; ++i)
            builder.vertex({width * i / nx, height * j / ny, 0.0});
    }
    builder.sheet(
        nx, ny, [&](int i, int j) { return j * (nx + 1) + i; }, alternate);
    return builder.mesh();
}

Mesh disk(int rings, double radius) {
    require_at_least("rings", rings, 1);
    require_positive("radius", radius);
    require_size(1.0 + 3.0 * rings * (rings + 1.0));
    MeshBuilder builder;
    builder.vertex(Vector3::Zero());
    for (int ring = 1; ring <= rings; ++ring) {
        for (int i = 0; i < 6 * ring; ++i) {
            const double angle = 2.0 * pi * i / (6 * ring);
            const double r = radius * ring / rings;
            builder.vertex({r * std::cos(angle), r * std::sin(angle), 0.0});
        }
    }
    // Ring k has 6 k vertices, and so k in each of six sectors.
    const auto at = [](int ring, int sector, int step) {
        return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1) + (sector * ring + step) % (6 * ring);
    };
    for (int ring = 1; ring <= rings; ++ring) {
        for (int sector = 0; sector < 6; ++sector) {
            for (int step = 0; step < ring; ++step) {
                const Index inner = at(ring - 1, sector, step);
                const Index outer = at(ring, sector, step + 1);
                builder.cell({inner, at(ring, sector, step), outer});
                if (step + 1 < ring) builder.cell({inner, outer, at(ring - 1, sector, step + 1)});
            }
        }
    }
    return builder.mesh();
}

Mesh torus(double major_radius, double minor_radius, int nu, int nv) {
    require_positive("major radius", major_radius);
    require_positive("minor radius", minor_radius);
    require_at_least("vertices along the large circle", nu, 3);
    require_at_least("vertices along the tube", nv, 3);
    require_size(double(nu) * nv);
    if (minor_radius >= major_radius) {
        throw InputError("a torus whose tube is as thick as its circle cuts itself",
                         "give a minor radius that is smaller than the major radius");
    }
    MeshBuilder builder;
    for (int j = 0; j < nv; ++j) {
        const double v = 2.0 * pi * j / nv;
        const double r = major_radius + minor_radius * std::cos(v);
        for (int i = 0; i < nu; ++i) {
            const double u = 2.0 * pi * i / nu;
            builder.vertex({r * std::cos(u), r * std::sin(u), minor_radius * std::sin(v)});
        }
    }
    builder.sheet(nu, nv, [&](int i, int j) { return (j % nv) * nu + i % nu; });
    return builder.mesh();
}

Mesh genus(int holes, int subdivisions) {
    require_at_least("holes", holes, 0);
    require_at_least("subdivisions", subdivisions, 1);
    const double squares =
        2.0 * (3.0 * (2.0 * holes + 1.0) - holes) + 2.0 * (2.0 * holes + 4.0) + 4.0 * holes;
    require_size(squares * subdivisions * subdivisions + 2.0 - 2.0 * holes);
    using Lattice = std::array<int, 3>;
    const Lattice cubes{2 * holes + 1, 3, 1};
    const auto solid = [&](const Lattice& cube) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (cube[k] < 0 || cube[k] >= cubes[k]) return false;
        }
        return cube[0] % 2 == 0 || cube[1] != 1;
    };
    MeshBuilder builder;
    std::unordered_map<std::int64_t, Index> numbers;
    const auto vertex = [&](const Lattice& place) {
        std::int64_t key = 0;
        for (std::size_t k = 0; k < 3; ++k)
            key = key * (std::int64_t{cubes[k]} * subdivisions + 1) + place[k];
        const auto [found, is_new] = numbers.try_emplace(key, static_cast<Index>(numbers.size()));
        if (is_new) {
            Vector3 position;
            for (std::size_t k = 0; k < 3; ++k) {
                position[static_cast<Eigen::Index>(k)] = double(place[k]) / subdivisions - 0.5 * cubes[k];
            }
            builder.vertex(position);
        }
        return found->second;
    };
    const auto side = [&](const Lattice& cube, std::size_t axis, int step) {
        Lattice beyond = cube;
        beyond[axis] += step;
        if (solid(beyond)) return;
        // The two other axes in the order that turns counterclockwise when seen from outside.
        const std::size_t u = (axis + (step > 0 ? 1U : 2U)) % 3;
        const std::size_t v = (axis + (step > 0 ? 2U : 1U)) % 3;
        builder.sheet(subdivisions, subdivisions, [&](int i, int j) {
            Lattice place;
            for (std::size_t k = 0; k < 3; ++k)
                place[k] = cube[k] * subdivisions;
            if (step > 0) place[axis] += subdivisions;
            place[u] += i;
            place[v] += j;
            return vertex(place);
        });
    };
    for (int x = 0; x < cubes[0]; ++x) {
        for (int y = 0; y < cubes[1]; ++y) {
            const Lattice cube{x, y, 0};
            if (!solid(cube)) continue;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                side(cube, axis, -1);
                side(cube, axis, 1);
            }
        }
    }
    return builder.mesh();
}

Mesh cylinder(double radius, double height, int nu, int nv) {
    require_positive("radius", radius);
    require_positive("height", height);
    require_at_least("squares around", nu, 3);
    require_at_least("squares along the height", nv, 1);
    require_size(double(nu) * (nv + 1.0));
    MeshBuilder builder;
    for (int j = 0; j <= nv; ++j) {
        for (int i = 0; i < nu; ++i) {
            const double u = 2.0 * pi * i / nu;
            builder.vertex({radius * std::cos(u), radius * std::sin(u), height * j / nv});
        }
    }
    builder.sheet(nu, nv, [&](int i, int j) { return j * nu + i % nu; });
    return builder.mesh();
}

Mesh circle(int n, double radius) {
    require_at_least("segments", n, 3);
    require_positive("radius", radius);
    require_size(n);
    MeshBuilder builder(CellKind::segment);
    for (int i = 0; i < n; ++i) {
        const double u = 2.0 * pi * i / n;
        builder.vertex({radius * std::cos(u), radius * std::sin(u), 0.0});
        builder.cell({i, (i + 1) % n});
    }
    return builder.mesh();
}

Mesh fins(int fins, int n) {
    require_at_least("fins", fins, 3);
    require_at_least("squares along a fin", n, 1);
    require_size((1.0 + double(fins) * n) * (n + 1.0));
    MeshBuilder builder;
    for (int j = 0; j <= n; ++j)
        builder.vertex({0.0, 0.0, double(j) / n});
    for (int fin = 0; fin < fins; ++fin) {
        const double angle = 2.0 * pi * fin / fins;
        const Index first = n + 1 + fin * n * (n + 1);
        for (int i = 1; i <= n; ++i) {
            for (int j = 0; j <= n; ++j) {
                const double r = double(i) / n;
                builder.vertex({r * std::cos(angle), r * std::sin(angle), double(j) / n});
            }
        }
        builder.sheet(n, n, [&](int i, int j) { return i == 0 ? j : first + (i - 1) * (n + 1) + j; });
    }
    return builder.mesh();
}

}  // namespace beltrami::shapes
