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
    // Of the rows that changed since A was factored as B, which has rows of the identity where it held A:
    //     [ B   V ] [x]   [b]    V: the column of A, but for what B holds, of each row let go; e_h of each row h newly held
    //     [ V^T C ] [y] = [c]    C: A among the rows let go; y: x there, and the forces that hold the others
    // so that (C - V^T B^-1 V) y = c - V^T B^-1 b and x = B^-1 b - B^-1 V y.
    struct Row {
        Index row;
        bool let_go;
        std::vector<std::pair<Index, double>> column;  // of V
    };
    struct Correction {
        std::vector<Row> rows;
        Block solved;  // B^-1 V: n x m
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
    bool correct(const Sparse& A, const std::vector<Index>& changed);
    [[nodiscard]] Eigen::MatrixXd set_columns(const Sparse& A, std::vector<Row>& rows) const;
    [[nodiscard]] Block solved_columns(const std::vector<Row>& rows) const;
    void sweep(const Block& b, Block& x) const;
    void solve_corrected(const Block& b, Block& x) const;
};

namespace {

// V^T z: m x k.
template <class Row>
Eigen::MatrixXd gathered(const std::vector<Row>& rows, const Block& z) {
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(std::ssize(rows), z.cols());
    for (Eigen::Index i = 0; i < sums.rows(); ++i) {
        for (const auto& [row, value] : rows[at(i)].column)
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

// Sets the rows' columns of V; returns C.
Eigen::MatrixXd Cholesky::Factor::set_columns(const Sparse& A, std::vector<Row>& rows) const {
    const auto m = std::ssize(rows);
    Eigen::MatrixXd C = Eigen::MatrixXd::Zero(m, m);
    std::vector<Index> place(at(size()), -1);  // among the rows let go
    bool any = false;
    for (Eigen::Index i = 0; i < m; ++i) {
        Row& changed = rows[at(i)];
        if (changed.let_go) {
            place[at(changed.row)] = static_cast<Index>(i);
            any = true;
        } else {
            changed.column.emplace_back(changed.row, 1.0);
        }
    }
    if (!any) return C;
    const auto add = [&](Index own, Eigen::Index other, double value) {
        if (place[at(other)] >= 0) {
            C(own, place[at(other)]) = value;
        } else if (held[at(other)] == 0) {
            rows[at(own)].column.emplace_back(static_cast<Index>(other), value);
        }
    };
    for (Eigen::Index col = 0; col < A.cols(); ++col) {
        for (Sparse::InnerIterator entry(A, col); entry && entry.row() <= col; ++entry) {
            const Index of_col = place[at(col)];
            const Index of_row = place[at(entry.row())];
            if (of_col >= 0) add(of_col, entry.row(), entry.value());
            if (of_row >= 0 && entry.row() != col) add(of_row, col, entry.value());
        }
    }
    return C;
}

// B^-1 V: n x m. Columns of rows that were corrected before are at hand.
Block Cholesky::Factor::solved_columns(const std::vector<Row>& rows) const {
    const auto m = std::ssize(rows);
    Block solved = Block::Zero(size(), m);
    std::vector<Eigen::Index> fresh;
    for (Eigen::Index i = 0; i < m; ++i) {
        const auto known = std::find_if(correction.rows.begin(), correction.rows.end(),
                                        [&](const Row& old) { return old.row == rows[at(i)].row; });
        if (known != correction.rows.end()) {
            solved.col(i) = correction.solved.col(known - correction.rows.begin());
            continue;
        }
        fresh.push_back(i);
        for (const auto& [row, value] : rows[at(i)].column)
            solved(row, i) = value;
    }
    if (std::ssize(fresh) == m) {
        sweep(solved, solved);
    } else if (!fresh.empty()) {
        Block columns = solved(Eigen::all, fresh);
        sweep(columns, columns);
        solved(Eigen::all, fresh) = columns;
    }
    return solved;
}

// False where the corrected solves would not be sound; nothing has changed then.
bool Cholesky::Factor::correct(const Sparse& A, const std::vector<Index>& changed) {
    Correction next;
    for (const Index row : changed)
        next.rows.push_back({row, held[at(row)] != 0, {}});
    const Eigen::MatrixXd C = set_columns(A, next.rows);
    next.solved = solved_columns(next.rows);
    const Eigen::MatrixXd schur = C - gathered(next.rows, next.solved);
    Eigen::VectorXd sizes(schur.rows());
    Eigen::Index let_go = 0;
    for (Eigen::Index i = 0; i < sizes.size(); ++i) {
        const Row& row = next.rows[at(i)];
        sizes[i] = row.let_go ? C(i, i) : next.solved(row.row, i);
        let_go += row.let_go ? 1 : 0;
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
        own.row(i) = b.row(correction.rows[at(i)].row);
    x = b;
    Eigen::MatrixXd y = own;
    for (Eigen::Index i = 0; i < m; ++i) {
        if (correction.rows[at(i)].let_go) continue;
        y.row(i).setZero();
        x.row(correction.rows[at(i)].row).setZero();
    }
    sweep(x, x);
    y -= gathered(correction.rows, x);
    y = correction.schur.solve(y).eval();
    x.noalias() -= correction.solved * y;
    for (Eigen::Index i = 0; i < m; ++i) {
        const Row& row = correction.rows[at(i)];
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
    if (factor_->factored && std::ssize(changed) <= most_corrected()) {
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
           static_cast<std::size_t>(factor_->correction.solved.size()) * sizeof(double);
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

}  // namespace beltrami
