#include "beltrami/operators/product_chain.hpp"

#include <omp.h>

#include <algorithm>

namespace beltrami {

namespace {

constexpr Index block_rows = EdgeGraph::block_rows;

/// Below this many numbers a product is over before threads have started.
constexpr std::int64_t worth_threads = 1 << 15;

struct Range {
    Index begin;
    Index end;
    [[nodiscard]] Index size() const { return end - begin; }
    [[nodiscard]] bool contains(Index i) const { return begin <= i && i < end; }
};

// The first of the rows that have an edge to `row` or a later one, rounded down to a block.
Index first_row_reaching(const EdgeGraph& graph, Index row) {
    const auto& reach = graph.reach();
    return static_cast<Index>(std::upper_bound(reach.begin(), reach.end(), row) - reach.begin()) * block_rows;
}

// The rows of x that a product needs in order to give `rows`, in whole blocks.
Range needed(const EdgeGraph& graph, Range rows) {
    const Index reach = graph.reach()[static_cast<std::size_t>((rows.end - 1) / block_rows)];
    const std::int64_t blocks_end = (std::int64_t{reach} + block_rows - 1) / block_rows * block_rows;
    return {first_row_reaching(graph, rows.begin),
            static_cast<Index>(std::min<std::int64_t>(graph.vertex_count(), blocks_end))};
}

// Rows from `first` on of a row-major block of K columns, or of as many as it says for K = 0.
template <int K, class Scalar>
struct Rows {
    Scalar* data;
    Index first;
    Index columns;
    [[nodiscard]] Index width() const {
        if constexpr (K > 0) return K;
        return columns;
    }
    Scalar* operator[](Index i) const { return data + static_cast<std::ptrdiff_t>(i - first) * width(); }
};

template <int K, class Scalar>
void add(Scalar* y, Scalar factor, const Scalar* x, Index width) {
    for (Index c = 0; c < (K > 0 ? K : width); ++c)
        y[c] += factor * x[c];
}

// The edges from rows first..end, both ways. There is no loop over a row: its length, three on average and never the
// same, would be mispredicted once a row, which costs more than the arithmetic.
template <int K, class Scalar>
void sweep(const EdgeNumbers<Scalar>& A, Index first, Index end, const Rows<K, const Scalar> x,
           const Rows<K, Scalar> y) {
    const Index* const offsets = A.graph.offsets().data();
    const Index* const upper = A.graph.upper().data();
    const std::uint8_t* const lower = A.graph.lower_in_block().data();
    const Index edges_end = offsets[end];
    // All that is touched lies behind the block's first row.
    const Scalar* const x_first = x[first];
    Scalar* const y_first = y[first];
    for (Index e = offsets[first]; e < edges_end; ++e) {
        const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(lower[e]) * y.width();
        const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(upper[e] - first) * y.width();
        const Scalar w = A.edges[e];
        const Scalar* const x_i = x_first + i;
        const Scalar* const x_j = x_first + j;
        Scalar* const y_i = y_first + i;
        Scalar* const y_j = y_first + j;
        if constexpr (K > 0) {
            // Everything is loaded before anything is stored, as the compiler cannot know that i and j differ.
            Scalar sum_i[K];
            Scalar sum_j[K];
            for (int c = 0; c < K; ++c)
                sum_i[c] = y_i[c] + w * x_j[c];
            for (int c = 0; c < K; ++c)
                sum_j[c] = y_j[c] + Eigen::numext::conj(w) * x_i[c];
            for (int c = 0; c < K; ++c)
                y_i[c] = sum_i[c];
            for (int c = 0; c < K; ++c)
                y_j[c] = sum_j[c];
        } else {
            add<0>(y_i, w, x_j, y.width());
            add<0>(y_j, Eigen::numext::conj(w), x_i, y.width());
        }
    }
}

// The same, but writes only to rows in `own`.
template <int K, class Scalar>
void sweep_clipped(const EdgeNumbers<Scalar>& A, Index first, Index end, Range own,
                   const Rows<K, const Scalar> x, const Rows<K, Scalar> y) {
    const Index* const offsets = A.graph.offsets().data();
    const Index* const upper = A.graph.upper().data();
    const std::uint8_t* const lower = A.graph.lower_in_block().data();
    const Index edges_end = offsets[end];
    for (Index e = offsets[first]; e < edges_end; ++e) {
        const Index i = first + lower[e];
        const Index j = upper[e];
        const Scalar w = A.edges[e];
        if (own.contains(i)) add<K>(y[i], w, x[j], y.width());
        if (own.contains(j)) add<K>(y[j], Eigen::numext::conj(w), x[i], y.width());
    }
}

template <int K, class Scalar>
void multiply_diagonal(const EdgeNumbers<Scalar>& A, Index begin, Index end, const Rows<K, const Scalar> x,
                       const Rows<K, Scalar> y) {
    for (Index i = begin; i < end; ++i) {
        const Scalar* const x_i = x[i];
        Scalar* const y_i = y[i];
        for (Index c = 0; c < y.width(); ++c)
            y_i[c] = A.diagonal[i] * x_i[c];
    }
}

// y <- product A y + field B u, with y = K x so far.
template <int K, class Scalar>
void finish(const ChainLink& link, Index begin, Index end, const Rows<K, const Scalar> u,
            const Rows<K, Scalar> y) {
    if (link.product == 1.0 && link.product_weight == nullptr && link.field == 0.0) return;
    for (Index i = begin; i < end; ++i) {
        const double a = link.product * (link.product_weight != nullptr ? (*link.product_weight)[i] : 1.0);
        const double b = link.field * (link.field_weight != nullptr ? (*link.field_weight)[i] : 1.0);
        const Scalar* const u_i = u[i];
        Scalar* const y_i = y[i];
        for (Index c = 0; c < y.width(); ++c)
            y_i[c] = a * y_i[c] + b * u_i[c];
    }
}

// A chain for a run of rows. It shares nothing with the chains of other runs: near its ends it repeats what they do
// too, so threads need not wait for each other, and every sum is taken in the same order for any number of runs.
template <int K, class Scalar>
class Chain {
  public:
    // Starts with x and gives y on `rows`; u is the u of the links.
    Chain(const EdgeNumbers<Scalar>& A, std::span<const ChainLink> links, Rows<K, const Scalar> x,
          Rows<K, const Scalar> u, Rows<K, Scalar> y, Range rows)
        : A_(A), u_(u), stages_(links.size()) {
        for (std::size_t s = links.size(); s-- > 0;) {
            stages_[s] = {links[s], rows, x, y, rows.begin, first_row_reaching(A.graph, rows.begin)};
            rows = needed(A.graph, rows);
        }
    }

    // Rows swept, over all links.
    [[nodiscard]] std::int64_t work() const {
        std::int64_t rows = 0;
        for (const Stage& stage : stages_)
            rows += stage.own.end - stage.swept;
        return rows;
    }

    // Room for what is between the links: one block less than links.
    void use(std::span<BlockOf<Scalar>> between) {
        for (std::size_t s = 0; s + 1 < stages_.size(); ++s) {
            Stage& stage = stages_[s];
            between[s].resize(stage.own.size(), u_.columns);
            stage.y = {between[s].data(), stage.own.begin, u_.columns};
            stages_[s + 1].x = {between[s].data(), stage.own.begin, u_.columns};
        }
    }

    void run() { advance(stages_.size() - 1, stages_.back().own.end); }

  private:
    struct Stage {
        ChainLink link;
        Range own;  // what the next link needs of it
        Rows<K, const Scalar> x;
        Rows<K, Scalar> y;
        Index started;  // the rows of own before it have been given the diagonal's part
        Index swept;    // the rows before it have been swept, and those in own are finished
    };

    // Finishes the rows of stage s before `end`, and of the stages before it what that takes.
    void advance(std::size_t s, Index end) {
        Stage& stage = stages_[s];
        while (stage.swept < end) {
            const Index first = stage.swept;
            const Index last = std::min(A_.graph.vertex_count(), first + block_rows);
            const Index touched = A_.graph.reach()[static_cast<std::size_t>(first / block_rows)];
            if (s > 0) advance(s - 1, touched);
            start(stage, std::min(touched, stage.own.end));
            if (first >= stage.own.begin && touched <= stage.own.end) {
                sweep(A_, first, last, stage.x, stage.y);
            } else {
                sweep_clipped(A_, first, last, stage.own, stage.x, stage.y);
            }
            if (first >= stage.own.begin) finish(stage.link, first, last, u_, stage.y);
            stage.swept = last;
        }
    }

    void start(Stage& stage, Index end) {
        if (end <= stage.started) return;
        multiply_diagonal(A_, stage.started, end, stage.x, stage.y);
        stage.started = end;
    }

    EdgeNumbers<Scalar> A_;
    Rows<K, const Scalar> u_;
    std::vector<Stage> stages_;
};

// Equal runs of whole blocks, one for each thread that is worth starting.
std::vector<Range> runs_of_rows(const EdgeGraph& graph, Index columns) {
    const auto blocks = static_cast<std::int64_t>(graph.reach().size());
    const Index n = graph.vertex_count();
    const std::int64_t threads = std::min<std::int64_t>(omp_get_max_threads(), blocks);
    const std::int64_t count = std::int64_t{n} * columns < worth_threads ? 1 : threads;
    std::vector<Range> runs;
    for (std::int64_t t = 0; t < count; ++t) {
        runs.push_back({static_cast<Index>(blocks * t / count) * block_rows,
                        t + 1 < count ? static_cast<Index>(blocks * (t + 1) / count) * block_rows : n});
    }
    return runs;
}

template <int K, class Scalar>
std::vector<Chain<K, Scalar>> make_chains(const EdgeNumbers<Scalar>& A, std::span<const ChainLink> links,
                                          Rows<K, const Scalar> x, Rows<K, const Scalar> u, Rows<K, Scalar> y,
                                          const std::vector<Range>& runs) {
    std::vector<Chain<K, Scalar>> chains;
    chains.reserve(runs.size());
    for (const Range& rows : runs)
        chains.emplace_back(A, links, x, u, y, rows);
    return chains;
}

template <int K, class Scalar>
void run(std::vector<Chain<K, Scalar>>& chains) {
    if (chains.size() == 1) return chains.front().run();
#pragma omp parallel for num_threads(static_cast <int>(chains.size())) schedule(static, 1)
    for (auto& chain : chains)
        chain.run();
}

// Together the chains of several threads repeat little of each other's work if the bandwidth is small.
template <int K, class Scalar>
bool overlap_little(const std::vector<Chain<K, Scalar>>& chains, std::int64_t work_of_one) {
    std::int64_t work = 0;
    for (const auto& chain : chains)
        work += chain.work();
    return 2 * work <= 3 * work_of_one;
}

template <int K, class Scalar>
void multiply_columns(const EdgeNumbers<Scalar>& A, std::span<const ChainLink> links, const Scalar* from,
                      Scalar* to, Index columns, ChainWorkspace<Scalar>& workspace) {
    const Index n = A.graph.vertex_count();
    const Rows<K, const Scalar> u{from, 0, columns};
    const Rows<K, Scalar> y{to, 0, columns};
    const std::vector<Range> runs = runs_of_rows(A.graph, columns);
    auto& between = workspace.between;
    auto chains = make_chains<K, Scalar>(A, links, u, u, y, runs);
    if (chains.size() == 1 ||
        overlap_little(chains, std::int64_t{n} * static_cast<std::int64_t>(links.size()))) {
        const std::size_t each = links.size() - 1;
        between.resize(std::max(between.size(), each * chains.size()));
        for (std::size_t t = 0; t < chains.size(); ++t)
            chains[t].use({between.data() + each * t, each});
        return run(chains);
    }
    // One link after the other; what is between them takes turns in two fields.
    between.resize(std::max<std::size_t>(between.size(), 2));
    Rows<K, const Scalar> x = u;
    for (std::size_t s = 0; s < links.size(); ++s) {
        Rows<K, Scalar> next = y;
        if (s + 1 < links.size()) {
            between[s % 2].resize(n, columns);
            next.data = between[s % 2].data();
        }
        auto link = make_chains<K, Scalar>(A, links.subspan(s, 1), x, u, next, runs);
        run(link);
        x.data = next.data;
    }
}

}  // namespace

template <class Scalar>
void multiply_chain(const EdgeNumbers<Scalar>& K, std::span<const ChainLink> links, const Scalar* u,
                    Scalar* y, Index columns, ChainWorkspace<Scalar>& workspace) {
    if (K.graph.vertex_count() == 0 || columns == 0) return;
    switch (columns) {
        case 1:
            return multiply_columns<1>(K, links, u, y, columns, workspace);
        case 2:
            return multiply_columns<2>(K, links, u, y, columns, workspace);
        case 3:
            return multiply_columns<3>(K, links, u, y, columns, workspace);
        case 4:
            return multiply_columns<4>(K, links, u, y, columns, workspace);
        default:
            return multiply_columns<0>(K, links, u, y, columns, workspace);
    }
}

template void multiply_chain(const EdgeNumbers<double>&, std::span<const ChainLink>, const double*, double*,
                             Index, ChainWorkspace<double>&);
template void multiply_chain(const EdgeNumbers<std::complex<double>>&, std::span<const ChainLink>,
                             const std::complex<double>*, std::complex<double>*, Index,
                             ChainWorkspace<std::complex<double>>&);

}  // namespace beltrami
