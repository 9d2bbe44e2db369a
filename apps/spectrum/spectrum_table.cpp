#include "beltrami/apps/spectrum/spectrum_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "beltrami/apps/picture/chart.hpp"
#include "beltrami/apps/picture/picture.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

int dimension(CellKind kind) {
    return static_cast<int>(kind) - 1;
}

const char* measure_column(CellKind kind) {
    switch (kind) {
        case CellKind::segment:
            return "eigenvalue_length2";
        case CellKind::tetrahedron:
            return "eigenvalue_volume23";
        default:
            return "eigenvalue_area";
    }
}

}  // namespace

SpectrumTable spectrum_table(const StoredBasis& basis, double measure, CellKind kind, const Block* field,
                             const Progress* progress) {
    SpectrumTable table;
    table.kind = kind;
    table.measure = measure;
    table.eigenvalues = clean_eigenvalues(basis);
    table.by_measure = shape_dna(table.eigenvalues, measure, dimension(kind));
    table.frequencies = table.eigenvalues.cwiseSqrt();
    table.wavelengths = 2.0 * std::numbers::pi * table.frequencies.cwiseInverse();
    const Eigen::Index n = table.eigenvalues.size();
    table.by_first = Vector::Constant(n, std::numeric_limits<double>::quiet_NaN());
    table.weyl.resize(n);
    for (Eigen::Index k = 0; k < n; ++k)
        table.weyl[k] = weyl_eigenvalue(static_cast<double>(k), measure, dimension(kind));
    for (const double value : table.eigenvalues) {
        if (!(value > 0.0)) continue;
        table.by_first = table.eigenvalues / value;
        break;
    }
    if (field != nullptr) {
        ReconstructionErrors errors = reconstruction_errors(basis, *field, progress);
        table.amplitudes = std::move(errors.amplitudes);
        table.errors = std::move(errors.relative);
    }
    return table;
}

std::string to_csv(const SpectrumTable& table) {
    const bool with_field = table.amplitudes.size() > 0;
    std::string text = fmt::format("number,eigenvalue,frequency,wavelength,{},eigenvalue_ratio,weyl{}\n",
                                   measure_column(table.kind), with_field ? ",amplitude,error" : "");
    for (Eigen::Index k = 0; k < table.eigenvalues.size(); ++k) {
        fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{}", k, table.eigenvalues[k],
                       table.frequencies[k], table.wavelengths[k], table.by_measure[k], table.by_first[k],
                       table.weyl[k]);
        if (with_field)
            fmt::format_to(std::back_inserter(text), ",{},{}", table.amplitudes[k], table.errors[k]);
        text += '\n';
    }
    return text;
}

std::vector<Chart> spectrum_charts(const SpectrumTable& table, const std::string& title) {
    const Eigen::Index n = table.eigenvalues.size();
    const Vector numbers = Vector::LinSpaced(n, 0.0, static_cast<double>(n - 1));
    std::vector<Chart> charts = {
        {.title = title,
         .across = "number",
         .up = "eigenvalue",
         .lines = {{.name = "eigenvalues", .x = numbers, .y = table.eigenvalues},
                   {.name = "Weyl's law", .x = numbers, .y = table.weyl, .dashed = true}}}};
    if (table.amplitudes.size() == 0) return charts;
    const double largest = table.amplitudes.maxCoeff();
    const Vector amplitudes = table.amplitudes / (largest > 0.0 ? largest : 1.0);
    charts.push_back({.title = {},
                      .across = "number",
                      .up = "amplitude over the largest, error over the field",
                      .logarithmic = true,
                      .lines = {{.name = "amplitude", .x = numbers, .y = amplitudes},
                                {.name = "relative error", .x = numbers, .y = table.errors}}});
    return charts;
}

Image draw_spectrum(const SpectrumTable& table, const std::string& title) {
    std::vector<Image> images;
    for (const Chart& chart : spectrum_charts(table, title))
        images.push_back(draw_chart(chart, 1000, 480));
    return side_by_side(images, 1);
}

}  // namespace beltrami
