// A sparse Cholesky factor that is kept: CHOLMOD behind a small door.
//
//     Cholesky factor(A);            // A symmetric positive definite, both triangles or the upper one
//     factor.solve(b, x);            // as often as wanted, all columns in one block
#pragma once

#include <Eigen/SparseCore>
#include <memory>

#include "beltrami/framework/types.hpp"

namespace beltrami {

class Cholesky {
  public:
    enum class Ordering {
        amd,   ///< quick to find: for a single factor
        metis  ///< less fill: for a factor that is used many times
    };

    /// Analyses and factors. Throws SolveError where A is not positive definite (which CHOLMOD's supernodal code does
    /// not report by its status alone) or memory does not suffice.
    explicit Cholesky(const Eigen::SparseMatrix<double>& A, Ordering ordering = Ordering::amd);
    Cholesky(Cholesky&&) noexcept;
    Cholesky& operator=(Cholesky&&) noexcept;
    Cholesky(const Cholesky&) = delete;
    Cholesky& operator=(const Cholesky&) = delete;
    ~Cholesky();

    /// x = A^-1 b, n x k. One thread at a time: CHOLMOD keeps its work space with the factor. Throws InputError for a wrong number of rows.
    void solve(const Block& b, Block& x) const;

    [[nodiscard]] Index rows() const;
    [[nodiscard]] double nonzeros() const;  ///< of the factor
    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    struct Factor;
    std::unique_ptr<Factor> factor_;
};

}  // namespace beltrami
