// sigma M + gamma_1 K + gamma_2 K D K + ... for a complex Hermitian K, such as the connection Laplacian, in its real
// form: a real symmetric operator of twice the size, so that every solver serves it unchanged.
//
//     HermitianPdeOperator A(connection_laplacian(mesh, laplacian, frames), laplacian, 0.0, {1.0, 0.1});
//     LinearSolver solver(A, options);
//
// Rows 2 v and 2 v + 1 are the real and the imaginary part at vertex v. Positive semidefinite when K is and sigma and
// all gamma are not negative.
#pragma once

#include <complex>
#include <memory>
#include <vector>

#include "beltrami/operators/laplacian.hpp"
#include "beltrami/operators/linear_operator.hpp"
#include "beltrami/operators/pde_terms.hpp"

namespace beltrami {

class HermitianPdeOperator : public LinearOperator {
  public:
    using Complex = std::complex<double>;

    /// M and D are the laplacian's. Throws InputError for K of another number of rows and for a coefficient that is
    /// negative or not finite.
    HermitianPdeOperator(EdgeOperator<Complex> K, Laplacian laplacian, double sigma,
                         std::vector<double> gamma);

    [[nodiscard]] Index rows() const override { return 2 * K_->rows(); }
    [[nodiscard]] int order() const override { return static_cast<int>(gamma_.size()); }
    [[nodiscard]] const EdgeGraph& graph() const override { return K_->graph(); }
    [[nodiscard]] double total_mass() const override { return 2.0 * sigma_ * laplacian_.mass().sum(); }

    void apply(const Block& u, Block& y) const override;
    [[nodiscard]] Product product() const override;
    [[nodiscard]] Vector diagonal() const override;
    [[nodiscard]] Eigen::SparseMatrix<double> to_sparse() const override;

    /// n x k complex numbers as 2 n x k real ones, and back. The second throws InputError for an odd number of rows.
    static Block to_real(const BlockOf<Complex>& z);
    static BlockOf<Complex> to_complex(const Block& x);

  private:
    struct Workspace {
        BlockOf<Complex> u;
        BlockOf<Complex> y;
        PdeWorkspace<Complex> terms;
    };
    [[nodiscard]] PdeTerms<Complex> terms() const;
    void apply(const Block& u, Block& y, Workspace& workspace) const;

    std::shared_ptr<const EdgeOperator<Complex>> K_;
    Laplacian laplacian_;
    double sigma_;
    std::vector<double> gamma_;
};

}  // namespace beltrami
