// A factor of K - shift M that is kept, with its inertia: what a spectrum is found and counted with.
//
//     ShiftInvert pencil(problem);                     // one analysis for all shifts
//     pencil.factor(12.5);                             // L D L^T with pivoting: K - 12.5 M is indefinite
//     pencil.eigenvalues_below();                      // exactly how many lie below 12.5 (Sylvester's law of inertia)
//     pencil.solve(columns);                           // columns <- (K - 12.5 M)^-1 columns
//
// MUMPS behind a small door, with METIS's ordering; its out-of-core mode keeps the factor on disk.
#pragma once

#include <filesystem>
#include <memory>

#include "beltrami/solvers/eigenproblem.hpp"

namespace beltrami {

struct ShiftInvertOptions {
    /// Bytes that a factor may take in memory; where it would take more it is kept on disk. 0: no limit.
    double memory_limit = 0.0;
    /// Where a factor on disk lies while it is used.
    std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

class ShiftInvert {
  public:
    /// Orders and analyses. Throws SolveError where that fails for lack of memory.
    explicit ShiftInvert(const Eigenproblem& problem, const ShiftInvertOptions& options = {});
    ShiftInvert(const ShiftInvert&) = delete;
    ShiftInvert& operator=(const ShiftInvert&) = delete;
    ~ShiftInvert();

    /// Factors K - shift M in place of an earlier factor. Throws SolveError where the shift is an eigenvalue to the
    /// last digits, and where memory or disk does not suffice.
    void factor(double shift);

    [[nodiscard]] double shift() const;
    /// The number of negative pivots: so many eigenvalues of K h = lambda M h are less than shift().
    [[nodiscard]] Index eigenvalues_below() const;

    /// columns <- (K - shift M)^-1 columns, rows() x k, all k together. One thread at a time.
    void solve(Columns& columns) const;

    [[nodiscard]] int factorizations() const;
    [[nodiscard]] long solved_columns() const;
    [[nodiscard]] bool on_disk() const;
    /// What a factor takes, by the analysis: in memory and, when on_disk(), on disk.
    [[nodiscard]] std::size_t memory_bytes() const;
    [[nodiscard]] std::size_t disk_bytes() const;

  private:
    struct Factor;
    std::unique_ptr<Factor> factor_;
};

}  // namespace beltrami
