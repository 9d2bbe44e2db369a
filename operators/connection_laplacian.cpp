#include "beltrami/operators/connection_laplacian.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>

#include "beltrami/framework/error.hpp"
#include "beltrami/operators/stiffness.hpp"

namespace beltrami {

namespace {

// The axes of the three corners, transported to the triangle's plane, as numbers there.
std::array<std::complex<double>, 3> axes_in_plane(const Mesh& mesh, Index cell, const TangentFrames& frames) {
    const Vector3 normal = frames.triangle_normal.row(cell);
    const Vector3 edge =
        (mesh.points().row(mesh.cells()(cell, 1)) - mesh.points().row(mesh.cells()(cell, 0))).normalized();
    const Vector3 across = normal.cross(edge);
    std::array<std::complex<double>, 3> axes;
    for (std::size_t k = 0; k < 3; ++k) {
        const Index v = mesh.cells()(cell, static_cast<Eigen::Index>(k));
        const Vector3 axis = turned(frames.axis.row(v), frames.normal.row(v), normal, edge);
        axes[k] = {edge.dot(axis), across.dot(axis)};
    }
    return axes;
}

}  // namespace

EdgeOperator<std::complex<double>> connection_laplacian(const Mesh& mesh, const Laplacian& laplacian,
                                                        const TangentFrames& frames) {
    if (mesh.vertex_count() != laplacian.vertex_count() || frames.normal.rows() != mesh.vertex_count() ||
        frames.triangle_normal.rows() != mesh.cell_count()) {
        throw InputError("the connection Laplacian got a Laplacian or frames of another mesh",
                         "make all three of one mesh");
    }
    if (frames.one_sided) {
        throw InputError("the surface is one-sided, as a Moebius strip is: it has no consistent normal",
                         "cut it open, or use the method coordinates");
    }
    const Renumbering& order = laplacian.order();
    const EdgeGraph& graph = laplacian.graph();
    using Numbers = EdgeOperator<std::complex<double>>::Array;
    Numbers diagonal = Numbers::Zero(graph.vertex_count());
    Numbers edges = Numbers::Zero(graph.edge_count());
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (frames.triangle_normal.row(c).isZero(0.0)) continue;
        const Eigen::Matrix3d local = cotangent_element(mesh, c);
        const auto axes = axes_in_plane(mesh, c, frames);
        for (int a = 0; a < 3; ++a) {
            for (int b = 0; b < 3; ++b) {
                const Index i = order.working(mesh.cells()(c, a));
                const Index j = order.working(mesh.cells()(c, b));
                if (i >= j) continue;
                edges[graph.require_edge(i, j)] += local(a, b) *
                                                   std::conj(axes[static_cast<std::size_t>(a)]) *
                                                   axes[static_cast<std::size_t>(b)];
                diagonal[i] -= local(a, b);
                diagonal[j] -= local(a, b);
            }
        }
    }
    return {laplacian.stiffness().shared_graph(), std::move(diagonal), std::move(edges)};
}

}  // namespace beltrami
