#include "beltrami/apps/interpolate/interpolate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

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

Interpolator::Interpolator(const Laplacian& laplacian, const InterpolateOptions& options)
    : laplacian_(laplacian),
      free_components_(options.free_components),
      components_(connected_components(laplacian.graph())),
      solver_(PdeOperator(laplacian, 0.0, term_weights(options.laplacian, options.bilaplacian)),
              options.linear) {
    for (Index v = 0; v < laplacian.vertex_count(); ++v) {
        if (laplacian.graph().degree(v) == 0) isolated_.push_back(v);
    }
}

InterpolateResult Interpolator::operator()(const Constraints& fixed, const std::optional<Bounds>& bounds) {
    if (fixed.empty())
        throw InputError("no vertex is fixed, so there is nothing to interpolate", "fix at least one");
    if (bounds) require_within(fixed, *bounds);
    const Renumbering& order = laplacian_.order();
    const Constraints held =
        order.to_working(hold_free_components(laplacian_, components_, fixed, free_components_));
    const Block no_load = Block::Zero(laplacian_.vertex_count(), fixed.columns());
    // A solve that fails leaves nothing to start from.
    Block value = std::exchange(value_, Block());
    if (value.cols() != fixed.columns() || value.rows() != no_load.rows()) value = no_load;
    for (const Index v : isolated_)
        value.row(v).setZero();
    LinearSummary summary;
    if (bounds) {
        summary = solve_bounded(solver_, no_load, held, *bounds, value).linear;
    } else {
        summary = solver_.solve(no_load, held, value);
        require_converged(summary);
    }
    value_ = std::move(value);
    return {order.to_user(value_), summary};
}

InterpolateResult interpolate(const Laplacian& laplacian, const Constraints& fixed,
                              const InterpolateOptions& options) {
    return Interpolator(laplacian, options)(fixed, options.bounds);
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
