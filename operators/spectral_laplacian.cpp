#include "beltrami/operators/spectral_laplacian.hpp"

#include <utility>

namespace beltrami {

std::string_view name(SpectralLaplacian kind) {
    switch (kind) {
        case SpectralLaplacian::combinatorial:
            return "combinatorial";
        case SpectralLaplacian::cotangent:
            return "cotangent";
        case SpectralLaplacian::weighted:
            return "weighted";
        case SpectralLaplacian::symmetrized:
            return "symmetrized";
        case SpectralLaplacian::dec:
            return "dec";
    }
    return "";
}

namespace {

// w_ij / ((A_i + A_j) / 2), with rows that sum to zero.
EdgeOperator<double> symmetrized(const Laplacian& laplacian) {
    const EdgeOperator<double>& K = laplacian.stiffness();
    const EdgeGraph& graph = laplacian.graph();
    Vector edges(graph.edge_count());
    Vector diagonal = Vector::Zero(graph.vertex_count());
    for (Index v = 0; v < graph.vertex_count(); ++v) {
        for (const EdgeGraph::Neighbour n : graph.neighbours(v)) {
            const double weight =
                2.0 * K.edges()[n.edge] / (laplacian.mass()[v] + laplacian.mass()[n.vertex]);
            edges[n.edge] = weight;
            diagonal[v] -= weight;
        }
    }
    return {K.shared_graph(), std::move(diagonal), std::move(edges)};
}

}  // namespace

Laplacian spectral_laplacian(const Mesh& mesh, SpectralLaplacian kind, Mass mass) {
    LaplacianOptions options;
    options.mass = mass;
    if (kind == SpectralLaplacian::combinatorial) options.weights = Weights::combinatorial;
    Laplacian laplacian(mesh, options);
    if (kind == SpectralLaplacian::dec || kind == SpectralLaplacian::weighted) return laplacian;
    const Vector ones = laplacian.mass().unaryExpr([](double m) { return m > 0.0 ? 1.0 : 0.0; });
    return {kind == SpectralLaplacian::symmetrized ? symmetrized(laplacian) : laplacian.stiffness(), ones,
            laplacian.order()};
}

}  // namespace beltrami
