#include "beltrami/operators/pde_operator.hpp"

#include <utility>

namespace beltrami {

PdeOperator::PdeOperator(Laplacian laplacian, double sigma, std::vector<double> gamma)
    : laplacian_(std::move(laplacian)),
      sigma_(sigma),
      gamma_(checked_coefficients(sigma, std::move(gamma))) {}

PdeTerms<double> PdeOperator::terms() const {
    return {laplacian_.stiffness(), laplacian_.mass(), laplacian_.inverse_mass(), sigma_, gamma_};
}

void PdeOperator::apply(const Block& u, Block& y, Workspace& workspace) const {
    terms().apply(u, y, workspace);
}

void PdeOperator::apply(const Block& u, Block& y) const {
    Workspace workspace;
    apply(u, y, workspace);
}

Product PdeOperator::product() const {
    return [this, workspace = Workspace()](const Block& u, Block& y) mutable { apply(u, y, workspace); };
}

Vector PdeOperator::diagonal() const {
    return terms().diagonal();
}

Eigen::SparseMatrix<double> PdeOperator::to_sparse() const {
    return terms().to_sparse();
}

}  // namespace beltrami
