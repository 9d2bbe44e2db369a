// Multigrid on every mesh under ../shared/meshes: slivers, boundary, non-manifold edges, many components.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/read_mesh.hpp"
#include "beltrami/solvers/linear_solver.hpp"
#include "meshes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::relative_difference;
using testing::shared_mesh;
using testing::shared_meshes;

// A vertex of each component, and every so many.
Constraints spread_over(const Laplacian& laplacian) {
    const Components components = connected_components(laplacian.graph());
    std::vector<char> has(static_cast<std::size_t>(components.count), 0);
    const Index n = laplacian.vertex_count();
    Constraints held;
    for (Index v = 0; v < n; ++v) {
        char& held_here = has[static_cast<std::size_t>(components.of_vertex[static_cast<std::size_t>(v)])];
        if (held_here == 0 || v % std::max(n / 30, 1) == 0)
            held.fix(v, std::sin(static_cast<double>(held.vertices().size())));
        held_here = 1;
    }
    return held;
}

TEST(SolverRobustness, EverySharedMesh) {
    BELTRAMI_SKIP_WITHOUT(shared_mesh("bunny_3485.off"));
    int solves = 0;
    int failures = 0;
    for (const std::filesystem::path& file : shared_meshes()) {
        const Mesh mesh = read_mesh(file.string());
        if (mesh.kind() == CellKind::point || mesh.vertex_count() > BELTRAMI_LARGEST_LOCAL_MESH) continue;
        const Laplacian laplacian(mesh);
        const double h2 = laplacian.mass().sum() / laplacian.vertex_count();
        const auto hierarchy = std::make_shared<const Hierarchy>(
            laplacian.graph(), *laplacian.points(), HierarchyOptions{.radius = 2.3, .coarsest = 100});
        const Constraints held = spread_over(laplacian);
        const Block b = Block::Zero(laplacian.vertex_count(), 1);
        for (const PdeOperator& A :
             {PdeOperator(laplacian, 1.0, {100.0 * h2}), PdeOperator(laplacian, 0.0, {1.0}),
              PdeOperator(laplacian, 0.0, {0.0, 1.0})}) {
            const std::string what =
                fmt::format("{}, order {}, sigma {}", file.filename().string(), A.order(), A.sigma());
            Block expected = b;
            LinearSolver direct(A, {.kind = SolverKind::cholesky, .tolerance = 1e-13});
            const LinearSummary by_factor = direct.solve(b, held, expected);
            Block x = b;
            LinearSolver solver(A, {.kind = SolverKind::multigrid, .hierarchy = hierarchy});
            const LinearSummary summary = solver.solve(b, held, x);
            ++solves;
            if (summary.converged) {
                EXPECT_LT(relative_difference(x, expected), 1e-6) << what << '\n' << summary.full();
                continue;
            }
            // What the choice of a solver is for.
            ++failures;
            fmt::print("{}: multigrid stopped at {:.1e} after {} cycles\n", what, summary.error,
                       summary.iterations);
            x = b;
            LinearSolver automatic(A, {.hierarchy = hierarchy});
            EXPECT_TRUE(automatic.solve(b, held, x).converged) << what;
            EXPECT_LT(relative_difference(x, expected), 1e-6) << what;
        }
    }
    EXPECT_GT(solves, 60);
    EXPECT_LE(failures, 3) << "K D K on bunny_tets, dragon_100k and teapot";
}

}  // namespace
}  // namespace beltrami
