// Local steps of gamma_1 K + gamma_2 K D K, 3 columns: what they cost by the size of the mesh and of the patch, against
// steps of the whole mesh.
//
//     ./dev bench local                                      # all three
//     ./dev bench local --benchmark_filter=elsewhere         # Google Benchmark's own options; the table of 1 kHz comes first

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "ratios.hpp"
#include "refined.hpp"

namespace {

using namespace beltrami;

constexpr double dt = 1e-3;
constexpr double pi = 3.14159265358979323846;

// Swings back 10 times a second, critically damped, over a length.
Pde skin(double length) {
    const double w = 2.0 * pi * 10.0;
    const double l2 = length * length;
    return {
        .alpha = 1.0, .beta_1 = 2.0 * w, .gamma = {0.2 * w * w * l2, w * w * l2 * l2}, .foundation = w * w};
}

// A finger that never rests.
Hold finger(Index v, long step) {
    const double t = static_cast<double>(step) * dt;
    return {{v},
            {1.0},
            {0.02 * std::sin(2.0 * pi * 5.0 * t), 0.01 * std::sin(2.0 * pi * 3.0 * t),
             -0.03 + 0.01 * std::sin(2.0 * pi * 7.0 * t)}};
}

struct Poke {
    Poke(std::shared_ptr<const Laplacian> surface, Index vertex, double length, double tolerance)
        : laplacian(std::move(surface)),
          v(laplacian->order().working(vertex)),
          motion(*laplacian, skin(length), dt, 3, {.tolerance = tolerance}) {}

    LocalStep step() { return motion.advance(std::array{finger(v, ++count)}); }

    std::shared_ptr<const Laplacian> laplacian;
    Index v;
    LocalIntegrator motion;
    long count = 0;
};

double mean_edge(const Mesh& mesh) {
    return report(mesh).mean_edge;
}

double at(std::vector<double>& sorted, double part) {
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size() - 1))];
}

// How many active vertices one core sustains at 1 kHz.
void table_of_1_kHz() {
    const Mesh mesh = shapes::shuffled(shapes::bumpy_sphere(150000)).mesh;
    const auto laplacian = std::make_shared<const Laplacian>(mesh);
    const double edge = mean_edge(mesh);
    fmt::print("steps of 1 ms on {} vertices, 3 columns, one core, 2000 steps after 500; milliseconds\n",
               mesh.vertex_count());
    fmt::print("{:>9} {:>8} {:>11} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "tolerance", "active", "iterations",
               "median", "99 %", "most", "MB", "GB/s");
    for (const double tolerance : {1e-2, 3e-2}) {
        for (const double reach : {1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0}) {
            Poke poke(laplacian, mesh.vertex_count() / 3, reach * edge, tolerance);
            std::vector<double> milliseconds, active, iterations;
            double bytes = 0.0;
            double total = 0.0;
            for (int step = 0; step < 2500; ++step) {
                const LocalStep s = poke.step();
                if (step < 500) continue;
                milliseconds.push_back(1e3 * s.seconds);
                active.push_back(s.active);
                iterations.push_back(s.iterations);
                bytes += s.bytes;
                total += s.seconds;
            }
            fmt::print("{:>9} {:>8} {:>11} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.2f} {:>9.1f}\n", tolerance,
                       at(active, 0.5), at(iterations, 0.5), at(milliseconds, 0.5), at(milliseconds, 0.99),
                       at(milliseconds, 1.0), static_cast<double>(poke.motion.memory_bytes()) / 1e6,
                       bytes / total / 1e9);
        }
    }
    fmt::print("\n");
}

template <class Work>
benchmark::internal::Benchmark* time(const std::string& name, Work work) {
    return benchmark::RegisterBenchmark(name.c_str(),
                                        [=](benchmark::State& state) {
                                            omp_set_num_threads(1);
                                            work(state);
                                            state.counters["threads"] = 1;
                                        })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
}

// The same patch on meshes that are refined elsewhere only.
void add_elsewhere() {
    Mesh mesh = shapes::geodesic_icosahedron(59);
    const double length = 2.0 * mean_edge(mesh);
    const Index vertex = 20000;
    const Vector3 middle = mesh.points().row(vertex).transpose();
    std::vector<std::string> counts;
    // Beyond 1 unit of length, and again beyond larger ones, up to a million vertices.
    for (const double beyond : {0.0, 0.9, 1.15, 1.4}) {
        if (beyond > 0.0) {
            mesh =
                testing::refined_where(mesh, [&](const Vector3& p) { return (p - middle).norm() > beyond; });
        }
        const auto laplacian = std::make_shared<const Laplacian>(mesh);
        // Counted apart from the timing, over the same steps on each mesh.
        Poke counted(laplacian, vertex, length, 1e-2);
        LocalStep sum;
        Index active = 0;
        for (int step = 0; step < 300; ++step) {
            const LocalStep s = counted.step();
            sum.iterations += s.iterations;
            sum.products += s.products;
            sum.bytes += s.bytes;
            active = s.active;
        }
        counts.push_back(fmt::format("{} active, {} iterations, {} products, {:.0f} bytes in 300 steps",
                                     active, sum.iterations, sum.products, sum.bytes));
        fmt::print("{:>8} vertices: {}{}\n", mesh.vertex_count(), counts.back(),
                   counts.back() == counts.front() ? "" : "   DIFFERENT");
        time(fmt::format("step, refined elsewhere/{} vertices",
                         counts.size() == 1 ? "35 K" : fmt::format("{}", mesh.vertex_count())),
             [=](benchmark::State& state) {
                 Poke poke(laplacian, vertex, length, 1e-2);
                 for (int step = 0; step < 300; ++step)
                     poke.step();
                 double bytes = 0.0;
                 for (auto unused : state) {
                     (void)unused;
                     bytes += poke.step().bytes;
                 }
                 state.counters["bytes"] = bytes / static_cast<double>(state.iterations());
                 state.counters["memory"] = static_cast<double>(poke.motion.memory_bytes());
             })
            ->Iterations(4000)
            ->Repetitions(5);
    }
    fmt::print("\n");
}

// The same step by the whole mesh.
void add_global() {
    const Mesh mesh = shapes::shuffled(shapes::bumpy_sphere(150000)).mesh;
    const auto laplacian = std::make_shared<const Laplacian>(mesh);
    const double length = 2.5 * mean_edge(mesh);
    const Index vertex = mesh.vertex_count() / 3;
    const std::string what = "step on 150000 vertices";
    time(what + "/local", [=](benchmark::State& state) {
        Poke poke(laplacian, vertex, length, 1e-2);
        LocalStep last;
        for (int step = 0; step < 500; ++step)
            last = poke.step();
        for (auto unused : state) {
            (void)unused;
            last = poke.step();
        }
        state.counters["bytes"] = last.bytes;
        state.counters["memory"] = static_cast<double>(poke.motion.memory_bytes());
    })->Iterations(2000);
    for (const auto kind : {SolverKind::cg, SolverKind::cholesky}) {
        // 1e-4 in the energy error is what CG needs to be as good as the local step.
        time(what + (kind == SolverKind::cg ? "/global CG" : "/global CHOLMOD"),
             [=](benchmark::State& state) {
                 TimeIntegrator motion(
                     *laplacian, skin(length),
                     {.step = dt,
                      .method = TimeMethod::backward_euler,
                      .steps = 1000,
                      .linear = {.kind = kind, .tolerance = kind == SolverKind::cg ? 1e-2 : 1e-6}});
                 motion.set_state(Block::Zero(laplacian->vertex_count(), 3));
                 const Index v = laplacian->order().working(vertex);
                 long step = 0;
                 const auto advance = [&] {
                     const Hold hold = finger(v, ++step);
                     Constraints held(3);
                     held.fix(v, hold.value);
                     motion.advance(held);
                 };
                 advance();
                 for (auto unused : state) {
                     (void)unused;
                     advance();
                 }
                 state.counters["memory"] = static_cast<double>(motion.summary().memory_bytes);
             })
            ->Iterations(20);
    }
    // What CHOLMOD cannot do without: one back-substitution of three columns with the factor at hand.
    time(what + "/CHOLMOD back-substitution", [=](benchmark::State& state) {
        const Pde pde = skin(length);
        std::vector<double> gamma = pde.gamma;
        for (double& g : gamma)
            g *= dt * dt;
        const PdeOperator A(*laplacian, pde.alpha + pde.beta_1 * dt + dt * dt * pde.foundation, gamma);
        const Cholesky factor(A.to_sparse(), Cholesky::Ordering::metis);
        const Block b = Block::Random(laplacian->vertex_count(), 3);
        Block x;
        for (auto unused : state) {
            (void)unused;
            factor.solve(b, x);
        }
        state.counters["memory"] = static_cast<double>(factor.memory_bytes());
        state.counters["bytes"] = 2.0 * 8.0 * factor.nonzeros();
    })->Iterations(20);
}

}  // namespace

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    omp_set_num_threads(1);
    beltrami::bench::RatioReporter reporter({"35 K vertices", "CHOLMOD back-substitution"});
    table_of_1_kHz();
    add_elsewhere();
    add_global();
    benchmark::RunSpecifiedBenchmarks(&reporter);
    return 0;
}
