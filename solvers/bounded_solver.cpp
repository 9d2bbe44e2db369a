#include "beltrami/solvers/bounded_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

enum class Side : signed char { low = -1, inside = 0, high = 1 };
using Sides = std::vector<Side>;

// One column.
class Column {
  public:
    Column(LinearSolver& solver, Block b, Constraints held, double low, double high)
        : solver_(solver), b_(std::move(b)), held_(std::move(held)), low_(low), high_(high) {
        const Vector diagonal = solver.op().diagonal();
        const double range = std::isfinite(high - low) ? high - low : 0.0;
        double size = std::max(range, 0.0);
        for (const Index v : held_.vertices())
            size = std::max(size, std::abs(held_.value(v)[0]));
        size_ = size;
        weight_ = diagonal * (size > 0.0 ? size : 1.0);
        empty_.reserve(static_cast<std::size_t>(diagonal.size()));
        for (const double d : diagonal)
            empty_.push_back(d == 0.0 ? 1 : 0);
    }

    void run(Block& u, int most_active_sets, BoundedSummary& summary) {
        Sides sides(static_cast<std::size_t>(u.rows()), Side::inside);
        std::set<Sides> seen;
        int sets = 0;
        bool settled = false;
        while (!settled && sets < most_active_sets && seen.insert(sides).second) {
            solve(sides, u, summary.linear);
            ++sets;
            settled = !update(sides, u);
        }
        clip(u);
        for (int newton = 0; !settled; ++newton) {
            if (newton == most_newton_steps) {
                throw SolveError(
                    fmt::format(
                        "the bounded solve did not find which vertices lie at their bounds in {} sets", sets),
                    "widen the bounds, or look at the mesh with `beltrami info`");
            }
            settled = newton_step(sides, u, summary.linear);
            ++sets;
            ++summary.projected;
        }
        summary.sets = std::max(summary.sets, sets);
        summary.at_bounds += static_cast<Index>(
            std::count_if(sides.begin(), sides.end(), [](Side side) { return side != Side::inside; }));
    }

  private:
    static constexpr int most_newton_steps = 200;

    [[nodiscard]] bool is_free(Index v) const {
        return empty_[static_cast<std::size_t>(v)] == 0 && !held_.is_fixed(v);
    }
    [[nodiscard]] Vector slope(const Block& u) const {
        Block product;
        solver_.op().apply(u, product);
        return (product - b_).col(0);
    }

    // The least energy with the vertices of `sides` at their bounds.
    void solve(const Sides& sides, Block& u, LinearSummary& total) {
        Constraints held = held_;
        for (Index v = 0; v < u.rows(); ++v) {
            const Side side = sides[static_cast<std::size_t>(v)];
            if (side != Side::inside) held.fix(v, side == Side::low ? low_ : high_);
        }
        const LinearSummary solved = solver_.solve(b_, held, u);
        require_converged(solved);
        total.add(solved);
        // What of a reaction and of a value is rounding: a direct solve's are exact but for the last digits.
        slack_ = solved.solver == "cg" ? solved.tolerance : 1e-12;
    }

    [[nodiscard]] bool pulls_inside(Side side, Index v, const Vector& slope) const {
        const double outward = side == Side::high ? slope[v] : -slope[v];
        return outward > slack_ * weight_[v];
    }

    // The next active set; false where it is the same.
    bool update(Sides& sides, const Block& u) const {
        const Vector g = slope(u);
        bool changed = false;
        for (Index v = 0; v < u.rows(); ++v) {
            if (!is_free(v)) continue;
            Side& side = sides[static_cast<std::size_t>(v)];
            Side next = side;
            if (side == Side::inside) {
                if (u(v, 0) > high_ + slack_ * size_) next = Side::high;
                if (u(v, 0) < low_ - slack_ * size_) next = Side::low;
            } else if (pulls_inside(side, v, g)) {
                next = Side::inside;
            }
            changed = changed || next != side;
            side = next;
        }
        return changed;
    }

    void clip(Block& u) const {
        for (Index v = 0; v < u.rows(); ++v) {
            if (is_free(v)) u(v, 0) = std::clamp(u(v, 0), low_, high_);
        }
    }

    // From u within the bounds: true where it is the solution.
    bool newton_step(Sides& sides, Block& u, LinearSummary& total) {
        const Vector g = slope(u);
        for (Index v = 0; v < u.rows(); ++v) {
            Side side = Side::inside;
            if (is_free(v) && u(v, 0) >= high_) side = Side::high;
            if (is_free(v) && u(v, 0) <= low_) side = Side::low;
            if (side != Side::inside && pulls_inside(side, v, g)) side = Side::inside;
            sides[static_cast<std::size_t>(v)] = side;
        }
        Block goal = u;
        solve(sides, goal, total);
        Sides next = sides;
        if (!update(next, goal)) {
            u = goal;
            clip(u);
            return true;
        }
        const Block step = goal - u;
        for (double length = 1.0; length > 1e-10; length /= 2.0) {
            Block trial = u + length * step;
            clip(trial);
            const Block moved = trial - u;
            Block product;
            solver_.op().apply(moved, product);
            const double linear = g.dot(moved.col(0));
            const double change = linear + 0.5 * product.col(0).dot(moved.col(0));
            if (change <= 1e-4 * linear && linear < 0.0) {
                u = trial;
                return false;
            }
        }
        // No step lowers the energy any more: this is the solution but for rounding.
        return true;
    }

    LinearSolver& solver_;
    Block b_;
    Constraints held_;
    double low_;
    double high_;
    double size_ = 1.0;
    double slack_ = 1e-12;
    Vector weight_;  // diagonal times the size of values: the scale of reactions
    std::vector<char> empty_;
};

void check(const Bounds& bounds, Eigen::Index columns) {
    if (bounds.low.size() != columns || bounds.high.size() != columns) {
        throw InputError(fmt::format("bounds of {} and {} columns for a field of {}", bounds.low.size(),
                                     bounds.high.size(), columns),
                         "give a low and a high one for each column");
    }
    for (Eigen::Index c = 0; c < columns; ++c) {
        if (!(bounds.low[c] <= bounds.high[c])) {
            throw InputError(fmt::format("the bounds {} to {} hold no number", bounds.low[c], bounds.high[c]),
                             "give the low one first");
        }
    }
}

}  // namespace

BoundedSummary solve_bounded(LinearSolver& solver, const Block& b, const Constraints& held,
                             const Bounds& bounds, Block& u, const BoundedOptions& options) {
    if (b.rows() != solver.op().rows() || u.rows() != b.rows() || u.cols() != b.cols() ||
        (!held.empty() && held.columns() != b.cols())) {
        throw InputError(fmt::format("a bounded solve of {} vertices got b of {} x {} and u of {} x {}",
                                     solver.op().rows(), b.rows(), b.cols(), u.rows(), u.cols()),
                         "give both one row a vertex and the columns of the constraints");
    }
    check(bounds, b.cols());
    held.check_range(static_cast<Index>(u.rows()));
    BoundedSummary summary;
    for (Eigen::Index c = 0; c < b.cols(); ++c) {
        Constraints held_column;
        for (const Index v : held.vertices())
            held_column.fix(v, held.value(v)[static_cast<std::size_t>(c)]);
        Block column = u.col(c);
        Column(solver, b.col(c), std::move(held_column), bounds.low[c], bounds.high[c])
            .run(column, options.active_sets, summary);
        u.col(c) = column;
    }
    return summary;
}

}  // namespace beltrami
