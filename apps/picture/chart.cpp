#include "beltrami/apps/picture/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "beltrami/apps/picture/sheet.hpp"
#include "beltrami/apps/picture/ticks.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

constexpr int least_width = 160;
constexpr int least_height = 120;
constexpr int most_pixels = 16384;

/// What a direction of the chart shows, and where on the paper.
struct Axis {
    bool logarithmic = false;
    double low =
        std::numeric_limits<double>::infinity();  // of what is plotted: the logarithm on such an axis
    double high = -std::numeric_limits<double>::infinity();
    double start = 0.0;  // pixels of low and high
    double end = 0.0;
    Ticks ticks = {};

    /// Not finite for what has no place.
    [[nodiscard]] double of(double value) const {
        if (!logarithmic) return value;
        return value > 0.0 ? std::log10(value) : std::numeric_limits<double>::quiet_NaN();
    }
    [[nodiscard]] double pixel(double plotted) const {
        return start + (plotted - low) / (high - low) * (end - start);
    }
    void include(double plotted) {
        low = std::min(low, plotted);
        high = std::max(high, plotted);
    }

    void set_ticks(int wanted) {
        if (!(low <= high)) {
            low = 0.0;
            high = 1.0;
        }
        if (logarithmic) {
            low = std::floor(low + 1e-9);
            high = std::max(std::ceil(high - 1e-9), low + 1.0);
            const int step = std::max(1, static_cast<int>(std::ceil((high - low) / std::max(wanted, 1))));
            for (double power = low; power <= high; power += step)
                ticks.ticks.push_back({power, power_of_ten(static_cast<int>(power))});
            return;
        }
        if (!(high > low)) {
            const double half = low == 0.0 ? 1.0 : 0.5 * std::abs(low);
            low -= half;
            high += half;
        }
        ticks = ticks_between(low, high, wanted);
    }
};

void check(const Chart& chart, int width, int height) {
    if (width < least_width || height < least_height || std::max(width, height) > most_pixels) {
        throw InputError(
            fmt::format("a chart of {} x {} pixels cannot be drawn", width, height),
            fmt::format("give at least {} x {}, and at most {}", least_width, least_height, most_pixels));
    }
    for (const ChartLine& line : chart.lines) {
        if (line.x.size() == line.y.size()) continue;
        throw InputError(
            fmt::format("the line '{}' has {} places and {} values", line.name, line.x.size(), line.y.size()),
            "give as many of both");
    }
}

void set_colour(cairo_t* cairo, const Colour& colour) {
    cairo_set_source_rgb(cairo, colour[0], colour[1], colour[2]);
}

constexpr Colour ink{0.13F, 0.13F, 0.15F};
constexpr Colour faint{0.88F, 0.88F, 0.90F};

class ChartPage {
  public:
    ChartPage(const Chart& chart, int width, int height)
        : chart_(chart),
          sheet_(width, height),
          font_(std::clamp(std::min(width, height) / 26.0, 10.0, 40.0)),
          line_(std::max(1.0, std::round(font_ / 14.0))) {
        up_.logarithmic = chart.logarithmic;
        for (const ChartLine& line : chart.lines) {
            for (Eigen::Index i = 0; i < line.x.size(); ++i) {
                const double y = up_.of(line.y[i]);
                if (!std::isfinite(y) || !std::isfinite(line.x[i])) continue;
                across_.include(line.x[i]);
                up_.include(y);
            }
        }
        const double top = (chart.title.empty() ? 1.0 : 2.4) * font_ + 1.4 * font_;
        up_.start = height - 3.6 * font_;
        up_.end = top;
        up_.set_ticks(std::clamp(static_cast<int>((up_.start - up_.end) / (2.6 * font_)), 2, 10));
        sheet_.set_font(font_);
        double label = 0.0;
        for (const Tick& tick : up_.ticks.ticks)
            label = std::max(label, sheet_.width_of(tick.label));
        across_.start = label + 2.2 * font_;
        across_.end = width - 2.0 * font_;
        across_.set_ticks(std::clamp(static_cast<int>((across_.end - across_.start) / (5.0 * font_)), 2, 10));
    }

    Image draw() {
        grid();
        frame();
        lines();
        letters();
        legend();
        return sheet_.image();
    }

  private:
    [[nodiscard]] cairo_t* cairo() const { return sheet_.cairo(); }
    /// On the middle of a pixel, so that thin lines are sharp.
    static double sharp(double pixel) { return std::floor(pixel) + 0.5; }

    void stroke(double x0, double y0, double x1, double y1) {
        cairo_move_to(cairo(), x0, y0);
        cairo_line_to(cairo(), x1, y1);
        cairo_stroke(cairo());
    }

    void grid() {
        set_colour(cairo(), faint);
        cairo_set_line_width(cairo(), 1.0);
        for (const Tick& tick : across_.ticks.ticks) {
            const double x = sharp(across_.pixel(tick.value));
            stroke(x, up_.start, x, up_.end);
        }
        for (const Tick& tick : up_.ticks.ticks) {
            const double y = sharp(up_.pixel(tick.value));
            stroke(across_.start, y, across_.end, y);
        }
    }

    void lines() {
        cairo_save(cairo());
        cairo_set_line_join(cairo(), CAIRO_LINE_JOIN_ROUND);
        cairo_set_line_cap(cairo(), CAIRO_LINE_CAP_ROUND);
        cairo_set_line_width(cairo(), 1.8 * line_);
        for (std::size_t l = 0; l < chart_.lines.size(); ++l) {
            const ChartLine& line = chart_.lines[l];
            set_style(l);
            bool drawing = false;
            for (Eigen::Index i = 0; i < line.x.size(); ++i) {
                const double y = up_.of(line.y[i]);
                if (!std::isfinite(y) || !std::isfinite(line.x[i])) {
                    drawing = false;
                    continue;
                }
                const double px = across_.pixel(line.x[i]);
                const double py = up_.pixel(y);
                // A point of its own, where there are gaps around it, is drawn too: a line to itself.
                if (!drawing) cairo_move_to(cairo(), px, py);
                cairo_line_to(cairo(), px, py);
                drawing = true;
            }
            cairo_stroke(cairo());
        }
        cairo_restore(cairo());
    }

    void set_style(std::size_t l) {
        set_colour(cairo(), chart_colour(l));
        const double dash = 0.5 * font_;
        cairo_set_dash(cairo(), &dash, chart_.lines[l].dashed ? 1 : 0, 0.0);
    }

    void frame() {
        set_colour(cairo(), ink);
        cairo_set_line_width(cairo(), 1.0);
        stroke(sharp(across_.start), up_.end, sharp(across_.start), up_.start);
        stroke(across_.start, sharp(up_.start), across_.end, sharp(up_.start));
    }

    void letters() {
        for (const Tick& tick : across_.ticks.ticks) {
            const double x = across_.pixel(tick.value);
            sheet_.write(x - 0.5 * sheet_.width_of(tick.label), up_.start + 1.3 * font_, tick.label);
        }
        for (const Tick& tick : up_.ticks.ticks) {
            sheet_.write(across_.start - 0.5 * font_ - sheet_.width_of(tick.label),
                         up_.pixel(tick.value) + 0.36 * font_, tick.label);
        }
        const std::string across = with_factor(chart_.across, across_.ticks.factor);
        sheet_.write(0.5 * (across_.start + across_.end - sheet_.width_of(across)), up_.start + 2.8 * font_,
                     across);
        sheet_.write(0.8 * font_, up_.end - 0.8 * font_, with_factor(chart_.up, up_.ticks.factor));
        if (chart_.title.empty()) return;
        sheet_.set_font(1.15 * font_, true);
        sheet_.write(0.8 * font_, 1.6 * font_, chart_.title);
        sheet_.set_font(font_);
    }

    static std::string with_factor(const std::string& text, const std::string& factor) {
        return factor.empty() ? text : fmt::format("{} ({})", text, factor);
    }

    /// At the upper right, on the line of the vertical axis's name, where no line of the chart runs.
    void legend() {
        double x = across_.end;
        for (std::size_t l = chart_.lines.size(); l-- > 0;) {
            const std::string& name = chart_.lines[l].name;
            if (name.empty()) continue;
            x -= sheet_.width_of(name);
            set_colour(cairo(), ink);
            const double y = up_.end - 0.8 * font_;
            sheet_.write(x, y, name);
            cairo_save(cairo());
            set_style(l);
            cairo_set_line_width(cairo(), 1.8 * line_);
            stroke(x - 2.4 * font_, y - 0.36 * font_, x - 0.5 * font_, y - 0.36 * font_);
            cairo_restore(cairo());
            x -= 3.6 * font_;
        }
    }

    const Chart& chart_;
    Sheet sheet_;
    double font_;
    double line_;
    Axis across_;
    Axis up_;
};

}  // namespace

Colour chart_colour(std::size_t i) {
    static constexpr std::array<Colour, 5> colours{{{0.0F, 0.45F, 0.70F},
                                                    {0.84F, 0.37F, 0.0F},
                                                    {0.0F, 0.62F, 0.45F},
                                                    {0.80F, 0.47F, 0.65F},
                                                    {0.35F, 0.35F, 0.38F}}};
    return colours[i % colours.size()];
}

Image draw_chart(const Chart& chart, int width, int height) {
    check(chart, width, height);
    return ChartPage(chart, width, height).draw();
}

}  // namespace beltrami
