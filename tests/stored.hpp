// A basis on disk for tests.
#pragma once

#include <algorithm>
#include <filesystem>

#include "beltrami/solvers/spectrum.hpp"
#include "beltrami/solvers/stored_basis.hpp"

namespace beltrami::testing {

/// The mesh's lowest `count` functions in that folder, all of them for 0; 0 at the held vertices (the user's order).
inline StoredBasis stored_basis(const std::filesystem::path& folder, const Mesh& mesh, Index count,
                                const Constraints& held = Constraints(), NpyType type = NpyType::float64) {
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian, laplacian.order().to_working(held));
    BasisWriter writer(folder, mesh, laplacian, problem, {.held = fingerprint(held)}, {.type = type});
    SpectrumOptions options{.count = count > 0 ? count : problem.rows()};
    if (count > 0) options.band = std::max<Index>(count / 3, 4);  // so that there is more than one
    writer.finish(spectrum(problem, options, writer.sink()));
    return StoredBasis(folder);
}

}  // namespace beltrami::testing
