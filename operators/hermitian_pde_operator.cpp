#include "beltrami/operators/hermitian_pde_operator.hpp"

#include <fmt/format.h>

#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

using Complex = HermitianPdeOperator::Complex;

void read_real(const Block& x, BlockOf<Complex>& z) {
    if (x.rows() % 2 != 0) {
        throw InputError(fmt::format("a real form of {} rows is none of complex numbers", x.rows()),
                         "give two rows a vertex, the real and the imaginary part");
    }
    z.resize(x.rows() / 2, x.cols());
    for (Eigen::Index v = 0; v < z.rows(); ++v) {
        for (Eigen::Index c = 0; c < z.cols(); ++c)
            z(v, c) = {x(2 * v, c), x(2 * v + 1, c)};
    }
}

void write_real(const BlockOf<Complex>& z, Block& x) {
    x.resize(2 * z.rows(), z.cols());
    for (Eigen::Index v = 0; v < z.rows(); ++v) {
        for (Eigen::Index c = 0; c < z.cols(); ++c) {
            x(2 * v, c) = z(v, c).real();
            x(2 * v + 1, c) = z(v, c).imag();
        }
    }
}

}  // namespace

HermitianPdeOperator::HermitianPdeOperator(EdgeOperator<Complex> K, Laplacian laplacian, double sigma,
                                           std::vector<double> gamma)
    : K_(std::make_shared<const EdgeOperator<Complex>>(std::move(K))),
      laplacian_(std::move(laplacian)),
      sigma_(sigma),
      gamma_(checked_coefficients(sigma, std::move(gamma))) {
    if (K_->rows() != laplacian_.vertex_count()) {
        throw InputError(fmt::format("an operator of {} rows got the mass of {} vertices", K_->rows(),
                                     laplacian_.vertex_count()),
                         "make both of one mesh");
    }
}

PdeTerms<Complex> HermitianPdeOperator::terms() const {
    return {*K_, laplacian_.mass(), laplacian_.inverse_mass(), sigma_, gamma_};
}

void HermitianPdeOperator::apply(const Block& u, Block& y, Workspace& workspace) const {
    read_real(u, workspace.u);
    terms().apply(workspace.u, workspace.y, workspace.terms);
    write_real(workspace.y, y);
}

void HermitianPdeOperator::apply(const Block& u, Block& y) const {
    Workspace workspace;
    apply(u, y, workspace);
}

Product HermitianPdeOperator::product() const {
    return [this, workspace = Workspace()](const Block& u, Block& y) mutable { apply(u, y, workspace); };
}

Vector HermitianPdeOperator::diagonal() const {
    const Vector of_vertices = terms().diagonal();
    Vector diagonal(rows());
    for (Index v = 0; v < K_->rows(); ++v)
        diagonal[2 * v] = diagonal[2 * v + 1] = of_vertices[v];
    return diagonal;
}

// a + b i becomes the block of rows (a, -b), (b, a).
Eigen::SparseMatrix<double> HermitianPdeOperator::to_sparse() const {
    const Eigen::SparseMatrix<Complex> A = terms().to_sparse();
    Eigen::SparseMatrix<double> real(rows(), rows());
    real.reserve(4 * A.nonZeros());
    for (Eigen::Index column = 0; column < A.cols(); ++column) {
        for (const bool imaginary : {false, true}) {
            const Eigen::Index real_column = 2 * column + (imaginary ? 1 : 0);
            real.startVec(real_column);
            for (Eigen::SparseMatrix<Complex>::InnerIterator entry(A, column); entry; ++entry) {
                // Of a diagonal entry the imaginary part is rounding.
                const bool on_diagonal = entry.row() == column;
                const double a = entry.value().real();
                const double b = on_diagonal ? 0.0 : entry.value().imag();
                real.insertBack(2 * entry.row(), real_column) = imaginary ? -b : a;
                real.insertBack(2 * entry.row() + 1, real_column) = imaginary ? a : b;
            }
        }
    }
    real.finalize();
    return real;
}

Block HermitianPdeOperator::to_real(const BlockOf<Complex>& z) {
    Block x;
    write_real(z, x);
    return x;
}

BlockOf<Complex> HermitianPdeOperator::to_complex(const Block& x) {
    BlockOf<Complex> z;
    read_real(x, z);
    return z;
}

}  // namespace beltrami
