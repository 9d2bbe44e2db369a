#include "beltrami/solvers/filter_curve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// Gain inside [low, high] and outside, with flanks of a tenth of the width.
FilterCurve plateau(double low, double high, double inside, double outside) {
    if (!(high > low)) {
        throw InputError(fmt::format("a filter's band reaches from {} to {}", low, high),
                         "give the lower frequency first");
    }
    const double flank = 0.1 * (high - low);
    std::vector<FilterCurve::Point> points;
    if (low > flank) {
        points = {{0.0, outside}, {low - flank, outside}, {low, inside}};
    } else {
        points = {{0.0, low > 0.0 ? outside : inside}, {low, inside}};
    }
    points.push_back({high, inside});
    points.push_back({high + flank, outside});
    return FilterCurve(std::move(points));
}

FilterCurve ramp(double low, double high, double before, double behind) {
    if (!(high >= low)) {
        throw InputError(fmt::format("a filter's flank reaches from {} to {}", low, high),
                         "give the lower frequency first");
    }
    return FilterCurve({{low, before}, {high, behind}});
}

}  // namespace

FilterCurve::FilterCurve(std::vector<Point> points) : points_(std::move(points)) {
    if (points_.empty())
        throw InputError("a filter's curve has no points", "give frequency and gain of one at least");
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const auto& [frequency, gain] = points_[i];
        if (!std::isfinite(frequency) || !std::isfinite(gain) || frequency < 0.0) {
            throw InputError(fmt::format("a filter's curve has the point {}={}", frequency, gain),
                             "frequencies are not negative, and both numbers finite");
        }
        if (i > 0 && frequency < points_[i - 1].frequency) {
            throw InputError(fmt::format("a filter's curve goes from the frequency {} back to {}",
                                         points_[i - 1].frequency, frequency),
                             "give its points in ascending order of frequency");
        }
    }
}

FilterCurve FilterCurve::low_pass(double pass, double stop) {
    return ramp(pass, stop, 1.0, 0.0);
}
FilterCurve FilterCurve::high_pass(double stop, double pass) {
    return ramp(stop, pass, 0.0, 1.0);
}
FilterCurve FilterCurve::band_pass(double low, double high) {
    return plateau(low, high, 1.0, 0.0);
}
FilterCurve FilterCurve::notch(double low, double high) {
    return plateau(low, high, 0.0, 1.0);
}
FilterCurve FilterCurve::enhancement(double low, double high, double gain) {
    return ramp(low, high, 1.0, gain);
}
FilterCurve FilterCurve::band_exaggeration(double low, double high, double gain) {
    return plateau(low, high, gain, 1.0);
}

double FilterCurve::operator()(double frequency) const {
    const auto behind = std::upper_bound(points_.begin(), points_.end(), frequency,
                                         [](double f, const Point& p) { return f < p.frequency; });
    if (behind == points_.begin()) return points_.front().gain;
    if (behind == points_.end()) return points_.back().gain;
    const Point& a = *(behind - 1);
    const Point& b = *behind;
    return a.gain + (b.gain - a.gain) * (frequency - a.frequency) / (b.frequency - a.frequency);
}

double FilterCurve::mean(double from, double to) const {
    if (!(to > from)) return (*this)(from);
    double integral = 0.0;
    double start = from;
    double start_gain = (*this)(from);
    for (const Point& p : points_) {
        if (p.frequency <= from) continue;
        if (p.frequency >= to) break;
        // The gain before a step: the line's end, which is the point's own.
        integral += 0.5 * (start_gain + p.gain) * (p.frequency - start);
        start = p.frequency;
        start_gain = p.gain;
    }
    // At `to` the line from the last point, not what a step there leads to.
    const double inside = std::nextafter(to, from);
    integral += 0.5 * (start_gain + (*this)(inside)) * (to - start);
    return integral / (to - from);
}

std::vector<std::pair<double, double>> FilterCurve::differs_from(double gain, double end) const {
    std::vector<Point> all;
    all.push_back({0.0, (*this)(0.0)});
    for (const Point& p : points_) {
        if (p.frequency > 0.0 && p.frequency < end) all.push_back(p);
    }
    all.push_back({end, (*this)(std::nextafter(end, 0.0))});
    std::vector<std::pair<double, double>> intervals;
    const double scale = 1e-12 * std::max(1.0, std::abs(gain));
    for (std::size_t i = 0; i + 1 < all.size(); ++i) {
        const bool differs = std::abs(all[i].gain - gain) > scale || std::abs(all[i + 1].gain - gain) > scale;
        if (!differs || all[i + 1].frequency <= all[i].frequency) continue;
        if (!intervals.empty() && intervals.back().second == all[i].frequency) {
            intervals.back().second = all[i + 1].frequency;
        } else {
            intervals.emplace_back(all[i].frequency, all[i + 1].frequency);
        }
    }
    return intervals;
}

}  // namespace beltrami
