#include "beltrami/solvers/pivoted_ldlt.hpp"

#include <cholmod.h>
#include <dmumps_c.h>
#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/blas_threads.hpp"

namespace beltrami {

// MUMPS's own numbers, as its guide numbers them.
struct PivotedLdlt::Factor {
    DMUMPS_STRUC_C mumps{};
    std::vector<MUMPS_INT> rows;      // of the upper triangle, from 1
    std::vector<MUMPS_INT> columns;   // of the upper triangle, from 1
    std::vector<double> stiffness;    // of the upper triangle
    std::vector<double> mass;         // of the upper triangle
    std::vector<double> values;       // stiffness - shift mass
    std::vector<MUMPS_INT> ordering;  // position[v] in the elimination, from 1
    double shift = 0.0;
    bool factored = false;
    bool on_disk = false;
    double memory = 0.0;
    double disk = 0.0;
    int factorizations = 0;
    mutable long solved = 0;

    Factor() = default;
    Factor(const Factor&) = delete;
    Factor& operator=(const Factor&) = delete;
    ~Factor() { run(-2); }

    MUMPS_INT& control(int i) { return mumps.icntl[i - 1]; }
    [[nodiscard]] MUMPS_INT info(int i) const { return mumps.infog[i - 1]; }
    MUMPS_INT run(MUMPS_INT job) {
        mumps.job = job;
        dmumps_c(&mumps);
        return info(1);
    }
    [[noreturn]] void fail(const char* doing) const;
};

void PivotedLdlt::Factor::fail(const char* doing) const {
    const MUMPS_INT status = info(1);
    if (status == -10) {
        throw SolveError(fmt::format("K - {:.17g} M is singular: the shift is an eigenvalue", shift),
                         "take another shift");
    }
    if (status == -13 || status == -9 || status == -8) {
        throw SolveError(fmt::format("{} K - lambda M of {} unknowns does not fit in memory", doing, mumps.n),
                         "keep the factor on disk with --memory LIMIT");
    }
    if (status == -90 || status == -91 || status == -92) {
        throw SolveError(fmt::format("the factor of {} unknowns could not be kept on disk in {}", mumps.n,
                                     static_cast<const char*>(mumps.ooc_tmpdir)),
                         "free some space there, or name another folder with the variable TMPDIR");
    }
    throw SolveError(
        fmt::format("MUMPS failed {} K - lambda M of {} unknowns with status {}", doing, mumps.n, status),
        "please report the mesh");
}

namespace {

std::vector<MUMPS_INT> metis_ordering(const Eigen::SparseMatrix<double, Eigen::RowMajor>& pattern) {
    cholmod_common common;
    cholmod_start(&common);
    common.print = 0;
    const auto n = static_cast<std::size_t>(pattern.rows());
    // The rows of a symmetric pattern are its columns; stype -1: only the lower triangle of them is read.
    cholmod_sparse view{};
    view.nrow = n;
    view.ncol = n;
    view.nzmax = static_cast<std::size_t>(pattern.nonZeros());
    view.p = const_cast<int*>(pattern.outerIndexPtr());
    view.i = const_cast<int*>(pattern.innerIndexPtr());
    view.stype = -1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_PATTERN;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    std::vector<int> order(n);
    const bool ordered = cholmod_metis(&view, nullptr, 0, 1, order.data(), &common) != 0;
    cholmod_finish(&common);
    if (!ordered) return {};
    std::vector<MUMPS_INT> position(n);
    for (std::size_t k = 0; k < n; ++k)
        position[static_cast<std::size_t>(order[k])] = static_cast<MUMPS_INT>(k + 1);
    return position;
}

}  // namespace

PivotedLdlt::PivotedLdlt(const Eigenproblem& problem, const PivotedLdltOptions& options)
    : factor_(std::make_unique<Factor>()) {
    Factor& f = *factor_;
    const auto& K = problem.stiffness();
    const Eigen::SparseMatrix<double, Eigen::RowMajor> M = problem.mass_matrix();
    for (Eigen::Index row = 0; row < K.rows(); ++row) {
        decltype(f.stiffness)::size_type at = f.stiffness.size();
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(K, row); entry; ++entry) {
            if (entry.col() < row) continue;
            f.rows.push_back(static_cast<MUMPS_INT>(row + 1));
            f.columns.push_back(static_cast<MUMPS_INT>(entry.col() + 1));
            f.stiffness.push_back(entry.value());
            f.mass.push_back(0.0);
        }
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(M, row); entry; ++entry) {
            if (entry.col() < row) continue;
            // Both hold the entries of the same graph in the same order, but M may hold the diagonal only.
            while (f.columns[at] != entry.col() + 1)
                ++at;
            f.mass[at] = entry.value();
        }
    }
    f.values.resize(f.stiffness.size());

    f.mumps.par = 1;
    f.mumps.sym = 2;
    f.mumps.comm_fortran = -987654;
    f.run(-1);
    for (const int stream : {1, 2, 3})
        f.control(stream) = -1;
    f.control(4) = 0;
    f.control(6) = 0;   // neither a maximum transversal ...
    f.control(8) = 0;   // ... nor scaling, which would hide the pivots' size
    f.control(12) = 1;  // ordering by the pattern
    f.control(13) = 1;
    f.control(24) = 0;  // a singular matrix is an error
    f.mumps.n = static_cast<MUMPS_INT>(problem.rows());
    f.mumps.nnz = static_cast<MUMPS_INT8>(f.values.size());
    f.mumps.irn = f.rows.data();
    f.mumps.jcn = f.columns.data();
    f.mumps.a = f.values.data();
    f.ordering = metis_ordering(K);
    if (!f.ordering.empty()) {
        f.control(7) = 1;
        f.mumps.perm_in = f.ordering.data();
    }
    if (f.run(1) < 0) f.fail("analysing");
    f.control(14) = 50;  // per cent of room for delayed pivots

    // MUMPS estimates in millions of bytes; -3: entries of the factor in millions where negative.
    const auto entries = static_cast<double>(f.info(3)) * (f.info(3) < 0 ? -1e6 : 1.0);
    f.disk = entries * sizeof(double);
    f.on_disk = options.on_disk;
    f.memory = 1e6 * static_cast<double>(f.info(f.on_disk ? 27 : 17));
    if (f.on_disk) {
        const std::string folder = options.scratch.string();
        if (folder.size() >= sizeof(f.mumps.ooc_tmpdir)) {
            throw InputError("the scratch folder's name is longer than MUMPS can take: " + folder,
                             "name a shorter one with the variable TMPDIR");
        }
        std::strcpy(static_cast<char*>(f.mumps.ooc_tmpdir), folder.c_str());
        std::strcpy(static_cast<char*>(f.mumps.ooc_prefix), "beltrami");
        f.control(22) = 1;
    }
}

PivotedLdlt::~PivotedLdlt() = default;

void PivotedLdlt::factor(double shift) {
    Factor& f = *factor_;
    f.shift = shift;
    f.factored = false;
    for (std::size_t e = 0; e < f.values.size(); ++e)
        f.values[e] = f.stiffness[e] - shift * f.mass[e];
    const BlasThreads threads(f.mumps.rinfog[0] < BlasThreads::worth_threads ? 1 : omp_get_max_threads());
    MUMPS_INT status = f.run(2);
    // More delayed pivots than there was room for.
    for (int attempt = 0; attempt < 4 && (status == -8 || status == -9); ++attempt) {
        f.control(14) *= 2;
        status = f.run(2);
    }
    if (status < 0) f.fail("factoring");
    f.factored = true;
    ++f.factorizations;
}

Index PivotedLdlt::negative_pivots() const {
    return static_cast<Index>(factor_->info(12));
}

void PivotedLdlt::solve(Columns& columns) const {
    Factor& f = *factor_;
    if (!f.factored || columns.rows() != f.mumps.n) {
        throw InputError(fmt::format("a factor of {} rows got a right-hand side of {} rows",
                                     f.factored ? f.mumps.n : 0, columns.rows()),
                         "factor first, and give one row an unknown");
    }
    if (columns.cols() == 0) return;
    const BlasThreads threads(1);
    f.mumps.rhs = columns.data();
    f.mumps.lrhs = f.mumps.n;
    f.mumps.nrhs = static_cast<MUMPS_INT>(columns.cols());
    f.control(27) = static_cast<MUMPS_INT>(columns.cols());
    if (f.run(3) < 0) f.fail("solving with");
    f.solved += columns.cols();
}

int PivotedLdlt::factorizations() const {
    return factor_->factorizations;
}
long PivotedLdlt::solved_columns() const {
    return factor_->solved;
}
std::size_t PivotedLdlt::memory_bytes() const {
    return static_cast<std::size_t>(factor_->memory);
}
std::size_t PivotedLdlt::disk_bytes() const {
    return factor_->on_disk ? static_cast<std::size_t>(factor_->disk) : 0;
}

}  // namespace beltrami
