// A frequency-space filter: the amplification F(omega) of each spatial frequency, piecewise linear.
//
//     const FilterCurve smooth = FilterCurve::low_pass(20.0, 25.0);      // 1 up to 20, 0 from 25 radians a unit length
//     smooth(22.5) == 0.5;
//     const FilterCurve own({{0.0, 1.0}, {10.0, 2.0}, {40.0, 1.0}});
//
// Frequencies are omega = sqrt(lambda), in radians a unit of length: a wave of length l has omega = 2 pi / l.
#pragma once

#include <utility>
#include <vector>

namespace beltrami {

class FilterCurve {
  public:
    struct Point {
        double frequency;
        double gain;
    };

    /// Linear between the points, constant before the first and behind the last; two points of one frequency are a
    /// step. Throws InputError for no point, frequencies that descend, and numbers that are negative frequencies or not
    /// finite.
    explicit FilterCurve(std::vector<Point> points);

    /// 1 up to `pass`, 0 from `stop`.
    static FilterCurve low_pass(double pass, double stop);
    /// 0 up to `stop`, 1 from `pass`.
    static FilterCurve high_pass(double stop, double pass);
    /// 1 between low and high, 0 outside; flanks of a tenth of the width reach outside.
    static FilterCurve band_pass(double low, double high);
    /// 0 between low and high, 1 outside; flanks as above.
    static FilterCurve notch(double low, double high);
    /// 1 up to low, `gain` from high.
    static FilterCurve enhancement(double low, double high, double gain);
    /// `gain` between low and high, 1 outside; flanks as above.
    static FilterCurve band_exaggeration(double low, double high, double gain);

    [[nodiscard]] const std::vector<Point>& points() const { return points_; }

    /// F(omega); at a step the gain behind it.
    [[nodiscard]] double operator()(double frequency) const;
    /// The mean of F over an interval (its value where the interval is empty).
    [[nodiscard]] double mean(double from, double to) const;
    /// The intervals within [0, end] where F is not `gain`, ascending and apart.
    [[nodiscard]] std::vector<std::pair<double, double>> differs_from(double gain, double end) const;

  private:
    std::vector<Point> points_;
};

}  // namespace beltrami
