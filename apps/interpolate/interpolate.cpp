#include "beltrami/apps/interpolate/interpolate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "beltrami/apps/term_weights.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

void require_within(const Constraints& fixed, const Bounds& bounds) {
    if (bounds.low.size() != fixed.columns() || bounds.high.size() != fixed.columns()) {
        throw InputError(
            fmt::format("bounds of {} columns for values of {}", bounds.low.size(), fixed.columns()),
            "give a low and a high one for each column");
    }
    for (const Index v : fixed.vertices()) {
        for (Index c = 0; c < fixed.columns(); ++c) {
            const double value = fixed.value(v)[static_cast<std::size_t>(c)];
            if (value < bounds.low[c] || value > bounds.high[c]) {
                throw InputError(fmt::format("vertex {} is fixed at {}, outside the bounds {} to {}", v,
                                             value, bounds.low[c], bounds.high[c]),
                                 "widen the bounds");
            }
        }
    }
}

}  // namespace

InterpolateResult interpolate(const Laplacian& laplacian, const Constraints& fixed,
                              const InterpolateOptions& options) {
    if (fixed.empty())
        throw InputError("no vertex is fixed, so there is nothing to interpolate", "fix at least one");
    const std::vector<double> gamma = term_weights(options.laplacian, options.bilaplacian);
    const Renumbering& order = laplacian.order();
    const Constraints held =
        order.to_working(hold_free_components(laplacian, fixed, options.free_components));
    LinearSolver solver(PdeOperator(laplacian, 0.0, gamma), options.linear);
    Block value = Block::Zero(laplacian.vertex_count(), fixed.columns());
    const Block no_load = value;
    if (!options.bounds) {
        const LinearSummary summary = solver.solve(no_load, held, value);
        require_converged(summary);
        return {order.to_user(value), summary};
    }
    require_within(fixed, *options.bounds);
    const LinearSummary summary = solve_bounded(solver, no_load, held, *options.bounds, value).linear;
    return {order.to_user(value), summary};
}

Bounds range_of(const Constraints& fixed) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Bounds range{Vector::Constant(fixed.columns(), infinity), Vector::Constant(fixed.columns(), -infinity)};
    for (const Index v : fixed.vertices()) {
        const Eigen::Map<const Vector> value(fixed.value(v).data(), fixed.columns());
        range.low = range.low.cwiseMin(value);
        range.high = range.high.cwiseMax(value);
    }
    return range;
}

Clamped clamped(const Block& value, double low, double high) {
    Clamped result{value.cwiseMax(low).cwiseMin(high)};
    const Vector beyond = (value - result.value).cwiseAbs().rowwise().maxCoeff();
    result.vertices = static_cast<Index>((beyond.array() > 0.0).count());
    result.farthest = beyond.size() > 0 ? beyond.maxCoeff() : 0.0;
    return result;
}

}  // namespace beltrami
