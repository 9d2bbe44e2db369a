// Block Lanczos for the pairs of K h = lambda M h nearest to a shift.
//
//     BlockLanczos lanczos(problem, pencil, locked, {.capacity = 240});   // pencil: factored at the shift
//     while (lanczos.extend()) {}
//     const RitzValues ritz = lanczos.ritz();                // ascending, each with its residual
//     const Columns h = lanczos.vectors(chosen);             // M-orthonormal to rounding, once converged
//
// The Krylov space of (K - shift M)^-1 M in the inner product of M (Ericsson & Ruhe 1980; Grimes, Lewis & Simon 1994) in
// blocks of eight, with full orthogonalization. Vectors are purified by one more application of the operator, which
// the next block of the space gives for free; what is left of the residual is then known without a product:
// |K h - lambda M h| = |B s| / theta^2 in the norm of M^-1, theta = 1 / (lambda - shift), where B s is the part of the
// Ritz vector that the operator carries out of the space.
#pragma once

#include <cstdint>
#include <vector>

#include "beltrami/solvers/panels.hpp"
#include "beltrami/solvers/shift_invert.hpp"

namespace beltrami {

struct BlockLanczosOptions {
    /// The largest dimension of the space; rounded up to whole blocks.
    Index capacity = 240;
    /// Of the random start.
    std::uint32_t seed = 1;
};

/// Of the same length, by ascending value.
struct RitzValues {
    Vector values;              ///< lambda
    Vector residuals;           ///< |K h - lambda M h| in the norm of M^-1, for h of M-norm 1
    std::vector<Index> vector;  ///< the number of each for vectors()
};

class BlockLanczos {
  public:
    /// locked: rows x l, M-orthonormal; the space stays M-orthogonal to them. Problem and pencil must outlive this.
    /// `room`: of an earlier space, release()d.
    BlockLanczos(const Eigenproblem& problem, const ShiftInvert& pencil, const Columns& locked,
                 const BlockLanczosOptions& options, LargeArray room = {});

    /// Adds a block. False, with nothing added, where the space is invariant (its Ritz pairs are exact then) or full.
    bool extend();

    [[nodiscard]] Index dimension() const { return panel_width * (blocks_ - locked_); }

    /// The Ritz values of the space.
    [[nodiscard]] RitzValues ritz();

    /// Purified Ritz vectors of the last ritz(), rows x chosen.size().
    [[nodiscard]] Columns vectors(const std::vector<Index>& chosen) const;

    [[nodiscard]] std::size_t memory_bytes() const { return space_.memory_bytes(); }
    /// Ends the space; its room is already backed by memory, which takes the system longer than a sweep over it.
    [[nodiscard]] LargeArray release() { return space_.release(); }

  private:
    PanelProduct multiply_mass(const double* x, double* y) const;  // y = M x, returns x^T M x
    PanelProduct orthonormalize(double* W, PanelProduct* last);

    const Eigenproblem& problem_;
    const ShiftInvert& pencil_;
    Index locked_;       // panels
    Index blocks_;       // panels that are locked or in the space
    Panels space_;       // the locked vectors, the space, the block that comes next, and room for M W
    Columns projected_;  // T: block tridiagonal
    PanelProduct out_;   // B: the next block's part of the operator times the last
    bool invariant_ = false;
    Vector theta_;
    Columns coefficients_;  // of the Ritz vectors
};

}  // namespace beltrami
