// Lines over numbers on white paper, with axes, round numbers beside them and a legend.
//
//     Chart chart{.title = "eigenvalues", .across = "number", .up = "eigenvalue", .lines = {{"measured", x, y}}};
//     write_picture("chart.png", draw_chart(chart, 900, 420));
#pragma once

#include <string>
#include <vector>

#include "beltrami/apps/picture/colour_map.hpp"
#include "beltrami/apps/picture/image.hpp"
#include "beltrami/framework/types.hpp"

namespace beltrami {

struct ChartLine {
    std::string name;  ///< in the legend, UTF-8; none where it is empty
    Vector x;
    Vector y;
    bool dashed = false;
};

struct Chart {
    std::string title;
    std::string across;        ///< what the horizontal axis is
    std::string up;            ///< what the vertical one is
    bool logarithmic = false;  ///< the vertical axis, in powers of ten
    std::vector<ChartLine> lines;
};

/// The colour of line number i: dark enough on white, told apart by colour-blind eyes (Okabe & Ito 2008).
Colour chart_colour(std::size_t i);

/// Values that are not finite, and those not above 0 on a logarithmic axis, are gaps in their line. Throws InputError for
/// sizes below 160 x 120 pixels or above what draw() takes, and for x and y of different lengths. The axes hold every
/// value that is drawn; without any they are from 0 to 1 (1 to 10).
Image draw_chart(const Chart& chart, int width, int height);

}  // namespace beltrami
