#include "beltrami/solvers/multigrid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/chebyshev.hpp"
#include "beltrami/solvers/cholesky.hpp"
#include "beltrami/solvers/sparse_rows.hpp"

namespace beltrami {

namespace {

std::size_t at(Eigen::Index i) {
    return static_cast<std::size_t>(i);
}

struct Level {
    Chebyshev smoother;
    SlicedRows from_coarser;  // empty on the coarsest
    SlicedRows to_coarser;    // its transpose
    Index n = 0;
    SmootherFields fields;

    [[nodiscard]] std::size_t memory_bytes() const {
        return smoother.memory_bytes() + from_coarser.memory_bytes() + to_coarser.memory_bytes() +
               fields.memory_bytes();
    }
};

// (I - omega diag(K)^-1 K) by rows, without rows that are held.
template <class Rows>
struct JacobiRows {
    const Rows& K;
    const std::vector<double>& weight;  // omega / K_ii, 0 where it is held

    template <class Function>
    void for_row(Index i, Function f) const {
        const double w = weight[at(i)];
        if (w == 0.0) return;
        K.for_row(i, [&](Index j, double a) { f(j, (i == j ? 1.0 : 0.0) - w * a); });
    }
};

// One step of Jacobi's iteration on every column of P: what K D K needs, whose energy sees the creases of linear interpolation.
template <class Rows>
SparseRows smoothed(Index n, const Rows& K, const SparseRows& P, const std::vector<char>& held) {
    constexpr double omega = 0.66;
    std::vector<double> weight(at(n), 0.0);
    for (Index i = 0; i < n; ++i) {
        if (held[at(i)] != 0) continue;
        K.for_row(i, [&](Index j, double a) {
            if (i == j && a > 0.0) weight[at(i)] = omega / a;
        });
    }
    return product(n, JacobiRows<Rows>{K, weight}, P);
}

// Entries from the unknowns of one level, the columns, to those of the next, the rows: of P from coarse to fine, of its
// transpose the other way.
SlicedRows transfer(const SparseRows& entries, const ScaledRows& rows, const ScaledRows& columns,
                    bool to_finer) {
    return SlicedRows(rows.size(), [&](Index place, auto f) {
        const Index i = rows.order[at(place)];
        if (rows.is_held(i)) return;
        entries.for_row(i, [&](Index j, double w) {
            if (columns.is_held(j)) return;
            const double scale = columns.scale[at(j)] / rows.scale[at(i)];
            f(columns.position[at(j)], to_finer ? w * scale : w / scale);
        });
    });
}

std::vector<Index> degrees(const EdgeGraph& graph) {
    std::vector<Index> result(at(graph.vertex_count()));
    for (Index i = 0; i < graph.vertex_count(); ++i)
        result[at(i)] = graph.degree(i);
    return result;
}

}  // namespace

struct Multigrid::Levels {
    std::vector<Level> levels;
    std::vector<Index> order;  // the row in each place of the finest level
    std::vector<float> scale;  // of each place
    std::optional<Cholesky> coarsest;
    std::vector<Index> factored;  // places of the coarsest level in its factor
    Block coarse_b;
    Block coarse_x;

    template <int K>
    void cycle(const Block& r, Block& z, Eigen::Index first);
    template <int K>
    void solve_coarsest();
    void factor(const SparseRows& A, const ScaledRows& scaled);
    void set_finest(const ScaledRows& scaled);
};

Multigrid::Multigrid(const PdeOperator& A, const Hierarchy& hierarchy, std::span<const Index> held,
                     const Progress* progress)
    : levels_(std::make_unique<Levels>()) {
    if (A.rows() != hierarchy.size(0)) {
        throw InputError(fmt::format("an operator of {} rows meets a hierarchy of {} vertices", A.rows(),
                                     hierarchy.size(0)),
                         "make both of the same mesh");
    }
    if (A.order() < 1 || A.order() > 2)
        throw InputError(
            "a multigrid is for sigma M + gamma_1 K + gamma_2 K D K, with one gamma that is not zero at "
            "least",
            "use another solver");
    const Vector diagonal = A.diagonal();
    const EdgeOperator<double>& K = A.laplacian().stiffness();
    const bool bilaplacian = A.order() == 2;
    const StiffnessRows plain{K, A.gamma()[0], A.sigma(), &A.laplacian().mass()};

    std::vector<char> is_held(at(A.rows()), 0);
    for (const Index i : held)
        is_held[at(i)] = 1;
    for (Index i = 0; i < A.rows(); ++i) {
        if (!(diagonal[i] > 0.0)) is_held[at(i)] = 1;
    }
    SparseRows stored;    // A on the level; the finest is not stored
    SparseRows stored_K;  // K on the level, where interpolation is smoothed with it
    ScaledRows scaled = bilaplacian ? scaled_rows(diagonal, degrees(K.graph()), is_held)
                                    : scaled_rows(A.rows(), plain, is_held);
    const int last = hierarchy.level_count() - 1;
    for (int l = 0; l < last; ++l) {
        report(progress, "multigrid", static_cast<double>(l) / (last + 1));
        const Index n = hierarchy.size(l);
        for (Index i = 0; i < n; ++i)
            is_held[at(i)] = scaled.is_held(i) ? 1 : 0;
        SparseRows P = rows_of(hierarchy.prolongation(l), is_held);
        SparseRows R;
        SparseRows coarse;
        SparseRows coarse_K;
        // What is made on the way to the coarse operator is gone before the level itself is made.
        if (!bilaplacian) {
            const SparseRows AP = l == 0 ? product(n, plain, P) : product(stored, P);
            R = transpose(P);
            coarse = product(R, AP);
        } else if (l == 0) {
            P = smoothed(n, StiffnessRows{K}, P, is_held);
            const SparseRows KP = product(n, StiffnessRows{K}, P);
            {
                SparseRows weighted = transpose(KP);
                scale_columns(A.gamma()[1] * A.laplacian().inverse_mass(), weighted);
                coarse = product(weighted, KP);
            }
            R = transpose(P);
            coarse_K = product(R, KP);
            if (A.gamma()[0] > 0.0 || A.sigma() > 0.0) coarse = sum(coarse, product(R, product(n, plain, P)));
        } else {
            P = smoothed(n, stored_K, P, is_held);
            R = transpose(P);
            coarse = product(R, product(stored, P));
            coarse_K = product(R, product(stored_K, P));
        }
        ScaledRows coarse_scaled =
            scaled_rows(hierarchy.size(l + 1), coarse, std::vector<char>(at(hierarchy.size(l + 1)), 0));
        Level& level = levels_->levels.emplace_back();
        level.n = n;
        level.from_coarser = transfer(P, scaled, coarse_scaled, true);
        P = {};
        level.to_coarser = transfer(R, coarse_scaled, scaled, false);
        R = {};
        level.smoother = l > 0         ? Chebyshev(stored, scaled)
                         : bilaplacian ? Chebyshev(A, scaled)
                                       : Chebyshev(plain, scaled);
        if (l == 0) levels_->set_finest(scaled);
        scaled = std::move(coarse_scaled);
        stored = std::move(coarse);
        stored_K = std::move(coarse_K);
    }
    if (last == 0) {
        levels_->set_finest(scaled);
        stored = rows_of(A.to_sparse());
    }
    levels_->levels.emplace_back().n = hierarchy.size(last);
    levels_->factor(stored, scaled);
}

// Where nothing holds a piece A is singular there: a little of its diagonal makes it definite. So much that the rounding of
// floats in a residual, which has no constant part, does not become a large constant.
void Multigrid::Levels::factor(const SparseRows& A, const ScaledRows& scaled) {
    std::vector<Index> number(at(scaled.size()), -1);
    for (Index place = 0; place < scaled.size(); ++place) {
        const Index i = scaled.order[at(place)];
        if (scaled.is_held(i)) continue;
        number[at(i)] = static_cast<Index>(factored.size());
        factored.push_back(place);
    }
    const auto size = static_cast<Eigen::Index>(factored.size());
    if (size == 0) return;
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(A.column.size());
    for (Index i = 0; i < scaled.size(); ++i) {
        if (number[at(i)] < 0) continue;
        A.for_row(i, [&](Index j, double a) {
            if (number[at(j)] < 0) return;
            const double value = scaled.scale[at(i)] * a * scaled.scale[at(j)];
            entries.emplace_back(number[at(i)], number[at(j)], i == j ? value * (1.0 + 1e-6) : value);
        });
    }
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    coarsest.emplace(matrix, Cholesky::Ordering::amd);
}
Multigrid::Multigrid(Multigrid&&) noexcept = default;
Multigrid& Multigrid::operator=(Multigrid&&) noexcept = default;
Multigrid::~Multigrid() = default;

void Multigrid::Levels::set_finest(const ScaledRows& scaled) {
    order = scaled.order;
    for (const Index i : order)
        scale.push_back(scaled.scale[at(i)]);
}

template <int K>
void Multigrid::Levels::solve_coarsest() {
    SmootherFields& fields = levels.back().fields;
    if (!coarsest) return;
    coarse_b.resize(static_cast<Eigen::Index>(factored.size()), K);
    for (std::size_t i = 0; i < factored.size(); ++i) {
        for (int c = 0; c < K; ++c)
            coarse_b(static_cast<Eigen::Index>(i), c) = fields.d[0][at(K * factored[i] + c)];
    }
    coarsest->solve(coarse_b, coarse_x);
    for (std::size_t i = 0; i < factored.size(); ++i) {
        for (int c = 0; c < K; ++c)
            fields.x[at(K * factored[i] + c)] = static_cast<float>(coarse_x(static_cast<Eigen::Index>(i), c));
    }
}

// Columns first ... first + K of z.
template <int K>
void Multigrid::Levels::cycle(const Block& r, Block& z, Eigen::Index first) {
    for (Level& level : levels)
        level.smoother.resize(K, level.fields);
    const auto coarsest_size = static_cast<std::size_t>(K) * at(SlicedRows::padded(levels.back().n));
    for (std::vector<float>* field : {&levels.back().fields.x, levels.back().fields.d.data()}) {
        if (field->size() < coarsest_size) field->assign(coarsest_size, 0.0F);
    }
    const Index n = levels.front().n;
    // Scaled, so that floats hold it.
    std::array<double, K> unit{};
    for (int c = 0; c < K; ++c)
        unit[c] = r.col(first + c).cwiseAbs().maxCoeff();
    SmootherFields& fields = levels.front().fields;
#pragma omp parallel for schedule(static) if (n > 20000)
    for (Index place = 0; place < n; ++place) {
        const Index i = order[at(place)];
        for (int c = 0; c < K; ++c) {
            const double value = unit[c] > 0.0 ? scale[at(place)] * (r(i, first + c) / unit[c]) : 0.0;
            fields.d[0][at(K * place + c)] = static_cast<float>(value);
        }
    }
    std::fill(fields.d[0].begin() + K * n, fields.d[0].begin() + K * SlicedRows::padded(n), 0.0F);
    for (std::size_t l = 0; l + 1 < levels.size(); ++l) {
        levels[l].smoother.descend(K, levels[l].fields);
        multiply(levels[l].to_coarser, K, levels[l].fields.r.data(), levels[l + 1].fields.d[0].data());
    }
    solve_coarsest<K>();
    for (std::size_t l = levels.size() - 1; l-- > 0;)
        levels[l].smoother.ascend(K, levels[l].from_coarser, levels[l + 1].fields.x.data(), levels[l].fields);
#pragma omp parallel for schedule(static) if (n > 20000)
    for (Index place = 0; place < n; ++place) {
        const Index i = order[at(place)];
        for (int c = 0; c < K; ++c)
            z(i, first + c) = unit[c] * scale[at(place)] * fields.x[at(K * place + c)];
    }
}

void Multigrid::apply(const Block& r, Block& z) const {
    if (r.rows() != size(0)) {
        throw InputError(fmt::format("a cycle of {} rows got a residual of {} rows", size(0), r.rows()),
                         "give one row a vertex");
    }
    z.resize(r.rows(), r.cols());
    for (Eigen::Index first = 0; first < r.cols();) {
        const Eigen::Index left = r.cols() - first;
        if (left >= 4) {
            levels_->cycle<4>(r, z, first);
            first += 4;
        } else if (left == 3) {
            levels_->cycle<3>(r, z, first);
            first += 3;
        } else if (left == 2) {
            levels_->cycle<2>(r, z, first);
            first += 2;
        } else {
            levels_->cycle<1>(r, z, first);
            first += 1;
        }
    }
}

Product Multigrid::preconditioner() const {
    return [this](const Block& r, Block& z) { apply(r, z); };
}

int Multigrid::level_count() const {
    return static_cast<int>(levels_->levels.size());
}
Index Multigrid::size(int level) const {
    return levels_->levels.at(at(level)).n;
}
double Multigrid::entries_per_row(int level) const {
    const Level& l = levels_->levels.at(at(level));
    return l.smoother.entries_per_row();
}
std::size_t Multigrid::memory_bytes() const {
    std::size_t bytes = levels_->order.size() * sizeof(Index) + levels_->scale.size() * sizeof(float) +
                        (levels_->coarsest ? levels_->coarsest->memory_bytes() : 0);
    for (const Level& level : levels_->levels)
        bytes += level.memory_bytes();
    return bytes;
}

}  // namespace beltrami
