#include "beltrami/solvers/supernodal_ldlt.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/supernodal_factor.hpp"

namespace beltrami {

namespace {

using supernodal::Symbolic;

std::size_t at(Index i) {
    return static_cast<std::size_t>(i);
}

[[noreturn]] void no_room(Index n) {
    throw SolveError(fmt::format("the factor L D L^T of {} unknowns does not fit in memory", n),
                     "keep the factor on disk with --memory LIMIT");
}

// Rows are columns, as K is symmetric: up to the diagonal, the upper triangle.
supernodal::UpperPattern upper_pattern(const Eigen::SparseMatrix<double, Eigen::RowMajor>& K) {
    supernodal::UpperPattern pattern;
    pattern.starts.reserve(static_cast<std::size_t>(K.rows()) + 1);
    pattern.rows.reserve(static_cast<std::size_t>(K.nonZeros() + K.rows()) / 2);
    for (Eigen::Index row = 0; row < K.rows(); ++row) {
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(K, row); entry; ++entry) {
            if (entry.col() <= row) pattern.rows.push_back(static_cast<Index>(entry.col()));
        }
        pattern.starts.push_back(pattern.rows.size());
    }
    return pattern;
}

// Its upper triangle, in the order of the factor.
std::vector<double> entries_of(const Symbolic& symbolic,
                               const Eigen::SparseMatrix<double, Eigen::RowMajor>& matrix) {
    std::vector<double> entries(symbolic.entry_count(), 0.0);
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(matrix, row); entry; ++entry) {
            if (entry.col() > row) break;
            entries[symbolic.entry(static_cast<Index>(row), static_cast<Index>(entry.col()))] = entry.value();
        }
    }
    return entries;
}

}  // namespace

struct SupernodalLdlt::Factor {
    std::optional<supernodal::Factor> numeric;
    // In the order of the factor.
    std::vector<double> stiffness;
    std::vector<double> mass;

    bool factored = false;
    double shift = 0.0;
    Index negative = 0;
    double backward_error = 0.0;
    int factorizations = 0;
    mutable long solved = 0;

    [[nodiscard]] const Symbolic& symbolic() const { return numeric->symbolic(); }
    void build(const Eigenproblem& problem, const supernodal::Kernels& kernels, bool few_solves);
    void factor(double new_shift);
    void measure();
    void solve(const supernodal::RightHandSides& b, Eigen::Index size) const;
};

void SupernodalLdlt::Factor::build(const Eigenproblem& problem, const supernodal::Kernels& kernels,
                                   bool few_solves) {
    numeric.emplace(std::make_shared<const Symbolic>(upper_pattern(problem.stiffness()), few_solves),
                    kernels);
    stiffness = entries_of(symbolic(), problem.stiffness());
    mass = entries_of(symbolic(), problem.mass_matrix());
}

void SupernodalLdlt::Factor::factor(double new_shift) {
    factored = false;
    shift = new_shift;
    negative = 0;
    int pivots = -1;
    try {
        pivots = numeric->factor({stiffness.data(), mass.data(), shift});
    } catch (const std::bad_alloc&) {
        no_room(symbolic().n);
    }
    if (pivots < 0) {
        throw SolveError(
            fmt::format("K - {:.17g} M has a pivot that is zero or not finite: the shift is an eigenvalue of "
                        "it or of a part of it",
                        shift),
            "take another shift");
    }
    negative = pivots;
    ++factorizations;
    measure();
    // Not true for what is not a number.
    factored = backward_error <= 1e-8;
    if (!factored) {
        throw SolveError(
            fmt::format("pivots of K - {:.17g} M are too small: solves have the backward error {:.1e}", shift,
                        backward_error),
            "take another shift");
    }
}

void SupernodalLdlt::Factor::measure() {
    const Symbolic& s = symbolic();
    const Index n = s.n;
    // The same numbers in [-1, 1] on every machine (Knuth's multiplicative hash).
    Columns b(n, 1);
    for (Index i = 0; i < n; ++i)
        b(i, 0) = static_cast<double>(static_cast<std::uint32_t>(i + 1) * 2654435761U) / 2147483648.0 - 1.0;
    Columns x = b;
    numeric->solve({x.data(), x.data(), 1, n, 1});
    Vector product = Vector::Zero(n);
    Vector sums = Vector::Zero(n);
    for (Index j = 0; j < n; ++j) {
        const Index c = s.column[at(j)];
        for (std::size_t e = s.starts[at(j)]; e < s.starts[at(j) + 1]; ++e) {
            const Index r = s.unknowns[e];
            const double a = stiffness[e] - shift * mass[e];
            product[r] += a * x(c, 0);
            sums[r] += std::abs(a);
            if (r == c) continue;
            product[c] += a * x(r, 0);
            sums[c] += std::abs(a);
        }
    }
    const double residual = (product - b.col(0)).cwiseAbs().maxCoeff();
    const double scale = sums.maxCoeff() * x.cwiseAbs().maxCoeff() + b.cwiseAbs().maxCoeff();
    // Not finite where x is not: maxCoeff may pass over what is not a number.
    backward_error = x.allFinite() && product.allFinite() ? residual / scale : INFINITY;
}

void SupernodalLdlt::Factor::solve(const supernodal::RightHandSides& b, Eigen::Index size) const {
    if (!factored || size != symbolic().n) {
        throw InputError(fmt::format("a factor of {} rows got a right-hand side of {} rows",
                                     factored ? symbolic().n : 0, size),
                         "factor first, and give one row an unknown");
    }
    numeric->solve(b);
    solved += b.count;
}

SupernodalLdlt::SupernodalLdlt(const Eigenproblem& problem, const SupernodalLdltOptions& options)
    : factor_(std::make_unique<Factor>()) {
    const supernodal::Kernels* kernels = nullptr;
    for (const supernodal::Kernels* available : supernodal::available_kernels()) {
        if (kernels == nullptr && (options.instructions.empty() || options.instructions == available->name)) {
            kernels = available;
        }
    }
    if (kernels == nullptr) {
        throw InputError(fmt::format("this machine has no instructions \"{}\"", options.instructions),
                         "use avx512, avx2 or any, or leave it empty");
    }
    try {
        factor_->build(problem, *kernels, options.few_solves);
    } catch (const std::bad_alloc&) {
        no_room(problem.rows());
    }
}
SupernodalLdlt::SupernodalLdlt(SupernodalLdlt&&) noexcept = default;
SupernodalLdlt& SupernodalLdlt::operator=(SupernodalLdlt&&) noexcept = default;
SupernodalLdlt::~SupernodalLdlt() = default;

void SupernodalLdlt::factor(double shift) {
    factor_->factor(shift);
}
Index SupernodalLdlt::rows() const {
    return factor_->symbolic().n;
}
double SupernodalLdlt::shift() const {
    return factor_->shift;
}
Index SupernodalLdlt::negative_pivots() const {
    return factor_->negative;
}
double SupernodalLdlt::backward_error() const {
    return factor_->backward_error;
}
void SupernodalLdlt::solve(Columns& columns) const {
    factor_->solve({columns.data(), columns.data(), 1, columns.rows(), static_cast<Index>(columns.cols())},
                   columns.rows());
}
void SupernodalLdlt::solve(Eigen::Ref<Block> block) const {
    factor_->solve({block.data(), block.data(), block.outerStride(), 1, static_cast<Index>(block.cols())},
                   block.rows());
}
double SupernodalLdlt::nonzeros() const {
    return factor_->symbolic().nonzeros;
}
double SupernodalLdlt::flops() const {
    return factor_->symbolic().flops;
}
std::size_t SupernodalLdlt::memory_bytes() const {
    const Factor& f = *factor_;
    return f.numeric->memory_bytes() + f.symbolic().memory_bytes() +
           (f.stiffness.size() + f.mass.size()) * sizeof(double);
}
std::size_t SupernodalLdlt::working_bytes() const {
    return factor_->symbolic().working;
}
int SupernodalLdlt::factorizations() const {
    return factor_->factorizations;
}
std::string SupernodalLdlt::instructions() const {
    return factor_->numeric->kernels().name;
}
long SupernodalLdlt::solved_columns() const {
    return factor_->solved;
}

}  // namespace beltrami
