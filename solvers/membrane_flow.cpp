#include "beltrami/solvers/membrane_flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/operators/stiffness.hpp"

namespace beltrami {

namespace {

// A triangle with every corner held neither moves nor pulls.
Mesh moving_part(const Mesh& mesh, const Constraints& held) {
    if (mesh.kind() != CellKind::triangle) {
        throw InputError(fmt::format("a membrane needs triangles, but the mesh has {}", plural(mesh.kind())),
                         "give a surface");
    }
    held.check_range(mesh.vertex_count());
    if (held.empty()) {
        throw InputError("nothing is held: the membrane would shrink to a point",
                         "hold at least a vertex of each component");
    }
    std::vector<Index> moving;
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        const auto corners = mesh.cells().row(c);
        if (!std::all_of(corners.begin(), corners.end(), [&](Index v) { return held.is_fixed(v); }))
            moving.push_back(c);
    }
    return {mesh.points(), mesh.cells()(moving, Eigen::all)};
}

void require_positive(double value, const char* what) {
    if (!std::isfinite(value) || value <= 0.0)
        throw InputError(fmt::format("{} of the membrane's flow is {}", what, value),
                         "give a positive number");
}

}  // namespace

MembraneFlow::MembraneFlow(const Mesh& mesh, Constraints held, const MembraneFlowOptions& options)
    : held_(std::move(held)),
      options_(options),
      moving_(moving_part(mesh, held_)),
      graph_(std::make_shared<const EdgeGraph>(moving_.vertex_count(), moving_.cells())),
      step_(options.step),
      now_(size_of(moving_)),
      energy_at_start_(now_.energy) {
    require_positive(options_.step, "the step");
    require_positive(options_.rest, "the limit of rest");
    if (options_.weights == Weights::combinatorial) {
        throw InputError("the combinatorial Laplacian knows no areas",
                         "use area weights or cotangent weights");
    }
    options_.linear.tolerance = std::max(options_.linear.tolerance, 1e-8);
    options_.linear.expected_solves = 1;
    unit_ = options_.weights == Weights::area_weighted ? moving_.cell_count() : now_.area;
    at_rest_ = now_.energy == 0.0;
}

MembraneFlow::Size MembraneFlow::size_of(const Mesh& mesh) const {
    const Vector areas = cell_measures(mesh);
    const double area = areas.sum();
    return {area, options_.weights == Weights::area_weighted ? 0.5 * areas.squaredNorm() : area};
}

void MembraneFlow::advance() {
    if (at_rest_) return;
    EdgeOperator<double> weighted = options_.weights == Weights::area_weighted
                                        ? area_weighted_stiffness(moving_, graph_)
                                        : stiffness(moving_, graph_);
    Block slope;
    weighted.apply(Block(moving_.points()), slope);
    const Laplacian laplacian(std::move(weighted), lumped_mass(moving_),
                              Renumbering::identity(moving_.vertex_count()));
    // The displacement that a step of that length gives; nothing where its solve fails, as may happen where triangles
    // collapse: a shorter step is better conditioned.
    const auto displacement = [&](double dt) -> std::optional<Block> {
        Block moved = Block::Zero(slope.rows(), 3);
        try {
            LinearSolver solver(PdeOperator(laplacian, 1.0, {dt}), options_.linear);
            const LinearSummary solved = solver.solve(-dt * slope, held_, moved);
            if (!solved.converged) return std::nullopt;
            summary_.add(solved);
        } catch (const SolveError&) {
            return std::nullopt;
        }
        return moved;
    };
    constexpr int most_halvings = 30;
    for (int halvings = 0; halvings <= most_halvings; ++halvings, step_ /= 2.0) {
        const std::optional<Block> moved = displacement(step_ * unit_);
        if (!moved) continue;
        const Mesh next = moving_.with_points(moving_.points() + *moved);
        const Size size = size_of(next);
        if (!(size.energy <= now_.energy)) continue;
        const double fall = (now_.energy - size.energy) / energy_at_start_;
        const double enough = options_.rest * std::min(1.0, options_.step);
        at_rest_ = fall <= enough;
        nearness_ = at_rest_ ? 1.0 : std::clamp(std::log(fall) / std::log(enough), 0.0, 1.0);
        moving_ = next;
        now_ = size;
        time_ += step_;
        ++step_count_;
        step_ = std::min(2.0 * step_, options_.step);
        return;
    }
    at_rest_ = true;
}

}  // namespace beltrami
