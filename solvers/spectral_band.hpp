// What all spectrum solvers share: a set of pairs between two ends becomes a certified band.
#pragma once

#include "beltrami/solvers/spectrum.hpp"

namespace beltrami {

/// Eigenpairs as a solver found them: values ascending, vectors rows x values.size().
struct Eigenpairs {
    Vector values;
    Columns vectors;
};

/// |K h - lambda M h| / (max(|lambda|, zero_scale) |M h|) of each pair, in the 2-norm.
Vector residuals(const Eigenproblem& problem, const Vector& values, const Columns& vectors,
                 double zero_scale);

/// X^T M Y and X^T M X.
Columns mass_product(const Eigenproblem& problem, const Columns& X, const Columns& Y);
Columns mass_gram(const Eigenproblem& problem, const Columns& X);

/// Makes the vectors M-orthonormal among each other and to those of the band before it (rows x any; may be empty), and
/// measures residuals and orthogonality. `zero_scale`: what residuals of zero modes are taken relative to.
SpectralBand make_band(const Eigenproblem& problem, Eigenpairs pairs, const SpectrumEnd& lower,
                       const SpectrumEnd& upper, const Columns& before, double zero_scale);

/// So many of its lowest pairs.
void keep(SpectralBand& band, Index kept);

/// What a solver takes that holds so many columns besides the factor.
SpectrumPlan plan_of(const Eigenproblem& problem, const ShiftInvert& pencil, double columns);

/// Where the eigenvalue of that number lies about, by Weyl's law with the constants of even meshes: to start from.
double estimated_eigenvalue(const Eigenproblem& problem, double number);

}  // namespace beltrami
