// Round numbers along a scale.
#pragma once

#include <string>
#include <vector>

namespace beltrami {

struct Tick {
    double value;
    std::string label;  ///< UTF-8
};

/// Ticks at multiples of 1, 2 or 5 times a power of ten. Labels of very large or very small numbers leave out
/// a common factor such as "×10⁻⁵"; empty where there is none.
struct Ticks {
    std::vector<Tick> ticks;
    std::string factor;
};

/// About `wanted` ticks from low to high, both finite; one where they are equal. Labels tell neighbours
/// apart.
Ticks ticks_between(double low, double high, int wanted);

/// "10⁻³".
std::string power_of_ten(int exponent);

}  // namespace beltrami
