// A sparse Cholesky factor that is kept, of a matrix whose pattern, and perhaps whose held rows, outlive its numbers.
//
//     Cholesky factor(A);                              // A symmetric positive definite: the upper triangle is read
//     factor.solve(b, x);                              // as often as wanted, all columns together
//
//     const auto analysis = std::make_shared<const CholeskyAnalysis>(A);   // once for a mesh
//     Cholesky held_factor(A, analysis, held);         // rows and columns of `held` as those of the identity
//     held_factor.change_held(A, others);              // few have changed: no new factor
//     held_factor.refactor(B, others);                 // another matrix on the pattern, in the same storage
//
// The factor is L D L^T with D > 0, by the analysis, the multifrontal factorization and the blocked sweeps of
// SupernodalLdlt: its sweeps take a third of the time of CHOLMOD's for many columns, and a Block goes through them as it
// lies. All threads of OpenMP work; results do not depend on their number.
#pragma once

#include <Eigen/SparseCore>
#include <atomic>
#include <memory>
#include <span>

#include "beltrami/framework/types.hpp"

namespace beltrami {

namespace supernodal {
struct Symbolic;
}

enum class CholeskyOrdering {
    amd,   ///< quick to find: for a single factor
    metis  ///< less fill: for a factor that is used many times
};

/// The ordering and the symbolic factor of an n x n pattern: immutable, for any number of matrices, held rows and threads.
class CholeskyAnalysis {
  public:
    using Ordering = CholeskyOrdering;

    /// Of the upper triangle of the pattern; its numbers do not matter, and entries that are zero belong to it. A diagonal
    /// entry that is missing does too. Throws InputError where it is not square, SolveError where memory does not suffice.
    explicit CholeskyAnalysis(const Eigen::SparseMatrix<double>& pattern,
                              Ordering ordering = Ordering::metis);

    [[nodiscard]] Index rows() const;
    [[nodiscard]] double nonzeros() const;  ///< of the factor, with the zeros of merged supernodes
    [[nodiscard]] double flops() const;     ///< of a factorization
    /// What is kept here; what a factor keeps; what a factorization takes more while it works.
    [[nodiscard]] std::size_t memory_bytes() const;
    [[nodiscard]] std::size_t factor_bytes() const;
    [[nodiscard]] std::size_t working_bytes() const;

    /// How many were made in this process: for tests that count them.
    static long builds() { return builds_.load(); }

  private:
    friend class Cholesky;
    std::shared_ptr<const supernodal::Symbolic> symbolic_;
    static inline std::atomic<long> builds_ = 0;
};

class Cholesky {
  public:
    using Ordering = CholeskyOrdering;

    /// Analyses and factors. Throws InputError where A is not square or not finite, SolveError where it is not positive
    /// definite or memory does not suffice.
    explicit Cholesky(const Eigen::SparseMatrix<double>& A, Ordering ordering = Ordering::amd);
    /// Factors A with the rows and columns in `held` replaced by those of the identity, which A_ff and its solutions do not
    /// notice: the pattern stays. A may lack entries of the analysed pattern. Throws InputError for an entry outside the
    /// pattern, another size, a number that is not finite and held rows out of range; SolveError as above.
    Cholesky(const Eigen::SparseMatrix<double>& A, std::shared_ptr<const CholeskyAnalysis> analysis,
             std::span<const Index> held = {});
    Cholesky(Cholesky&&) noexcept;
    Cholesky& operator=(Cholesky&&) noexcept;
    Cholesky(const Cholesky&) = delete;
    Cholesky& operator=(const Cholesky&) = delete;
    ~Cholesky();

    /// Another matrix and other held rows in place of the earlier ones, in the same storage. Throws as the constructor; an
    /// InputError changes nothing, after a SolveError there is no factor.
    void refactor(const Eigen::SparseMatrix<double>& A, std::span<const Index> held = {});

    /// Other held rows of the same A, whose numbers are those of the last factorization. Where at most most_corrected() rows
    /// differ from it, at most 20 of them since the last change, there is no new factor: a dense system of that size corrects
    /// the solves (see "Cholesky" in docs/solvers.md), for a solve of one column for each row that is new, and that many
    /// numbers for each row of A.
    /// Otherwise, and where that system is close to singular, as refactor(). Throws like it.
    void change_held(const Eigen::SparseMatrix<double>& A, std::span<const Index> held);

    /// x = A^-1 b, n x k; held rows of x are those of b and take no part. b and x may be the same. One thread of callers at
    /// a time, as the room it works in stays here. Throws InputError for a wrong number of rows and where there is no factor.
    void solve(const Block& b, Block& x) const;

    [[nodiscard]] Index rows() const;
    [[nodiscard]] double nonzeros() const;  ///< of the factor, with the zeros of merged supernodes
    /// Of the factor and the room to work in, the shared analysis included.
    [[nodiscard]] std::size_t memory_bytes() const;
    [[nodiscard]] const std::shared_ptr<const CholeskyAnalysis>& analysis() const;
    [[nodiscard]] int factorizations() const;
    /// Rows that are held now and were not in the last factorization, or the other way round.
    [[nodiscard]] Index corrected() const;
    /// Half as many as a row of the factor has entries, but 20 at least: solves with the correction take up to half as long
    /// again as with a new factor.
    [[nodiscard]] Index most_corrected() const;

  private:
    struct Factor;
    std::unique_ptr<Factor> factor_;
};

}  // namespace beltrami
