// CHOLMOD as a person would use it: METIS or AMD, supernodes, OpenBLAS on one thread, right-hand sides in blocks with their
// work space kept. What our factors are measured against.
#pragma once

#include <cholmod.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <vector>

#include "beltrami/framework/types.hpp"
#include "beltrami/solvers/blas_threads.hpp"

namespace beltrami::bench {

class CholmodFactor {
  public:
    /// The upper triangle of A.
    CholmodFactor(const Eigen::SparseMatrix<double>& A, bool metis) {
        for (Eigen::Index col = 0; col < A.cols(); ++col) {
            for (Eigen::SparseMatrix<double>::InnerIterator entry(A, col); entry && entry.row() <= col;
                 ++entry) {
                rows_.push_back(entry.row());
                values_.push_back(entry.value());
            }
            starts_.push_back(static_cast<SuiteSparse_long>(rows_.size()));
        }
        cholmod_l_start(&common_);
        common_.nmethods = 1;
        common_.method[0].ordering = metis ? CHOLMOD_METIS : CHOLMOD_AMD;
        common_.postorder = 1;
        upper_.nrow = upper_.ncol = static_cast<std::size_t>(A.cols());
        upper_.nzmax = rows_.size();
        upper_.p = starts_.data();
        upper_.i = rows_.data();
        upper_.x = values_.data();
        upper_.stype = 1;
        upper_.itype = CHOLMOD_LONG;
        upper_.xtype = CHOLMOD_REAL;
        upper_.dtype = CHOLMOD_DOUBLE;
        upper_.sorted = 1;
        upper_.packed = 1;
        factor_ = cholmod_l_analyze(&upper_, &common_);
        factor();
    }
    CholmodFactor(const CholmodFactor&) = delete;
    CholmodFactor& operator=(const CholmodFactor&) = delete;
    ~CholmodFactor() {
        for (cholmod_dense** block : {&X_, &Y_, &E_})
            cholmod_l_free_dense(block, &common_);
        cholmod_l_free_factor(&factor_, &common_);
        cholmod_l_finish(&common_);
    }

    void factor() {
        const BlasThreads threads(1);
        cholmod_l_factorize(&upper_, factor_, &common_);
    }
    /// `width` columns at a time; b and x are copied to and from columns.
    void solve(const Block& b, Block& x, Index width) {
        const BlasThreads threads(1);
        x.resize(b.rows(), b.cols());
        for (Eigen::Index first = 0; first < b.cols(); first += width) {
            const Eigen::Index count = std::min<Eigen::Index>(width, b.cols() - first);
            columns_ = b.middleCols(first, count);
            cholmod_dense right{};
            right.nrow = right.d = static_cast<std::size_t>(columns_.rows());
            right.ncol = static_cast<std::size_t>(count);
            right.nzmax = right.nrow * right.ncol;
            right.x = columns_.data();
            right.xtype = CHOLMOD_REAL;
            right.dtype = CHOLMOD_DOUBLE;
            cholmod_l_solve2(CHOLMOD_A, factor_, &right, nullptr, &X_, nullptr, &Y_, &E_, &common_);
            x.middleCols(first, count) =
                Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(X_->x), columns_.rows(), count);
        }
    }
    [[nodiscard]] double memory_bytes() const { return static_cast<double>(common_.memory_inuse); }
    [[nodiscard]] double nonzeros() const { return common_.lnz; }

  private:
    std::vector<SuiteSparse_long> starts_{0};
    std::vector<SuiteSparse_long> rows_;
    std::vector<double> values_;
    cholmod_common common_{};
    cholmod_sparse upper_{};
    cholmod_factor* factor_ = nullptr;
    cholmod_dense* X_ = nullptr;
    cholmod_dense* Y_ = nullptr;
    cholmod_dense* E_ = nullptr;
    Eigen::MatrixXd columns_;
};

}  // namespace beltrami::bench
