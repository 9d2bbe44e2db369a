// A few of the lowest pairs, to low accuracy, from coarse levels of the mesh to fine ones: in the style of HSIM
// (Nasikun & Hildebrandt, "The Hierarchical Subspace Iteration Method for Laplace-Beltrami Eigenproblems", ACM
// Transactions on Graphics 2022).
//
// The pairs of a coarse level, a few more than are wanted, are interpolated to the next finer one, solved for once with
// K - shift M and made a Rayleigh-Ritz basis. Pairs whose residual is still too large are solved for again; unlike in
// HSIM the basis keeps what it had and grows by these (a block Krylov space), which takes far fewer solves.
#pragma once

#include "beltrami/solvers/spectrum.hpp"

namespace beltrami {

/// As spectrum() with SpectrumMethod::hierarchical, in one band; fills what it knows of the summary, where factorizations
/// and columns are those of the mesh and coarse levels count as seconds only. Where more than about a third of all pairs
/// are asked for it leaves them to another method, and the summary says so. Throws InputError without a hierarchy or for another mesh's, with options.from > 0 and with options.resume.
void spectrum_hierarchically(const Eigenproblem& problem, const SpectrumOptions& options,
                             const BandSink& sink, SpectrumSummary& summary);

}  // namespace beltrami
