// The eigenvalues of K h = lambda M h on the sphere approach l (l + 1), 2 l + 1 times each, in second order.
// Spectra finds them: nothing of our own solvers takes part.
#include <gtest/gtest.h>

#include <Spectra/MatOp/SparseSymShiftSolve.h>
#include <Spectra/SymEigsShiftSolver.h>

#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

constexpr int wanted = 16;  // l = 0 to 3

Vector smallest_eigenvalues(const Mesh& mesh) {
    const Laplacian laplacian(mesh);
    const Vector scale = laplacian.mass().cwiseSqrt().cwiseInverse();
    const Eigen::SparseMatrix<double> A =
        scale.asDiagonal() * laplacian.stiffness().to_sparse() * scale.asDiagonal();
    Spectra::SparseSymShiftSolve<double> op(A);
    Spectra::SymEigsShiftSolver<Spectra::SparseSymShiftSolve<double>> solver(op, wanted, 40, -0.5);
    solver.init();
    solver.compute(Spectra::SortRule::LargestMagn, 1000, 1e-12, Spectra::SortRule::SmallestAlge);
    EXPECT_EQ(solver.info(), Spectra::CompInfo::Successful);
    return solver.eigenvalues();
}

TEST(Spectrum, OfTheSphere) {
    std::vector<double> widths;
    std::vector<double> errors;
    for (const int level : {1, 2, 3, 4}) {
        const Vector eigenvalues = smallest_eigenvalues(shapes::icosphere(level));
        EXPECT_NEAR(eigenvalues[0], 0.0, 1e-10);
        double worst = 0.0;
        for (int l = 1, i = 1; l <= 3; ++l) {
            for (int m = 0; m < 2 * l + 1; ++m, ++i) {
                worst = std::max(worst, std::abs(eigenvalues[i] / (l * (l + 1.0)) - 1.0));
            }
        }
        widths.push_back(std::pow(0.5, level));
        errors.push_back(worst);
    }
    const double order = testing::fitted_order(widths, errors);
    EXPECT_GE(order, 1.9);
    EXPECT_LE(order, 2.3);
    EXPECT_LT(errors.back(), 0.01);
    RecordProperty("order", std::to_string(order));
}

}  // namespace
}  // namespace beltrami
