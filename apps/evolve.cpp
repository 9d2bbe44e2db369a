#include "beltrami/apps/evolve.hpp"

#include <fmt/format.h>

#include <cmath>

#include "beltrami/framework/error.hpp"

namespace beltrami {

Evolution evolve(const Laplacian& laplacian, const Pde& pde, const Block& u, const Block& v,
                 const Constraints& held, const EvolveOptions& options) {
    if (!std::isfinite(options.time) || options.time <= 0.0) {
        throw InputError(fmt::format("the time to simulate is {}", options.time), "give a positive number");
    }
    if (options.steps < 1) throw InputError(fmt::format("{} time steps", options.steps), "take at least one");
    const Renumbering& order = laplacian.order();
    held.check_range(laplacian.vertex_count());
    Block start = u;
    held.impose(start);
    const Constraints held_working = order.to_working(held);

    TimeOptions time_options{options.time / options.steps, options.method, options.steps, options.linear};
    time_options.linear.progress = options.progress;
    TimeIntegrator integrator(laplacian, pde, time_options);
    integrator.set_state(order.to_working(start), order.to_working(v));

    Evolution result;
    result.energy_before = integrator.energy().sum();
    const auto show = [&](double energy) {
        if (options.on_frame) {
            options.on_frame(
                {integrator.step_count(), integrator.time(), order.to_user(integrator.u()), energy});
        }
    };
    show(result.energy_before);
    for (int step = 1; step <= options.steps; ++step) {
        integrator.advance(held_working);
        show(options.on_frame ? integrator.energy().sum() : 0.0);
        report(options.progress, "time steps", static_cast<double>(step) / options.steps);
    }
    result.u = order.to_user(integrator.u());
    result.summary = integrator.summary();
    result.energy_after = integrator.energy().sum();
    return result;
}

double extent(const Mesh& mesh) {
    Vector3 lower = Vector3::Constant(INFINITY);
    Vector3 upper = Vector3::Constant(-INFINITY);
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        for (Eigen::Index k = 0; k < mesh.cells().cols(); ++k) {
            const Vector3 p = mesh.points().row(mesh.cells()(c, k)).transpose();
            lower = lower.cwiseMin(p);
            upper = upper.cwiseMax(p);
        }
    }
    return mesh.cell_count() > 0 ? 0.5 * (upper - lower).norm() : 0.0;
}

}  // namespace beltrami
