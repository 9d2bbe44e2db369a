// From numbers to colours.
//
//     const ColourScale scale(-0.3, 1.0);
//     const Colour zero = scale.colour(0.0);     // the neutral grey of the diverging map
#pragma once

#include <array>

namespace beltrami {

/// Red, green, blue as a screen shows them (sRGB), in [0, 1].
using Colour = std::array<float, 3>;

/// What is drawn where a value is not a finite number.
inline constexpr Colour no_value_colour{0.55F, 0.55F, 0.55F};

/// A curve through colour space whose lightness changes evenly, so that equal differences of the number look
/// equal, also in grey and to colour-blind eyes.
class ColourMap {
  public:
    /// Dark violet over green to bright yellow, for values of one sign.
    static const ColourMap& sequential();
    /// Blue over light grey, at 0.5, to red, of the same lightness left and right of it.
    static const ColourMap& diverging();

    /// The colour at a position in [0, 1]; beyond it, that of the nearer end; no_value_colour for NaN.
    [[nodiscard]] Colour operator()(double position) const;

  private:
    static constexpr int entries = 1024;
    ColourMap() = default;
    std::array<Colour, entries> table_{};
};

/// Which colour a value has when values between low and high are shown. A range with a fair share on both
/// sides of zero (the smaller at least 1/20 of the larger, so that rounding below zero does not count) is
/// shown on the diverging map, zero in its middle and equal distances from zero equally strong; others on the
/// sequential map.
class ColourScale {
  public:
    /// low <= high, both finite. Where they are equal, that value has the middle of the sequential map.
    ColourScale(double low, double high);

    [[nodiscard]] double low() const { return low_; }
    [[nodiscard]] double high() const { return high_; }
    [[nodiscard]] bool is_diverging() const { return diverging_; }

    /// Where on the map a value lies; linear in the value and not clamped, so that it may be interpolated,
    /// yet bounded so that this stays finite. NaN for what is not a finite number.
    [[nodiscard]] double position(double value) const;
    /// The colour at an (interpolated) position, clamped to what low and high have.
    [[nodiscard]] Colour colour_at(double position) const;
    [[nodiscard]] Colour colour(double value) const { return colour_at(position(value)); }

  private:
    double low_;
    double high_;
    bool diverging_;
    double first_;  // positions of low and high
    double last_;
};

}  // namespace beltrami
