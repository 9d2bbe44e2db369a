#include "beltrami/apps/picture/lettering.hpp"

#include <algorithm>
#include <cmath>

#include "beltrami/apps/picture/sheet.hpp"
#include "beltrami/apps/picture/ticks.hpp"

namespace beltrami {

Image draw_title(const std::string& text, int width, double font) {
    const double margin = 0.8 * font;
    Sheet sheet(width, static_cast<int>(std::ceil(1.9 * font)));
    sheet.set_font(font);
    const double room = width - 2.0 * margin;
    const double length = sheet.width_of(text);
    if (length > room) sheet.set_font(font * std::max(0.5, room / length));
    sheet.write(margin, 1.45 * font, text);
    return sheet.image();
}

Image draw_colour_bar(const ColourScale& scale, int height, double font) {
    const double bar_width = std::round(1.1 * font);
    const double bar_height = std::round(std::max(0.62 * height, std::min(6.0 * font, height - 4.0 * font)));
    const double top = std::round(0.5 * (height - bar_height));
    const double tick = 0.35 * font;
    const double rim = 0.8 * font;
    const int wanted = std::clamp(static_cast<int>(bar_height / (2.8 * font)), 1, 8);
    const Ticks ticks = ticks_between(scale.low(), scale.high(), wanted);

    Sheet measure(1, 1);
    measure.set_font(font);
    double text_width = measure.width_of(ticks.factor) - bar_width - tick;
    for (const Tick& t : ticks.ticks)
        text_width = std::max(text_width, measure.width_of(t.label));

    Sheet sheet(static_cast<int>(std::ceil(bar_width + 2.0 * tick + text_width + rim)), height);
    sheet.set_font(font);
    cairo_t* const cairo = sheet.cairo();
    const bool constant = scale.low() == scale.high();
    for (int row = 0; row < static_cast<int>(bar_height); ++row) {
        const double s = (row + 0.5) / bar_height;
        const Colour c = scale.colour((1.0 - s) * scale.high() + s * scale.low());
        cairo_set_source_rgb(cairo, c[0], c[1], c[2]);
        cairo_rectangle(cairo, 0.0, top + row, bar_width, 1.0);
        cairo_fill(cairo);
    }
    cairo_set_source_rgb(cairo, 0.13, 0.13, 0.15);
    const double line = std::max(1.0, std::round(font / 16.0));
    cairo_set_line_width(cairo, line);
    for (const Tick& t : ticks.ticks) {
        const double s =
            constant ? 0.5 : (0.5 * scale.high() - 0.5 * t.value) / (0.5 * scale.high() - 0.5 * scale.low());
        const double y =
            std::clamp(std::round(top + s * bar_height - 0.5 * line), top, top + bar_height - line) +
            0.5 * line;
        cairo_move_to(cairo, bar_width, y);
        cairo_line_to(cairo, bar_width + tick, y);
        cairo_stroke(cairo);
        sheet.write(bar_width + 2.0 * tick, y + 0.36 * font, t.label);
    }
    if (!ticks.factor.empty()) sheet.write(0.0, top - 0.8 * font, ticks.factor);
    return sheet.image();
}

}  // namespace beltrami
