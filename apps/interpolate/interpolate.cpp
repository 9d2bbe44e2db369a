#include "beltrami/apps/interpolate/interpolate.hpp"

#include "beltrami/framework/error.hpp"

namespace beltrami {

InterpolateResult interpolate(const Laplacian& laplacian, const Constraints& fixed,
                              const InterpolateOptions& options) {
    if (fixed.empty())
        throw InputError("no vertex is fixed, so there is nothing to interpolate", "fix at least one");
    if (options.laplacian == 0.0 && options.bilaplacian == 0.0) {
        throw InputError("the coefficients of Laplacian and bi-Laplacian are both 0",
                         "give one of them a value");
    }
    const Renumbering& order = laplacian.order();
    const Constraints held =
        order.to_working(hold_free_components(laplacian, fixed, options.free_components));
    LinearSolver solver(PdeOperator(laplacian, 0.0, {options.laplacian, options.bilaplacian}),
                        options.linear);
    Block value = Block::Zero(laplacian.vertex_count(), fixed.columns());
    const Block no_load = value;
    const LinearSummary summary = solver.solve(no_load, held, value);
    require_converged(summary);
    return {order.to_user(value), summary};
}

}  // namespace beltrami
