// Solves from nothing to a given error: ours against CHOLMOD, conjugate gradients with the diagonal, and BoomerAMG where it is
// installed. Everything is counted in: assembly, ordering, hierarchy, factor, solve.
//
//     ./dev bench solvers                              # 150 K and 1 M irregular vertices, one thread
//     ./dev bench solvers --vertices 150000 --threads 2
//     ./dev bench solvers --mesh scan.obj --json results.json
//     ./dev bench solvers --only bi-Laplacian
//
// Each run is a process of its own, so that the peak of its memory is its own. Errors are those of u, against a direct solution
// that was refined with the matrix-free residual.

#include <fmt/format.h>
#include <malloc.h>
#include <omp.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "beltrami/framework/stopwatch.hpp"
#include "cholmod_factor.hpp"
#include "ratios.hpp"

#ifdef BELTRAMI_HYPRE
#include <HYPRE.h>
#include <HYPRE_krylov.h>
#include <HYPRE_parcsr_ls.h>
#include <mpi.h>
#endif

namespace {

using namespace beltrami;
using Json = nlohmann::json;

struct Problem {
    std::string name;
    PdeOperator A;
    Constraints held;
    std::vector<Block> loads;  // solved one after the other
    double error;              // in u, that is asked for, against the largest |u|
    double tolerance;          // by which ours reaches it: see docs/solvers.md
};

struct Outcome {
    double seconds = 0.0;
    double setup = 0.0;
    double peak = 0.0;  // bytes above those of the mesh and the operator
    double error = 0.0;
    double iterations = 0.0;
    char solver[16] = "";
    bool ok = false;
};

using Method = std::function<std::vector<Block>(const Problem&, Outcome&)>;

// The most memory that the process has had since it was asked to forget.
double peak_bytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        if (line.starts_with("VmHWM:")) return 1024.0 * std::stod(line.substr(6));
    }
    return 0.0;
}
void forget_peak() {
    std::ofstream("/proc/self/clear_refs") << "5";
}

Block start_of(const Problem& problem) {
    Block x = Block::Zero(problem.A.rows(), problem.loads[0].cols());
    problem.held.impose(x);
    return x;
}

std::vector<Block> solve_by(const Problem& problem, LinearSolverOptions options, Outcome& outcome) {
    options.expected_solves = static_cast<int>(problem.loads.size());
    LinearSolver solver(std::make_shared<const PdeOperator>(problem.A), options);
    std::vector<Block> solutions;
    LinearSummary total;
    for (const Block& b : problem.loads) {
        Block x = start_of(problem);
        total.add(solver.solve(b, problem.held, x));
        solutions.push_back(std::move(x));
    }
    outcome.ok = total.converged;
    outcome.setup = total.setup_seconds;
    outcome.iterations = total.iterations;
    total.solver.copy(outcome.solver, sizeof outcome.solver - 1);
    return solutions;
}

Method ours(SolverKind kind) {
    return [kind](const Problem& problem, Outcome& outcome) {
        return solve_by(problem, {.kind = kind, .tolerance = problem.tolerance}, outcome);
    };
}

// The free rows of A, and what the held ones load them with.
struct Reduced {
    std::vector<Index> free;
    Eigen::SparseMatrix<double> A;
    std::vector<Block> loads;
};
Reduced reduced(const Problem& problem) {
    const Eigen::SparseMatrix<double> A = problem.A.to_sparse();
    Reduced result;
    std::vector<Index> row(static_cast<std::size_t>(A.rows()), -1);
    for (Index v = 0; v < A.rows(); ++v) {
        if (problem.held.is_fixed(v)) continue;
        row[static_cast<std::size_t>(v)] = static_cast<Index>(result.free.size());
        result.free.push_back(v);
    }
    const auto n = static_cast<Eigen::Index>(result.free.size());
    result.A.resize(n, n);
    result.A.reserve(A.nonZeros());
    for (Eigen::Index j = 0; j < n; ++j) {
        result.A.startVec(j);
        for (Eigen::SparseMatrix<double>::InnerIterator e(A, result.free[static_cast<std::size_t>(j)]); e;
             ++e) {
            const Index i = row[static_cast<std::size_t>(e.row())];
            if (i >= 0) result.A.insertBack(i, j) = e.value();
        }
    }
    result.A.finalize();
    Block product;
    problem.A.apply(start_of(problem), product);
    for (const Block& b : problem.loads)
        result.loads.emplace_back((b - product)(result.free, Eigen::all));
    return result;
}

Block spread(const Problem& problem, const std::vector<Index>& free, const Block& solution) {
    Block x = start_of(problem);
    for (std::size_t i = 0; i < free.size(); ++i)
        x.row(free[i]) = solution.row(static_cast<Eigen::Index>(i));
    return x;
}

Method cholmod(bool metis) {
    return [metis](const Problem& problem, Outcome& outcome) {
        const Stopwatch watch;
        Reduced system = reduced(problem);
        bench::CholmodFactor factor(system.A, metis);
        outcome.setup = watch.seconds();
        std::vector<Block> solutions;
        for (const Block& b : system.loads) {
            Block x;
            factor.solve(b, x, 32);
            solutions.push_back(spread(problem, system.free, x));
        }
        outcome.ok = true;
        return solutions;
    };
}

#ifdef BELTRAMI_HYPRE
// Conjugate gradients with one V-cycle of BoomerAMG, to a relative residual that gives the error asked for.
std::vector<Block> boomer_amg(const Problem& problem, Outcome& outcome) {
    const Stopwatch watch;
    const Reduced system = reduced(problem);
    const auto n = static_cast<HYPRE_Int>(system.A.rows());
    // Under its other name: MUMPS brings a library of its own that stands in for MPI.
    PMPI_Init(nullptr, nullptr);
    HYPRE_Init();
    HYPRE_IJMatrix matrix = nullptr;
    HYPRE_IJMatrixCreate(MPI_COMM_WORLD, 0, n - 1, 0, n - 1, &matrix);
    HYPRE_IJMatrixSetObjectType(matrix, HYPRE_PARCSR);
    HYPRE_IJMatrixInitialize(matrix);
    std::vector<HYPRE_Int> counts(static_cast<std::size_t>(n));
    std::vector<HYPRE_BigInt> rows(static_cast<std::size_t>(n));
    for (HYPRE_Int i = 0; i < n; ++i) {
        rows[static_cast<std::size_t>(i)] = i;
        counts[static_cast<std::size_t>(i)] = system.A.outerIndexPtr()[i + 1] - system.A.outerIndexPtr()[i];
    }
    HYPRE_IJMatrixSetValues(matrix, n, counts.data(), rows.data(), system.A.innerIndexPtr(),
                            system.A.valuePtr());
    HYPRE_IJMatrixAssemble(matrix);
    HYPRE_ParCSRMatrix A = nullptr;
    HYPRE_IJMatrixGetObject(matrix, reinterpret_cast<void**>(&A));

    HYPRE_Solver amg = nullptr;
    HYPRE_BoomerAMGCreate(&amg);
    HYPRE_BoomerAMGSetPrintLevel(amg, 0);
    HYPRE_BoomerAMGSetCoarsenType(amg, 8);  // PMIS
    HYPRE_BoomerAMGSetInterpType(amg, 6);   // extended + i
    HYPRE_BoomerAMGSetPMaxElmts(amg, 4);
    HYPRE_BoomerAMGSetRelaxType(amg, 6);  // symmetric Gauss-Seidel
    HYPRE_BoomerAMGSetTol(amg, 0.0);
    HYPRE_BoomerAMGSetMaxIter(amg, 1);
    HYPRE_Solver cg = nullptr;
    HYPRE_ParCSRPCGCreate(MPI_COMM_WORLD, &cg);
    HYPRE_PCGSetMaxIter(cg, 1000);
    HYPRE_PCGSetTol(cg, problem.tolerance);
    HYPRE_PCGSetTwoNorm(cg, 0);  // stops on r^T B r, as ours does on K D K
    HYPRE_PCGSetPrecond(cg, reinterpret_cast<HYPRE_PtrToSolverFcn>(HYPRE_BoomerAMGSolve),
                        reinterpret_cast<HYPRE_PtrToSolverFcn>(HYPRE_BoomerAMGSetup), amg);
    const auto vector = [&](std::vector<double> values) {
        HYPRE_IJVector v = nullptr;
        HYPRE_IJVectorCreate(MPI_COMM_WORLD, 0, n - 1, &v);
        HYPRE_IJVectorSetObjectType(v, HYPRE_PARCSR);
        HYPRE_IJVectorInitialize(v);
        HYPRE_IJVectorSetValues(v, n, rows.data(), values.data());
        HYPRE_IJVectorAssemble(v);
        return v;
    };
    const auto object = [](HYPRE_IJVector v) {
        HYPRE_ParVector p = nullptr;
        HYPRE_IJVectorGetObject(v, reinterpret_cast<void**>(&p));
        return p;
    };
    std::vector<Block> solutions;
    outcome.ok = true;
    for (const Block& load : system.loads) {
        const HYPRE_IJVector b = vector(std::vector<double>(load.data(), load.data() + load.size()));
        const HYPRE_IJVector x = vector(std::vector<double>(static_cast<std::size_t>(n), 0.0));
        if (solutions.empty()) {
            HYPRE_ParCSRPCGSetup(cg, A, object(b), object(x));
            outcome.setup = watch.seconds();
        }
        outcome.ok = HYPRE_ParCSRPCGSolve(cg, A, object(b), object(x)) == 0 && outcome.ok;
        HYPRE_ClearAllErrors();
        HYPRE_Int iterations = 0;
        HYPRE_PCGGetNumIterations(cg, &iterations);
        outcome.iterations += iterations;
        Block solution(n, 1);
        HYPRE_IJVectorGetValues(x, n, rows.data(), solution.data());
        solutions.push_back(spread(problem, system.free, solution));
    }
    return solutions;
}
#endif

// In a process of its own.
Outcome run(const Problem& problem, const Method& method, const std::vector<Block>& reference, int threads) {
    int ends[2];
    malloc_trim(0);
    if (pipe(ends) != 0) throw SolveError("no pipe", "close what else runs");
    const pid_t child = fork();
    if (child == 0) {
        Outcome outcome;
        try {
            omp_set_num_threads(threads);
            forget_peak();
            const double before = peak_bytes();
            const Stopwatch watch;
            const std::vector<Block> solutions = method(problem, outcome);
            outcome.seconds = watch.seconds();
            outcome.peak = peak_bytes() - before;
            for (std::size_t i = 0; i < reference.size(); ++i) {
                outcome.error = std::max(outcome.error, (solutions[i] - reference[i]).cwiseAbs().maxCoeff() /
                                                            reference[i].cwiseAbs().maxCoeff());
            }
        } catch (const std::exception& error) {
            outcome.ok = false;
            std::cerr << error.what() << '\n';
        }
        const auto written = write(ends[1], &outcome, sizeof outcome);
        _exit(written == sizeof outcome ? 0 : 1);
    }
    close(ends[1]);
    Outcome outcome;
    if (child < 0 || read(ends[0], &outcome, sizeof outcome) != sizeof outcome) outcome = {};
    close(ends[0]);
    waitpid(child, nullptr, 0);
    return outcome;
}

Constraints random_values(Index n, Index count) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> value;
    Constraints held;
    while (static_cast<Index>(held.vertices().size()) < std::min(count, n / 2))
        held.fix(static_cast<Index>(random() % static_cast<unsigned>(n)), value(random));
    return held;
}

// Heat of twenty sources, as a load M f.
Block sources(const Laplacian& laplacian, unsigned seed, Index columns = 1) {
    std::mt19937 random(seed);
    Block b = Block::Zero(laplacian.vertex_count(), columns);
    for (Index c = 0; c < columns; ++c) {
        for (int s = 0; s < 20; ++s) {
            const auto v = static_cast<Index>(random() % static_cast<unsigned>(b.rows()));
            b(v, c) = laplacian.mass()[v];
        }
    }
    return b;
}

std::vector<Problem> problems(const Laplacian& laplacian, double h) {
    const Index n = laplacian.vertex_count();
    const Block none = Block::Zero(n, 1);
    const auto heat = [&](double t) { return PdeOperator(laplacian, 1.0, {t * h * h}); };
    const PdeOperator K(laplacian, 0.0, {1.0});
    const PdeOperator KDK(laplacian, 0.0, {0.0, 1.0});
    std::vector<Problem> all;
    all.push_back({"heat, t = 100 h^2", heat(100), Constraints(), {sources(laplacian, 1)}, 1e-8, 6e-9});
    all.push_back({"heat, t = 10,000 h^2", heat(10000), Constraints(), {sources(laplacian, 1)}, 1e-8, 1e-8});
    all.push_back({"Laplace, 100 constraints", K, random_values(n, 100), {none}, 1e-8, 6e-10});
    std::vector<Block> ten;
    for (unsigned s = 1; s <= 10; ++s)
        ten.push_back(sources(laplacian, s));
    all.push_back({"heat, ten steps of t = 100 h^2", heat(100), Constraints(), std::move(ten), 1e-8, 6e-9});
    all.push_back({"heat, 100 right-hand sides",
                   heat(100),
                   Constraints(100),
                   {sources(laplacian, 1, 100)},
                   1e-8,
                   2e-9});
    all.push_back({"bi-Laplacian, 100 constraints", KDK, random_values(n, 100), {none}, 1e-6, 1e-6});
    all.push_back(
        {"bi-Laplacian, 1 constraint", KDK, random_values(n, 1), {sources(laplacian, 1)}, 1e-6, 1e-6});
    all.push_back({"bi-Laplacian, 10,000 constraints", KDK, random_values(n, 10000), {none}, 1e-6, 1e-6});
    return all;
}

void compare(const std::string& where, const Mesh& mesh, int threads, const std::string& only, Json& json) {
    const Laplacian laplacian(mesh);
    const double h = report(mesh).mean_edge;
    for (const Problem& problem : problems(laplacian, h)) {
        if (problem.name.find(only) == std::string::npos) continue;
        const bool bilaplacian = problem.A.order() == 2;
        const bool many = problem.loads[0].cols() > 1;
        // The reference: direct, refined as far as rounding allows.
        std::vector<Block> reference;
        {
            Outcome outcome;
            reference = solve_by(problem, {.kind = SolverKind::cholesky, .tolerance = 1e-14}, outcome);
        }
        std::vector<std::pair<std::string, Method>> methods{{"CHOLMOD, AMD", cholmod(false)},
                                                            {"CHOLMOD, METIS", cholmod(true)},
                                                            {"auto", ours(SolverKind::automatic)},
                                                            {"cholesky", ours(SolverKind::cholesky)}};
        if (!many) methods.emplace_back("multigrid", ours(SolverKind::multigrid));
        if (!bilaplacian && problem.loads.size() == 1 && !many)
            methods.emplace_back("cg", ours(SolverKind::cg));
        if (bilaplacian && problem.held.vertices().size() <= 100)
            methods.emplace_back("green", ours(SolverKind::green));
#ifdef BELTRAMI_HYPRE
        if (!bilaplacian && !many) methods.emplace_back("CG with BoomerAMG", boomer_amg);
#endif
        fmt::print("\n{}: {}, error wanted {:.0e}, {} thread{}\n", where, problem.name, problem.error,
                   threads, threads == 1 ? "" : "s");
        fmt::print("  {:<18} {:>9} {:>9} {:>7} {:>9} {:>7} {:>7} {:>9}\n", "method", "seconds", "set-up",
                   "ratio", "peak, MB", "ratio", "steps", "error");
        Outcome baseline;
        for (const auto& [name, method] : methods) {
            const Outcome outcome = run(problem, method, reference, threads);
            // Against the faster of the two orderings.
            if (name == "CHOLMOD, AMD" || (name == "CHOLMOD, METIS" && outcome.seconds < baseline.seconds))
                baseline = outcome;
            const std::string shown = outcome.solver[0] != '\0' && name != outcome.solver
                                          ? fmt::format("{} ({})", name, outcome.solver)
                                          : name;
            fmt::print("  {:<18} {:>9.3f} {:>9.3f} {:>7.2f} {:>9.1f} {:>7.2f} {:>7.0f} {:>9.1e}{}\n", shown,
                       outcome.seconds, outcome.setup, outcome.seconds / baseline.seconds, outcome.peak / 1e6,
                       outcome.peak / baseline.peak, outcome.iterations, outcome.error,
                       !outcome.ok                     ? "  FAILED"
                       : outcome.error > problem.error ? "  (short of it)"
                                                       : "");
            std::fflush(stdout);
            json.push_back({{"mesh", where},
                            {"vertices", laplacian.vertex_count()},
                            {"problem", problem.name},
                            {"method", name},
                            {"solver", outcome.solver},
                            {"threads", threads},
                            {"seconds", outcome.seconds},
                            {"setup_seconds", outcome.setup},
                            {"peak_bytes", outcome.peak},
                            {"iterations", outcome.iterations},
                            {"error", outcome.error},
                            {"converged", outcome.ok}});
        }
    }
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Solves from nothing to a given error: ours and the alternatives");
    std::vector<Index> sizes;
    std::vector<std::string> meshes;
    std::string only;
    std::string json_file;
    int threads = 1;
    app.add_option("--vertices", sizes,
                   "irregular bumpy spheres of so many vertices (default: 150000 1000000)");
    app.add_option("--mesh", meshes, "files, or shapes as `beltrami` takes them");
    app.add_option("--only", only, "problems whose name has this");
    app.add_option("--threads", threads, "of OpenMP (default: 1)")->check(CLI::PositiveNumber);
    app.add_option("--json", json_file, "every figure");
    CLI11_PARSE(app, argc, argv);
    if (sizes.empty() && meshes.empty()) sizes = {150000, 1000000};
    // A team of threads would not survive the forks.
    omp_set_num_threads(1);
    fmt::print("{}; stream triad {:.1f} GB/s on one thread\n", bench::machine(), bench::stream_bandwidth(1));
    Json json = Json::array();
    try {
        for (const Index n : sizes)
            compare(fmt::format("{} irregular vertices", n), shapes::shuffled(shapes::bumpy_sphere(n)).mesh,
                    threads, only, json);
        for (const std::string& name : meshes)
            compare(name, name.starts_with("shape:") ? shapes::from_name(name.substr(6)) : read_mesh(name),
                    threads, only, json);
    } catch (const Error& error) {
        std::cerr << error.what() << "; " << error.hint() << '\n';
        return error.exit_status();
    }
    if (!json_file.empty()) std::ofstream(json_file) << json.dump(2) << '\n';
    return 0;
}
