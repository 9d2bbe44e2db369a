// A factor of K - shift M that is kept, with its inertia: what a spectrum is found and counted with.
//
//     ShiftInvert pencil(problem);                     // one analysis for all shifts
//     pencil.factor(12.5);
//     pencil.eigenvalues_below();                      // exactly how many lie below 12.5 (Sylvester's law of inertia)
//     pencil.solve(columns);                           // columns <- (K - 12.5 M)^-1 columns
//
// SupernodalLdlt does it, which is several times faster; PivotedLdlt does where that has no stable factor, and where the
// factor does not fit in the memory that is allowed.
#pragma once

#include <filesystem>
#include <memory>

#include "beltrami/solvers/eigenproblem.hpp"

namespace beltrami {

class SupernodalLdlt;
class PivotedLdlt;

struct ShiftInvertOptions {
    /// A few hundred columns at most: an ordering that is found quickly is worth more than one that fills less.
    bool few_solves = false;
    /// Bytes that a factor may take in memory; where it would take more it is kept on disk. 0: no limit.
    double memory_limit = 0.0;
    /// Where a factor on disk lies while it is used.
    std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

class ShiftInvert {
  public:
    /// Orders and analyses; problem must outlive this. Throws InputError where even a factor on disk needs more memory
    /// than is allowed, SolveError where there is not enough.
    explicit ShiftInvert(const Eigenproblem& problem, const ShiftInvertOptions& options = {});
    ShiftInvert(const ShiftInvert&) = delete;
    ShiftInvert& operator=(const ShiftInvert&) = delete;
    ~ShiftInvert();

    /// Factors K - shift M in place of an earlier factor. Throws SolveError where the shift is an eigenvalue to the
    /// last digits, and where memory or disk does not suffice.
    void factor(double shift);

    [[nodiscard]] double shift() const { return shift_; }
    /// So many eigenvalues of K h = lambda M h are less than shift().
    [[nodiscard]] Index eigenvalues_below() const;

    /// columns <- (K - shift M)^-1 columns, rows() x k, all k together. One thread at a time. Throws InputError for
    /// another number of rows and where there is no factor.
    void solve(Columns& columns) const;
    /// The same for columns whose values of a row lie together, which is faster.
    void solve(Eigen::Ref<Block> block) const;

    [[nodiscard]] int factorizations() const;
    [[nodiscard]] long solved_columns() const;
    /// What a factor takes: in memory while it is made, and on disk where it is kept there.
    [[nodiscard]] std::size_t memory_bytes() const;
    [[nodiscard]] std::size_t disk_bytes() const;

  private:
    const Eigenproblem& problem_;
    double shift_ = 0.0;
    bool pivoted_now_ = false;
    std::unique_ptr<SupernodalLdlt> supernodal_;  // null where it does not fit
    std::unique_ptr<PivotedLdlt> pivoted_;        // null until it is needed
};

}  // namespace beltrami
