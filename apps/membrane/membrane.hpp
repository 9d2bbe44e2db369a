// Membranes: a region of a surface shrinks to the film of least area that the rest holds.
//
//     const MembraneResult film = membrane(mesh, laplacian, region, {});
//     write_mesh("film.ply", mesh.with_points(film.points));
//
// The flow of solvers/membrane_flow.hpp, until rest or for a number of steps: section 5.2, Figures 6 and 7 of Kim &
// Rossignac. Weighting by area keeps the triangles equal; with cotangent weights vertices gather.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "beltrami/apps/evolve.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "beltrami/solvers/free_components.hpp"
#include "beltrami/solvers/membrane_flow.hpp"

namespace beltrami {

struct MembraneOptions {
    MembraneFlowOptions flow = {};
    int steps = 0;  ///< the most to take; 0 goes until rest
    /// Components that lie in the region as a whole would shrink to a point.
    FreeComponents free_components = FreeComponents::refuse;
    const Progress* progress = nullptr;
    std::function<void(const Frame&)> on_frame = {};  ///< for the start and every step; u are the positions
};

struct MembraneResult {
    Points points;               ///< n x 3 in the user's order
    bool at_rest = false;        ///< always, unless a number of steps was asked for
    double time = 0.0;           ///< without a unit, see MembraneFlowOptions::step
    std::vector<double> areas;   ///< of the triangles that move, at the start and after every step
    std::vector<double> energy;  ///< what every step lowers: half the sum of their squares, or the area
    LinearSummary summary;
    Index stayed = 0;  ///< vertices of the region without a cell: they stay
};

/// `region` in the user's numbering: the vertices that may move. Throws InputError for cells that are not triangles, a
/// region without vertices, one out of range, components that nothing holds, and a step that is not positive;
/// SolveError where the flow is not at rest after 2000 steps.
MembraneResult membrane(const Mesh& mesh, const Laplacian& laplacian, std::span<const Index> region,
                        const MembraneOptions& options);

}  // namespace beltrami
