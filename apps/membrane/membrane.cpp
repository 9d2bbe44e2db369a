#include "beltrami/apps/membrane/membrane.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "beltrami/apps/region.hpp"
#include "beltrami/framework/error.hpp"

namespace beltrami {

MembraneResult membrane(const Mesh& mesh, const Laplacian& laplacian, std::span<const Index> region,
                        const MembraneOptions& options) {
    if (options.steps < 0)
        throw InputError(fmt::format("{} steps", options.steps), "take at least one, or go until rest");
    const Constraints held = hold_outside(region, laplacian.vertex_count());
    const Renumbering& order = laplacian.order();
    MembraneFlowOptions flow_options = options.flow;
    flow_options.linear.progress = options.progress;
    MembraneFlow flow(order.to_working(Mesh(mesh.points(), mesh.cells())),
                      order.to_working(hold_free_components(laplacian, held, options.free_components)),
                      flow_options);
    MembraneResult result;
    const auto show = [&] {
        result.areas.push_back(flow.area());
        result.energy.push_back(flow.energy());
        if (options.on_frame)
            options.on_frame(
                {flow.step_count(), flow.time(), order.to_user(Block(flow.points())), flow.energy()});
    };
    show();
    constexpr int most_steps = 2000;
    const int limit = options.steps > 0 ? options.steps : most_steps;
    while (!flow.at_rest() && flow.step_count() < limit) {
        const int before = flow.step_count();
        flow.advance();
        if (flow.step_count() > before) show();
        const double of_steps = options.steps > 0 ? static_cast<double>(flow.step_count()) / limit : 0.0;
        report(options.progress, "steps", std::max(of_steps, flow.nearness()));
    }
    if (!flow.at_rest() && options.steps == 0) {
        throw SolveError(fmt::format("the membrane is not at rest after {} steps", limit),
                         "take a larger step, or as many steps as you want with --steps");
    }
    result.points = order.to_user(Block(flow.points()));
    result.at_rest = flow.at_rest();
    result.time = flow.time();
    result.summary = flow.summary();
    result.stayed = isolated_inside(laplacian, held);
    return result;
}

}  // namespace beltrami
