// The spectrum of a shape as a table and as a chart.
//
//     const SpectrumTable table = spectrum_table(basis, area, CellKind::triangle, &colours);
//     write_whole("spectrum.csv", [&](std::ostream& out) { out << to_csv(table); });
//     write_picture("spectrum.png", draw_spectrum(table, "bunny"));
#pragma once

#include <string>
#include <vector>

#include "beltrami/apps/picture/chart.hpp"
#include "beltrami/apps/picture/image.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/solvers/spectral_signature.hpp"

namespace beltrami {

/// One row a function, from number 0.
struct SpectrumTable {
    CellKind kind = CellKind::triangle;
    double measure = 0.0;  ///< of the shape: length, area or volume
    Vector eigenvalues;    ///< 1/length^2; those of zero modes are 0
    Vector frequencies;    ///< sqrt(lambda), radians a unit of length
    Vector wavelengths;    ///< 2 pi / frequency, infinite for zero modes
    Vector by_measure;     ///< lambda measure^(2/dimension): shape DNA
    Vector by_first;       ///< lambda over the first that is not 0; NaN where there is none
    Vector weyl;           ///< what Weyl's law has on average
    Vector amplitudes;     ///< |x~_k| of a field, if there is one
    Vector errors;  ///< relative, of the field made of the functions up to this: reconstruction_errors()
};

/// kind: of the mesh's cells, 1, 2 or 3 dimensions; measure: of all of them. field: vertices x columns, or nothing. Throws
/// InputError for a field of other rows, and points.
SpectrumTable spectrum_table(const StoredBasis& basis, double measure, CellKind kind, const Block* field,
                             const Progress* progress = nullptr);

/// A header line, then a line a function, numbers to the last bit: number, eigenvalue, frequency, wavelength,
/// eigenvalue_length2 (eigenvalue_area, eigenvalue_volume23), eigenvalue_ratio, weyl and, with a field, amplitude, error.
std::string to_csv(const SpectrumTable& table);

/// Eigenvalues over their numbers with Weyl's law; with a field also its amplitude at each, over the largest, and the
/// relative error of what is made of the functions so far.
std::vector<Chart> spectrum_charts(const SpectrumTable& table, const std::string& title);

/// Eigenvalues over their numbers with Weyl's law; below it, with a field, amplitude over that of the largest and relative
/// error on a logarithmic axis.
Image draw_spectrum(const SpectrumTable& table, const std::string& title);

}  // namespace beltrami
