#include "spectral.hpp"

#include "beltrami/solvers/band_json.hpp"

#include "text.hpp"

namespace beltrami::program {

void add_operator_options(CLI::App& command, OperatorOptions& options) {
    command.add_option("--mass", options.mass, "lumped, voronoi or consistent (default: lumped)")
        ->check(CLI::IsMember({"lumped", "voronoi", "consistent"}))
        ->option_text("KIND");
    command
        .add_option("--laplacian", options.laplacian,
                    "dec, or for comparison combinatorial, cotangent, weighted or symmetrized (default: dec)")
        ->check(CLI::IsMember({"dec", "combinatorial", "cotangent", "weighted", "symmetrized"}))
        ->option_text("KIND");
    command.add_flag("--hold-boundary", options.hold_boundary, "functions are 0 on the boundary (Dirichlet)");
    command.add_option("--hold", options.hold, "functions are 0 at these vertices")->option_text("V ...");
}

namespace {

SpectralLaplacian kind_of(const std::string& text) {
    for (const auto kind : {SpectralLaplacian::combinatorial, SpectralLaplacian::cotangent,
                            SpectralLaplacian::weighted, SpectralLaplacian::symmetrized}) {
        if (text == name(kind)) return kind;
    }
    return SpectralLaplacian::dec;
}

Constraints held_vertices(const Mesh& mesh, const OperatorOptions& options) {
    Constraints held;
    for (const Index v : options.hold)
        held.fix(v, 0.0);
    held.check_range(mesh.vertex_count());
    if (!options.hold_boundary) return held;
    const std::vector<Index> boundary = boundary_vertices(mesh);
    if (boundary.empty())
        throw InputError("--hold-boundary on a mesh that has no boundary", "leave it out, or use --hold");
    for (const Index v : boundary)
        held.fix(v, 0.0);
    return held;
}

}  // namespace

SpectralProblem spectral_problem(Run& run, const Mesh& mesh, const OperatorOptions& options) {
    const Constraints held = held_vertices(mesh, options);
    const SpectralLaplacian kind = kind_of(options.laplacian);
    const bool consistent = options.mass == "consistent";
    if (consistent && kind != SpectralLaplacian::dec) {
        throw InputError("--mass consistent goes with --laplacian dec only", "leave one of them out");
    }
    Laplacian laplacian = run.build(
        mesh,
        [&] {
            return spectral_laplacian(mesh, kind,
                                      options.mass == "voronoi" ? Mass::voronoi : Mass::barycentric);
        },
        "are left out: functions are 0 there");
    const Constraints working = laplacian.order().to_working(held);
    BasisOperator description{options.laplacian, options.mass, fingerprint(held)};
    return run.timed("build", [&] {
        if (!consistent) return SpectralProblem{laplacian, Eigenproblem(laplacian, working), description};
        const EdgeOperator<double> mass =
            consistent_mass(laplacian.order().to_working(mesh), laplacian.stiffness().shared_graph());
        return SpectralProblem{laplacian, Eigenproblem(laplacian, mass, working), description};
    });
}

void add_spectrum_options(CLI::App& command, SpectrumCommandOptions& options) {
    command.add_option("--method", options.method, "auto, bands, full or hierarchical (default: auto)")
        ->check(CLI::IsMember({"auto", "bands", "full", "hierarchical"}))
        ->option_text("NAME");
    command.add_option("--tolerance", options.tolerance, "the largest residual of a pair (default: 1e-8)")
        ->option_text("X");
    command
        .add_option("--memory", options.memory,
                    "keep factors on disk that would take more, such as 4G or 500M")
        ->option_text("LIMIT");
    command.add_option("--band", options.band, "pairs in a band (default: by what they cost)")
        ->option_text("N");
}

namespace {

// "8G", "500M": bytes.
double parse_bytes(const std::string& option, const std::string& text) {
    std::string_view number = text;
    double unit = 1.0;
    constexpr std::string_view units = "KMGT";
    if (!number.empty()) {
        const auto at = units.find(number.back());
        if (at != std::string_view::npos) {
            unit = std::pow(1e3, static_cast<double>(at + 1));
            number.remove_suffix(1);
        }
    }
    double value = 0.0;
    if (!parse(number, value) || !(value > 0.0)) {
        throw InputError(fmt::format("{} {} is not a size", option, text), "write it as 500M or 4G");
    }
    return value * unit;
}

}  // namespace

SpectrumOptions spectrum_options(Run& run, const SpectrumCommandOptions& options, const Mesh& mesh,
                                 const Laplacian& laplacian, const std::filesystem::path& scratch) {
    SpectrumOptions spectrum;
    if (options.method == "bands") spectrum.method = SpectrumMethod::bands;
    if (options.method == "full") spectrum.method = SpectrumMethod::full;
    spectrum.tolerance = options.tolerance;
    spectrum.band = options.band;
    if (!options.memory.empty()) spectrum.factor.memory_limit = parse_bytes("--memory", options.memory);
    spectrum.factor.scratch = scratch;
    spectrum.progress = run.progress();
    if (options.method == "hierarchical") {
        spectrum.method = SpectrumMethod::hierarchical;
        spectrum.hierarchy = run.timed("build", [&] {
            return std::make_shared<const Hierarchy>(laplacian.graph(),
                                                     laplacian.order().to_working(mesh).points(),
                                                     HierarchyOptions{.progress = run.progress()});
        });
    }
    return spectrum;
}

void record(Run& run, const SpectrumSummary& summary) {
    run.result()["spectrum"] = {{"method", name(summary.method)},
                                {"why", summary.why},
                                {"count", summary.count},
                                {"largest", summary.largest},
                                {"zero_modes", summary.zero_modes},
                                {"components", summary.components},
                                {"certificate",
                                 {{"complete", summary.complete},
                                  {"max_residual", summary.max_residual},
                                  {"max_orthogonality_error", summary.max_orthogonality_error},
                                  {"bands", summary.bands}}},
                                {"tolerance", summary.tolerance},
                                {"factorizations", summary.factorizations},
                                {"solved_columns", summary.solved_columns},
                                {"analysis_seconds", summary.analysis_seconds},
                                {"factor_seconds", summary.factor_seconds},
                                {"solve_seconds", summary.solve_seconds},
                                {"total_seconds", summary.total_seconds},
                                {"memory_bytes", summary.memory_bytes},
                                {"disk_bytes", summary.disk_bytes}};
    run.say("spectrum", fmt::format("{}; chosen: {}", summary.brief(), summary.why));
    if (run.verbose()) fmt::print("{}", summary.full());
}

void add_basis_option(CLI::App& command, std::string& folder) {
    command.add_option("--basis", folder, "a folder made by beltrami harmonics")
        ->required()
        ->option_text("BASIS");
}

NamedTarget target_of(const std::string& on) {
    if (on == "positions") return {FilterTarget::positions};
    if (on == "normals") return {FilterTarget::normals};
    if (on == "colors") return {FilterTarget::colors};
    return {FilterTarget::field, on};
}

Block field_on(const Mesh& mesh, const std::string& what) {
    const NamedTarget target = target_of(what);
    return filter_field(mesh, target.kind, target.field);
}

StoredBasis open_basis(Run& run, const std::string& folder, const Mesh& mesh) {
    StoredBasis basis = run.timed("read", [&] {
        StoredBasis opened(folder);
        opened.check(mesh);
        return opened;
    });
    run.say("basis", fmt::format("{}: {} functions up to the frequency {:.6g}, {}", folder, basis.count(),
                                 cutoff_frequency(basis), basis.complete() ? "certified" : "NOT COMPLETE"));
    if (!basis.complete()) {
        run.warn(fmt::format(
            "{} is what an interrupted run left: finish it with beltrami harmonics ... --resume", folder));
    }
    run.result()["basis"] = {{"folder", folder},
                             {"count", basis.count()},
                             {"complete", basis.complete()},
                             {"cutoff", cutoff_frequency(basis)},
                             {"max_residual", basis.max_residual()}};
    return basis;
}

}  // namespace beltrami::program
