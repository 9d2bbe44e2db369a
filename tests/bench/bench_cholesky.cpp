// Factors and solves of M + t K and K D K by Cholesky against CHOLMOD, one thread.
//
//     ./dev bench cholesky           # the options of Google Benchmark
//     BELTRAMI_BENCH_VERTICES=1000000 ./dev bench cholesky

#include <fmt/format.h>
#include <omp.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "cholmod_factor.hpp"
#include "ratios.hpp"

namespace {

using namespace beltrami;
using Sparse = Eigen::SparseMatrix<double>;

template <class Work>
void time(const std::string& name, double bytes, double memory, Work work) {
    benchmark::RegisterBenchmark(name.c_str(),
                                 [=](benchmark::State& state) {
                                     omp_set_num_threads(1);
                                     for (auto unused : state) {
                                         (void)unused;
                                         work();
                                     }
                                     state.counters["threads"] = 1;
                                     state.counters["bytes"] = bytes;
                                     state.counters["memory"] = memory;
                                 })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
}

void add(const std::string& name, const Sparse& A, const std::vector<Index>& held) {
    const auto analysis = std::make_shared<const CholeskyAnalysis>(A, CholeskyOrdering::metis);
    const auto ours = std::make_shared<Cholesky>(A, analysis, held);
    const auto matrix = std::make_shared<const Sparse>(A);
    // The same rows and columns of the identity.
    Sparse identity = A;
    std::vector<char> mask(static_cast<std::size_t>(A.cols()), 0);
    for (const Index v : held)
        mask[static_cast<std::size_t>(v)] = 1;
    for (Eigen::Index col = 0; col < A.cols(); ++col) {
        for (Sparse::InnerIterator entry(identity, col); entry; ++entry) {
            if (mask[static_cast<std::size_t>(col)] != 0 || mask[static_cast<std::size_t>(entry.row())] != 0)
                entry.valueRef() = entry.row() == col ? 1.0 : 0.0;
        }
    }
    const auto theirs = std::make_shared<bench::CholmodFactor>(identity, true);
    time(name + " factor/Cholesky", 0.0, static_cast<double>(ours->memory_bytes()),
         [=] { ours->refactor(*matrix, held); });
    time(name + " factor/CHOLMOD", 0.0, theirs->memory_bytes(), [=] { theirs->factor(); });
    for (const Index columns : {1, 3, 32, 100}) {
        const auto b = std::make_shared<Block>(Block::Random(A.cols(), columns));
        const auto x = std::make_shared<Block>();
        const std::string what = fmt::format("{} solve of {}", name, columns);
        time(what + "/Cholesky", 16.0 * ours->nonzeros(), static_cast<double>(ours->memory_bytes()),
             [=] { ours->solve(*b, *x); });
        for (const Index width : {8, 16, 32, 64, 100}) {
            if (width > columns && width > 8) break;
            time(fmt::format("{}/CHOLMOD by {}", what, width), 16.0 * theirs->nonzeros(),
                 theirs->memory_bytes(), [=] { theirs->solve(*b, *x, width); });
        }
    }
}

}  // namespace

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    omp_set_num_threads(1);
    const char* wanted = std::getenv("BELTRAMI_BENCH_VERTICES");
    const Index n = wanted != nullptr ? std::atoi(wanted) : 150000;
    const Laplacian laplacian(shapes::bumpy_sphere(n));
    const double h2 = laplacian.mass().sum() / n;
    std::vector<Index> held;
    for (Index i = 0; i < 100; ++i)
        held.push_back(n / 100 * i);
    bench::RatioReporter reporter({"CHOLMOD", "CHOLMOD by 32", "CHOLMOD by 8"});
    add("M + tK", PdeOperator(laplacian, 1.0, {100.0 * h2}).to_sparse(), {});
    add("K D K", PdeOperator(laplacian, 0.0, {0.0, 1.0}).to_sparse(), held);
    benchmark::RunSpecifiedBenchmarks(&reporter);
    return 0;
}
