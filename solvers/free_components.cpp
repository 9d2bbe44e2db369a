#include "beltrami/solvers/free_components.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

#include "beltrami/framework/error.hpp"

namespace beltrami {

Constraints hold_free_components(const Laplacian& laplacian, const Constraints& held, FreeComponents policy) {
    return hold_free_components(laplacian, connected_components(laplacian.graph()), held, policy);
}

Constraints hold_free_components(const Laplacian& laplacian, const Components& components,
                                 const Constraints& held, FreeComponents policy) {
    const Renumbering& order = laplacian.order();
    held.check_range(laplacian.vertex_count());
    const auto component = [&](Index user) {
        return static_cast<std::size_t>(components.of_vertex[static_cast<std::size_t>(order.working(user))]);
    };
    std::vector<char> is_held(static_cast<std::size_t>(components.count), 0);
    for (const Index v : held.vertices())
        is_held[component(v)] = 1;

    Constraints all = held;
    const std::vector<double> zero(static_cast<std::size_t>(held.columns()), 0.0);
    std::vector<char> seen(static_cast<std::size_t>(components.count), 0);
    std::vector<Index> first_vertices;
    for (Index v = 0; v < laplacian.vertex_count(); ++v) {
        const std::size_t c = component(v);
        if (is_held[c] != 0 || laplacian.graph().degree(order.working(v)) == 0) continue;
        if (seen[c] == 0) first_vertices.push_back(v);
        seen[c] = 1;
        all.fix(v, zero);
    }
    if (first_vertices.empty() || policy == FreeComponents::keep_at_zero) return all;

    const auto shown = std::min<std::ptrdiff_t>(std::ssize(first_vertices), 10);
    throw InputError(
        fmt::format("{} component{} of the mesh ha{} no constraint, with {} {}{}", first_vertices.size(),
                    first_vertices.size() == 1 ? "" : "s", first_vertices.size() == 1 ? "s" : "ve",
                    first_vertices.size() == 1 ? "vertex" : "vertices",
                    fmt::join(first_vertices.begin(), first_vertices.begin() + shown, ", "),
                    shown < std::ssize(first_vertices) ? ", ..." : ""),
        "fix a vertex of each, or leave them at zero with --free-components keep");
}

}  // namespace beltrami
