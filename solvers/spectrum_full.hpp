// All eigenpairs of a small problem, by a dense solver.
#pragma once

#include "beltrami/solvers/spectrum.hpp"

namespace beltrami {

/// As spectrum() with SpectrumMethod::full, in one band; fills what it knows of the summary. Takes 24 rows^2 bytes.
void spectrum_in_full(const Eigenproblem& problem, const SpectrumOptions& options, const BandSink& sink,
                      SpectrumSummary& summary);

}  // namespace beltrami
