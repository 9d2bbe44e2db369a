#include "beltrami/solvers/cholesky.hpp"

#include <cholmod.h>
#include <fmt/format.h>
#include <omp.h>

#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/blas_threads.hpp"

namespace beltrami {

// CHOLMOD's long interface throughout: its 32-bit one overflows near two million vertices.
struct Cholesky::Factor {
    Factor() {
        cholmod_l_start(&common);
        common.print = 0;
        common.error_handler = nullptr;
        common.try_catch = 1;
    }
    Factor(const Factor&) = delete;
    Factor& operator=(const Factor&) = delete;
    ~Factor() {
        cholmod_l_free_factor(&factor, &common);
        cholmod_l_finish(&common);
    }
    mutable cholmod_common common{};
    cholmod_factor* factor = nullptr;
    double nonzeros = 0.0;
    std::size_t memory = 0;
};

namespace {

[[noreturn]] void fail(const cholmod_common& common, Index n) {
    if (common.status == CHOLMOD_OUT_OF_MEMORY || common.status == CHOLMOD_TOO_LARGE) {
        throw SolveError(fmt::format("the Cholesky factor of {} unknowns does not fit in memory", n),
                         "use the solver cg");
    }
    if (common.status < CHOLMOD_OK) {
        throw SolveError(fmt::format("CHOLMOD failed on {} unknowns with status {}", n, common.status),
                         "use the solver cg");
    }
    throw SolveError(fmt::format("the operator is not positive definite on its {} unknowns", n),
                     "every component needs a constraint; extreme slivers have the same effect");
}

}  // namespace

Cholesky::Cholesky(const Eigen::SparseMatrix<double>& A, Ordering ordering)
    : factor_(std::make_unique<Factor>()) {
    cholmod_common& common = factor_->common;
    const auto n = static_cast<Index>(A.rows());
    std::vector<SuiteSparse_long> starts{0};
    std::vector<SuiteSparse_long> rows;
    std::vector<double> values;
    starts.reserve(static_cast<std::size_t>(n) + 1);
    for (Eigen::Index column = 0; column < n; ++column) {
        for (Eigen::SparseMatrix<double>::InnerIterator entry(A, column); entry; ++entry) {
            if (entry.row() > column) break;
            rows.push_back(entry.row());
            values.push_back(entry.value());
        }
        starts.push_back(static_cast<SuiteSparse_long>(rows.size()));
    }
    cholmod_sparse upper{};
    upper.nrow = static_cast<std::size_t>(n);
    upper.ncol = static_cast<std::size_t>(n);
    upper.nzmax = rows.size();
    upper.p = starts.data();
    upper.i = rows.data();
    upper.x = values.data();
    upper.stype = 1;
    upper.itype = CHOLMOD_LONG;
    upper.xtype = CHOLMOD_REAL;
    upper.dtype = CHOLMOD_DOUBLE;
    upper.sorted = 1;
    upper.packed = 1;

    common.nmethods = 1;
    common.method[0].ordering = ordering == Ordering::amd ? CHOLMOD_AMD : CHOLMOD_METIS;
    common.postorder = 1;
    // L L^T also where CHOLMOD works column by column: its L D L^T there would accept negative pivots.
    common.final_ll = 1;
    factor_->factor = cholmod_l_analyze(&upper, &common);
    if (factor_->factor == nullptr) fail(common, n);
    factor_->nonzeros = common.lnz;
    const BlasThreads threads(common.fl < BlasThreads::worth_threads ? 1 : omp_get_max_threads());
    if (!cholmod_l_factorize(&upper, factor_->factor, &common) || common.status != CHOLMOD_OK ||
        factor_->factor->minor < factor_->factor->n) {
        fail(common, n);
    }
    factor_->memory = common.memory_inuse;
}

Cholesky::Cholesky(Cholesky&&) noexcept = default;
Cholesky& Cholesky::operator=(Cholesky&&) noexcept = default;
Cholesky::~Cholesky() = default;

Index Cholesky::rows() const {
    return static_cast<Index>(factor_->factor->n);
}
double Cholesky::nonzeros() const {
    return factor_->nonzeros;
}
std::size_t Cholesky::memory_bytes() const {
    return factor_->memory;
}

void Cholesky::solve(const Block& b, Block& x) const {
    if (b.rows() != rows()) {
        throw InputError(
            fmt::format("a factor of {} rows got a right-hand side of {} rows", rows(), b.rows()),
            "give one row an unknown");
    }
    const BlasThreads threads(1);
    Eigen::MatrixXd columns = b;
    cholmod_dense right{};
    right.nrow = static_cast<std::size_t>(columns.rows());
    right.ncol = static_cast<std::size_t>(columns.cols());
    right.nzmax = static_cast<std::size_t>(columns.size());
    right.d = right.nrow;
    right.x = columns.data();
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    cholmod_dense* solution = cholmod_l_solve(CHOLMOD_A, factor_->factor, &right, &factor_->common);
    if (solution == nullptr) fail(factor_->common, rows());
    x = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(solution->x), columns.rows(),
                                          columns.cols());
    cholmod_l_free_dense(&solution, &factor_->common);
}

}  // namespace beltrami
