// K u, K D K u: ours against Eigen's CSR and an assembled K D K, in the file's order and in Cuthill-McKee order.
//
//     ./dev bench operators                                  # 150 K and 1 M vertices
//     ./dev bench operators --benchmark_filter=150000        # Google Benchmark's own options

#include <fmt/format.h>
#include <omp.h>

#include <Eigen/SparseCore>
#include <memory>
#include <string>

#include "beltrami/beltrami.hpp"
#include "ratios.hpp"

namespace {

using namespace beltrami;
using Csr = Eigen::SparseMatrix<double, Eigen::RowMajor, Index>;

constexpr const char* baseline = "Eigen CSR";
constexpr const char* assembled = "Eigen CSR of K D K";

// One mesh in one order.
struct Case {
    explicit Case(const Mesh& mesh, bool renumber)
        : laplacian(mesh, {.renumber = renumber}),
          K(laplacian.stiffness().to_sparse()),
          bilaplacian(laplacian, 0.0, {0.0, 1.0}),
          KDK(bilaplacian.to_sparse()) {
        // The two agree, or their times mean nothing.
        const Block u = Block::Random(laplacian.vertex_count(), 3);
        Block ours;
        bilaplacian.apply(u, ours);
        const Block theirs = KDK * u;
        if ((ours - theirs).norm() > 1e-10 * theirs.norm())
            throw SolveError("the benchmarked products differ", "mend them before timing them");
    }

    Laplacian laplacian;
    Csr K;
    PdeOperator bilaplacian;
    Csr KDK;
};

double csr_bytes(const Csr& matrix, Index columns) {
    return 12.0 * static_cast<double>(matrix.nonZeros()) + 4.0 * matrix.rows() +
           16.0 * columns * matrix.rows();
}

double edge_bytes(const Laplacian& laplacian, Index columns) {
    const double n = laplacian.vertex_count();
    return 13.0 * laplacian.graph().edge_count() + 8.0 * n + 16.0 * columns * n;
}

template <class Work>
void time(const std::string& name, double bytes, double memory, int threads, Work work) {
    benchmark::RegisterBenchmark(name.c_str(),
                                 [=](benchmark::State& state) {
                                     omp_set_num_threads(threads);
                                     for (auto unused : state) {
                                         (void)unused;
                                         work();
                                         benchmark::ClobberMemory();
                                     }
                                     state.counters["bytes"] = bytes;
                                     state.counters["memory"] = memory;
                                     state.counters["threads"] = threads;
                                 })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
}

void add_case(const std::string& where, const std::shared_ptr<const Case>& c) {
    const Index n = c->laplacian.vertex_count();
    const int all = omp_get_num_procs();
    const auto operator_memory = static_cast<double>(c->laplacian.stiffness().memory_bytes()) +
                                 5.0 * c->laplacian.graph().edge_count() + 4.0 * n;
    const auto csr_memory = [](const Csr& m) {
        return 12.0 * static_cast<double>(m.nonZeros()) + 4.0 * m.rows();
    };

    for (const Index columns : {1, 3}) {
        auto u = std::make_shared<Block>(Block::Random(n, columns));
        auto y = std::make_shared<Block>(Block::Zero(n, columns));
        auto workspace = std::make_shared<PdeOperator::Workspace>();
        const std::string K = fmt::format("{} K u, {} column{}", where, columns, columns == 1 ? "" : "s");
        time(K + "/" + baseline, csr_bytes(c->K, columns), csr_memory(c->K), 1, [=] {
            if (columns == 1) {
                y->col(0).noalias() = c->K * u->col(0);
            } else {
                y->noalias() = c->K * *u;
            }
        });
        for (const int threads : {1, all}) {
            time(fmt::format("{}/EdgeOperator, {} thread{}", K, threads, threads == 1 ? "" : "s"),
                 edge_bytes(c->laplacian, columns), operator_memory, threads,
                 [=] { c->laplacian.stiffness().apply(*u, *y); });
        }

        const std::string KDK =
            fmt::format("{} K D K u, {} column{}", where, columns, columns == 1 ? "" : "s");
        time(KDK + "/" + assembled, csr_bytes(c->KDK, columns), csr_memory(c->KDK), 1, [=] {
            if (columns == 1) {
                y->col(0).noalias() = c->KDK * u->col(0);
            } else {
                y->noalias() = c->KDK * *u;
            }
        });
        for (const int threads : {1, all}) {
            // The stored numbers once is the bound even for two products: an ideal sweep runs them together.
            time(fmt::format("{}/PdeOperator, {} thread{}", KDK, threads, threads == 1 ? "" : "s"),
                 edge_bytes(c->laplacian, columns) + 8.0 * n, operator_memory + 8.0 * n, threads,
                 [=] { c->bilaplacian.apply(*u, *y, *workspace); });
        }
    }
}

}  // namespace

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    beltrami::bench::RatioReporter reporter({baseline, assembled});
    for (const Index n : {150000, 1000000}) {
        const Mesh mesh = shapes::shuffled(shapes::bumpy_sphere(n)).mesh;
        for (const bool renumber : {false, true}) {
            add_case(fmt::format("{} {},", n, renumber ? "Cuthill-McKee" : "file order"),
                     std::make_shared<const Case>(mesh, renumber));
        }
    }
    benchmark::RunSpecifiedBenchmarks(&reporter);
    return 0;
}
