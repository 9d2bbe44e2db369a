#include "beltrami/operators/edge_operator.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

constexpr Index block_rows = 512;

/// Below this many numbers a product is over before threads have started.
constexpr std::int64_t worth_threads = 1 << 15;

template <class Scalar>
struct Rows {
    const Index* offsets;
    const Index* upper;
    const Scalar* diagonal;
    const Scalar* edges;
    const Scalar* u;
    Scalar* y;
    Index columns;
};

template <int K, class Scalar>
Index width(const Rows<Scalar>& rows) {
    if constexpr (K > 0) return K;
    return rows.columns;
}

template <class Values>
void require_fit(const Values& u, const Values& y, Index rows) {
    if (u.size() > 0 && u.data() == y.data()) {
        throw InputError("a product was asked to write over the field it reads",
                         "give it another field to write to");
    }
    const Eigen::Index got = u.rows();
    if (got == rows) return;
    throw InputError(fmt::format("an operator of {} rows got a field of {} rows", rows, got),
                     "give one row a vertex, in the working order");
}

// y_j for j < limit goes to y, above it to `beyond` (the part of the result that another thread owns).
template <int K, bool Bounded, class Scalar>
void sweep(const Rows<Scalar>& a, Index begin, Index end, Index limit, Scalar* beyond) {
    const Index k = width<K>(a);
    const auto row = [k](Index i) { return static_cast<std::ptrdiff_t>(i) * k; };
    for (Index i = begin; i < end; ++i) {
        const Scalar* const u_i = a.u + row(i);
        Scalar* const y_i = a.y + row(i);
        if constexpr (K > 0) {
            Scalar own[K];
            Scalar sum[K];
            for (int c = 0; c < K; ++c) {
                own[c] = u_i[c];
                sum[c] = y_i[c] + a.diagonal[i] * own[c];
            }
            for (Index e = a.offsets[i]; e < a.offsets[i + 1]; ++e) {
                const Index j = a.upper[e];
                const Scalar w = a.edges[e];
                const Scalar* const u_j = a.u + row(j);
                Scalar* const y_j = Bounded && j >= limit ? beyond + row(j - limit) : a.y + row(j);
                for (int c = 0; c < K; ++c) {
                    sum[c] += w * u_j[c];
                    y_j[c] += Eigen::numext::conj(w) * own[c];
                }
            }
            for (int c = 0; c < K; ++c)
                y_i[c] = sum[c];
        } else {
            for (Index c = 0; c < k; ++c)
                y_i[c] += a.diagonal[i] * u_i[c];
            for (Index e = a.offsets[i]; e < a.offsets[i + 1]; ++e) {
                const Index j = a.upper[e];
                const Scalar w = a.edges[e];
                const Scalar* const u_j = a.u + row(j);
                Scalar* const y_j = Bounded && j >= limit ? beyond + row(j - limit) : a.y + row(j);
                for (Index c = 0; c < k; ++c) {
                    y_i[c] += w * u_j[c];
                    y_j[c] += Eigen::numext::conj(w) * u_i[c];
                }
            }
        }
    }
}

// Rows begin..end of the product. y is cleared a block ahead of where it is first written, while it is in cache.
template <int K, class Scalar>
void sweep_chunk(const Rows<Scalar>& a, const std::vector<Index>& reach, Index begin, Index end,
                 Scalar* beyond) {
    const Index k = width<K>(a);
    Index cleared = begin;
    for (Index first = begin; first < end; first += block_rows) {
        const Index last = std::min(end, first + block_rows);
        const Index touched = std::max(last, reach[static_cast<std::size_t>(first / block_rows)]);
        const Index clear_to = std::min(end, touched);
        if (clear_to > cleared) {
            std::fill(a.y + static_cast<std::ptrdiff_t>(cleared) * k,
                      a.y + static_cast<std::ptrdiff_t>(clear_to) * k, Scalar(0));
            cleared = clear_to;
        }
        if (touched <= end) {
            sweep<K, false>(a, first, last, end, beyond);
        } else {
            sweep<K, true>(a, first, last, end, beyond);
        }
    }
}

// Each thread owns a run of rows. What it adds to rows of later threads goes to a buffer of its own, added to the
// owner's rows when all sweeps are done. In Cuthill-McKee order the buffers are as short as the bandwidth.
template <int K, class Scalar>
void multiply_rows(const Rows<Scalar>& a, const std::vector<Index>& reach, Index n) {
    const Index k = width<K>(a);
    const auto blocks = static_cast<Index>(reach.size());
    const int wanted =
        static_cast<std::int64_t>(n) * k < worth_threads ? 1 : std::min<int>(omp_get_max_threads(), blocks);
    if (wanted <= 1) {
        sweep_chunk<K, Scalar>(a, reach, 0, n, nullptr);
        return;
    }
    const auto chunks = static_cast<std::size_t>(wanted);
    const auto numbers = [k](Index rows) {
        return static_cast<std::size_t>(rows) * static_cast<std::size_t>(k);
    };
    std::vector<Index> begin(chunks + 1);
    for (std::size_t t = 0; t <= chunks; ++t) {
        begin[t] = std::min(
            n, static_cast<Index>(std::int64_t{blocks} * static_cast<std::int64_t>(t) / wanted) * block_rows);
    }
    std::vector<std::vector<Scalar>> beyond(chunks);
    for (std::size_t t = 0; t < chunks; ++t) {
        const Index highest = reach[static_cast<std::size_t>((begin[t + 1] - 1) / block_rows)];
        beyond[t].resize(numbers(std::max<Index>(0, highest - begin[t + 1])));
    }
#pragma omp parallel num_threads(wanted)
    {
#pragma omp for schedule(static, 1)
        for (std::size_t t = 0; t < chunks; ++t) {
            sweep_chunk<K, Scalar>(a, reach, begin[t], begin[t + 1], beyond[t].data());
        }
#pragma omp for schedule(static, 1)
        for (std::size_t t = 0; t < chunks; ++t) {
            for (std::size_t s = 0; s < t; ++s) {
                const Index origin = begin[s + 1];
                const auto length = static_cast<Index>(beyond[s].size() / static_cast<std::size_t>(k));
                const Index first = std::max(begin[t], origin);
                const Index end = std::max(first, std::min(begin[t + 1], origin + length));
                const Scalar* const from = beyond[s].data() + numbers(first - origin);
                Scalar* const to = a.y + numbers(first);
                for (std::size_t i = 0; i < numbers(end - first); ++i)
                    to[i] += from[i];
            }
        }
    }
}

}  // namespace

template <class Scalar>
EdgeOperator<Scalar>::EdgeOperator(std::shared_ptr<const EdgeGraph> graph, Array diagonal, Array edges)
    : graph_(std::move(graph)), diagonal_(std::move(diagonal)), edges_(std::move(edges)) {
    if (diagonal_.size() != graph_->vertex_count() || edges_.size() != graph_->edge_count()) {
        throw InputError(
            fmt::format("an operator got {} vertex and {} edge values for {} vertices and {} edges",
                        diagonal_.size(), edges_.size(), graph_->vertex_count(), graph_->edge_count()),
            "give one value a vertex and one an edge of the graph");
    }
    const auto& offsets = graph_->offsets();
    const auto& upper = graph_->upper();
    Index highest = 0;
    for (Index first = 0; first < rows(); first += block_rows) {
        const Index last = std::min(rows(), first + block_rows);
        for (Index e = offsets[static_cast<std::size_t>(first)]; e < offsets[static_cast<std::size_t>(last)];
             ++e) {
            highest = std::max(highest, upper[static_cast<std::size_t>(e)] + 1);
        }
        reach_.push_back(std::max(highest, last));
    }
    ++builds_;
}

template <class Scalar>
void EdgeOperator<Scalar>::multiply(const Scalar* u, Scalar* y, Index columns) const {
    const Rows<Scalar> rows{
        graph_->offsets().data(), graph_->upper().data(), diagonal_.data(), edges_.data(), u, y, columns};
    const Index n = this->rows();
    switch (columns) {
        case 0:
            break;
        case 1:
            multiply_rows<1>(rows, reach_, n);
            break;
        case 2:
            multiply_rows<2>(rows, reach_, n);
            break;
        case 3:
            multiply_rows<3>(rows, reach_, n);
            break;
        case 4:
            multiply_rows<4>(rows, reach_, n);
            break;
        default:
            multiply_rows<0>(rows, reach_, n);
    }
}

template <class Scalar>
void EdgeOperator<Scalar>::apply(const Values& u, Values& y) const {
    require_fit(u, y, rows());
    y.resize(u.rows(), u.cols());
    multiply(u.data(), y.data(), static_cast<Index>(u.cols()));
}

template <class Scalar>
void EdgeOperator<Scalar>::apply(const Array& u, Array& y) const {
    require_fit(u, y, rows());
    y.resize(u.rows());
    multiply(u.data(), y.data(), 1);
}

template <class Scalar>
Eigen::SparseMatrix<Scalar> EdgeOperator<Scalar>::to_sparse() const {
    using Sparse = Eigen::SparseMatrix<Scalar>;
    const Index n = rows();
    Sparse matrix(n, n);
    if (n == 0) return matrix;
    Eigen::Matrix<Index, Eigen::Dynamic, 1> column_size(n);
    for (Index i = 0; i < n; ++i)
        column_size[i] = 1 + graph_->degree(i);
    matrix.reserve(column_size);
    // Column j in ascending rows: the lower neighbours, the diagonal, the upper ones.
    for (Index j = 0; j < n; ++j) {
        const auto neighbours = graph_->neighbours(j);
        auto n_it = neighbours.begin();
        for (; n_it != neighbours.end() && n_it->vertex < j; ++n_it)
            matrix.insert(n_it->vertex, j) = edges_[n_it->edge];
        matrix.insert(j, j) = diagonal_[j];
        for (; n_it != neighbours.end(); ++n_it) {
            matrix.insert(n_it->vertex, j) = Eigen::numext::conj(edges_[n_it->edge]);
        }
    }
    matrix.makeCompressed();
    return matrix;
}

template class EdgeOperator<double>;
template class EdgeOperator<std::complex<double>>;

}  // namespace beltrami
