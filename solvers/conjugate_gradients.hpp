// Preconditioned conjugate gradients over any symmetric operator, k columns at once, on the free vertices.
//
//     CgOptions options{.tolerance = 1e-10};
//     CgResult result = conjugate_gradients(apply, jacobi(diagonal, held), held, b, x, options);
//
// Held vertices are masked: their rows of x are read and never changed, and nothing is rebuilt when they change. Each
// column runs its own iteration (step lengths of its own, stopped when it has converged) over shared products.
// Source: Hestenes & Stiefel 1952; the masking is section 4.1 of Kim & Rossignac.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "beltrami/framework/progress.hpp"
#include "beltrami/framework/types.hpp"
#include "beltrami/operators/linear_operator.hpp"
#include "beltrami/solvers/linear_summary.hpp"

namespace beltrami {

struct CgOptions {
    double tolerance = 1e-10;                           ///< in `norm`
    StoppingNorm norm = StoppingNorm::scaled_residual;  ///< refinement: with a preconditioner only
    int max_iterations = 50000;
    /// z = B r, B symmetric and positive definite on the free rows, z = 0 on the held: such as Multigrid's. Empty: the
    /// diagonal. It may be linear to single precision only, as directions are chosen flexibly (Polak & Ribiere 1969).
    Product preconditioner = {};
    const Progress* progress = nullptr;
};

struct CgResult {
    StopReason reason = StopReason::iteration_limit;
    int iterations = 0;  ///< of the column that took the most
    long products = 0;
    double error = 0.0;  ///< in the norm asked for, residuals computed afresh, the worst column
    double relative_residual =
        0.0;                       ///< scaled by `inverse_diagonal`, from a fresh residual, the worst column
    std::size_t memory_bytes = 0;  ///< of the work fields
    std::vector<double> history;   ///< as LinearSummary::history
};

/// Solves A x = b for the rows that are not held. b: n x k. x: n x k, on entry the start (held rows at their values).
/// inverse_diagonal: n, positive, what scaled residuals are scaled with and the Jacobi preconditioner. Throws Cancelled; never throws for a solve that fails:
/// see `reason`, and x then is the last iterate.
CgResult conjugate_gradients(const Product& apply, const Vector& inverse_diagonal,
                             std::span<const Index> held, const Block& b, Block& x,
                             const CgOptions& options = {});

/// r = b - A x with the held rows at zero.
void masked_residual(const Product& apply, std::span<const Index> held, const Block& b, const Block& x,
                     Block& r);

/// x with its free rows at zero, and the residual there: the load that errors are measured against. Nothing where the
/// free rows of x are zero already, and then the residual of x is the load.
struct ZeroStart {
    Block x;
    Block r;
};
std::optional<ZeroStart> zero_start(const Product& apply, std::span<const Index> held, const Block& b,
                                    const Block& x);

/// The square root of the sum of weight_i r_ic^2 over i, for each column c.
Vector column_norms(const Block& r, const Vector& weight);

/// The largest norm / load over the columns that have a load; infinity for NaN.
double worst_ratio(const Vector& norms, const Vector& loads);

}  // namespace beltrami
