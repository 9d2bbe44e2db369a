// A basis of eigenfunctions in a folder that NumPy opens without our code, and that any number of runs can fill.
//
//     BasisWriter writer("BASIS", mesh, laplacian, problem, description, {.resume = true});
//     spectrum(problem, writer.continued(options), writer.sink());
//     const StoredBasis basis("BASIS");                    // mapped, not read
//     basis.check(mesh);                                   // it is this mesh's
//
// | BASIS/manifest.json    | what there is: written last, so that what it lists is whole                        |
// | BASIS/eigenvalues.npy  | lambda of all pairs, ascending                                                     |
// | BASIS/band-00000.npy   | pairs x vertices, in the file's vertex order, float64 or float32; then band-00001  |
// | BASIS/mass.npy         | the lumped mass of each vertex, or the diagonal of the consistent one ...          |
// | BASIS/mass-edges.npy   | ... with its other entries: rows of vertex, vertex, value                          |
//
// Isolated and held vertices are 0 in every function. A band lands whole or not at all; the manifest names the mesh by a
// fingerprint of its points and cells, the operator, and the certificate of every band.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "beltrami/framework/npy.hpp"
#include "beltrami/solvers/spectrum.hpp"

namespace beltrami {

/// 64 bits over points and cells, in the file's order: two meshes with the same are the same.
std::uint64_t fingerprint(const Mesh& mesh);

/// What an eigenproblem was made of, in words: a basis is only continued and used where these are equal.
struct BasisOperator {
    std::string weights = "cotangent";
    std::string mass = "barycentric";  ///< "barycentric", "voronoi", "consistent", ...
    std::uint64_t held = 0;            ///< fingerprint of the held vertices; 0: none
    friend bool operator==(const BasisOperator&, const BasisOperator&) = default;
};
/// Of a set of vertices, in the user's order.
std::uint64_t fingerprint(const Constraints& held);

/// Read from a folder. Cheap to copy: the bands are mapped.
class StoredBasis {
  public:
    /// Throws InputError for a folder that is not a basis, and names the file that is missing or damaged.
    explicit StoredBasis(std::filesystem::path folder);

    [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
    /// Pairs.
    [[nodiscard]] Index count() const { return static_cast<Index>(eigenvalues_.size()); }
    [[nodiscard]] Index vertex_count() const { return vertex_count_; }
    /// Whether everything that the last run was asked for is there and certified.
    [[nodiscard]] bool complete() const { return complete_; }
    [[nodiscard]] const Vector& eigenvalues() const { return eigenvalues_; }
    /// vertex_count(): lumped, or the diagonal of the consistent mass.
    [[nodiscard]] const Vector& mass() const { return mass_; }
    /// M x in the file's vertex order, whichever mass it is.
    [[nodiscard]] Block apply_mass(const Block& x) const;
    [[nodiscard]] const BasisOperator& of_operator() const { return operator_; }
    [[nodiscard]] double mean_edge() const { return mean_edge_; }
    [[nodiscard]] Index zero_modes() const { return zero_modes_; }
    [[nodiscard]] double max_residual() const { return max_residual_; }
    [[nodiscard]] double max_orthogonality_error() const { return max_orthogonality_error_; }
    [[nodiscard]] const std::vector<BandCertificate>& certificates() const { return certificates_; }
    [[nodiscard]] std::uint64_t mesh_fingerprint() const { return fingerprint_; }

    /// Pairs x vertices each, one after the other.
    [[nodiscard]] const std::vector<NpyArray>& bands() const { return bands_; }
    /// Function number i, vertex_count() values.
    [[nodiscard]] Vector function(Index i) const;

    /// Throws InputError where the basis is of another mesh.
    void check(const Mesh& mesh) const;

  private:
    std::filesystem::path folder_;
    Index vertex_count_ = 0;
    bool complete_ = false;
    Vector eigenvalues_;
    Vector mass_;
    Block mass_edges_;
    BasisOperator operator_;
    double mean_edge_ = 0.0;
    Index zero_modes_ = 0;
    double max_residual_ = 0.0;
    double max_orthogonality_error_ = 0.0;
    std::vector<BandCertificate> certificates_;
    std::uint64_t fingerprint_ = 0;
    std::vector<NpyArray> bands_;
};

struct BasisWriterOptions {
    NpyType type = NpyType::float64;
    /// Go on with what is there. Without it a folder that holds a basis is refused.
    bool resume = false;
    /// Store functions of 2-norm 1 and a mass of 1, as if they were orthogonal without the mass: what Figure 2 C of
    /// Vallet & Levy 2008 warns of. For comparison only.
    bool plain_product = false;
};

/// Writes bands as they come.
class BasisWriter {
  public:
    /// Makes the folder. problem: of the laplacian, which is of the mesh. Throws InputError where the folder holds
    /// another basis or anything else, and where it cannot be written.
    BasisWriter(std::filesystem::path folder, const Mesh& mesh, const Laplacian& laplacian,
                const Eigenproblem& problem, BasisOperator of, const BasisWriterOptions& options);

    /// Pairs that are there already.
    [[nodiscard]] Index present() const;
    /// The options with `resume` set to where the folder ends; valid while the writer lives. The count is the whole
    /// basis's.
    [[nodiscard]] SpectrumOptions continued(SpectrumOptions options);
    /// Whether the folder has all that `options` ask for.
    [[nodiscard]] bool satisfies(const SpectrumOptions& options) const;
    /// Bytes that a basis of so many pairs takes.
    [[nodiscard]] double disk_bytes(Index pairs) const;

    /// Writes the band, then the eigenvalues, then the manifest.
    void add(const SpectralBand& band);
    [[nodiscard]] BandSink sink() {
        return [this](const SpectralBand& band) { add(band); };
    }
    /// Marks the basis as complete, with what the whole run found.
    void finish(const SpectrumSummary& summary);

  private:
    void write_manifest() const;
    void set_resume();

    std::filesystem::path folder_;
    const Eigenproblem& problem_;
    std::vector<Index> vertices_;  // the user's of each unknown
    BasisOperator of_;
    BasisWriterOptions options_;
    std::uint64_t fingerprint_;
    double mean_edge_;
    bool complete_ = false;
    double max_orthogonality_error_ = 0.0;
    Index zero_modes_ = 0;
    std::vector<double> eigenvalues_;
    std::vector<BandCertificate> certificates_;
    std::optional<SpectrumResume> resume_;
};

}  // namespace beltrami
