// The five discrete Laplacians that Figure 2 of Vallet & Levy 2008 compares.
//
//     const Laplacian A = spectral_laplacian(mesh, SpectralLaplacian::combinatorial);
//
// Each is a pair of a stiffness and a mass in the working order, so that every solver takes it. Only the last keeps
// functions both independent of the mesh's density and orthogonal; the others are for comparison.
#pragma once

#include <string_view>

#include "beltrami/framework/mesh.hpp"
#include "beltrami/operators/laplacian.hpp"

namespace beltrami {

enum class SpectralLaplacian {
    combinatorial,  ///< A: -1 for every edge; mass 1
    cotangent,      ///< B: (cot a + cot b) / 2, unweighted; mass 1
    weighted,  ///< C: (cot a + cot b) / (2 A_i): not symmetric. Its functions are those of `dec`, but taken to be
               ///< orthogonal without the mass, as they are not
    symmetrized,  ///< D: (cot a + cot b) / (A_i + A_j); mass 1
    dec           ///< E: (cot a + cot b) / (2 sqrt(A_i A_j)), which is K h = lambda M h
};
std::string_view name(SpectralLaplacian kind);

/// Isolated vertices have the mass 0 in all five. Throws InputError as Laplacian does.
Laplacian spectral_laplacian(const Mesh& mesh, SpectralLaplacian kind, Mass mass = Mass::barycentric);

}  // namespace beltrami
