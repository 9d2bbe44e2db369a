// What heat, wave and fair share: a field that changes in time, step by step, in the user's order.
#pragma once

#include <functional>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/framework/progress.hpp"
#include "beltrami/solvers/time_integrator.hpp"

namespace beltrami {

/// A state that a simulation has reached. u in the user's order.
struct Frame {
    int step;
    double time;
    const Block& u;
    double energy;  ///< TimeIntegrator::energy(), summed over the columns
};

struct EvolveOptions {
    double time = 0.0;  ///< total, positive
    int steps = 0;      ///< at least 1
    TimeMethod method = TimeMethod::backward_euler;
    LinearSolverOptions linear = {};
    const Progress* progress = nullptr;
    std::function<void(const Frame&)> on_frame = {};  ///< called for the start and after every step
};

struct Evolution {
    Block u;  ///< at the end, n x k in the user's order
    LinearSummary summary;
    double energy_before = 0.0;
    double energy_after = 0.0;
};

/// From displacement u and velocity v (n x k) with vertices held at constant values, all in the user's order. Held
/// values are imposed on the start. Throws InputError for a time or number of steps that is not positive.
Evolution evolve(const Laplacian& laplacian, const Pde& pde, const Block& u, const Block& v,
                 const Constraints& held, const EvolveOptions& options);

/// Half the diagonal of the bounding box of the vertices that cells use, 0 for a mesh without cells: a length to choose a
/// time by.
double extent(const Mesh& mesh);

}  // namespace beltrami
