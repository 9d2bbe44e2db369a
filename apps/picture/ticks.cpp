#include "beltrami/apps/picture/ticks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace beltrami {

namespace {

constexpr std::string_view minus = "\u2212";

std::string with_sign(double value, const std::string& digits) {
    const bool is_zero = digits.find_first_not_of("0.") == std::string::npos;
    return value < 0.0 && !is_zero ? std::string(minus) + digits : digits;
}

int exponent_of(double value) {
    return static_cast<int>(std::floor(std::log10(value)));
}

/// 1, 2 or 5 times a power of ten, at least `rough`.
double round_step(double rough) {
    const double power = std::pow(10.0, exponent_of(rough));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * power >= rough * (1.0 - 1e-9)) return factor * power;
    }
    return 10.0 * power;
}

}  // namespace

std::string power_of_ten(int exponent) {
    constexpr std::array<std::string_view, 10> raised{"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                                      "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
    std::string text = "10";
    if (exponent < 0) text += "\u207b";
    for (const char digit : fmt::format("{}", std::abs(exponent))) {
        text += raised[static_cast<std::size_t>(digit - '0')];
    }
    return text;
}

Ticks ticks_between(double low, double high, int wanted) {
    Ticks result;
    const double largest = std::max(std::abs(low), std::abs(high));
    double unit = 1.0;
    if (largest > 0.0 && (largest >= 1e5 || largest < 1e-3)) {
        const int exponent = std::max(exponent_of(largest), -307);
        unit = std::pow(10.0, exponent);
        result.factor = "\u00d7" + power_of_ten(exponent);
    }
    const double from = low / unit;
    const double to = high / unit;
    constexpr int most_decimals = 12;
    if (!(to > from)) {
        result.ticks.push_back({low, with_sign(from, fmt::format("{:.6g}", std::abs(from)))});
        return result;
    }
    const double step = round_step((to - from) / std::max(wanted, 1));
    const int decimals = std::clamp(-exponent_of(step * (1.0 + 1e-9)), 0, most_decimals);
    const double slack = 0.005 * (to - from);  // the end is as good as at the round number: too close to see
    const double first = std::ceil((from - slack) / step);
    for (int i = 0; i <= 2 * std::max(wanted, 1) + 2; ++i) {
        const double value = (first + i) * step;
        if (value > to + slack) break;
        result.ticks.push_back({std::clamp(value * unit, low, high),
                                with_sign(value, fmt::format("{:.{}f}", std::abs(value), decimals))});
    }
    return result;
}

}  // namespace beltrami
