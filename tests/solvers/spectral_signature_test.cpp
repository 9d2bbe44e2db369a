#include "beltrami/solvers/spectral_signature.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "meshes.hpp"
#include "numerics.hpp"
#include "stored.hpp"

namespace beltrami {
namespace {

using testing::relative_difference;
using testing::Scratch;
using testing::stored_basis;

constexpr double pi = std::numbers::pi;

Vector vector_of(std::initializer_list<double> numbers) {
    return Eigen::Map<const Vector>(numbers.begin(), static_cast<Eigen::Index>(numbers.size()));
}

/// K and M of a mesh, dense and in the user's order, made without the library's operators or eigenfunctions.
struct DenseSpectrum {
    Eigen::MatrixXd K;
    Vector m;
    explicit DenseSpectrum(const Mesh& mesh)
        : K(testing::reference_stiffness(mesh)), m(Vector::Zero(mesh.vertex_count())) {
        for (Index c = 0; c < mesh.cell_count(); ++c) {
            const double measure = testing::reference_element(mesh, c).measure;
            for (int k = 0; k < mesh.cells().cols(); ++k)
                m[mesh.cells()(c, k)] += measure / static_cast<double>(mesh.cells().cols());
        }
    }
    [[nodiscard]] Eigen::MatrixXd generator() const { return m.cwiseInverse().asDiagonal() * K; }
};

Mesh small_mesh() {
    const Mesh sphere = shapes::icosphere(1);
    const Vector factor =
        Vector::Ones(sphere.vertex_count()) + 0.15 * testing::random_vector(sphere.vertex_count(), 7);
    return sphere.with_points(Points(factor.asDiagonal() * sphere.points()));
}

// Complete multiplets up to l = 5: the sum over m of Y_lm^2 is (2 l + 1) / (4 pi) everywhere (Unsoeld).
TEST(HeatKernelSignature, OfTheSphereIsTheSeriesInSecondOrder) {
    const Scratch scratch;
    const Vector times = vector_of({0.05, 0.2, 1.0});
    std::vector<double> widths;
    std::vector<double> errors;
    for (const int level : {2, 3, 4}) {
        const Mesh sphere = shapes::icosphere(level);
        const StoredBasis basis = stored_basis(scratch / std::to_string(level), sphere, 36);
        const Block found = heat_kernel_signature(basis, times);
        double worst = 0.0;
        for (Eigen::Index i = 0; i < times.size(); ++i) {
            double series = 0.0;
            for (int l = 0; l <= 5; ++l)
                series += (2 * l + 1) / (4.0 * pi) * std::exp(-l * (l + 1) * times[i]);
            worst = std::max(worst, (found.col(i).array() / series - 1.0).abs().maxCoeff());
        }
        widths.push_back(std::pow(0.5, level));
        errors.push_back(worst);
    }
    EXPECT_GE(testing::fitted_order(widths, errors), 1.8);
    EXPECT_LT(errors.back(), 0.01);
}

TEST(HeatKernelSignature, IntegratesToTheHeatTrace) {
    const Scratch scratch;
    const StoredBasis basis = stored_basis(scratch / "b", shapes::bumpy_sphere(800), 60);
    ASSERT_GT(basis.bands().size(), 1u);
    const Vector times = heat_signature_times(basis, 9);
    const double scale = 4.0 * std::log(10.0);
    EXPECT_NEAR(times[0] * basis.eigenvalues()[59], scale, 1e-9);
    EXPECT_NEAR(times[8] * basis.eigenvalues()[1], scale, 1e-9);
    EXPECT_NEAR(times[4] * times[4], times[0] * times[8], 1e-12 * times[8] * times[8]);
    const Block found = heat_kernel_signature(basis, times);
    const Block scaled = heat_kernel_signature(basis, times, true);
    for (Eigen::Index i = 0; i < times.size(); ++i) {
        const double trace = (-times[i] * clean_eigenvalues(basis)).array().exp().sum();
        EXPECT_NEAR(basis.mass().dot(found.col(i)), trace, 1e-9 * trace);
        EXPECT_NEAR(basis.mass().dot(scaled.col(i)), 1.0, 1e-9);
    }
}

TEST(SpectralSignature, OfSimilarShapes) {
    const Scratch scratch;
    const Mesh mesh = shapes::bumpy_sphere(500);
    const StoredBasis one = stored_basis(scratch / "one", mesh, 40);
    const StoredBasis moved = stored_basis(scratch / "moved", testing::rigidly_moved(mesh), 40);
    const StoredBasis large = stored_basis(scratch / "large", testing::scaled(mesh, 3.0), 40);
    const Vector times = heat_signature_times(one, 5);
    const Block hks = heat_kernel_signature(one, times);
    const Block wks = wave_kernel_signature(one, wave_signature_energies(one, 20));
    EXPECT_LT(relative_difference(heat_kernel_signature(moved, times), hks), 1e-8);
    EXPECT_LT(relative_difference(wave_kernel_signature(moved, wave_signature_energies(moved, 20)), wks),
              1e-8);
    EXPECT_LT(relative_difference(9.0 * heat_kernel_signature(large, 9.0 * times), hks), 1e-8);
    EXPECT_LT(
        relative_difference(9.0 * wave_kernel_signature(large, wave_signature_energies(large, 20)), wks),
        1e-8);
    // A distance in space of h (1/length) over lambda (1/length^2): a length.
    EXPECT_LT(relative_difference(biharmonic_distance(large, 7), 3.0 * biharmonic_distance(one, 7)), 1e-8);
    const double area = one.mass().sum();
    EXPECT_LT(relative_difference(shape_dna(large.eigenvalues(), 9.0 * area, 2),
                                  shape_dna(one.eigenvalues(), area, 2)),
              1e-8);
    EXPECT_GT(relative_difference(large.eigenvalues(), one.eigenvalues()), 0.5);
}

TEST(WaveKernelSignature, IsAMeanOfSquares) {
    const Scratch scratch;
    const StoredBasis basis = stored_basis(scratch / "b", shapes::bumpy_sphere(500), 40);
    const SignatureEnergies energies = wave_signature_energies(basis, 100);
    const double delta = energies.energies[1] - energies.energies[0];
    EXPECT_NEAR(energies.sigma, 7.0 * delta, 1e-12);
    EXPECT_NEAR(energies.energies[0], std::log(basis.eigenvalues()[1]) + 2.0 * energies.sigma, 1e-9);
    EXPECT_NEAR(energies.energies[99], std::log(basis.eigenvalues()[39]) - 2.0 * energies.sigma, 1e-9);
    const Block found = wave_kernel_signature(basis, energies);
    for (const Index e : {0, 50, 99}) {
        Vector sum = Vector::Zero(basis.vertex_count());
        double weights = 0.0;
        for (Index k = 1; k < 40; ++k) {
            const double away = energies.energies[e] - std::log(basis.eigenvalues()[k]);
            const double weight = std::exp(-away * away / (2.0 * energies.sigma * energies.sigma));
            sum += weight * basis.function(k).cwiseAbs2();
            weights += weight;
        }
        EXPECT_LT(relative_difference(found.col(e), sum / weights), 1e-12);
    }
    // Far from every eigenvalue the nearest one is left, not 0 / 0.
    const Block far = wave_kernel_signature(basis, {vector_of({1e4}), energies.sigma});
    EXPECT_LT(relative_difference(far.col(0), basis.function(39).cwiseAbs2()), 1e-12);
}

TEST(SpectralDistance, IsTheMatrixFormula) {
    const Scratch scratch;
    const Mesh mesh = small_mesh();
    const StoredBasis basis = stored_basis(scratch / "b", mesh, 0);
    const DenseSpectrum dense(mesh);
    const Index n = mesh.vertex_count();
    const Index y = 5;
    const Vector times = vector_of({0.02, 0.3});
    const Block diffusion = diffusion_distance(basis, y, times);
    // Coifman & Lafon: the distance in L2 of two heat kernels.
    for (Eigen::Index i = 0; i < times.size(); ++i) {
        const Eigen::MatrixXd kernel =
            Eigen::MatrixXd((-times[i] * dense.generator()).exp()) * dense.m.cwiseInverse().asDiagonal();
        Vector expected(n);
        for (Index x = 0; x < n; ++x)
            expected[x] = std::sqrt(dense.m.dot((kernel.row(x) - kernel.row(y)).cwiseAbs2().transpose()));
        EXPECT_LT(relative_difference(diffusion.col(i), expected), 1e-8);
    }
    // Green's functions: the pseudo-inverse of the symmetric operator, and of K (effective resistance).
    const Vector root = dense.m.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd symmetric = root.asDiagonal() * dense.K * root.asDiagonal();
    const Eigen::MatrixXd green =
        root.asDiagonal() * Eigen::MatrixXd(symmetric.completeOrthogonalDecomposition().pseudoInverse());
    const Eigen::MatrixXd inverse = dense.K.completeOrthogonalDecomposition().pseudoInverse();
    Vector biharmonic(n);
    Vector commute(n);
    for (Index x = 0; x < n; ++x) {
        biharmonic[x] = (green.row(x) - green.row(y)).norm();
        commute[x] = std::sqrt(inverse(x, x) + inverse(y, y) - 2.0 * inverse(x, y));
    }
    EXPECT_LT(relative_difference(biharmonic_distance(basis, y).col(0), biharmonic), 1e-8);
    EXPECT_LT(relative_difference(commute_time_distance(basis, y).col(0), commute), 1e-7);
    EXPECT_EQ(biharmonic_distance(basis, y)(y, 0), 0.0);
    EXPECT_EQ(diffusion(y, 1), 0.0);
}

TEST(SpectralPropagation, IsTheMatrixExponential) {
    const Scratch scratch;
    const Mesh mesh = small_mesh();
    const StoredBasis basis = stored_basis(scratch / "b", mesh, 0);
    const DenseSpectrum dense(mesh);
    const Index n = mesh.vertex_count();
    const Block u0 = testing::random_block(n, 3, 1);
    const Block v0 = testing::random_block(n, 3, 2);
    const SpectralPropagation state(basis, u0, v0);
    EXPECT_LT(state.left_out(), 1e-12);
    for (const double t : {0.0, 0.1, 0.7}) {
        const Eigen::MatrixXd heat = (-t * dense.generator()).exp();
        EXPECT_LT(relative_difference(state.heat(t), Block(heat * u0)), 1e-9);
        // u' = v, v' = -M^-1 K u
        Eigen::MatrixXd system = Eigen::MatrixXd::Zero(2 * n, 2 * n);
        system.topRightCorner(n, n).setIdentity();
        system.bottomLeftCorner(n, n) = -dense.generator();
        const Eigen::MatrixXd wave = (t * system).exp();
        Eigen::MatrixXd start(2 * n, 3);
        start << u0, v0;
        const Eigen::MatrixXd moved = wave * start;
        EXPECT_LT(relative_difference(state.wave(t), Block(moved.topRows(n))), 1e-8) << t;
        EXPECT_LT(relative_difference(state.wave_velocity(t), Block(moved.bottomRows(n))), 1e-8) << t;
    }
    const auto energy = [&](double t) {
        const Block u = state.wave(t);
        const Block v = state.wave_velocity(t);
        return (v.array() * basis.apply_mass(v).array()).sum() + (u.array() * (dense.K * u).array()).sum();
    };
    EXPECT_NEAR(energy(1234.5), energy(0.0), 1e-9 * energy(0.0));
}

TEST(SpectralPropagation, SaysWhatTheBasisLacks) {
    const Scratch scratch;
    const Mesh mesh = shapes::bumpy_sphere(500);
    const StoredBasis basis = stored_basis(scratch / "b", mesh, 40);
    Block spike = Block::Zero(mesh.vertex_count(), 1);
    spike(11, 0) = 1.0;
    EXPECT_GT(SpectralPropagation(basis, spike).left_out(), 0.5);
    EXPECT_LT(SpectralPropagation(basis, basis.function(13)).left_out(), 1e-8);
    EXPECT_GT(SpectralPropagation(basis, basis.function(13), spike).left_out(), 0.5);
    // A wave of one velocity all over goes on.
    const SpectralPropagation drift(basis, Block::Zero(500, 1), Block::Ones(500, 1));
    EXPECT_LT(relative_difference(drift.wave(3.0), Block::Constant(500, 1, 3.0)), 1e-8);
}

TEST(ReconstructionErrors, AreThoseOfTheReconstruction) {
    const Scratch scratch;
    const Mesh mesh = small_mesh();
    const StoredBasis basis = stored_basis(scratch / "b", mesh, 0);
    const Block field = mesh.points();
    const ReconstructionErrors found = reconstruction_errors(basis, field);
    const Block coefficients = forward_transform(basis, field);
    const auto norm = [&](const Block& x) {
        return std::sqrt((x.array() * basis.apply_mass(x).array()).sum());
    };
    EXPECT_NEAR(found.norm, norm(field), 1e-12);
    for (const Index k : {0, 3, 10, 40}) {
        const double error =
            norm(field - inverse_transform(basis, coefficients.topRows(k + 1))) / norm(field);
        EXPECT_NEAR(found.relative[k], error, 1e-10 * error + 1e-14) << k;
        EXPECT_NEAR(found.amplitudes[k], coefficients.row(k).norm(), 1e-14);
    }
    EXPECT_LT(found.relative[mesh.vertex_count() - 1], 1e-12) << "the basis is complete";
    EXPECT_GT(found.relative[mesh.vertex_count() - 2], 1e-6);
    EXPECT_EQ(reconstruction_errors(basis, Block::Zero(field.rows(), 1)).relative.maxCoeff(), 0.0);
}

TEST(Weyl, HasTheMiddleOfTheSpheresMultiplets) {
    for (const int l : {1, 5, 30})  // numbers l^2 to l^2 + 2 l have l (l + 1)
        EXPECT_NEAR(weyl_eigenvalue(l * l + l, 4.0 * pi, 2), l * (l + 1.0), 1e-9 * l * l);
    // A closed curve of length L: numbers 2 j - 1 and 2 j have (2 pi j / L)^2. A box of volume V: V lambda^1.5 / (6 pi^2).
    EXPECT_NEAR(weyl_eigenvalue(14.0, 3.0, 1), std::pow(2.0 * pi * 7.0 / 3.0, 2), 1e-9);
    EXPECT_NEAR(weyl_eigenvalue(5.0 * std::pow(40.0, 1.5) / (6.0 * pi * pi), 5.0, 3), 40.0, 1e-9);
}

TEST(SpectralSignature, OfAFloatBasisAndHeldVertices) {
    const Scratch scratch;
    const Mesh disk = shapes::disk(8);
    Constraints held;
    held.fix(0, 0.0);
    const StoredBasis exact = stored_basis(scratch / "double", disk, 20, held);
    const StoredBasis single = stored_basis(scratch / "float", disk, 20, held, NpyType::float32);
    const Vector times = vector_of({0.01, 0.1});
    const Block hks = heat_kernel_signature(exact, times);
    EXPECT_LT(relative_difference(heat_kernel_signature(single, times), hks), 1e-5);
    EXPECT_LT(relative_difference(diffusion_distance(single, 9, times), diffusion_distance(exact, 9, times)),
              1e-5);
    EXPECT_EQ(hks.row(0).maxCoeff(), 0.0);
    EXPECT_EQ(first_nonzero_eigenvalue(exact), exact.eigenvalues()[0]) << "no zero mode";
}

TEST(SpectralSignature, RefusesWhatMakesNoSense) {
    const Scratch scratch;
    const Mesh mesh = shapes::icosphere(1);
    const StoredBasis basis = stored_basis(scratch / "b", mesh, 12);
    const StoredBasis constant = stored_basis(scratch / "c", mesh, 1);
    EXPECT_THROW(heat_signature_times(basis, 0), InputError);
    EXPECT_THROW(heat_signature_times(constant, 5), InputError);
    EXPECT_THROW(wave_signature_energies(constant, 5), InputError);
    EXPECT_THROW(heat_kernel_signature(basis, vector_of({-1.0})), InputError);
    EXPECT_THROW(heat_kernel_signature(basis, vector_of({NAN})), InputError);
    EXPECT_THROW(wave_kernel_signature(basis, {vector_of({1.0}), 0.0}), InputError);
    EXPECT_THROW(sum_of_squares(basis, Block::Ones(11, 1)), InputError);
    EXPECT_THROW(spectral_distance(basis, 0, Block::Constant(12, 1, -1.0)), InputError);
    EXPECT_THROW(biharmonic_distance(basis, -1), InputError);
    EXPECT_THROW(biharmonic_distance(basis, 42), InputError);
    EXPECT_THROW(shape_dna(basis.eigenvalues(), 0.0, 2), InputError);
    const SpectralPropagation state(basis, Block::Ones(42, 1));
    EXPECT_THROW(state.heat(-1.0), InputError);
    EXPECT_THROW(state.wave(INFINITY), InputError);
    EXPECT_THROW(SpectralPropagation(basis, Block::Ones(41, 1)), InputError);
    EXPECT_THROW(SpectralPropagation(basis, Block::Ones(42, 1), Block::Ones(42, 2)), InputError);
}

}  // namespace
}  // namespace beltrami
