// Spectra: ours against ARPACK's shift-invert (as SciPy's eigsh runs it) and Spectra's, all on the same factorization; the
// papers' Table 1; filters against a read sweep of their basis.
//
//     ./dev bench spectrum                       # the comparison at 150 K vertices and the filters
//     ./dev bench spectrum --table1[=VERTICES]   # Table 1 of Vallet & Levy, sizes up to VERTICES (default: 1000000)
//
// Each run is a process of its own, so that the peak of its memory is its own.

#include <Spectra/SymEigsShiftSolver.h>
#include <fmt/format.h>
#include <omp.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "beltrami/solvers/blas_threads.hpp"
#include "ratios.hpp"

// ARPACK's reverse communication, as its Fortran has it.
extern "C" {
void dsaupd_(int* ido, const char* bmat, const int* n, const char* which, const int* nev, const double* tol,
             double* resid, const int* ncv, double* v, const int* ldv, int* iparam, int* ipntr, double* workd,
             double* workl, const int* lworkl, int* info);
void dseupd_(const int* rvec, const char* howmny, int* select, double* d, double* z, const int* ldz,
             const double* sigma, const char* bmat, const int* n, const char* which, const int* nev,
             const double* tol, double* resid, const int* ncv, double* v, const int* ldv, int* iparam,
             int* ipntr, double* workd, double* workl, const int* lworkl, int* info);
}

namespace {

using namespace beltrami;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What a process sends back.
struct Outcome {
    double seconds = 0.0;
    double residual = 0.0;
    double solved = 0.0;  ///< columns
    double peak = 0.0;    ///< bytes that the process took at most, above what the problem itself took
    double pairs = 0.0;
    bool ok = false;
};

double peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

/// The numbers that a process of this program with these arguments prints: a process that has used threads cannot fork.
template <class Numbers>
bool from_its_own_process(const std::string& arguments, Numbers& numbers) {
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    FILE* const pipe = popen(fmt::format("'{}' {}", self, arguments).c_str(), "r");
    if (pipe == nullptr) return false;
    const bool received = std::fread(&numbers, sizeof(numbers), 1, pipe) == 1;
    return pclose(pipe) == 0 && received;
}
template <class Numbers>
int send(const Numbers& numbers) {
    return std::fwrite(&numbers, sizeof(numbers), 1, stdout) == 1 ? 0 : 1;
}

double worst_residual(const Eigenproblem& problem, const Vector& values, const Columns& vectors) {
    double worst = 0.0;
    for (Eigen::Index first = 0; first < values.size(); first += 32) {
        const Eigen::Index count = std::min<Eigen::Index>(32, values.size() - first);
        Columns Kh;
        Columns Mh;
        problem.apply_stiffness(vectors.middleCols(first, count), Kh);
        problem.apply_mass(vectors.middleCols(first, count), Mh);
        for (Eigen::Index i = 0; i < count; ++i) {
            const double lambda = values[first + i];
            if (lambda < 1e-6) continue;
            worst = std::max(worst, (Kh.col(i) - lambda * Mh.col(i)).norm() / (lambda * Mh.col(i).norm()));
        }
    }
    return worst;
}

Outcome ours(Index vertices, Index count, int threads) {
    omp_set_num_threads(threads);
    const Eigenproblem problem{Laplacian(shapes::bumpy_sphere(vertices))};
    const double before = peak_bytes();
    const auto start = Clock::now();
    const Spectrum found = spectrum(problem, {.count = count});
    Outcome outcome{.seconds = since(start)};
    outcome.peak = peak_bytes() - before;
    outcome.residual = worst_residual(problem, found.values, found.vectors);
    outcome.solved = static_cast<double>(found.summary.solved_columns);
    outcome.pairs = count;
    outcome.ok = found.summary.complete;
    return outcome;
}

// A shift below the spectrum, far nearer to 0 than the first eigenvalue.
constexpr double shift = -0.01;

Outcome arpack(Index vertices, Index count, int threads) {
    omp_set_num_threads(threads);
    const Eigenproblem problem{Laplacian(shapes::bumpy_sphere(vertices))};
    const double before = peak_bytes();
    const auto start = Clock::now();
    ShiftInvert pencil(problem);
    pencil.factor(shift);
    const BlasThreads blas(threads);
    // As SciPy: mode 3, ncv = 2 k + 1, tolerance 0 (machine precision).
    const int n = problem.rows();
    const int nev = count;
    const int ncv = std::min(2 * nev + 1, n);
    const double tolerance = 0.0;
    std::vector<double> residual(static_cast<std::size_t>(n));
    Columns v(n, ncv);
    std::vector<double> workd(3 * static_cast<std::size_t>(n));
    const int lworkl = ncv * (ncv + 8);
    std::vector<double> workl(static_cast<std::size_t>(lworkl));
    int iparam[11] = {1, 0, 10 * n, 1, 0, 0, 3};  // NOLINT(modernize-avoid-c-arrays)
    int ipntr[14] = {};                           // NOLINT(modernize-avoid-c-arrays)
    int ido = 0;
    int info = 0;
    Outcome outcome;
    const Vector& mass = problem.lumped_mass();
    for (;;) {
        dsaupd_(&ido, "G", &n, "LM", &nev, &tolerance, residual.data(), &ncv, v.data(), &n, iparam, ipntr,
                workd.data(), workl.data(), &lworkl, &info);
        const auto at = [&](int i) { return Eigen::Map<Vector>(workd.data() + ipntr[i] - 1, n); };
        if (ido == -1 || ido == 1) {
            Columns x = ido == -1 ? Columns(mass.cwiseProduct(at(0))) : Columns(at(2));
            pencil.solve(x);
            at(1) = x.col(0);
            outcome.solved += 1.0;
        } else if (ido == 2) {
            at(1) = mass.cwiseProduct(at(0));
        } else {
            break;
        }
    }
    const int vectors_too = 1;
    std::vector<int> select(static_cast<std::size_t>(ncv));
    Vector values(nev);
    dseupd_(&vectors_too, "A", select.data(), values.data(), v.data(), &n, &shift, "G", &n, "LM", &nev,
            &tolerance, residual.data(), &ncv, v.data(), &n, iparam, ipntr, workd.data(), workl.data(),
            &lworkl, &info);
    outcome.seconds = since(start);
    outcome.peak = peak_bytes() - before;
    outcome.pairs = iparam[4];
    outcome.ok = info == 0;
    outcome.residual = worst_residual(problem, values, v.leftCols(nev));
    return outcome;
}

// M^(1/2) (K - shift M)^-1 M^(1/2) for Spectra.
class Scaled {
  public:
    using Scalar = double;
    explicit Scaled(const Eigenproblem& problem)
        : scale_(problem.lumped_mass().cwiseSqrt()), pencil_(problem) {}
    [[nodiscard]] Eigen::Index rows() const { return scale_.size(); }
    [[nodiscard]] Eigen::Index cols() const { return scale_.size(); }
    void set_shift(double value) { pencil_.factor(value); }
    void perform_op(const double* x, double* y) const {
        Columns columns = scale_.cwiseProduct(Eigen::Map<const Vector>(x, rows()));
        pencil_.solve(columns);
        Eigen::Map<Vector>(y, rows()) = scale_.cwiseProduct(columns.col(0));
        ++products;
    }
    [[nodiscard]] const Vector& scale() const { return scale_; }
    mutable long products = 0;

  private:
    Vector scale_;
    ShiftInvert pencil_;
};

Outcome spectra(Index vertices, Index count, int threads) {
    omp_set_num_threads(threads);
    const Eigenproblem problem{Laplacian(shapes::bumpy_sphere(vertices))};
    const double before = peak_bytes();
    const auto start = Clock::now();
    Scaled op(problem);
    Spectra::SymEigsShiftSolver<Scaled> solver(op, count, 2 * count + 1, shift);
    solver.init();
    solver.compute(Spectra::SortRule::LargestMagn, 1000, 1e-10, Spectra::SortRule::SmallestAlge);
    const Vector values = solver.eigenvalues();
    const Columns vectors = op.scale().cwiseInverse().asDiagonal() * solver.eigenvectors();
    Outcome outcome{.seconds = since(start)};
    outcome.peak = peak_bytes() - before;
    outcome.solved = static_cast<double>(op.products);
    outcome.pairs = static_cast<double>(values.size());
    outcome.ok = solver.info() == Spectra::CompInfo::Successful;
    outcome.residual = worst_residual(problem, values, vectors);
    return outcome;
}

void add(Index vertices, Index count, const std::string& method, const std::string& label, int threads) {
    const std::string name = fmt::format("{} pairs of {} vertices/{}", count, vertices, label);
    benchmark::RegisterBenchmark(
        name.c_str(),
        [=](benchmark::State& state) {
            for (auto _ : state) {
                Outcome outcome;
                const bool ran = from_its_own_process(
                    fmt::format("--one {} {} {} {}", method, vertices, count, threads), outcome);
                state.SetIterationTime(outcome.seconds);
                state.counters["threads"] = threads;
                state.counters["memory"] = outcome.peak;
                state.counters["residual"] = outcome.residual;
                state.counters["solved"] = outcome.solved;
                state.counters["pairs"] = outcome.pairs;
                if (!ran || !outcome.ok) state.SkipWithError("it did not converge");
            }
        })
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kSecond);
}

void add_eigenproblems() {
    constexpr Index n = 150000;
    const int all = omp_get_num_procs();
    for (const Index k : {315, 50}) {
        add(n, k, "ours", fmt::format("ours, {} threads", all), all);
        add(n, k, "ours", "ours, 1 thread", 1);
        add(n, k, k > 100 ? "arpack" : "spectra", k > 100 ? "ARPACK" : "Spectra", all);
    }
}

/// A folder that is removed at the end.
class Folder {
  public:
    explicit Folder(const std::string& name)
        : path_(std::filesystem::temp_directory_path() /
                fmt::format("beltrami_bench_{}_{}", name, getpid())) {
        std::filesystem::remove_all(path_);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() { std::filesystem::remove_all(path_); }
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

// A basis of numbers of the right size: what is in it does not change how long a sweep takes.
StoredBasis made_up_basis(const std::filesystem::path& folder, const Mesh& mesh, Index count, NpyType type) {
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    BasisWriter writer(folder, mesh, laplacian, problem, {}, {.type = type});
    SpectralBand band;
    for (Index first = 0; first < count; first += 105) {
        band.first = first;
        band.values = Vector::LinSpaced(105, first, first + 104);
        band.vectors = Columns::Random(problem.rows(), 105);
        band.certificate.kept = 105;
        band.certificate.found = 105;
        band.certificate.upper.value = first + 104.5;
        writer.add(band);
    }
    return StoredBasis(folder);
}

template <class Scalar>
double sweep(const StoredBasis& basis) {
    double total = 0.0;
    for (const NpyArray& band : basis.bands()) {
        const Scalar* const values = band.row<Scalar>(0);
        const std::ptrdiff_t size = band.rows() * band.columns();
        double sum = 0.0;
#pragma omp parallel for simd reduction(+ : sum) schedule(static)
        for (std::ptrdiff_t i = 0; i < size; ++i)
            sum += static_cast<double>(values[i]);
        total += sum;
    }
    return total;
}

void add_filters() {
    for (const NpyType type : {NpyType::float64, NpyType::float32}) {
        const bool wide = type == NpyType::float64;
        auto folder = std::make_shared<Folder>(wide ? "double" : "float");
        const Mesh mesh = shapes::bumpy_sphere(150000);
        auto basis = std::make_shared<StoredBasis>(made_up_basis(folder->path(), mesh, 315, type));
        auto filter = std::make_shared<HarmonicFilter>(*basis, mesh.points());
        const int all = omp_get_num_procs();
        const double bytes = (wide ? 8.0 : 4.0) * 315 * 150000;
        const std::string what = fmt::format("filter 150000 x 315 x 3, {}", wide ? "double" : "float");
        for (const int threads : {1, all}) {
            const auto label = [&](const char* text) {
                return fmt::format("{} {}, {} thread{}", what, "", threads, threads == 1 ? "" : "s") + "/" +
                       text;
            };
            benchmark::RegisterBenchmark(
                label("read sweep").c_str(),
                [=](benchmark::State& state) {
                    omp_set_num_threads(threads);
                    (void)folder;
                    for (auto _ : state)
                        benchmark::DoNotOptimize(wide ? sweep<double>(*basis) : sweep<float>(*basis));
                    state.counters["bytes"] = bytes;
                    state.counters["threads"] = threads;
                })
                ->UseRealTime()
                ->Unit(benchmark::kMillisecond);
            benchmark::RegisterBenchmark(label("ours").c_str(),
                                         [=](benchmark::State& state) {
                                             omp_set_num_threads(threads);
                                             (void)folder;
                                             const FilterCurve curve({{0.0, 2.0}, {8.0, 0.5}, {18.0, 0.1}});
                                             for (auto _ : state)
                                                 benchmark::DoNotOptimize(filter->apply(curve).data());
                                             state.counters["bytes"] = bytes;
                                             state.counters["threads"] = threads;
                                         })
                ->UseRealTime()
                ->Unit(benchmark::kMillisecond);
        }
    }
}

/// A row of Table 1: vertices, pairs, and the seconds of 2008 on a T7600 at 2.33 GHz.
struct Published {
    Index vertices;
    Index pairs;
    double basis, forward, inverse, limited;
};

struct Row {
    double basis = 0.0, analysis = 0.0, factors = 0.0, spaces = 0.0, forward = 0.0, inverse = 0.0,
           limited = 0.0;
    double residual = 0.0, orthogonality = 0.0, peak = 0.0, first_band = 0.0, last_band = 0.0,
           limited_pairs = 0.0;
    bool complete = false;
};

Row row_of(Index vertices, Index pairs) {
    const Mesh mesh = shapes::bumpy_sphere(vertices);
    const Folder folder("table");
    Row row;
    {
        const Laplacian laplacian(mesh);
        const Eigenproblem problem(laplacian);
        BasisWriter writer(folder.path(), mesh, laplacian, problem, {}, {});
        std::vector<double> per_pair;
        auto start = Clock::now();
        auto last = start;
        const SpectrumSummary summary =
            spectrum(problem, {.count = pairs, .tolerance = 1e-6}, [&](const SpectralBand& band) {
                writer.add(band);
                const auto now = Clock::now();
                per_pair.push_back(std::chrono::duration<double>(now - last).count() /
                                   band.certificate.found);
                last = now;
            });
        writer.finish(summary);
        row.basis = since(start);
        row.analysis = summary.analysis_seconds;
        row.factors = summary.factor_seconds;
        row.spaces = summary.solve_seconds;
        row.residual = summary.max_residual;
        row.orthogonality = summary.max_orthogonality_error;
        row.complete = summary.complete;
        row.first_band =
            per_pair.size() > 1 ? per_pair[1] : per_pair.front();  // the first holds the analysis
        row.last_band = per_pair.back();
        row.peak = peak_bytes();
    }
    const StoredBasis basis(folder.path());
    auto start = Clock::now();
    const Block coefficients = forward_transform(basis, mesh.points());
    row.forward = since(start);
    start = Clock::now();
    inverse_transform(basis, coefficients);
    row.inverse = since(start);
    // A band-exaggeration over a quarter of the spectrum's frequencies.
    const double cutoff = cutoff_frequency(basis);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const Block field = laplacian.order().to_working(Block(mesh.points()));
    start = Clock::now();
    row.limited_pairs = limited_memory_filter(
                            problem, field, FilterCurve::band_exaggeration(0.45 * cutoff, 0.65 * cutoff, 2.0),
                            {.cutoff = cutoff, .mean_edge = basis.mean_edge()})
                            .pairs;
    row.limited = since(start);
    return row;
}

void table_1(Index largest) {
    fmt::print(
        "machine: {}\n{:<16}{:>8}{:>10}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>7}{:>10}{:>10}{:>8}{:>9}{:>9}\n",
        bench::machine(), "vertices/pairs", "theirs", "ours", "analysis", "factors", "spaces", "forward",
        "inverse", "limited", "pairs", "residual", "orthogon.", "peak GB", "ms/pair", "to last");
    const std::vector<Published> table = {{56000, 447, 77.0, 0.34, 0.53, 18.0},
                                          {150000, 315, 160.0, 0.65, 1.02, 41.0},
                                          {244000, 667, 540.0, 18.0, 4.0, 135.0},
                                          {500000, 800, 8460.0, 32.0, 48.0, 1680.0},
                                          {1000000, 1331, 21600.0, 76.0, 85.0, 3600.0}};
    for (const Published& published : table) {
        if (published.vertices > largest) continue;
        Row row;
        const bool received =
            from_its_own_process(fmt::format("--row {} {}", published.vertices, published.pairs), row);
        if (!received || !row.complete) {
            fmt::print("{}/{}: failed\n", published.vertices, published.pairs);
            continue;
        }
        fmt::print(
            "{:<16}{:>8.0f}{:>10.1f}{:>9.1f}{:>9.1f}{:>9.1f}{:>9.2f}{:>9.2f}{:>9.1f}{:>7.0f}{:>10.1e}{:>10."
            "1e}{:>8.2f}{:>9.1f}{:>9.1f}\n",
            fmt::format("{}/{}", published.vertices, published.pairs), published.basis, row.basis,
            row.analysis, row.factors, row.spaces, row.forward, row.inverse, row.limited, row.limited_pairs,
            row.residual, row.orthogonality, row.peak / 1e9, 1e3 * row.first_band, 1e3 * row.last_band);
        std::fflush(stdout);
    }
}

}  // namespace

int main(int argc, char** argv) {
    const std::string first = argc > 1 ? argv[1] : "";
    if (first == "--one" && argc == 6) {
        const std::string method = argv[2];
        const int threads = std::atoi(argv[5]);
        const auto run = method == "ours" ? ours : method == "arpack" ? arpack : spectra;
        return send(run(std::atoi(argv[3]), std::atoi(argv[4]), threads));
    }
    if (first == "--row" && argc == 4) return send(row_of(std::atoi(argv[2]), std::atoi(argv[3])));
    if (first.starts_with("--table1")) {
        table_1(first.size() > 9 ? std::atoi(first.c_str() + 9) : 1000000);
        return 0;
    }
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    add_eigenproblems();
    add_filters();
    beltrami::bench::RatioReporter reporter({"ARPACK", "Spectra", "read sweep"});
    benchmark::RunSpecifiedBenchmarks(&reporter);
    return 0;
}
