// sigma M + gamma_1 K + gamma_2 K D K + ... + gamma_m K (D K)^(m-1), never assembled.
//
//     PdeOperator A(laplacian, 1.0, {0.01});              // M + t K: a step of heat
//     PdeOperator B(laplacian, 0.0, {1.0, 0.1});          // Laplacian and bi-Laplacian mixed
//     B.apply(u, y);                                      // two products with K
//
// The stiffness K~ of eq. (13) of Kim & Rossignac is sigma = 0. Symmetric; positive semidefinite when sigma and all
// gamma are not negative.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "beltrami/operators/laplacian.hpp"
#include "beltrami/operators/linear_operator.hpp"
#include "beltrami/operators/pde_terms.hpp"

namespace beltrami {

class PdeOperator : public LinearOperator {
  public:
    /// gamma[i - 1] multiplies K (D K)^(i - 1). Throws InputError for a coefficient that is negative or not finite.
    PdeOperator(Laplacian laplacian, double sigma, std::vector<double> gamma);

    [[nodiscard]] const Laplacian& laplacian() const { return laplacian_; }
    [[nodiscard]] double sigma() const { return sigma_; }
    [[nodiscard]] const std::vector<double>& gamma() const { return gamma_; }
    [[nodiscard]] Index rows() const override { return laplacian_.vertex_count(); }
    /// The number of terms with K up to the last whose coefficient is not zero: the products with K in one apply().
    [[nodiscard]] int order() const override { return static_cast<int>(gamma_.size()); }
    [[nodiscard]] const EdgeGraph& graph() const override { return laplacian_.graph(); }
    [[nodiscard]] double total_mass() const override { return sigma_ * laplacian_.mass().sum(); }

    /// Room for intermediate fields, kept by callers that apply often.
    using Workspace = PdeWorkspace<double>;

    /// y = A u for an n x k block, in the working order, as sigma M u + K (gamma_1 u + D K (gamma_2 u + ...)).
    void apply(const Block& u, Block& y, Workspace& workspace) const;
    void apply(const Block& u, Block& y) const override;
    [[nodiscard]] Product product() const override;

    /// The diagonal of A, exact for any number of terms: n.
    [[nodiscard]] Vector diagonal() const override;

    /// A as an n x n matrix, both triangles, for direct solvers and tests.
    [[nodiscard]] Eigen::SparseMatrix<double> to_sparse() const override;

  private:
    [[nodiscard]] PdeTerms<double> terms() const;

    Laplacian laplacian_;
    double sigma_;
    std::vector<double> gamma_;
};

}  // namespace beltrami
