#include "beltrami/operators/laplacian.hpp"

#include <fmt/format.h>

#include <utility>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/operators/stiffness.hpp"

namespace beltrami {

namespace {

EdgeOperator<double> weighted(Weights weights, const Mesh& mesh,
                              const std::shared_ptr<const EdgeGraph>& graph) {
    switch (weights) {
        case Weights::cotangent:
            return stiffness(mesh, graph);
        case Weights::area_weighted:
            return area_weighted_stiffness(mesh, graph);
        case Weights::combinatorial:
            return combinatorial_stiffness(graph);
    }
    return stiffness(mesh, graph);
}

}  // namespace

Laplacian::Laplacian(const Mesh& mesh, const LaplacianOptions& options) {
    if (mesh.kind() == CellKind::point || mesh.cell_count() == 0) {
        throw InputError("the mesh has no cells: a Laplacian needs segments, triangles or tetrahedra",
                         "triangulate the points first");
    }
    // Products of four lengths must neither overflow nor vanish.
    const double extent =
        (mesh.points().colwise().maxCoeff() - mesh.points().colwise().minCoeff()).maxCoeff();
    if (extent > 1e60 || extent < 1e-60) {
        throw InputError(fmt::format("the mesh is {:.3g} units wide", extent),
                         "rescale it to a size between 1e-60 and 1e60");
    }
    const Mesh kept(mesh.points(), non_degenerate_cells(mesh));
    if (kept.cell_count() == 0) {
        throw InputError(
            fmt::format("all {} {} of the mesh are degenerate", mesh.cell_count(), plural(mesh.kind())),
            "check the positions in the file");
    }
    Renumbering order = options.renumber ? cuthill_mckee(EdgeGraph(kept.vertex_count(), kept.cells()))
                                         : Renumbering::identity(kept.vertex_count());
    const Mesh working = order.to_working(kept);
    auto graph = std::make_shared<const EdgeGraph>(working.vertex_count(), working.cells());
    set(weighted(options.weights, working, graph), lumped_mass(working, options.mass), std::move(order));
    points_ = std::make_shared<const Points>(working.points());
    left_out_cells_ = mesh.cell_count() - kept.cell_count();
}

Laplacian::Laplacian(EdgeOperator<double> stiffness, Vector mass, Renumbering order) {
    if (mass.size() != stiffness.rows() || order.vertex_count() != stiffness.rows()) {
        throw InputError(fmt::format("a Laplacian of {} vertices got {} masses and an order of {}",
                                     stiffness.rows(), mass.size(), order.vertex_count()),
                         "give one mass a vertex and an order of all of them");
    }
    set(std::move(stiffness), std::move(mass), std::move(order));
}

void Laplacian::set(EdgeOperator<double> stiffness, Vector mass, Renumbering order) {
    Vector inverse = mass.unaryExpr([](double m) { return m > 0.0 ? 1.0 / m : 0.0; });
    for (Index v = 0; v < stiffness.rows(); ++v)
        isolated_vertices_ += stiffness.graph().degree(v) == 0 ? 1 : 0;
    stiffness_ = std::make_shared<const EdgeOperator<double>>(std::move(stiffness));
    lumped_ = std::make_shared<const Lumped>(Lumped{std::move(mass), std::move(inverse)});
    order_ = std::make_shared<const Renumbering>(std::move(order));
}

std::size_t Laplacian::memory_bytes() const {
    return stiffness_->memory_bytes() + graph().memory_bytes() +
           (points_ ? static_cast<std::size_t>(points_->size()) * sizeof(double) : 0) +
           static_cast<std::size_t>(vertex_count()) * (2 * sizeof(double) + 2 * sizeof(Index));
}

double dirichlet_energy(const Laplacian& laplacian, const Block& u) {
    Block product(u.rows(), u.cols());
    laplacian.stiffness().apply(u, product);
    return 0.5 * u.cwiseProduct(product).sum();
}

}  // namespace beltrami
