#include "beltrami/apps/poisson/poisson.hpp"

#include <fmt/format.h>

#include "beltrami/framework/error.hpp"
#include "beltrami/operators/gradient.hpp"

namespace beltrami {

namespace {

// load: n x k in the working order.
PoissonResult solve(const Laplacian& laplacian, const Block& load, const Constraints& fixed,
                    const PoissonOptions& options) {
    const Constraints held =
        laplacian.order().to_working(hold_free_components(laplacian, fixed, options.free_components));
    LinearSolver solver(PdeOperator(laplacian, 0.0, {1.0}), options.linear);
    Block u = Block::Zero(load.rows(), load.cols());
    const LinearSummary summary = solver.solve(load, held, u);
    require_converged(summary);
    return {laplacian.order().to_user(u), summary};
}

}  // namespace

PoissonResult poisson(const Laplacian& laplacian, const Block& f, const Constraints& fixed,
                      const PoissonOptions& options) {
    if (f.rows() != laplacian.vertex_count()) {
        throw InputError(
            fmt::format("a right-hand side of {} rows for {} vertices", f.rows(), laplacian.vertex_count()),
            "give a value for each vertex");
    }
    const Block load = -(laplacian.mass().asDiagonal() * laplacian.order().to_working(f));
    return solve(laplacian, load, fixed, options);
}

PoissonResult poisson_from_gradient(const Mesh& mesh, const Laplacian& laplacian, const Points& vectors,
                                    const Constraints& fixed, const PoissonOptions& options) {
    const Block load = -laplacian.order().to_working(Block(divergence(mesh, cell_average(mesh, vectors))));
    return solve(laplacian, load, fixed, options);
}

}  // namespace beltrami
