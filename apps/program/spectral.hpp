// What the spectral commands share: which operator, the folder of a basis, the summary of a spectrum.
#pragma once

#include "run.hpp"

namespace beltrami::program {

struct OperatorOptions {
    std::string mass = "lumped";
    std::string laplacian = "dec";
    bool hold_boundary = false;
    std::vector<Index> hold = {};
};
/// Declares --mass, --laplacian, --hold-boundary and --hold.
void add_operator_options(CLI::App& command, OperatorOptions& options);

/// The eigenproblem of a mesh, made as the options say.
struct SpectralProblem {
    Laplacian laplacian;
    Eigenproblem problem;
    BasisOperator description;
};
SpectralProblem spectral_problem(Run& run, const Mesh& mesh, const OperatorOptions& options);

struct SpectrumCommandOptions {
    std::string method = "auto";
    double tolerance = 1e-8;
    std::string memory;
    int band = 0;
};
/// Declares --method, --tolerance, --memory and --band.
void add_spectrum_options(CLI::App& command, SpectrumCommandOptions& options);
/// For a spectrum of the mesh's Laplacian. `scratch`: where a factor that does not fit lies.
SpectrumOptions spectrum_options(Run& run, const SpectrumCommandOptions& options, const Mesh& mesh,
                                 const Laplacian& laplacian, const std::filesystem::path& scratch);

void record(Run& run, const SpectrumSummary& summary);

/// Declares --basis, which must be given.
void add_basis_option(CLI::App& command, std::string& folder);
/// Opens the basis, which must be the mesh's, and says what it is. Warns where it is not complete.
StoredBasis open_basis(Run& run, const std::string& folder, const Mesh& mesh);

/// What --on names.
struct NamedTarget {
    FilterTarget kind = FilterTarget::positions;
    std::string field = {};
};
NamedTarget target_of(const std::string& on);
/// Its values: positions, normals, colors or a field, vertices x columns.
Block field_on(const Mesh& mesh, const std::string& what);

}  // namespace beltrami::program
