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

namespace beltrami {

namespace {

using Matrix = Eigen::SparseMatrix<double>;

// Rows from which threads gain, and stretches of rows that are swept at once.
constexpr Index worth_threads = 20000;
constexpr int most_stretches = 4;

std::size_t at(Eigen::Index i) {
    return static_cast<std::size_t>(i);
}

struct Level {
    Index n = 0;
    int stretches = 1;
    // Rows without their diagonal, columns ascending: first those before the row's stretch, then those in it before the
    // row, then those behind the row.
    std::vector<Index> begin;
    std::vector<Index> in_stretch;
    std::vector<Index> behind;
    std::vector<Index> columns;
    std::vector<float> values;
    std::vector<float> diagonal;
    std::vector<float> inverse;  // of the diagonal; 0 for rows that are held
    // Interpolation from the next coarser level, by rows; empty on the coarsest.
    std::vector<Index> from_begin;
    std::vector<Index> from;
    std::vector<float> weights;
    // Of a cycle: solution, right-hand side, residual or correction; n x k.
    std::vector<float> x;
    std::vector<float> b;
    std::vector<float> e;

    [[nodiscard]] Index first_row(int stretch) const {
        return static_cast<Index>(static_cast<std::ptrdiff_t>(n) * stretch / stretches);
    }
    [[nodiscard]] std::size_t memory_bytes() const {
        return (begin.size() + in_stretch.size() + behind.size() + columns.size() + from_begin.size() +
                from.size()) *
                   sizeof(Index) +
               (values.size() + diagonal.size() + inverse.size() + weights.size() + x.size() + b.size() +
                e.size()) *
                   sizeof(float);
    }
};

// K numbers of a row.
template <int K>
struct Numbers {
    std::array<float, K> v{};
    explicit Numbers() = default;
    explicit Numbers(const float* p) { std::copy_n(p, K, v.begin()); }
    void add(float w, const float* p) {
        for (int c = 0; c < K; ++c)
            v[c] += w * p[c];
    }
    void store(float w, float* p) const {
        for (int c = 0; c < K; ++c)
            p[c] = w * v[c];
    }
};

// work(stretch) of each stretch.
template <class Work>
void for_stretches(const Level& level, Work work) {
#pragma omp parallel for schedule(static, 1) if (level.stretches > 1)
    for (int s = 0; s < level.stretches; ++s)
        work(s);
}

// x = (D + L)^-1 b in each stretch.
template <int K>
void sweep_down(Level& level) {
    for_stretches(level, [&](int s) {
        for (Index i = level.first_row(s); i < level.first_row(s + 1); ++i) {
            Numbers<K> sum(level.b.data() + K * i);
            for (Index e = level.in_stretch[at(i)]; e < level.behind[at(i)]; ++e)
                sum.add(-level.values[at(e)], level.x.data() + K * level.columns[at(e)]);
            sum.store(level.inverse[at(i)], level.x.data() + K * i);
        }
    });
}

// e = b - A x where sweep_down() made x: what it has seen cancels.
template <int K>
void residual_after_sweep(Level& level) {
    for_stretches(level, [&](int s) {
        for (Index i = level.first_row(s); i < level.first_row(s + 1); ++i) {
            Numbers<K> sum;
            for (Index e = level.begin[at(i)]; e < level.in_stretch[at(i)]; ++e)
                sum.add(-level.values[at(e)], level.x.data() + K * level.columns[at(e)]);
            for (Index e = level.behind[at(i)]; e < level.begin[at(i + 1)]; ++e)
                sum.add(-level.values[at(e)], level.x.data() + K * level.columns[at(e)]);
            sum.store(1.0F, level.e.data() + K * i);
        }
    });
}

// x += (D + U)^-1 (b - A x) in each stretch.
template <int K>
void sweep_up(Level& level) {
    for_stretches(level, [&](int s) {
        for (Index i = level.first_row(s); i < level.first_row(s + 1); ++i) {
            Numbers<K> sum(level.b.data() + K * i);
            sum.add(-level.diagonal[at(i)], level.x.data() + K * i);
            for (Index e = level.begin[at(i)]; e < level.begin[at(i + 1)]; ++e)
                sum.add(-level.values[at(e)], level.x.data() + K * level.columns[at(e)]);
            sum.store(1.0F, level.e.data() + K * i);
        }
    });
    for_stretches(level, [&](int s) {
        const Index last = level.first_row(s + 1);
        for (Index i = last; i-- > level.first_row(s);) {
            Numbers<K> sum(level.e.data() + K * i);
            for (Index e = level.behind[at(i)]; e < level.begin[at(i + 1)] && level.columns[at(e)] < last;
                 ++e)
                sum.add(-level.values[at(e)], level.e.data() + K * level.columns[at(e)]);
            sum.store(level.inverse[at(i)], level.e.data() + K * i);
            for (int c = 0; c < K; ++c)
                level.x[at(K * i + c)] += level.e[at(K * i + c)];
        }
    });
}

// The coarse b = P^T e.
template <int K>
void restrict_residual(const Level& fine, Level& coarse) {
    std::fill_n(coarse.b.begin(), K * coarse.n, 0.0F);
    for (Index i = 0; i < fine.n; ++i) {
        for (Index p = fine.from_begin[at(i)]; p < fine.from_begin[at(i + 1)]; ++p) {
            float* const to = coarse.b.data() + K * fine.from[at(p)];
            for (int c = 0; c < K; ++c)
                to[c] += fine.weights[at(p)] * fine.e[at(K * i + c)];
        }
    }
}

// x += P (the coarse x).
template <int K>
void interpolate(const Level& coarse, Level& fine) {
    for_stretches(fine, [&](int s) {
        for (Index i = fine.first_row(s); i < fine.first_row(s + 1); ++i) {
            Numbers<K> sum(fine.x.data() + K * i);
            for (Index p = fine.from_begin[at(i)]; p < fine.from_begin[at(i + 1)]; ++p)
                sum.add(fine.weights[at(p)], coarse.x.data() + K * fine.from[at(p)]);
            sum.store(1.0F, fine.x.data() + K * i);
        }
    });
}

Level level_of(const Matrix& A) {
    Level level;
    level.n = static_cast<Index>(A.rows());
    level.stretches = level.n < worth_threads ? 1 : most_stretches;
    level.begin.reserve(at(level.n) + 1);
    level.diagonal.assign(at(level.n), 0.0F);
    level.inverse.assign(at(level.n), 0.0F);
    level.columns.reserve(at(A.nonZeros()));
    level.values.reserve(at(A.nonZeros()));
    for (int s = 0; s < level.stretches; ++s) {
        const Index first = level.first_row(s);
        for (Index i = first; i < level.first_row(s + 1); ++i) {
            const auto start = static_cast<Index>(level.columns.size());
            Index before = start;
            Index lower = start;
            // A is symmetric: its columns are its rows.
            for (Matrix::InnerIterator entry(A, i); entry; ++entry) {
                const auto j = static_cast<Index>(entry.row());
                if (j == i) {
                    level.diagonal[at(i)] = static_cast<float>(entry.value());
                    level.inverse[at(i)] =
                        entry.value() > 0.0 ? static_cast<float>(1.0 / entry.value()) : 0.0F;
                    continue;
                }
                before += j < first ? 1 : 0;
                lower += j < i ? 1 : 0;
                level.columns.push_back(j);
                level.values.push_back(static_cast<float>(entry.value()));
            }
            level.begin.push_back(start);
            level.in_stretch.push_back(before);
            level.behind.push_back(lower);
        }
    }
    level.begin.push_back(static_cast<Index>(level.columns.size()));
    return level;
}

}  // namespace

struct Multigrid::Levels {
    std::vector<Level> levels;
    std::optional<Cholesky> coarsest;
    std::vector<Index> factored;  // rows of the coarsest level in its factor
    std::vector<Index> held;
    Block coarse_b;
    Block coarse_x;

    template <int K>
    void cycle(const Block& r, Block& z, Eigen::Index first);
    template <int K>
    void solve_coarsest();
};

Multigrid::Multigrid(const Matrix& A, const Hierarchy& hierarchy, std::span<const Index> held,
                     const Progress* progress)
    : levels_(std::make_unique<Levels>()) {
    if (A.rows() != hierarchy.size(0) || A.cols() != A.rows()) {
        throw InputError(fmt::format("an operator of {} x {} meets a hierarchy of {} vertices", A.rows(),
                                     A.cols(), hierarchy.size(0)),
                         "make both of the same mesh");
    }
    std::vector<char> masked(at(A.rows()), 0);
    for (const Index i : held)
        masked[at(i)] = 1;
    Matrix fine = A;
    fine.prune(
        [&](Eigen::Index i, Eigen::Index j, double) { return masked[at(i)] == 0 && masked[at(j)] == 0; });
    for (int l = 0;; ++l) {
        report(progress, "multigrid", static_cast<double>(l) / hierarchy.level_count());
        Level& level = levels_->levels.emplace_back(level_of(fine));
        if (l == 0) {
            for (Index i = 0; i < level.n; ++i) {
                if (level.inverse[at(i)] == 0.0F) levels_->held.push_back(i);
            }
        }
        if (l + 1 == hierarchy.level_count()) break;
        Hierarchy::Prolongation P = hierarchy.prolongation(l);
        P.prune([&](Eigen::Index i, Eigen::Index, double) { return level.inverse[at(i)] != 0.0F; });
        level.from_begin.assign(P.outerIndexPtr(), P.outerIndexPtr() + P.rows() + 1);
        level.from.assign(P.innerIndexPtr(), P.innerIndexPtr() + P.nonZeros());
        level.weights.resize(at(P.nonZeros()));
        std::transform(P.valuePtr(), P.valuePtr() + P.nonZeros(), level.weights.begin(),
                       [](double w) { return static_cast<float>(w); });
        fine = galerkin_product(fine, P);
    }
    // Where nothing holds a piece A is singular there: a little of its diagonal makes it definite. So much that the rounding
    // of floats in a residual, which has no constant part, does not become a large constant.
    const Level& last = levels_->levels.back();
    std::vector<Index> number(at(last.n), -1);
    for (Index i = 0; i < last.n; ++i) {
        if (last.inverse[at(i)] == 0.0F) continue;
        number[at(i)] = static_cast<Index>(levels_->factored.size());
        levels_->factored.push_back(i);
    }
    const auto size = static_cast<Eigen::Index>(levels_->factored.size());
    if (size == 0) return;
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(at(fine.nonZeros()));
    for (const Index j : levels_->factored) {
        for (Matrix::InnerIterator entry(fine, j); entry; ++entry) {
            const Index i = number[at(entry.row())];
            if (i < 0) continue;
            const double more = entry.row() == j ? 1.0 + 1e-6 : 1.0;
            entries.emplace_back(i, number[at(j)], more * entry.value());
        }
    }
    Matrix coarsest(size, size);
    coarsest.setFromTriplets(entries.begin(), entries.end());
    levels_->coarsest.emplace(coarsest, Cholesky::Ordering::amd);
}
Multigrid::Multigrid(Multigrid&&) noexcept = default;
Multigrid& Multigrid::operator=(Multigrid&&) noexcept = default;
Multigrid::~Multigrid() = default;

template <int K>
void Multigrid::Levels::solve_coarsest() {
    Level& level = levels.back();
    std::fill(level.x.begin(), level.x.begin() + K * level.n, 0.0F);
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
        const std::size_t size = K * at(level.n);
        if (level.x.size() >= size) continue;
        level.x.resize(size);
        level.b.resize(size);
        level.e.resize(size);
    }
    // Scaled, so that floats hold it.
    std::array<double, K> scale{};
    for (int c = 0; c < K; ++c)
        scale[c] = r.col(first + c).cwiseAbs().maxCoeff();
    Level& finest = levels.front();
    for (Index i = 0; i < finest.n; ++i) {
        for (int c = 0; c < K; ++c)
            finest.b[at(K * i + c)] = scale[c] > 0.0 ? static_cast<float>(r(i, first + c) / scale[c]) : 0.0F;
    }
    for (std::size_t l = 0; l + 1 < levels.size(); ++l) {
        sweep_down<K>(levels[l]);
        residual_after_sweep<K>(levels[l]);
        restrict_residual<K>(levels[l], levels[l + 1]);
    }
    solve_coarsest<K>();
    for (std::size_t l = levels.size() - 1; l-- > 0;) {
        interpolate<K>(levels[l + 1], levels[l]);
        sweep_up<K>(levels[l]);
    }
    for (Index i = 0; i < finest.n; ++i) {
        for (int c = 0; c < K; ++c)
            z(i, first + c) = scale[c] * finest.x[at(K * i + c)];
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
    return levels_->levels.at(at(level)).n;
}
double Multigrid::entries_per_row(int level) const {
    const Level& l = levels_->levels.at(at(level));
    return 1.0 + static_cast<double>(l.columns.size()) / std::max<Index>(l.n, 1);
}
std::size_t Multigrid::memory_bytes() const {
    std::size_t bytes = levels_->coarsest ? levels_->coarsest->memory_bytes() : 0;
    for (const Level& level : levels_->levels)
        bytes += level.memory_bytes();
    return bytes;
}

}  // namespace beltrami
