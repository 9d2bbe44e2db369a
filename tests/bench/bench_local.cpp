// Local steps of gamma_1 K + gamma_2 K D K, 3 columns: what they cost by the size of the mesh and of the patch, against
// steps of the whole mesh.
//
//     ./dev bench local              # two tables, then the comparison by Google Benchmark, whose options it takes

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "cholmod_factor.hpp"
#include "ratios.hpp"
#include "refined.hpp"

namespace {

using namespace beltrami;

constexpr double dt = 1e-3;
using std::numbers::pi;

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

// 121,002 vertices in no order.
Mesh rough_sphere() {
    return shapes::shuffled(shapes::with_noise(shapes::geodesic_icosahedron(110), 0.1)).mesh;
}

// How many active vertices one core sustains at 1 kHz.
void table_of_1_kHz() {
    const Mesh mesh = rough_sphere();
    const auto laplacian = std::make_shared<const Laplacian>(mesh);
    const double edge = mean_edge(mesh);
    fmt::print("steps of 1 ms on {} vertices, 3 columns, one core, 1000 steps after 300; milliseconds\n",
               mesh.vertex_count());
    fmt::print("{:>9} {:>8} {:>11} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "tolerance", "active", "iterations",
               "median", "99 %", "most", "MB", "GB/s");
    for (const double tolerance : {1e-2, 1e-3}) {
        for (const double reach : {1.0, 1.5, 2.0, 2.5, 3.0, 3.25, 3.5, 4.0, 5.0}) {
            Poke poke(laplacian, mesh.vertex_count() / 3, reach * edge, tolerance);
            std::vector<double> milliseconds, active, iterations;
            double bytes = 0.0;
            double total = 0.0;
            for (int step = 0; step < 1300; ++step) {
                const LocalStep s = poke.step();
                if (step < 300) continue;
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

// The same patch on meshes that are refined elsewhere only: counts over 300 steps, and the time of a step. The meshes take
// turns in blocks of steps, so that the machine's moods come to all of them, and the median block counts.
void table_of_elsewhere() {
    Mesh mesh = shapes::geodesic_icosahedron(59);
    const double length = 2.0 * mean_edge(mesh);
    const Index vertex = 20000;
    const Vector3 middle = mesh.points().row(vertex).transpose();
    struct Row {
        Index vertices;
        std::string counts;
        Poke poke;
        std::vector<double> milliseconds;
    };
    std::vector<Row> rows;
    // Finer beyond 1 unit of length, and again beyond larger ones, up to a million vertices.
    for (const double beyond : {0.0, 0.9, 1.15, 1.4}) {
        if (beyond > 0.0) {
            mesh =
                testing::refined_where(mesh, [&](const Vector3& p) { return (p - middle).norm() > beyond; });
        }
        Row row{
            mesh.vertex_count(), {}, Poke(std::make_shared<const Laplacian>(mesh), vertex, length, 1e-2), {}};
        LocalStep sum;
        for (int step = 0; step < 300; ++step) {
            const LocalStep s = row.poke.step();
            sum.active = s.active;
            sum.iterations += s.iterations;
            sum.products += s.products;
            sum.bytes += s.bytes;
        }
        row.counts = fmt::format("{:>7} {:>11} {:>9} {:>10.1f}", sum.active, sum.iterations, sum.products,
                                 sum.bytes / 1e6);
        rows.push_back(std::move(row));
    }
    constexpr int blocks = 60;
    constexpr int steps = 200;
    for (int block = 0; block < blocks; ++block) {
        for (Row& row : rows) {
            double seconds = 0.0;
            for (int step = 0; step < steps; ++step)
                seconds += row.poke.step().seconds;
            row.milliseconds.push_back(1e3 * seconds / steps);
        }
    }
    fmt::print("the same patch, the mesh refined elsewhere; counts of 300 steps, milliseconds of a step\n");
    fmt::print("{:>9} {:>7} {:>11} {:>9} {:>10} {:>9} {:>9} {:>9}\n", "vertices", "active", "iterations",
               "products", "MB", "median", "ratio", "counts");
    const double first = at(rows.front().milliseconds, 0.5);
    for (Row& row : rows) {
        const double median = at(row.milliseconds, 0.5);
        fmt::print("{:>9} {} {:>9.3f} {:>9.2f} {:>9}\n", row.vertices, row.counts, median, median / first,
                   row.counts == rows.front().counts ? "equal" : "DIFFER");
    }
    fmt::print("\n");
    std::fflush(stdout);
}

// The same step by the whole mesh.
void add_global() {
    const Mesh mesh = rough_sphere();
    const auto laplacian = std::make_shared<const Laplacian>(mesh);
    const double length = 3.0 * mean_edge(mesh);
    const Index vertex = mesh.vertex_count() / 3;
    const std::string what = fmt::format("step on {} vertices", mesh.vertex_count());
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
        time(what + (kind == SolverKind::cg ? "/global CG" : "/global Cholesky"),
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
        bench::CholmodFactor factor(A.to_sparse(), true);
        const Block b = Block::Random(laplacian->vertex_count(), 3);
        Block x;
        for (auto unused : state) {
            (void)unused;
            factor.solve(b, x, 3);
        }
        state.counters["memory"] = factor.memory_bytes();
        state.counters["bytes"] = 2.0 * 8.0 * factor.nonzeros();
    })->Iterations(20);
}

}  // namespace

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    omp_set_num_threads(1);
    beltrami::bench::RatioReporter reporter({"CHOLMOD back-substitution"});
    table_of_1_kHz();
    table_of_elsewhere();
    add_global();
    benchmark::RunSpecifiedBenchmarks(&reporter);
    return 0;
}
