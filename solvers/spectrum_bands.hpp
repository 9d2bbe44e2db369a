// The spectrum band by band: a shift inside each band, block Lanczos around it, and an end in a gap behind it.
#pragma once

#include "beltrami/solvers/spectrum.hpp"

namespace beltrami {

/// As spectrum() with SpectrumMethod::bands; fills what it knows of the summary.
void spectrum_by_bands(const Eigenproblem& problem, const SpectrumOptions& options, const BandSink& sink,
                       SpectrumSummary& summary);

}  // namespace beltrami
