// sigma M + gamma_1 K + gamma_2 K D K + ... for a real or a complex K: what PdeOperator and HermitianPdeOperator share.
#pragma once

#include <Eigen/SparseCore>
#include <complex>
#include <vector>

#include "beltrami/operators/edge_operator.hpp"

namespace beltrami {

/// Room for intermediate fields, kept by callers that apply often.
template <class Scalar>
using PdeWorkspace = ChainWorkspace<Scalar>;

/// gamma without the zeros at its end. Throws InputError for a coefficient that is negative or not finite.
std::vector<double> checked_coefficients(double sigma, std::vector<double> gamma);

/// A view: what it refers to must outlive it.
template <class Scalar>
struct PdeTerms {
    const EdgeOperator<Scalar>& K;
    const Vector& M;
    const Vector& D;
    double sigma;
    const std::vector<double>& gamma;

    /// y = sigma M u + K (gamma_1 u + D K (gamma_2 u + ...)). Throws InputError for another number of rows.
    void apply(const BlockOf<Scalar>& u, BlockOf<Scalar>& y, PdeWorkspace<Scalar>& workspace) const;
    /// Exact for any number of terms; real, as K is self-adjoint.
    [[nodiscard]] Vector diagonal() const;
    /// Both triangles.
    [[nodiscard]] Eigen::SparseMatrix<Scalar> to_sparse() const;
};

extern template struct PdeTerms<double>;
extern template struct PdeTerms<std::complex<double>>;

}  // namespace beltrami
