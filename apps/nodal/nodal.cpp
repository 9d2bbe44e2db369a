#include "beltrami/apps/nodal/nodal.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/sides.hpp"

namespace beltrami {

namespace {

constexpr double rounding = 1e-9;  // eigenfunctions are not more accurate than that

// Numbers of sets of vertices, joined one edge at a time (union-find with path halving).
class Sets {
  public:
    explicit Sets(Index count) : parents_(static_cast<std::size_t>(count)) {
        std::iota(parents_.begin(), parents_.end(), 0);
    }
    Index find(Index v) {
        while (parent(v) != v) {
            parent(v) = parent(parent(v));
            v = parent(v);
        }
        return v;
    }
    void join(Index a, Index b) { parent(find(a)) = find(b); }

  private:
    Index& parent(Index v) { return parents_[static_cast<std::size_t>(v)]; }
    std::vector<Index> parents_;
};

}  // namespace

NodalLines nodal_lines(const Mesh& mesh, const Vector& values, double level) {
    if (mesh.kind() != CellKind::triangle || values.size() != mesh.vertex_count() || !values.allFinite() ||
        !std::isfinite(level)) {
        return {isolines(mesh, values, level)};  // throws
    }
    Vector above = values.array() - level;
    const double threshold = rounding * above.cwiseAbs().maxCoeff();
    const auto undecided = [&](Index v) { return std::abs(above[v]) <= threshold; };
    const Cells all = proper_cells(mesh);
    std::vector<char> on_level(static_cast<std::size_t>(mesh.vertex_count()), 0);
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        on_level[static_cast<std::size_t>(v)] = undecided(v) ? 1 : 0;

    // Sides on the boundary with both ends on the level: a line that meets them ends at a vertex, and does not go along.
    std::vector<char> ends(static_cast<std::size_t>(all.rows()), 0);
    const Sides sides(all, mesh.vertex_count());
    for (Index side = 0; side < sides.count(); ++side) {
        if (sides.places(side).size() != 1) continue;
        const Index place = sides.places(side).front();
        const Index c = sides.cell(place);
        const int corner = sides.corner(place);
        ends[static_cast<std::size_t>(c)] |= on_level[static_cast<std::size_t>(all(c, (corner + 1) % 3))] &
                                             on_level[static_cast<std::size_t>(all(c, (corner + 2) % 3))];
    }

    Vector around = Vector::Zero(mesh.vertex_count());
    Cells cells(all.rows(), 3);
    Eigen::Index kept = 0;
    for (Eigen::Index c = 0; c < all.rows(); ++c) {
        double sum = 0.0;
        bool flat = true;
        for (int k = 0; k < 3; ++k) {
            sum += above[all(c, k)];
            flat = flat && on_level[static_cast<std::size_t>(all(c, k))] != 0;
        }
        if (!flat && ends[static_cast<std::size_t>(c)] == 0) cells.row(kept++) = all.row(c);
        for (int k = 0; k < 3; ++k)
            around[all(c, k)] += sum;
    }
    cells.conservativeResize(kept, 3);
    const double most = around.cwiseAbs().maxCoeff();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (on_level[static_cast<std::size_t>(v)] != 0)
            above[v] = most > 0.0 ? threshold * (around[v] / most) : 0.0;
    }

    Sets sets(mesh.vertex_count());
    std::vector<char> used(static_cast<std::size_t>(mesh.vertex_count()), 0);
    for (Eigen::Index c = 0; c < kept; ++c) {
        for (int k = 0; k < 3; ++k) {
            const Index a = cells(c, k);
            const Index b = cells(c, (k + 1) % 3);
            used[static_cast<std::size_t>(a)] = 1;
            if ((above[a] < 0.0) == (above[b] < 0.0)) sets.join(a, b);
        }
    }
    NodalLines result{isolines(Mesh(mesh.points(), std::move(cells)), above, 0.0)};
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        result.domains += used[static_cast<std::size_t>(v)] != 0 && sets.find(v) == v ? 1 : 0;
    return result;
}

}  // namespace beltrami
