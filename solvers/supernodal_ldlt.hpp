// L D L^T of K - shift M without pivoting, for many solves with few columns at once.
//
//     SupernodalLdlt pencil(problem);                  // one ordering and analysis for all shifts
//     pencil.factor(12.5);                             // P (K - 12.5 M) P^T = L D L^T, L unit lower, D diagonal
//     pencil.negative_pivots();                        // so many eigenvalues lie below 12.5 (Sylvester's law of inertia)
//     pencil.solve(columns);                           // columns <- (K - 12.5 M)^-1 columns
//     pencil.backward_error();                         // how well the last factor solves
//
// METIS's or AMD's ordering and CHOLMOD's relaxed supernodes (Ng & Peyton 1993; Davis 2006, Direct Methods for Sparse Linear
// Systems); a multifrontal factorization (Duff & Reid 1983) and blocked sweeps with kernels of our own, as dense blocks of
// a surface's factor are far below the size at which a BLAS pays. Without pivoting L may grow where a leading block of
// K - shift M is nearly singular; at an interior shift of a semidefinite K few pivots are negative and this is rare.
// factor() measures it and throws rather than keep a factor that is not backward stable.
//
// Threads of OpenMP share subtrees of the elimination tree and the large fronts above them. Results do not depend on the
// number of threads.
#pragma once

#include <memory>
#include <string>

#include "beltrami/solvers/eigenproblem.hpp"

namespace beltrami {

struct SupernodalLdltOptions {
    /// Of the inner loops: "avx512", "avx2" or "any", which every machine can run. Empty: the best this one can. Results
    /// differ by rounding.
    std::string instructions = {};
    /// AMD's ordering (Amestoy, Davis & Duff 1996) instead of METIS's: found in a quarter of the time, for a factor with
    /// about a third more entries. For a few hundred columns.
    bool few_solves = false;
};

class SupernodalLdlt {
  public:
    /// Orders and analyses the pattern of K, which holds that of M, once for all shifts; keeps a copy of their numbers.
    /// Throws SolveError where memory does not suffice and InputError for instructions that this machine has not.
    explicit SupernodalLdlt(const Eigenproblem& problem, const SupernodalLdltOptions& options = {});
    SupernodalLdlt(SupernodalLdlt&&) noexcept;
    SupernodalLdlt& operator=(SupernodalLdlt&&) noexcept;
    ~SupernodalLdlt();

    /// Factors K - shift M in place of an earlier factor, on all threads. Throws SolveError for a pivot that is zero or not
    /// finite, for a backward_error() above 1e-8, and where memory does not suffice; there is no factor then.
    void factor(double shift);

    [[nodiscard]] Index rows() const;
    [[nodiscard]] double shift() const;
    /// So many eigenvalues of K h = lambda M h are less than shift().
    [[nodiscard]] Index negative_pivots() const;
    /// |A x - b| / (|A| |x| + |b|) of a solve with A = K - shift() M for a random b, measured by factor(); the largest
    /// entry of a vector, and the largest sum of the absolute values of a row of A. 1e-16 is perfect.
    [[nodiscard]] double backward_error() const;

    /// columns <- (K - shift M)^-1 columns, rows() x k, k >= 0. One thread of callers at a time, as the room it works in
    /// stays with the object. Throws InputError for another number of rows and where there is no factor.
    void solve(Columns& columns) const;
    /// The same for columns whose values of a row lie together, which is faster.
    void solve(Eigen::Ref<Block> block) const;

    /// Entries of L below its diagonal and of D, with the zeros of merged supernodes.
    [[nodiscard]] double nonzeros() const;
    /// Floating-point operations of a factorization.
    [[nodiscard]] double flops() const;
    /// What is kept; factor() takes working_bytes() more while it works.
    [[nodiscard]] std::size_t memory_bytes() const;
    [[nodiscard]] std::size_t working_bytes() const;
    [[nodiscard]] int factorizations() const;
    [[nodiscard]] long solved_columns() const;
    /// Those in use.
    [[nodiscard]] std::string instructions() const;

  private:
    struct Factor;
    std::unique_ptr<Factor> factor_;
};

}  // namespace beltrami
