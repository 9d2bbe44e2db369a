#include "beltrami/solvers/multigrid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/cholesky.hpp"
#include "beltrami/solvers/gauss_seidel.hpp"
#include "beltrami/solvers/normal_gauss_seidel.hpp"
#include "beltrami/solvers/sparse_rows.hpp"

namespace beltrami {

namespace {

std::size_t at(Eigen::Index i) {
    return static_cast<std::size_t>(i);
}

// From a coarser level to a finer one, in floats.
class Interpolation {
  public:
    Interpolation() = default;
    explicit Interpolation(const SparseRows& P) {
        const Index n = P.rows();
        begin_.reserve(at(n) + 1);
        entry_.reserve(at(n));
        for (Index i = 0; i < n; ++i) {
            Index filled = 4;
            P.for_row(i, [&](Index j, double w) {
                if (filled == 4) {
                    entry_.push_back(no_entries(j));
                    filled = 0;
                }
                entry_.back().column[at(filled)] = j;
                entry_.back().value[at(filled++)] = static_cast<float>(w);
            });
            begin_.push_back(static_cast<Index>(entry_.size()));
        }
        // Restriction adds to coarse rows: stretches of fine rows that are apart by one touch none in common.
        int count = std::clamp(n / 10000, 1, 16);
        for (; count > 1 && !apart(P, count); --count) {
        }
        for (int s = 0; s < count; ++s)
            stretches_[s % 2].push_back(even_part(n, s, count));
    }

    // coarse = P^T f(i), where f gives the numbers of a fine row.
    template <int K, class Function>
    void restrict(Index coarse_rows, float* coarse, Function f) const {
        std::fill_n(coarse, K * at(coarse_rows), 0.0F);
        for (const std::vector<RowRange>& stretches : stretches_) {
            sweep(stretches, [&](Index i) {
                const FloatRow<K> numbers = f(i);
                for (Index e = begin_[at(i)]; e < begin_[at(i + 1)]; ++e)
                    add_four_to<K>(entry_[at(e)], numbers, coarse);
            });
        }
    }
    // Row i of P coarse.
    template <int K>
    [[nodiscard]] FloatRow<K> row(Index i, const float* coarse) const {
        FloatRow<K> sum;
        for (Index e = begin_[at(i)]; e < begin_[at(i + 1)]; ++e) {
            for (std::size_t f = 0; f < 4; ++f)
                sum.add(entry_[at(e)].value[f], coarse + K * at(entry_[at(e)].column[f]));
        }
        return sum;
    }
    // fine += P coarse.
    template <int K>
    void add(const float* coarse, float* fine) const {
        for (const std::vector<RowRange>& stretches : stretches_)
            sweep(stretches, [&](Index i) { row<K>(i, coarse).add_to(1.0F, fine + K * at(i)); });
    }
    [[nodiscard]] std::size_t memory_bytes() const {
        return entry_.size() * sizeof(FourEntries) + begin_.size() * sizeof(Index);
    }

  private:
    static bool apart(const SparseRows& P, int count) {
        Index before_last = -1;  // the highest column of all stretches but the last two
        Index last = -1;
        for (int s = 0; s < count; ++s) {
            const RowRange rows = even_part(P.rows(), s, count);
            Index lowest = P.columns;
            Index highest = -1;
            for (Index i = rows.first; i < rows.end; ++i) {
                P.for_row(i, [&](Index j, double) {
                    lowest = std::min(lowest, j);
                    highest = std::max(highest, j);
                });
            }
            if (lowest <= before_last) return false;
            before_last = std::max(before_last, last);
            last = highest;
        }
        return true;
    }
    std::vector<Index> begin_{0};
    std::vector<FourEntries> entry_;
    std::array<std::vector<RowRange>, 2> stretches_;  // every other one
};

struct Level {
    GaussSeidel stored;
    std::optional<NormalGaussSeidel> normal;  // takes its place on the finest level of an operator with K D K
    Interpolation from_coarser;               // empty on the coarsest
    std::vector<float> x;                     // n x k, as b
    std::vector<float> b;
    std::vector<float> w;  // of NormalGaussSeidel

    [[nodiscard]] Index n() const { return normal ? normal->rows() : stored.rows(); }
    [[nodiscard]] bool is_held(Index i) const { return normal ? normal->is_held(i) : stored.is_held(i); }
    [[nodiscard]] std::size_t memory_bytes() const {
        return (normal ? normal->memory_bytes() : stored.memory_bytes()) + from_coarser.memory_bytes() +
               (x.size() + b.size() + w.size()) * sizeof(float);
    }

    // x from zero; the residual goes to `coarse`.
    template <int K>
    void descend(Level& coarser) {
        if (normal) {
            normal->down<K>(b.data(), x.data(), w.data());
            from_coarser.restrict<K>(coarser.n(), coarser.b.data(), [&](Index i) {
                return normal->residual<K>(i, b.data(), x.data(), w.data());
            });
        } else {
            stored.down<K>(b.data(), x.data());
            from_coarser.restrict<K>(coarser.n(), coarser.b.data(),
                                     [&](Index i) { return stored.residual_of_down<K>(i, x.data()); });
        }
    }
    // With the correction of the coarser level.
    template <int K>
    void ascend(const Level& coarser) {
        if (normal) {
            normal->add<K>([&](Index i) { return from_coarser.row<K>(i, coarser.x.data()); }, x.data(),
                           w.data());
            normal->up<K>(b.data(), x.data(), w.data());
        } else {
            from_coarser.add<K>(coarser.x.data(), x.data());
            stored.up<K>(b.data(), x.data());
        }
    }
};

// The geometric mean of what is positive; 1 where nothing is.
double typical(const Vector& diagonal) {
    double sum = 0.0;
    double count = 0.0;
    for (const double d : diagonal) {
        if (!(d > 0.0)) continue;
        sum += std::log(d);
        ++count;
    }
    return count > 0.0 ? std::exp(sum / count) : 1.0;
}

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

}  // namespace

struct Multigrid::Levels {
    std::vector<Level> levels;
    double unit = 1.0;  // what A was divided by
    std::optional<Cholesky> coarsest;
    std::vector<Index> factored;  // rows of the coarsest level in its factor
    std::vector<Index> held;
    Block coarse_b;
    Block coarse_x;

    template <int K>
    void cycle(const Block& r, Block& z, Eigen::Index first);
    template <int K>
    void solve_coarsest();
    void factor(const SparseRows& A);
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
    // In a unit of its own, so that floats hold it in any unit of length.
    const Vector diagonal = A.diagonal();
    levels_->unit = typical(diagonal);
    std::vector<double> gamma = A.gamma();
    for (double& g : gamma)
        g /= levels_->unit;
    const PdeOperator scaled(A.laplacian(), A.sigma() / levels_->unit, gamma);
    const EdgeOperator<double>& K = A.laplacian().stiffness();
    const bool bilaplacian = A.order() == 2;
    const StiffnessRows plain{K, gamma[0], scaled.sigma(), &A.laplacian().mass()};

    std::vector<char> is_held(at(A.rows()), 0);
    for (const Index i : held)
        is_held[at(i)] = 1;
    SparseRows stored;    // A on the level; the finest is not stored
    SparseRows stored_K;  // K on the level, where interpolation is smoothed with it
    for (int l = 0;; ++l) {
        report(progress, "multigrid", static_cast<double>(l) / hierarchy.level_count());
        const bool last = l + 1 == hierarchy.level_count();
        const Index n = hierarchy.size(l);
        SparseRows coarse;
        SparseRows coarse_K;
        SparseRows P;
        if (l == 0) {
            for (Index i = 0; i < n; ++i) {
                if (!(diagonal[i] > 0.0)) is_held[at(i)] = 1;
                if (is_held[at(i)] != 0) levels_->held.push_back(i);
            }
        } else {
            is_held.assign(at(n), 0);
            for (Index i = 0; i < n; ++i) {
                double own = 0.0;
                stored.for_row(i, [&](Index j, double a) { own = i == j ? a : own; });
                if (!(own > 0.0)) is_held[at(i)] = 1;
            }
        }
        // What is made on the way to the coarse operator is gone before the level itself is made.
        if (!last) {
            P = rows_of(hierarchy.prolongation(l), is_held);
            if (!bilaplacian) {
                const SparseRows AP = l == 0 ? product(n, plain, P) : product(stored, P);
                coarse = product(transpose(P), AP);
            } else if (l == 0) {
                P = smoothed(n, StiffnessRows{K}, P, is_held);
                const SparseRows KP = product(n, StiffnessRows{K}, P);
                {
                    SparseRows weighted = transpose(KP);
                    scale_columns(gamma[1] * A.laplacian().inverse_mass(), weighted);
                    coarse = product(weighted, KP);
                }
                const SparseRows restriction = transpose(P);
                coarse_K = product(restriction, KP);
                if (gamma[0] > 0.0 || scaled.sigma() > 0.0)
                    coarse = sum(coarse, product(restriction, product(n, plain, P)));
            } else {
                P = smoothed(n, stored_K, P, is_held);
                const SparseRows restriction = transpose(P);
                coarse = product(restriction, product(stored, P));
                coarse_K = product(restriction, product(stored_K, P));
            }
        }
        Level& level = levels_->levels.emplace_back();
        if (l > 0) {
            level.stored = GaussSeidel(n, stored, is_held);
        } else if (bilaplacian) {
            level.normal.emplace(scaled, is_held);
        } else {
            level.stored = GaussSeidel(n, plain, is_held);
        }
        if (last) break;
        level.from_coarser = Interpolation(P);
        stored = std::move(coarse);
        stored_K = std::move(coarse_K);
    }
    if (levels_->levels.size() == 1) stored = rows_of(scaled.to_sparse());
    levels_->factor(stored);
}

// Where nothing holds a piece A is singular there: a little of its diagonal makes it definite. So much that the rounding of
// floats in a residual, which has no constant part, does not become a large constant.
void Multigrid::Levels::factor(const SparseRows& A) {
    const Level& last = levels.back();
    std::vector<Index> number(at(last.n()), -1);
    for (Index i = 0; i < last.n(); ++i) {
        if (last.is_held(i)) continue;
        number[at(i)] = static_cast<Index>(factored.size());
        factored.push_back(i);
    }
    const auto size = static_cast<Eigen::Index>(factored.size());
    if (size == 0) return;
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(A.column.size());
    for (const Index i : factored) {
        A.for_row(i, [&](Index j, double a) {
            if (number[at(j)] < 0) return;
            entries.emplace_back(number[at(i)], number[at(j)], i == j ? a * (1.0 + 1e-6) : a);
        });
    }
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    coarsest.emplace(matrix, Cholesky::Ordering::amd);
}
Multigrid::Multigrid(Multigrid&&) noexcept = default;
Multigrid& Multigrid::operator=(Multigrid&&) noexcept = default;
Multigrid::~Multigrid() = default;

template <int K>
void Multigrid::Levels::solve_coarsest() {
    Level& level = levels.back();
    std::fill_n(level.x.begin(), K * at(level.n()), 0.0F);
    if (!coarsest) return;
    coarse_b.resize(static_cast<Eigen::Index>(factored.size()), K);
    for (std::size_t i = 0; i < factored.size(); ++i) {
        for (int c = 0; c < K; ++c)
            coarse_b(static_cast<Eigen::Index>(i), c) = level.b[at(K * factored[i] + c)];
    }
    coarsest->solve(coarse_b, coarse_x);
    for (std::size_t i = 0; i < factored.size(); ++i) {
        for (int c = 0; c < K; ++c)
            level.x[at(K * factored[i] + c)] = static_cast<float>(coarse_x(static_cast<Eigen::Index>(i), c));
    }
}

// Columns first ... first + K of z.
template <int K>
void Multigrid::Levels::cycle(const Block& r, Block& z, Eigen::Index first) {
    for (Level& level : levels) {
        const std::size_t size = K * at(level.n());
        if (level.x.size() >= size) continue;
        level.x.resize(size);
        level.b.resize(size);
        if (level.normal) level.w.resize(size);
    }
    // Scaled, so that floats hold it.
    std::array<double, K> scale{};
    for (int c = 0; c < K; ++c)
        scale[c] = r.col(first + c).cwiseAbs().maxCoeff();
    Level& finest = levels.front();
    for (Index i = 0; i < finest.n(); ++i) {
        for (int c = 0; c < K; ++c)
            finest.b[at(K * i + c)] = scale[c] > 0.0 ? static_cast<float>(r(i, first + c) / scale[c]) : 0.0F;
    }
    for (std::size_t l = 0; l + 1 < levels.size(); ++l) {
        levels[l].descend<K>(levels[l + 1]);
    }
    solve_coarsest<K>();
    for (std::size_t l = levels.size() - 1; l-- > 0;)
        levels[l].ascend<K>(levels[l + 1]);
    for (Index i = 0; i < finest.n(); ++i) {
        for (int c = 0; c < K; ++c)
            z(i, first + c) = scale[c] / unit * finest.x[at(K * i + c)];
    }
    for (const Index i : held)
        z.row(i).segment(first, K).setZero();
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
    return levels_->levels.at(at(level)).n();
}
double Multigrid::entries_per_row(int level) const {
    const Level& l = levels_->levels.at(at(level));
    return l.normal ? l.normal->entries_per_row() : l.stored.entries_per_row();
}
std::size_t Multigrid::memory_bytes() const {
    std::size_t bytes = levels_->coarsest ? levels_->coarsest->memory_bytes() : 0;
    for (const Level& level : levels_->levels)
        bytes += level.memory_bytes();
    return bytes;
}

}  // namespace beltrami
