// L D L^T of K - shift M with pivoting, in memory or on disk: MUMPS behind a small door, with METIS's ordering.
//
//     PivotedLdlt pencil(problem, {.on_disk = true});
//     pencil.factor(12.5);
//     pencil.negative_pivots();                        // so many eigenvalues lie below 12.5 (Sylvester's law of inertia)
//     pencil.solve(columns);                           // columns <- (K - 12.5 M)^-1 columns
#pragma once

#include <filesystem>
#include <memory>

#include "beltrami/solvers/eigenproblem.hpp"

namespace beltrami {

struct PivotedLdltOptions {
    /// Keep the factor on disk, and of it in memory only what is worked on.
    bool on_disk = false;
    /// Where it lies while it is used.
    std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

class PivotedLdlt {
  public:
    /// Orders and analyses. Throws SolveError where memory does not suffice.
    explicit PivotedLdlt(const Eigenproblem& problem, const PivotedLdltOptions& options = {});
    PivotedLdlt(const PivotedLdlt&) = delete;
    PivotedLdlt& operator=(const PivotedLdlt&) = delete;
    ~PivotedLdlt();

    /// Factors K - shift M in place of an earlier factor. Throws SolveError where the shift is an eigenvalue to the
    /// last digits, and where memory or disk does not suffice.
    void factor(double shift);

    /// So many eigenvalues of K h = lambda M h are less than shift().
    [[nodiscard]] Index negative_pivots() const;

    /// columns <- (K - shift M)^-1 columns, rows() x k, all k together. One thread at a time.
    void solve(Columns& columns) const;

    [[nodiscard]] int factorizations() const;
    [[nodiscard]] long solved_columns() const;
    /// What a factor takes, by the analysis: in memory, and on disk where it is kept there.
    [[nodiscard]] std::size_t memory_bytes() const;
    [[nodiscard]] std::size_t disk_bytes() const;

  private:
    struct Factor;
    std::unique_ptr<Factor> factor_;
};

}  // namespace beltrami
