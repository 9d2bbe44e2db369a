// Dense products of tall blocks (many rows, few columns) and dense symmetric eigenproblems, by BLAS and LAPACK.
//
//     Columns C = transposed_product(X, Y);     // X^T Y
//     add_product(-1.0, X, C, Y);               // Y -= X C
//
// Rows are cut in chunks that OpenMP's threads take, each with one BLAS thread: OpenBLAS's own threads gain nothing on
// such shapes. The sums do not depend on the number of threads.
#pragma once

#include <cstddef>
#include <cstdint>

#include "beltrami/framework/types.hpp"
#include "beltrami/solvers/eigenproblem.hpp"

namespace beltrami {

using TallColumns = Eigen::Ref<const Columns, 0, Eigen::OuterStride<>>;

/// X^T Y: X is n x a, Y is n x b.
Columns transposed_product(const TallColumns& X, const TallColumns& Y);
/// X^T diag(weights) Y, without room for a weighted Y.
Columns transposed_product(const TallColumns& X, const Vector& weights, const TallColumns& Y);

/// X^T diag(weights) X, at half the price.
Columns gram_matrix(const TallColumns& X, const Vector& weights);

/// Y += scale X C: X is n x a, C is a x b, Y is n x b.
void add_product(double scale, const TallColumns& X, const Eigen::Ref<const Columns>& C,
                 Eigen::Ref<Columns, 0, Eigen::OuterStride<>> Y);

/// X <- X C, without a second X: X is n x a, C is a x b with b <= a.
void transform(Columns& X, const Columns& C);

/// Even numbers in [-1, 1]: the same on every machine, which the standard's distributions are not.
void fill_random(double* values, std::size_t size, std::uint32_t seed);

/// A = V diag(values) V^T of a symmetric A, values ascending; the columns of `vectors` are V.
struct SymmetricEigen {
    Vector values;
    Columns vectors;
};
/// Divide and conquer (LAPACK's dsyevd), on all cores. Throws SolveError where it does not converge.
SymmetricEigen symmetric_eigen(Columns A);

}  // namespace beltrami
