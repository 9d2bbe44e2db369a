#include "beltrami/framework/isolines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/sides.hpp"

namespace beltrami {

namespace {

// An edge in one number that sorts by its lower vertex.
std::uint64_t key(Index a, Index b) {
    const auto [low, high] = std::minmax(a, b);
    return (static_cast<std::uint64_t>(low) << 32U) | static_cast<std::uint32_t>(high);
}

// The two edges of each crossed triangle: those at the corner that is alone on its side.
std::vector<std::array<std::uint64_t, 2>> crossings(const Cells& triangles, const Vector& values,
                                                    double level) {
    std::vector<std::array<std::uint64_t, 2>> crossed;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        std::array<bool, 3> above{};
        for (int k = 0; k < 3; ++k)
            above[static_cast<std::size_t>(k)] = values[triangles(t, k)] >= level;
        if (above[0] == above[1] && above[1] == above[2]) continue;
        const int alone = above[1] == above[2] ? 0 : above[0] == above[2] ? 1 : 2;
        const Index apex = triangles(t, alone);
        crossed.push_back(
            {key(apex, triangles(t, (alone + 1) % 3)), key(apex, triangles(t, (alone + 2) % 3))});
    }
    return crossed;
}

class Tracer {
  public:
    Tracer(const Cells& segments, Index point_count)
        : segments_(segments),
          used_(static_cast<std::size_t>(segments.rows()), 0),
          first_(static_cast<std::size_t>(point_count) + 1, 0) {
        for (Eigen::Index i = 0; i < segments.size(); ++i)
            ++first_[static_cast<std::size_t>(segments.data()[i]) + 1];
        for (std::size_t p = 1; p < first_.size(); ++p)
            first_[p] += first_[p - 1];
        at_.resize(static_cast<std::size_t>(segments.size()));
        std::vector<Index> next(first_.begin(), first_.end() - 1);
        for (Eigen::Index s = 0; s < segments.rows(); ++s) {
            for (const Index p : {segments(s, 0), segments(s, 1)})
                at_[static_cast<std::size_t>(next[static_cast<std::size_t>(p)]++)] = static_cast<Index>(s);
        }
    }

    std::vector<Polyline> trace() {
        std::vector<Polyline> lines;
        // First those that end somewhere, then the loops that are left.
        for (const bool loops : {false, true}) {
            for (Index p = 0; p + 1 < static_cast<Index>(first_.size()); ++p) {
                if ((degree(p) == 2) != loops) continue;
                for (Index i = begin(p); i < begin(p + 1); ++i) {
                    if (used_[static_cast<std::size_t>(at_[static_cast<std::size_t>(i)])] == 0)
                        lines.push_back(follow(p, at_[static_cast<std::size_t>(i)]));
                }
            }
        }
        return lines;
    }

  private:
    [[nodiscard]] Index begin(Index point) const { return first_[static_cast<std::size_t>(point)]; }
    [[nodiscard]] Index degree(Index point) const { return begin(point + 1) - begin(point); }

    Polyline follow(Index from, Index segment) {
        Polyline line;
        line.points.push_back(from);
        Index point = from;
        for (;;) {
            used_[static_cast<std::size_t>(segment)] = 1;
            point = segments_(segment, 0) == point ? segments_(segment, 1) : segments_(segment, 0);
            if (point == from) {
                line.closed = true;
                return line;
            }
            line.points.push_back(point);
            if (degree(point) != 2) return line;
            const auto i = static_cast<std::size_t>(begin(point));
            segment = used_[static_cast<std::size_t>(at_[i])] == 0 ? at_[i] : at_[i + 1];
        }
    }

    const Cells& segments_;
    std::vector<char> used_;
    std::vector<Index> first_;  // of the segments at each point, in at_
    std::vector<Index> at_;
};

void check(const Mesh& mesh, const Vector& values, double level) {
    if (mesh.kind() != CellKind::triangle) {
        throw InputError(
            fmt::format("lines of equal value are drawn on triangles, not on {}", plural(mesh.kind())),
            mesh.kind() == CellKind::tetrahedron ? "give a surface, such as the boundary of the solid"
                                                 : "give a mesh of triangles");
    }
    if (values.size() != mesh.vertex_count()) {
        throw InputError(fmt::format("a field of {} values meets a mesh of {} vertices", values.size(),
                                     mesh.vertex_count()),
                         "give one number a vertex");
    }
    if (!std::isfinite(level) || !values.allFinite()) {
        throw InputError("lines of equal value need numbers that are finite",
                         "look for values that are not, and for the level");
    }
}

}  // namespace

Isolines isolines(const Mesh& mesh, const Vector& values, double level) {
    check(mesh, values, level);
    const auto crossed = crossings(proper_cells(mesh), values, level);
    std::vector<std::uint64_t> edges;
    edges.reserve(2 * crossed.size());
    for (const auto& pair : crossed)
        edges.insert(edges.end(), pair.begin(), pair.end());
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());

    Points points(static_cast<Eigen::Index>(edges.size()), 3);
    for (std::size_t e = 0; e < edges.size(); ++e) {
        const auto a = static_cast<Index>(edges[e] >> 32U);
        const auto b = static_cast<Index>(edges[e] & 0xffffffffU);
        // Halved, so that the difference of very large values stays finite; one end is below and the other is not.
        const double part =
            std::clamp((0.5 * level - 0.5 * values[a]) / (0.5 * values[b] - 0.5 * values[a]), 0.0, 1.0);
        points.row(static_cast<Eigen::Index>(e)) =
            (1.0 - part) * mesh.points().row(a) + part * mesh.points().row(b);
    }
    Cells segments(static_cast<Eigen::Index>(crossed.size()), 2);
    double length = 0.0;
    for (std::size_t s = 0; s < crossed.size(); ++s) {
        const auto row = static_cast<Eigen::Index>(s);
        for (std::size_t k = 0; k < 2; ++k) {
            segments(row, static_cast<Eigen::Index>(k)) = static_cast<Index>(
                std::lower_bound(edges.begin(), edges.end(), crossed[s][k]) - edges.begin());
        }
        length += (points.row(segments(row, 1)) - points.row(segments(row, 0))).norm();
    }
    std::vector<Polyline> lines = Tracer(segments, static_cast<Index>(edges.size())).trace();
    return {Mesh(std::move(points), std::move(segments)), std::move(lines), length};
}

}  // namespace beltrami
