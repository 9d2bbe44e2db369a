#include "beltrami/framework/orientation.hpp"

namespace beltrami {

namespace {

std::size_t at(Index i) {
    return static_cast<std::size_t>(i);
}

}  // namespace

Orientation orientation(const Cells& triangles, const Sides& sides) {
    // The triangle's side at a place runs from the corner after it to the one before it.
    const auto start = [&](Index place) {
        return triangles(sides.cell(place), (sides.corner(place) + 1) % 3);
    };
    std::vector<Index> across(static_cast<std::size_t>(triangles.size()), -1);
    for (Index s = 0; s < sides.count(); ++s) {
        const auto places = sides.places(s);
        if (places.size() != 2) continue;
        across[at(places[0])] = places[1];
        across[at(places[1])] = places[0];
    }

    // Breadth first; 0 has not been reached.
    Orientation result{std::vector<signed char>(static_cast<std::size_t>(triangles.rows()), 0)};
    std::vector<Index> queue;
    for (Index seed = 0; seed < triangles.rows(); ++seed) {
        if (result.sense[at(seed)] != 0) continue;
        result.sense[at(seed)] = 1;
        queue.assign(1, seed);
        for (std::size_t head = 0; head < queue.size(); ++head) {
            const Index cell = queue[head];
            for (Index place = 3 * cell; place < 3 * cell + 3; ++place) {
                const Index other = across[at(place)];
                if (other < 0) continue;
                const bool turned = start(place) == start(other);
                const auto wanted =
                    static_cast<signed char>(turned ? -result.sense[at(cell)] : result.sense[at(cell)]);
                signed char& found = result.sense[at(sides.cell(other))];
                if (found == 0) {
                    found = wanted;
                    queue.push_back(sides.cell(other));
                } else if (found != wanted) {
                    result.one_sided = true;
                }
            }
        }
    }
    return result;
}

}  // namespace beltrami
