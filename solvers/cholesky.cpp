#include "beltrami/solvers/cholesky.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <new>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/supernodal_factor.hpp"

namespace beltrami {

namespace {

using Sparse = Eigen::SparseMatrix<double>;
using supernodal::Symbolic;

std::size_t at(Eigen::Index i) {
    return static_cast<std::size_t>(i);
}

[[noreturn]] void no_room(Eigen::Index n) {
    throw SolveError(fmt::format("the Cholesky factor of {} unknowns does not fit in memory", n),
                     "use the solver multigrid or cg");
}

[[noreturn]] void not_definite(Index n) {
    throw SolveError(fmt::format("the operator is not positive definite on its {} unknowns", n),
                     "every component needs a constraint; extreme slivers have the same effect");
}

void check_square(const Sparse& A) {
    if (A.rows() != A.cols()) {
        throw InputError(fmt::format("a matrix of {} x {} has no Cholesky factor", A.rows(), A.cols()),
                         "give a symmetric one");
    }
}

supernodal::UpperPattern upper_pattern(const Sparse& A) {
    supernodal::UpperPattern pattern;
    pattern.starts.reserve(at(A.cols()) + 1);
    pattern.rows.reserve(at(A.nonZeros() + A.cols()) / 2);
    for (Eigen::Index col = 0; col < A.cols(); ++col) {
        for (Sparse::InnerIterator entry(A, col); entry && entry.row() < col; ++entry)
            pattern.rows.push_back(static_cast<Index>(entry.row()));
        pattern.rows.push_back(static_cast<Index>(col));
        pattern.starts.push_back(pattern.rows.size());
    }
    return pattern;
}

// Throws InputError for what is out of range.
std::vector<char> mask_of(std::span<const Index> held, Index n) {
    std::vector<char> mask(at(n), 0);
    for (const Index v : held) {
        if (v < 0 || v >= n) {
            throw InputError(fmt::format("row {} is to be held in a matrix of {} rows", v, n),
                             "rows are numbered from 0");
        }
        mask[at(v)] = 1;
    }
    return mask;
}

// The upper triangle of A in the order of the factor, held rows and columns as those of the identity.
std::vector<double> entries_of(const Sparse& A, const Symbolic& symbolic, const std::vector<char>& held) {
    std::vector<double> entries(symbolic.entry_count(), 0.0);
    for (Index col = 0; col < symbolic.n; ++col) {
        for (Sparse::InnerIterator entry(A, col); entry && entry.row() <= col; ++entry) {
            const auto row = static_cast<Index>(entry.row());
            const std::size_t e = symbolic.entry(row, col);
            if (e == Symbolic::none) {
                throw InputError(
                    fmt::format("entry ({}, {}) lies outside the pattern that was analysed", row, col),
                    "analyse the pattern of this matrix");
            }
            if (held[at(row)] != 0 || held[at(col)] != 0) continue;
            if (!std::isfinite(entry.value())) {
                throw InputError(fmt::format("entry ({}, {}) of the matrix is {}", row, col, entry.value()),
                                 "look for NaN and infinity in what it was made of");
            }
            entries[e] = entry.value();
        }
    }
    for (Index row = 0; row < symbolic.n; ++row) {
        if (held[at(row)] != 0) entries[symbolic.entry(row, row)] = 1.0;
    }
    return entries;
}

}  // namespace

CholeskyAnalysis::CholeskyAnalysis(const Sparse& pattern, Ordering ordering) {
    check_square(pattern);
    try {
        symbolic_ = std::make_shared<const Symbolic>(upper_pattern(pattern), ordering == Ordering::amd);
    } catch (const std::bad_alloc&) {
        no_room(pattern.rows());
    }
    ++builds_;
}
Index CholeskyAnalysis::rows() const {
    return symbolic_->n;
}
double CholeskyAnalysis::nonzeros() const {
    return symbolic_->nonzeros;
}
double CholeskyAnalysis::flops() const {
    return symbolic_->flops;
}
std::size_t CholeskyAnalysis::memory_bytes() const {
    return symbolic_->memory_bytes();
}
std::size_t CholeskyAnalysis::factor_bytes() const {
    return symbolic_->values_size * sizeof(double);
}
std::size_t CholeskyAnalysis::working_bytes() const {
    return symbolic_->working;
}

struct Cholesky::Factor {
    using SparseColumn = std::vector<std::pair<Index, double>>;

    // Of the rows that changed since A was factored as B, which has rows of the identity where it held A:
    //     [ B   V ] [x]   [b]    V: the column of A, but for what B holds, of each row let go; e_h of each row h newly held
    //     [ V^T C ] [y] = [c]    C: A among the rows let go; y: x there, and the forces that hold the others
    // so that (C - V^T B^-1 V) y = c - V^T B^-1 b and x = B^-1 b - B^-1 V y.
    // A row keeps what it needs from one correction to the next.
    struct Row {
        Index row;
        bool let_go;
        SparseColumn column;  // of V
        SparseColumn beside;  // of A, at rows that B holds: what C is made of
        Vector solved;        // B^-1 V
    };
    using Rows = std::vector<std::shared_ptr<Row>>;
    struct Correction {
        Rows rows;
        Eigen::PartialPivLU<Eigen::MatrixXd> schur;
    };

    std::shared_ptr<const CholeskyAnalysis> analysis;
    supernodal::Factor numeric;
    std::vector<char> held;  // in the factorization
    bool factored = false;
    int factorizations = 0;
    Correction correction;

    Factor(std::shared_ptr<const CholeskyAnalysis> of, std::shared_ptr<const Symbolic> symbolic)
        : analysis(std::move(of)), numeric(std::move(symbolic), *supernodal::available_kernels().front()) {}
    [[nodiscard]] Index size() const { return numeric.symbolic().n; }
    void check_size(const Sparse& A) const;
    void factor(const Sparse& A, std::span<const Index> now);
    [[nodiscard]] Index most_corrected() const;
    bool correct(const Sparse& A, const std::vector<Index>& changed);
    void set_columns(const Sparse& A, const Rows& rows) const;
    void solve_columns(const Rows& rows) const;
    void sweep(const Block& b, Block& x) const;
    void solve_corrected(const Block& b, Block& x) const;
};

namespace {

// work(first row, count): of runs of rows that stay in the cache meanwhile.
template <class Work>
void for_each_run(Index rows, Work work) {
    constexpr Index rows_a_run = 4096;
    const Index runs = (rows + rows_a_run - 1) / rows_a_run;
#pragma omp parallel for schedule(static) if (runs > 8)
    for (Index run = 0; run < runs; ++run) {
        const Index first = run * rows_a_run;
        work(first, std::min(rows_a_run, rows - first));
    }
}

// V^T z: m x k.
template <class Rows, class Derived>
Eigen::MatrixXd gathered(const Rows& rows, const Eigen::MatrixBase<Derived>& z) {
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(std::ssize(rows), z.cols());
    for (Eigen::Index i = 0; i < sums.rows(); ++i) {
        for (const auto& [row, value] : rows[at(i)]->column)
            sums.row(i) += value * z.row(row);
    }
    return sums;
}

// The inertia tells whether the matrix with the changed rows is positive definite (Haynsworth 1968): as many positive
// eigenvalues as rows were let go and the others negative. Where one is small beside the rows' own size, what is left of it
// is rounding.
bool is_sound(const Eigen::MatrixXd& schur, const Eigen::VectorXd& sizes, Eigen::Index let_go) {
    constexpr double smallest = 1e-8;
    if (!schur.allFinite() || !(sizes.minCoeff() > 0.0)) return false;
    const Eigen::VectorXd scale = sizes.cwiseSqrt().cwiseInverse();
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scale.asDiagonal() * schur * scale.asDiagonal(),
                                                       Eigen::EigenvaluesOnly)
            .eigenvalues();
    return (values.array() > smallest).count() == let_go &&
           (values.array() < -smallest).count() == values.size() - let_go;
}

}  // namespace

// x = B^-1 b, both n x k; they may be the same.
void Cholesky::Factor::sweep(const Block& b, Block& x) const {
    x.resize(b.rows(), b.cols());
    numeric.solve({b.data(), x.data(), b.cols(), 1, static_cast<Index>(b.cols())});
}

void Cholesky::Factor::check_size(const Sparse& A) const {
    if (A.rows() == size() && A.cols() == size()) return;
    throw InputError(
        fmt::format("a matrix of {} x {} meets the analysis of one of {} rows", A.rows(), A.cols(), size()),
        "analyse the pattern of this matrix");
}

void Cholesky::Factor::factor(const Sparse& A, std::span<const Index> now) {
    check_size(A);
    std::vector<char> mask = mask_of(now, size());
    const std::vector<double> entries = entries_of(A, numeric.symbolic(), mask);
    factored = false;
    correction = {};
    held = std::move(mask);
    const int negative = numeric.factor({entries.data(), nullptr, 0.0});
    if (negative != 0) not_definite(size());
    factored = true;
    ++factorizations;
}

// What is kept of the corrected rows is then half as large as the factor.
Index Cholesky::Factor::most_corrected() const {
    constexpr double least = 20.0;
    return static_cast<Index>(std::max(least, 0.5 * analysis->nonzeros() / std::max<Index>(size(), 1)));
}

// Of rows of which nothing is known yet.
void Cholesky::Factor::set_columns(const Sparse& A, const Rows& rows) const {
    std::vector<Row*> of_vertex(at(size()), nullptr);
    bool any = false;
    for (const std::shared_ptr<Row>& changed : rows) {
        if (changed->let_go) {
            of_vertex[at(changed->row)] = changed.get();
            any = true;
        } else {
            changed->column.emplace_back(changed->row, 1.0);
        }
    }
    if (!any) return;
    const auto add = [&](Row* to, Eigen::Index other, double value) {
        if (to == nullptr) return;
        (held[at(other)] != 0 ? to->beside : to->column).emplace_back(static_cast<Index>(other), value);
    };
    for (Eigen::Index col = 0; col < A.cols(); ++col) {
        Row* const of_col = of_vertex[at(col)];
        for (Sparse::InnerIterator entry(A, col); entry && entry.row() <= col; ++entry) {
            add(of_col, entry.row(), entry.value());
            if (entry.row() != col) add(of_vertex[at(entry.row())], col, entry.value());
        }
    }
}

// All in one sweep.
void Cholesky::Factor::solve_columns(const Rows& rows) const {
    const auto m = std::ssize(rows);
    Block columns = Block::Zero(size(), m);
    for (Eigen::Index i = 0; i < m; ++i) {
        for (const auto& [row, value] : rows[at(i)]->column)
            columns(row, i) = value;
    }
    sweep(columns, columns);
    for (const std::shared_ptr<Row>& row : rows)
        row->solved.resize(size());
    for_each_run(size(), [&](Index first, Index count) {
        for (Eigen::Index i = 0; i < m; ++i)
            rows[at(i)]->solved.segment(first, count) = columns.col(i).segment(first, count);
    });
}

// False where the corrected solves would not be sound; nothing has changed then.
bool Cholesky::Factor::correct(const Sparse& A, const std::vector<Index>& changed) {
    constexpr std::ptrdiff_t most_fresh = 20;  // a sweep of more of them costs as much as a new factor
    Correction next;
    Rows fresh;
    for (const Index row : changed) {
        const auto known = std::find_if(correction.rows.begin(), correction.rows.end(),
                                        [&](const auto& old) { return old->row == row; });
        if (known != correction.rows.end()) {
            next.rows.push_back(*known);
            continue;
        }
        fresh.push_back(std::make_shared<Row>(Row{row, held[at(row)] != 0, {}, {}, {}}));
        next.rows.push_back(fresh.back());
    }
    if (std::ssize(fresh) > most_fresh) return false;
    if (!fresh.empty()) {
        set_columns(A, fresh);
        solve_columns(fresh);
    }
    const auto m = std::ssize(next.rows);
    const auto place = [&](Index row) {
        return std::lower_bound(changed.begin(), changed.end(), row) - changed.begin();
    };
    Eigen::MatrixXd schur(m, m);
    Eigen::VectorXd sizes(m);
    Eigen::Index let_go = 0;
    for (Eigen::Index i = 0; i < m; ++i) {
        const Row& row = *next.rows[at(i)];
        schur.col(i) = -gathered(next.rows, row.solved);
        sizes[i] = row.let_go ? 0.0 : row.solved[row.row];
        let_go += row.let_go ? 1 : 0;
        for (const auto& [other, value] : row.beside) {
            const std::ptrdiff_t j = place(other);
            if (j == m || changed[at(j)] != other) continue;
            schur(j, i) += value;
            if (j == i) sizes[i] = value;
        }
    }
    if (!is_sound(schur, sizes, let_go)) return false;
    next.schur.compute(schur);
    correction = std::move(next);
    return true;
}

void Cholesky::Factor::solve_corrected(const Block& b, Block& x) const {
    const auto m = std::ssize(correction.rows);
    Eigen::MatrixXd own(m, b.cols());
    for (Eigen::Index i = 0; i < m; ++i)
        own.row(i) = b.row(correction.rows[at(i)]->row);
    x = b;
    Eigen::MatrixXd y = own;
    for (Eigen::Index i = 0; i < m; ++i) {
        if (correction.rows[at(i)]->let_go) continue;
        y.row(i).setZero();
        x.row(correction.rows[at(i)]->row).setZero();
    }
    sweep(x, x);
    y -= gathered(correction.rows, x);
    y = correction.schur.solve(y).eval();
    for_each_run(size(), [&](Index first, Index count) {
        for (Eigen::Index i = 0; i < m; ++i)
            x.middleRows(first, count).noalias() -=
                correction.rows[at(i)]->solved.segment(first, count) * y.row(i);
    });
    for (Eigen::Index i = 0; i < m; ++i) {
        const Row& row = *correction.rows[at(i)];
        x.row(row.row) = row.let_go ? y.row(i) : own.row(i);
    }
}

Cholesky::Cholesky(const Sparse& A, Ordering ordering)
    : Cholesky(A, std::make_shared<const CholeskyAnalysis>(A, ordering)) {}

Cholesky::Cholesky(const Sparse& A, std::shared_ptr<const CholeskyAnalysis> analysis,
                   std::span<const Index> held) {
    try {
        const std::shared_ptr<const Symbolic> symbolic = analysis->symbolic_;
        factor_ = std::make_unique<Factor>(std::move(analysis), symbolic);
    } catch (const std::bad_alloc&) {
        no_room(A.rows());
    }
    refactor(A, held);
}

Cholesky::Cholesky(Cholesky&&) noexcept = default;
Cholesky& Cholesky::operator=(Cholesky&&) noexcept = default;
Cholesky::~Cholesky() = default;

void Cholesky::refactor(const Sparse& A, std::span<const Index> held) {
    try {
        factor_->factor(A, held);
    } catch (const std::bad_alloc&) {
        no_room(A.rows());
    }
}

void Cholesky::change_held(const Sparse& A, std::span<const Index> held) {
    factor_->check_size(A);
    const std::vector<char> mask = mask_of(held, rows());
    std::vector<Index> changed;
    for (Index row = 0; row < rows(); ++row) {
        if (mask[at(row)] != factor_->held[at(row)]) changed.push_back(row);
    }
    if (factor_->factored && changed.empty()) {
        factor_->correction = {};
        return;
    }
    if (factor_->factored && std::ssize(changed) <= factor_->most_corrected()) {
        try {
            if (factor_->correct(A, changed)) return;
        } catch (const std::bad_alloc&) {
            no_room(rows());
        }
    }
    refactor(A, held);
}

void Cholesky::solve(const Block& b, Block& x) const {
    if (!factor_->factored || b.rows() != rows()) {
        throw InputError(fmt::format("a factor of {} rows got a right-hand side of {} rows",
                                     factor_->factored ? rows() : 0, b.rows()),
                         "factor first, and give one row an unknown");
    }
    try {
        if (factor_->correction.rows.empty()) {
            factor_->sweep(b, x);
        } else {
            factor_->solve_corrected(b, x);
        }
    } catch (const std::bad_alloc&) {
        no_room(rows());
    }
}

Index Cholesky::rows() const {
    return factor_->size();
}
double Cholesky::nonzeros() const {
    return factor_->analysis->nonzeros();
}
std::size_t Cholesky::memory_bytes() const {
    return factor_->numeric.memory_bytes() + factor_->analysis->memory_bytes() + factor_->held.size() +
           factor_->correction.rows.size() * static_cast<std::size_t>(rows()) * sizeof(double);
}
const std::shared_ptr<const CholeskyAnalysis>& Cholesky::analysis() const {
    return factor_->analysis;
}
int Cholesky::factorizations() const {
    return factor_->factorizations;
}
Index Cholesky::corrected() const {
    return static_cast<Index>(factor_->correction.rows.size());
}
Index Cholesky::most_corrected() const {
    return factor_->most_corrected();
}

}  // namespace beltrami
