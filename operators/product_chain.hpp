// x <- a A K x + b B u, once or several times in a row: what sums of powers of K are made of.
//
// K D K u, say, is the chain of x <- D K x and x <- K x. All links run in one sweep over the edges: row i of a product
// is complete when the rows up to i have been swept, so the next link follows the first at the distance of a bandwidth
// and finds the numbers of K in the cache.
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/types.hpp"

namespace beltrami {

/// x <- product A K x + field B u. A and B are diagonal: n numbers that must outlive the link, or null for ones.
struct ChainLink {
    double product = 1.0;
    const Vector* product_weight = nullptr;
    double field = 0.0;
    const Vector* field_weight = nullptr;
};

/// Room for what is between two links, kept by callers that multiply often.
template <class Scalar>
struct ChainWorkspace {
    std::vector<BlockOf<Scalar>> between;
};

/// The numbers of an EdgeOperator.
template <class Scalar>
struct EdgeNumbers {
    const EdgeGraph& graph;
    const Scalar* diagonal;
    const Scalar* edges;
};

/// y = the last x of the chain that starts with x = u. u and y: n x columns, row-major, and apart from each other.
template <class Scalar>
void multiply_chain(const EdgeNumbers<Scalar>& K, std::span<const ChainLink> links, const Scalar* u,
                    Scalar* y, Index columns, ChainWorkspace<Scalar>& workspace);

extern template void multiply_chain(const EdgeNumbers<double>&, std::span<const ChainLink>, const double*,
                                    double*, Index, ChainWorkspace<double>&);
extern template void multiply_chain(const EdgeNumbers<std::complex<double>>&, std::span<const ChainLink>,
                                    const std::complex<double>*, std::complex<double>*, Index,
                                    ChainWorkspace<std::complex<double>>&);

}  // namespace beltrami
