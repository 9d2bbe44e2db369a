#include "beltrami/apps/picture/arrows.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace beltrami {

namespace {

constexpr Colour given_colour{0.86F, 0.10F, 0.12F};

/// One vertex in each cube of that size, the one nearest to its middle; those that are hidden get an arrow too, which
/// the surface hides.
std::vector<Index> spread(const Points& positions, const std::vector<Index>& seen, double size) {
    struct Nearest {
        Index vertex;
        double distance;
    };
    std::map<std::array<std::int64_t, 3>, Nearest> cubes;
    for (const Index v : seen) {
        const Eigen::Array3d place = positions.row(v).transpose().array() / size;
        const Eigen::Array3d cube = place.floor();
        const double distance = (place - cube - 0.5).matrix().squaredNorm();
        const std::array<std::int64_t, 3> key{static_cast<std::int64_t>(cube[0]),
                                              static_cast<std::int64_t>(cube[1]),
                                              static_cast<std::int64_t>(cube[2])};
        const auto [entry, is_new] = cubes.try_emplace(key, Nearest{v, distance});
        if (!is_new && distance < entry->second.distance) entry->second = {v, distance};
    }
    std::vector<Index> chosen;
    chosen.reserve(cubes.size());
    for (const auto& [cube, nearest] : cubes)
        chosen.push_back(nearest.vertex);
    return chosen;
}

class Collector {
  public:
    Collector(const Points& positions, const Block& vectors, double lift)
        : positions_(positions), vectors_(vectors), lift_(lift) {}

    /// The vector at v, in the picture so many pixels long for each unit.
    void add(Index v, double pixels, const Colour& colour) {
        const Vector3 middle = positions_.row(v).transpose() + lift_ * Vector3::UnitZ();
        const Vector3 half = 0.5 * pixels * vectors_.row(v).transpose();
        const Vector3 tip = middle + half;
        const Vector3 tail = middle - half;
        rod(tail, tip, colour);
        if (half.isZero(0.0)) return;
        // Barbs in the plane of the picture, so that they are seen; of a vector toward the viewer there are none.
        const Vector3 aside = Vector3(-half.y(), half.x(), 0.0);
        for (const double side : {-1.0, 1.0})
            rod(tip, tip - 0.6 * half + side * 0.4 * aside, colour);
    }

    [[nodiscard]] Arrows take() const {
        Arrows arrows;
        const auto count = static_cast<Eigen::Index>(ends_.size());
        arrows.ends.resize(count, 3);
        arrows.colours.resize(count, 3);
        arrows.rods.resize(count / 2, 2);
        for (Eigen::Index i = 0; i < count; ++i) {
            const auto at = static_cast<std::size_t>(i);
            arrows.ends.row(i) = ends_[at];
            arrows.colours.row(i) << colours_[at][0], colours_[at][1], colours_[at][2];
            arrows.rods(i / 2, i % 2) = static_cast<Index>(i);
        }
        return arrows;
    }

  private:
    void rod(const Vector3& from, const Vector3& to, const Colour& colour) {
        for (const Vector3& end : {from, to}) {
            ends_.push_back(end);
            colours_.push_back(colour);
        }
    }

    const Points& positions_;
    const Block& vectors_;
    double lift_;
    std::vector<Vector3> ends_;
    std::vector<Colour> colours_;
};

}  // namespace

Arrows arrows(const Points& positions, const std::vector<Index>& seen, const Block& vectors,
              const std::vector<Index>& given, const ColourScale& scale, double spacing, double lift) {
    double longest = 0.0;
    for (const Index v : seen) {
        if (vectors.row(v).allFinite()) longest = std::max(longest, vectors.row(v).norm());
    }
    // Short ones must still show their direction.
    const auto pixels = [&](Index v, double largest) {
        const double length = vectors.row(v).norm();
        return length > 0.0 ? largest * (0.35 + 0.65 * std::min(1.0, length / longest)) / length : 0.0;
    };
    Collector collector(positions, vectors, lift);
    const std::set<Index> kept(given.begin(), given.end());
    for (const Index v : spread(positions, seen, spacing)) {
        if (kept.contains(v) || !vectors.row(v).allFinite()) continue;
        collector.add(v, pixels(v, 0.95 * spacing), scale.colour(vectors.row(v).norm()));
    }
    for (const Index v : spread(positions, given, spacing)) {
        if (vectors.row(v).allFinite()) collector.add(v, pixels(v, 2.0 * spacing), given_colour);
    }
    return collector.take();
}

}  // namespace beltrami
