#include "beltrami/apps/picture/colour_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace beltrami {

namespace {

// Oklab (B. Ottosson, 2020): lightness and two colour axes in which distances are nearly as the eye has them.
struct Oklab {
    double lightness, a, b;
};

double to_linear(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

double to_srgb(double linear) {
    const double c = std::clamp(linear, 0.0, 1.0);
    return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
}

Oklab oklab_of(unsigned hex) {
    const double r = to_linear(((hex >> 16U) & 255U) / 255.0);
    const double g = to_linear(((hex >> 8U) & 255U) / 255.0);
    const double b = to_linear((hex & 255U) / 255.0);
    const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
    const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
            1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
            0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

Colour colour_of(const Oklab& c) {
    const double l = std::pow(c.lightness + 0.3963377774 * c.a + 0.2158037573 * c.b, 3.0);
    const double m = std::pow(c.lightness - 0.1055613458 * c.a - 0.0638541728 * c.b, 3.0);
    const double s = std::pow(c.lightness - 0.0894841775 * c.a - 1.2914855480 * c.b, 3.0);
    return {static_cast<float>(to_srgb(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s)),
            static_cast<float>(to_srgb(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s)),
            static_cast<float>(to_srgb(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s))};
}

// Ten equidistant colours of viridis (S. van der Walt and N. Smith, CC0).
constexpr std::array<unsigned, 10> viridis{0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e,
                                           0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725};

Colour sequential_colour(double t) {
    constexpr int last = static_cast<int>(viridis.size()) - 1;
    const int i = std::min(static_cast<int>(t * last), last - 1);
    const double w = t * last - i;
    const Oklab p = oklab_of(viridis[static_cast<std::size_t>(i)]);
    const Oklab q = oklab_of(viridis[static_cast<std::size_t>(i) + 1]);
    return colour_of(
        {p.lightness + w * (q.lightness - p.lightness), p.a + w * (q.a - p.a), p.b + w * (q.b - p.b)});
}

// Lightness falls evenly from the middle, which is grey enough to stand out from white paper; the
// colourfulness rises to what a screen can show at that lightness.
Colour diverging_colour(double t) {
    const double away = std::abs(2.0 * t - 1.0);
    const double lightness = 0.93 - 0.51 * away;
    const double chroma = 0.155 * std::sin(0.5 * std::numbers::pi * std::min(1.0, 1.3 * away));
    const double hue = (t < 0.5 ? 256.0 : 27.0) * std::numbers::pi / 180.0;
    return colour_of({lightness, chroma * std::cos(hue), chroma * std::sin(hue)});
}

// A value far outside of a narrow range must stay finite when it is interpolated.
constexpr double farthest = 1e9;

}  // namespace

const ColourMap& ColourMap::sequential() {
    static const ColourMap map = [] {
        ColourMap made;
        for (std::size_t i = 0; i < entries; ++i) {
            made.table_[i] = sequential_colour(static_cast<double>(i) / (entries - 1));
        }
        return made;
    }();
    return map;
}

const ColourMap& ColourMap::diverging() {
    static const ColourMap map = [] {
        ColourMap made;
        for (std::size_t i = 0; i < entries; ++i) {
            made.table_[i] = diverging_colour(static_cast<double>(i) / (entries - 1));
        }
        return made;
    }();
    return map;
}

Colour ColourMap::operator()(double position) const {
    if (std::isnan(position)) return no_value_colour;
    const double entry = std::clamp(position, 0.0, 1.0) * (entries - 1);
    return table_[static_cast<std::size_t>(std::lround(entry))];
}

ColourScale::ColourScale(double low, double high)
    : low_(low), high_(high), diverging_(std::min(-low, high) > 0.05 * std::max(-low, high)) {
    first_ = position(low);
    last_ = position(high);
}

double ColourScale::position(double value) const {
    if (!std::isfinite(value)) return std::numeric_limits<double>::quiet_NaN();
    if (diverging_) {
        return 0.5 + 0.5 * std::clamp(value / std::max(-low_, high_), -farthest, farthest);
    }
    if (low_ == high_) {
        if (value == low_) return 0.5;
        return value < low_ ? 0.0 : 1.0;
    }
    // Halves, since high - low may be more than a double holds.
    return std::clamp((0.5 * value - 0.5 * low_) / (0.5 * high_ - 0.5 * low_), -farthest, farthest);
}

Colour ColourScale::colour_at(double position) const {
    const ColourMap& map = diverging_ ? ColourMap::diverging() : ColourMap::sequential();
    if (low_ == high_ || std::isnan(position)) return map(position);
    return map(std::clamp(position, first_, last_));
}

}  // namespace beltrami
