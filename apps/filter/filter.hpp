// Filtering what lies on a mesh in frequency space.
//
//     const StoredBasis basis("BASIS");
//     const FilterCurve curve = parse_filter("low-pass:20e", {mesh_edge, &basis.eigenvalues()});
//     const Block field = filter_field(mesh, FilterTarget::positions);
//     const Mesh smooth = filtered(mesh, FilterTarget::positions, HarmonicFilter(basis, field).apply(curve));
#pragma once

#include <string>
#include <string_view>

#include "beltrami/solvers/harmonic_transform.hpp"

namespace beltrami {

/// What frequencies in a filter's text may refer to.
struct FilterUnits {
    double mean_edge = 0.0;               ///< for "20e"
    const Vector* eigenvalues = nullptr;  ///< for "#100"; may be null
};

/// NAME:NUMBERS, where a frequency is a number (radians a unit of length), `20e` (waves of 20 mean edges) or `#100` (the
/// frequency of pair 100, counted from 0):
///
/// | low-pass:PASS[,STOP]      | 1 up to PASS, 0 from STOP (default: 1.25 PASS)           |
/// | high-pass:STOP[,PASS]     | 0 up to STOP, 1 from PASS (default: 1.25 STOP)           |
/// | band:LOW,HIGH             | 1 between, 0 outside                                     |
/// | notch:LOW,HIGH            | 0 between, 1 outside                                     |
/// | enhance:LOW,HIGH,GAIN     | 1 up to LOW, GAIN from HIGH                              |
/// | exaggerate:LOW,HIGH,GAIN  | GAIN between, 1 outside                                  |
/// | curve:W=G,W=G,...         | through these points, linear between them                |
/// | identity                  | 1                                                        |
///
/// Throws InputError that quotes what cannot be understood.
FilterCurve parse_filter(std::string_view text, const FilterUnits& units);
/// One frequency of the three kinds.
double parse_frequency(std::string_view text, const FilterUnits& units);

enum class FilterTarget { positions, normals, colors, field };

/// What is filtered, vertices x columns: positions, unit normals, the field `color`, or the field of that name. Throws
/// InputError where the mesh has none.
Block filter_field(const Mesh& mesh, FilterTarget target, const std::string& name = {});

/// The mesh with the filtered positions, or with the field `normal` (of unit length again), `color` (within 0 to 1) or
/// `name` replaced.
Mesh filtered(const Mesh& mesh, FilterTarget target, Block field, const std::string& name = {});

/// The volume that a closed surface of triangles encloses; 0 for other meshes.
double enclosed_volume(const Mesh& mesh);

}  // namespace beltrami
