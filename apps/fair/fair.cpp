#include "beltrami/apps/fair/fair.hpp"

#include <utility>

#include "beltrami/apps/region.hpp"
#include "beltrami/apps/term_weights.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// Where the flow ends: A (x + d) = 0 on the region. The displacement d is solved for, about the mesh's middle, so that
// meshes far from the origin lose no digits.
std::pair<Points, LinearSummary> until_rest(const Mesh& mesh, const Laplacian& laplacian,
                                            const Constraints& held, const std::vector<double>& gamma,
                                            const FairOptions& options) {
    if (held.empty()) {
        throw InputError("the region is the whole mesh: nothing would stay fixed",
                         "leave vertices out of the region, or let the flow run for a time");
    }
    const Renumbering& order = laplacian.order();
    const Constraints held_working =
        order.to_working(hold_free_components(laplacian, held, options.free_components));
    LinearSolverOptions linear = options.linear;
    linear.progress = options.progress;
    LinearSolver solver(PdeOperator(laplacian, 0.0, gamma), linear);
    Block load;
    solver.op().apply(order.to_working(mesh.points().rowwise() - mesh.points().colwise().mean()), load);
    load *= -1.0;
    Block displacement = Block::Zero(mesh.vertex_count(), 3);
    LinearSummary summary = solver.solve(load, held_working, displacement);
    require_converged(summary);
    return {mesh.points() + order.to_user(displacement), std::move(summary)};
}

std::pair<Points, LinearSummary> flow(const Mesh& mesh, const Laplacian& laplacian, const Constraints& held,
                                      const std::vector<double>& gamma, const FairOptions& options) {
    Constraints place(3);
    for (const Index v : held.vertices())
        place.fix(v, std::span(mesh.points().row(v).data(), 3));
    EvolveOptions evolution;
    evolution.time = *options.time;
    evolution.steps = options.steps;
    evolution.linear = options.linear;
    evolution.progress = options.progress;
    evolution.on_frame = options.on_frame;
    const Pde pde{.beta_1 = 1.0, .gamma = gamma};
    Evolution end =
        evolve(laplacian, pde, mesh.points(), Block::Zero(mesh.vertex_count(), 3), place, evolution);
    return {end.u, std::move(end.summary)};
}

}  // namespace

FairResult fair(const Mesh& mesh, const Laplacian& laplacian, std::span<const Index> region,
                const FairOptions& options) {
    const std::vector<double> gamma = term_weights(options.laplacian, options.bilaplacian);
    const Constraints held = hold_outside(region, laplacian.vertex_count());
    FairResult result;
    std::tie(result.points, result.summary) = options.time
                                                  ? flow(mesh, laplacian, held, gamma, options)
                                                  : until_rest(mesh, laplacian, held, gamma, options);
    result.stayed = isolated_inside(laplacian, held);
    return result;
}

}  // namespace beltrami
