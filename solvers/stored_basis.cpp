#include "beltrami/solvers/stored_basis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <ostream>
#include <system_error>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/write_mesh.hpp"
#include "beltrami/solvers/band_json.hpp"

namespace beltrami {

namespace fs = std::filesystem;

namespace {

constexpr const char* format_name = "beltrami basis";
constexpr int format_version = 1;

// FNV-1a.
class Hash {
  public:
    void add(const void* data, std::size_t size) {
        const auto* const bytes = static_cast<const unsigned char*>(data);
        for (std::size_t i = 0; i < size; ++i)
            value_ = (value_ ^ bytes[i]) * 1099511628211ULL;
    }
    template <class Array>
    void add_array(const Array& array) {
        add(array.data(), sizeof(*array.data()) * static_cast<std::size_t>(array.size()));
    }
    [[nodiscard]] std::uint64_t value() const { return value_; }

  private:
    std::uint64_t value_ = 14695981039346656037ULL;
};

fs::path band_file(const fs::path& folder, std::size_t band) {
    return folder / fmt::format("band-{:05}.npy", band);
}

std::string in_hex(std::uint64_t number) {
    return fmt::format("{:016x}", number);
}
std::uint64_t from_hex(const std::string& text) {
    return std::stoull(text, nullptr, 16);
}

double mean_edge_length(const Mesh& mesh, const Laplacian& laplacian) {
    const EdgeGraph& graph = laplacian.graph();
    double sum = 0.0;
    for (Index v = 0; v < graph.vertex_count(); ++v) {
        const auto p = mesh.points().row(laplacian.order().user(v));
        for (const EdgeGraph::Neighbour n : graph.neighbours(v)) {
            if (n.vertex > v) sum += (mesh.points().row(laplacian.order().user(n.vertex)) - p).norm();
        }
    }
    return sum / std::max<Index>(graph.edge_count(), 1);
}

// The entries of M beside its diagonal, in the user's order: vertex, vertex, value.
// vertices: the user's of each unknown.
Block mass_edges(const Eigenproblem& problem, const std::vector<Index>& vertices) {
    const auto& M = problem.consistent_mass();
    Block edges((M.nonZeros() - M.rows()) / 2, 3);
    Eigen::Index at = 0;
    const auto user = [&](Eigen::Index unknown) { return vertices[static_cast<std::size_t>(unknown)]; };
    for (Eigen::Index row = 0; row < M.rows(); ++row) {
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(M, row); entry; ++entry) {
            if (entry.col() > row) edges.row(at++) << user(row), user(entry.col()), entry.value();
        }
    }
    return edges.topRows(at);
}

}  // namespace

std::uint64_t fingerprint(const Mesh& mesh) {
    Hash hash;
    hash.add_array(mesh.points());
    hash.add_array(mesh.cells());
    return hash.value();
}

std::uint64_t fingerprint(const Constraints& held) {
    if (held.empty()) return 0;
    std::vector<Index> vertices = held.vertices();
    std::sort(vertices.begin(), vertices.end());
    Hash hash;
    hash.add_array(vertices);
    return hash.value();
}

StoredBasis::StoredBasis(fs::path folder) : folder_(std::move(folder)) {
    const fs::path manifest = folder_ / "manifest.json";
    const auto damaged = [&](const std::string& what) {
        return InputError(fmt::format("{}: {}", manifest.string(), what),
                          "make the basis anew with beltrami harmonics");
    };
    if (!fs::is_directory(folder_)) {
        throw InputError(folder_.string() + " is not a folder with a basis",
                         "make one with beltrami harmonics");
    }
    std::ifstream stream(manifest);
    if (!stream) throw damaged("the file cannot be read, so the folder is not a basis");
    try {
        const auto json = nlohmann::json::parse(stream);
        if (json.at("format") != format_name) throw damaged("the folder is not a basis");
        if (json.at("version") != format_version) {
            throw damaged(fmt::format("it is of version {}, this program reads version {}",
                                      json.at("version").dump(), format_version));
        }
        vertex_count_ = json.at("mesh").at("vertices");
        fingerprint_ = from_hex(json.at("mesh").at("fingerprint"));
        mean_edge_ = json.at("mesh").at("mean_edge");
        operator_.weights = json.at("operator").at("weights");
        operator_.mass = json.at("operator").at("mass");
        operator_.held = from_hex(json.at("operator").at("held"));
        const auto& certificate = json.at("certificate");
        complete_ = certificate.at("complete");
        max_residual_ = certificate.at("max_residual");
        max_orthogonality_error_ = certificate.at("max_orthogonality_error");
        zero_modes_ = certificate.at("zero_modes");
        for (const auto& band : certificate.at("bands"))
            certificates_.push_back(band.get<BandCertificate>());
    } catch (const nlohmann::json::exception& error) {
        throw damaged(error.what());
    } catch (const std::logic_error&) {
        throw damaged("a fingerprint is not a number");
    }
    const auto require = [&](const char* name, const NpyArray& array, Eigen::Index rows,
                             Eigen::Index columns) {
        if (array.rows() >= rows && array.columns() == columns) return;
        throw damaged(fmt::format("{} is {} x {}, but should be {} x {}", name, array.rows(), array.columns(),
                                  rows, columns));
    };
    Index pairs = 0;
    for (std::size_t b = 0; b < certificates_.size(); ++b) {
        const fs::path file = band_file(folder_, b);
        bands_.emplace_back(file);
        const Index kept = certificates_[b].kept;
        if (bands_.back().rows() != kept) {
            throw damaged(fmt::format("{} holds {} pairs, but should hold {}", file.filename().string(),
                                      bands_.back().rows(), kept));
        }
        require(file.filename().c_str(), bands_.back(), kept, vertex_count_);
        pairs += kept;
    }
    const NpyArray values(folder_ / "eigenvalues.npy");
    // A run that was stopped between the two files leaves one band more here than the manifest lists.
    require("eigenvalues.npy", values, pairs, 1);
    eigenvalues_ = values.values().col(0).head(pairs);
    const NpyArray mass(folder_ / "mass.npy");
    require("mass.npy", mass, vertex_count_, 1);
    mass_ = mass.values().col(0);
    if (operator_.mass == "consistent") mass_edges_ = NpyArray(folder_ / "mass-edges.npy").values();
}

Block StoredBasis::apply_mass(const Block& x) const {
    if (x.rows() != vertex_count_) {
        throw InputError(
            fmt::format("a field of {} rows meets a basis of {} vertices", x.rows(), vertex_count_),
            "give one row a vertex");
    }
    Block y = mass_.asDiagonal() * x;
    for (Eigen::Index e = 0; e < mass_edges_.rows(); ++e) {
        const auto i = static_cast<Index>(mass_edges_(e, 0));
        const auto j = static_cast<Index>(mass_edges_(e, 1));
        y.row(i) += mass_edges_(e, 2) * x.row(j);
        y.row(j) += mass_edges_(e, 2) * x.row(i);
    }
    return y;
}

Vector StoredBasis::function(Index i) const {
    if (i < 0 || i >= count()) {
        throw InputError(fmt::format("the basis has no function {}: it has {}", i, count()),
                         "count from 0, in ascending order of the eigenvalues");
    }
    for (const NpyArray& band : bands_) {
        if (i < band.rows()) {
            if (band.type() == NpyType::float64)
                return Eigen::Map<const Vector>(band.row<double>(i), vertex_count_);
            return Eigen::Map<const Eigen::VectorXf>(band.row<float>(i), vertex_count_).cast<double>();
        }
        i -= static_cast<Index>(band.rows());
    }
    return {};
}

void StoredBasis::check(const Mesh& mesh) const {
    if (mesh.vertex_count() == vertex_count_ && beltrami::fingerprint(mesh) == fingerprint_) return;
    throw InputError(
        fmt::format(
            "{} is the basis of another mesh: of {} vertices with the fingerprint {}, not of {} with {}",
            folder_.string(), vertex_count_, in_hex(fingerprint_), mesh.vertex_count(),
            in_hex(beltrami::fingerprint(mesh))),
        "name the mesh that the basis was made for, or make a basis of this one with beltrami harmonics");
}

BasisWriter::BasisWriter(fs::path folder, const Mesh& mesh, const Laplacian& laplacian,
                         const Eigenproblem& problem, BasisOperator of, const BasisWriterOptions& options)
    : folder_(std::move(folder)),
      problem_(problem),
      vertices_(user_vertices(problem, laplacian.order())),
      of_(std::move(of)),
      options_(options),
      fingerprint_(fingerprint(mesh)),
      mean_edge_(mean_edge_length(mesh, laplacian)) {
    std::error_code error;
    const bool there = fs::exists(folder_ / "manifest.json", error);
    if (there && !options.resume) {
        throw InputError(folder_.string() + " holds a basis already",
                         "go on with it by --resume, or name another folder");
    }
    if (!there && fs::exists(folder_, error) &&
        (!fs::is_directory(folder_, error) || !fs::is_empty(folder_, error))) {
        // A run that was killed before its first band leaves no manifest.
        if (!options.resume || !fs::exists(folder_ / "mass.npy", error)) {
            throw InputError(folder_.string() + " is there already and is not a basis",
                             "name a folder that does not exist");
        }
    }
    fs::create_directories(folder_, error);
    if (error) {
        throw InputError(fmt::format("the folder {} cannot be made: {}", folder_.string(), error.message()),
                         "name a folder in a place that can be written");
    }
    // What a killed run was writing.
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
        if (entry.path().extension() == ".part") fs::remove(entry.path(), error);
    }
    if (there) {
        const StoredBasis basis(folder_);
        basis.check(mesh);
        if (!(basis.of_operator() == of_)) {
            throw InputError(folder_.string() + " is the basis of another operator",
                             fmt::format("it was made with {} weights and {} mass; give the same options",
                                         basis.of_operator().weights, basis.of_operator().mass));
        }
        if (!basis.bands().empty() && basis.bands().front().type() != options.type) {
            throw InputError(folder_.string() + " stores its functions in another precision",
                             "give the same options as before");
        }
        certificates_ = basis.certificates();
        eigenvalues_.assign(basis.eigenvalues().begin(), basis.eigenvalues().end());
        max_orthogonality_error_ = basis.max_orthogonality_error();
        complete_ = basis.complete();
    }
    Vector mass = Vector::Zero(mesh.vertex_count());
    for (Index i = 0; i < problem.rows(); ++i) {
        mass[vertices_[static_cast<std::size_t>(i)]] = options.plain_product ? 1.0
                                                       : problem.lumped()
                                                           ? problem.lumped_mass()[i]
                                                           : problem.consistent_mass().coeff(i, i);
    }
    write_npy(folder_ / "mass.npy", mass);
    if (!problem.lumped()) write_npy(folder_ / "mass-edges.npy", mass_edges(problem, vertices_));
}

void BasisWriter::set_resume() {
    resume_.reset();
    if (certificates_.empty()) return;
    const Block functions = NpyArray(band_file(folder_, certificates_.size() - 1)).values();
    Columns before = functions(Eigen::all, vertices_).transpose();
    Columns weighted;
    problem_.apply_mass(before, weighted);
    // Stored in another norm, or in fewer digits.
    before *= before.cwiseProduct(weighted).colwise().sum().cwiseSqrt().cwiseInverse().asDiagonal();
    resume_ =
        SpectrumResume{certificates_.back(), std::move(before), static_cast<Index>(certificates_.size())};
}

Index BasisWriter::present() const {
    return static_cast<Index>(eigenvalues_.size());
}

bool BasisWriter::satisfies(const SpectrumOptions& options) const {
    if (!complete_ || certificates_.empty()) return false;
    if (options.count > 0) return present() >= options.count;
    return certificates_.back().upper.value >= options.cutoff * options.cutoff &&
           certificates_.back().kept == certificates_.back().found;
}

SpectrumOptions BasisWriter::continued(SpectrumOptions options) {
    // A last band that was cut off at the count asked for is found again.
    if (!certificates_.empty() && certificates_.back().kept < certificates_.back().found) {
        eigenvalues_.resize(eigenvalues_.size() - static_cast<std::size_t>(certificates_.back().kept));
        certificates_.pop_back();
    }
    set_resume();
    complete_ = false;
    options.resume = resume_ ? &*resume_ : nullptr;
    return options;
}

double BasisWriter::disk_bytes(Index pairs) const {
    const double width = options_.type == NpyType::float64 ? 8.0 : 4.0;
    return width * pairs * problem_.vertex_count();
}

void BasisWriter::add(const SpectralBand& band) {
    Block functions = Block::Zero(band.vectors.cols(), problem_.vertex_count());
#pragma omp parallel for schedule(dynamic, 1)
    for (Eigen::Index k = 0; k < functions.rows(); ++k) {
        for (Index i = 0; i < problem_.rows(); ++i)
            functions(k, vertices_[static_cast<std::size_t>(i)]) = band.vectors(i, k);
    }
    if (options_.plain_product) functions.rowwise().normalize();
    write_npy(band_file(folder_, certificates_.size()), functions, options_.type);
    eigenvalues_.insert(eigenvalues_.end(), band.values.begin(), band.values.end());
    write_npy(folder_ / "eigenvalues.npy",
              Vector(Eigen::Map<const Vector>(eigenvalues_.data(),
                                              static_cast<Eigen::Index>(eigenvalues_.size()))));
    certificates_.push_back(band.certificate);
    max_orthogonality_error_ = std::max(max_orthogonality_error_, band.certificate.max_orthogonality_error);
    write_manifest();
}

void BasisWriter::finish(const SpectrumSummary& summary) {
    complete_ = summary.complete;
    max_orthogonality_error_ = std::max(max_orthogonality_error_, summary.max_orthogonality_error);
    write_manifest();
}

void BasisWriter::write_manifest() const {
    nlohmann::json bands = nlohmann::json::array();
    double residual = 0.0;
    for (const BandCertificate& band : certificates_) {
        bands.push_back(band);
        residual = std::max(residual, band.max_residual);
    }
    const double zero = certificates_.empty() ? 0.0 : 1e-9 * certificates_.front().upper.value;
    const auto zeros = std::count_if(eigenvalues_.begin(), eigenvalues_.end(),
                                     [&](double v) { return std::abs(v) <= zero; });
    const nlohmann::json json = {
        {"format", format_name},
        {"version", format_version},
        {"mesh",
         {{"vertices", problem_.vertex_count()},
          {"fingerprint", in_hex(fingerprint_)},
          {"mean_edge", mean_edge_}}},
        {"operator", {{"weights", of_.weights}, {"mass", of_.mass}, {"held", in_hex(of_.held)}}},
        {"pairs", eigenvalues_.size()},
        {"type", options_.type == NpyType::float64 ? "float64" : "float32"},
        {"certificate",
         {{"complete", complete_},
          {"max_residual", residual},
          {"max_orthogonality_error", max_orthogonality_error_},
          {"zero_modes", zeros},
          {"components", problem_.constants().cols()},
          {"bands", bands}}}};
    write_whole(folder_ / "manifest.json", [&](std::ostream& stream) { stream << json.dump(2) << '\n'; });
}

}  // namespace beltrami
