#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/solvers/hierarchy.hpp"
#include "beltrami/solvers/spectrum.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using SharedHierarchy = std::shared_ptr<const Hierarchy>;

SharedHierarchy hierarchy_of(const Mesh& mesh, const Laplacian& laplacian, Index coarsest = 30) {
    return std::make_shared<const Hierarchy>(laplacian.graph(), laplacian.order().to_working(mesh).points(),
                                             HierarchyOptions{.coarsest = coarsest});
}

Spectrum hierarchical(const Eigenproblem& problem, const SharedHierarchy& hierarchy,
                      SpectrumOptions options) {
    options.method = SpectrumMethod::hierarchical;
    options.hierarchy = hierarchy;
    return spectrum(problem, options);
}

// Residuals computed here, not taken from the summary.
double largest_residual(const Eigenproblem& problem, const Spectrum& found, double zero_scale) {
    const Columns Mh = problem.mass_matrix() * found.vectors;
    const Columns r = problem.stiffness() * found.vectors - Mh * found.values.asDiagonal();
    double largest = 0.0;
    for (Index i = 0; i < r.cols(); ++i)
        largest = std::max(
            largest, r.col(i).norm() / (std::max(std::abs(found.values[i]), zero_scale) * Mh.col(i).norm()));
    return largest;
}

// The lowest of a dense solver's values, and vectors within the spaces of equal values.
void expect_lowest(const Eigenproblem& problem, const Spectrum& found, Index count, double tolerance) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Columns> reference(Columns(problem.stiffness()),
                                                                      Columns(problem.mass_matrix()));
    const Vector& values = reference.eigenvalues();
    ASSERT_EQ(found.summary.method, SpectrumMethod::hierarchical) << found.summary.why;
    ASSERT_TRUE(found.summary.complete);
    ASSERT_EQ(found.values.size(), count);
    ASSERT_EQ(found.vectors.cols(), count);
    EXPECT_EQ(found.summary.count, count);
    EXPECT_EQ(found.summary.zero_modes, std::min(found.summary.components, count));
    const double scale = values[std::max(count - 1, found.summary.components)];
    EXPECT_LT((found.values - values.head(count)).cwiseAbs().maxCoeff(), tolerance * scale);
    EXPECT_LE(largest_residual(problem, found, values[found.summary.components]),
              1.01 * found.summary.tolerance);
    const Columns gram = found.vectors.transpose() * (problem.mass_matrix() * found.vectors);
    EXPECT_LT((gram - Columns::Identity(count, count)).cwiseAbs().maxCoeff(), 1e-12);
    const Columns parts = reference.eigenvectors().transpose() * (problem.mass_matrix() * found.vectors);
    for (Index i = 0; i < parts.cols(); ++i) {
        for (Index j = 0; j < parts.rows(); ++j) {
            if (std::abs(values[j] - found.values[i]) > 1e-3 * scale) {
                EXPECT_LT(std::abs(parts(j, i)), 1e-5) << "pairs " << i << " and " << j;
            }
        }
    }
    const BandCertificate& certificate = found.summary.bands.at(0);
    EXPECT_EQ(found.summary.bands.size(), 1u);
    EXPECT_EQ(certificate.lower.below, 0);
    EXPECT_EQ(certificate.upper.below, (values.array() < certificate.upper.value).count());
    EXPECT_EQ(certificate.found, certificate.upper.below);
    EXPECT_EQ(certificate.kept, count);
    EXPECT_LE(found.summary.max_residual, found.summary.tolerance);
}

TEST(SpectrumHierarchical, EqualsADenseReferenceOnMultiplets) {
    for (const int level : {2, 3}) {
        const Mesh mesh = shapes::icosphere(level);
        const Laplacian laplacian(mesh);
        const Eigenproblem problem(laplacian);
        const SharedHierarchy hierarchy = hierarchy_of(mesh, laplacian);
        ASSERT_GE(hierarchy->level_count(), 2);
        // Within multiplets and at their ends.
        for (const Index count : {1, 2, 4, 5, 7, 9, 12, 16, 20, 25, 30, 36})
            expect_lowest(problem, hierarchical(problem, hierarchy, {.count = count}), count, 1e-9);
    }
}

TEST(SpectrumHierarchical, OnManyKindsOfMeshes) {
    for (const Mesh& mesh : {shapes::torus(1.0, 0.4, 40, 20), shapes::grid(30, 20, 1.0, 0.7),
                             shapes::tetrahedral_ball(6), shapes::fins(3, 14), shapes::circle(600)}) {
        const Laplacian laplacian(mesh);
        const Eigenproblem problem(laplacian);
        expect_lowest(problem, hierarchical(problem, hierarchy_of(mesh, laplacian), {.count = 40}), 40, 1e-9);
    }
}

TEST(SpectrumHierarchical, ComponentsAreZeroModes) {
    std::vector<Mesh> spheres;
    for (int i = 0; i < 5; ++i) {
        const Mesh one = shapes::icosphere(2);
        Points points = one.points();
        points.col(0).array() += 3.0 * i;
        spheres.push_back(one.with_points(std::move(points)));
    }
    const Mesh mesh = shapes::together(spheres);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const SharedHierarchy hierarchy = hierarchy_of(mesh, laplacian);
    // Eigenvalues come 5, 15, 25 and 35 times: 30 pairs end within such a group.
    for (const Index count : {3, 5, 20, 30, 45}) {
        const Spectrum found = hierarchical(problem, hierarchy, {.count = count});
        EXPECT_EQ(found.summary.components, 5);
        expect_lowest(problem, found, count, 1e-9);
    }
}

TEST(SpectrumHierarchical, HeldVerticesAndConsistentMass) {
    const Mesh mesh = shapes::grid(32, 24);
    const Laplacian laplacian(mesh);
    const EdgeOperator<double> mass =
        consistent_mass(laplacian.order().to_working(mesh), laplacian.stiffness().shared_graph());
    Constraints side;
    Constraints scattered;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.points()(v, 0) < 0.4) side.fix(laplacian.order().working(v), 0.0);
        if (v % 3 == 0) scattered.fix(v, 0.0);
    }
    const SharedHierarchy hierarchy = hierarchy_of(mesh, laplacian);
    for (const Eigenproblem& problem :
         {Eigenproblem(laplacian, mass), Eigenproblem(laplacian, side), Eigenproblem(laplacian, mass, side),
          Eigenproblem(laplacian, scattered)})
        expect_lowest(problem, hierarchical(problem, hierarchy, {.count = 30}), 30, 1e-9);
    // All coarse vertices are held: nothing of the hierarchy is of use.
    Constraints coarse;
    for (const Index v : hierarchy->vertices(1))
        coarse.fix(v, 0.0);
    const Eigenproblem problem(laplacian, coarse);
    expect_lowest(problem, hierarchical(problem, hierarchy, {.count = 30}), 30, 1e-9);
}

TEST(SpectrumHierarchical, IsolatedVerticesAreNoUnknowns) {
    const Mesh sphere = shapes::icosphere(3);
    Points points(sphere.vertex_count() + 7, 3);
    points.topRows(7).setRandom();
    points.bottomRows(sphere.vertex_count()) = sphere.points();
    const Mesh mesh(points, Cells(sphere.cells().array() + 7));
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    ASSERT_EQ(problem.rows(), sphere.vertex_count());
    expect_lowest(problem, hierarchical(problem, hierarchy_of(mesh, laplacian), {.count = 20}), 20, 1e-9);
}

TEST(SpectrumHierarchical, HoldsTheToleranceAndDoesLessForALargerOne) {
    const Mesh mesh = shapes::bumpy_sphere(6000);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const SharedHierarchy hierarchy = hierarchy_of(mesh, laplacian, 500);
    const Spectrum exact = spectrum(problem, {.count = 50, .method = SpectrumMethod::bands});
    long columns = 0;
    for (const double tolerance : {1e-2, 1e-4, 1e-8}) {
        const Spectrum found = hierarchical(problem, hierarchy, {.count = 50, .tolerance = tolerance});
        EXPECT_TRUE(found.summary.complete);
        EXPECT_EQ(found.summary.zero_modes, 1);
        EXPECT_LE(found.summary.max_residual, tolerance);
        EXPECT_LE(largest_residual(problem, found, found.values[1]), 1.01 * tolerance);
        // Values are better than vectors: their error is of second order in the residual's.
        EXPECT_LT(((found.values - exact.values).tail(49).cwiseQuotient(exact.values.tail(49)))
                      .cwiseAbs()
                      .maxCoeff(),
                  std::max(0.3 * tolerance, 1e-9));
        EXPECT_GT(found.summary.solved_columns, columns);
        columns = found.summary.solved_columns;
    }
}

TEST(SpectrumHierarchical, AgreesWithBandsOnALargerMesh) {
    const Mesh mesh = shapes::bumpy_sphere(20000);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const SharedHierarchy hierarchy = hierarchy_of(mesh, laplacian, 500);
    ASSERT_GE(hierarchy->level_count(), 3);
    const Spectrum found = hierarchical(problem, hierarchy, {.count = 50});
    const Spectrum bands = spectrum(problem, {.count = 50, .method = SpectrumMethod::bands});
    EXPECT_LT(testing::relative_difference(found.values, bands.values), 1e-9);
    // The same space: the cosines of the angles between both are 1.
    const Columns cosines = found.vectors.transpose() * (problem.mass_matrix() * bands.vectors);
    EXPECT_GT(Eigen::JacobiSVD<Columns>(cosines).singularValues().minCoeff(), 1.0 - 1e-10);
    EXPECT_EQ(found.summary.bands[0].upper.below, found.summary.bands[0].found);
    EXPECT_LE(found.summary.max_residual, 1e-8);
}

TEST(SpectrumHierarchical, StartsNearTheEnd) {
    const Mesh mesh = shapes::bumpy_sphere(20000);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const SharedHierarchy with = hierarchy_of(mesh, laplacian, 500);
    const SharedHierarchy without = hierarchy_of(mesh, laplacian, mesh.vertex_count());
    ASSERT_EQ(without->level_count(), 1);
    const SpectrumOptions options{.count = 30, .tolerance = 1e-2};
    const SpectrumSummary near = hierarchical(problem, with, options).summary;
    const SpectrumSummary far = hierarchical(problem, without, options).summary;
    EXPECT_TRUE(far.complete);
    EXPECT_LT(2 * near.solved_columns, far.solved_columns);
    EXPECT_LT(near.solved_columns, 2 * 30);
}

TEST(SpectrumHierarchical, ACutoffTakesWhatLiesBelow) {
    const Mesh mesh = shapes::bumpy_sphere(5000);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const SharedHierarchy hierarchy = hierarchy_of(mesh, laplacian, 500);
    const Spectrum bands = spectrum(problem, {.count = 101, .method = SpectrumMethod::bands});
    for (const Index count : {1, 2, 40, 100}) {
        const double cutoff = std::sqrt(0.5 * (bands.values[count - 1] + bands.values[count]));
        for (const double tolerance : {1e-2, 1e-8}) {
            const Spectrum found =
                hierarchical(problem, hierarchy, {.cutoff = cutoff, .tolerance = tolerance});
            ASSERT_EQ(found.values.size(), count);
            EXPECT_LT((found.values - bands.values.head(count)).cwiseAbs().maxCoeff(),
                      std::max(0.3 * tolerance, 1e-9) * bands.values[std::max(count - 1, 1)]);
            EXPECT_EQ(found.summary.bands[0].upper.below, count);
            EXPECT_EQ(found.summary.bands[0].upper.value, cutoff * cutoff);
        }
        // With both, the smaller of the two.
        EXPECT_EQ(hierarchical(problem, hierarchy, {.count = 30, .cutoff = cutoff, .tolerance = 1e-2})
                      .values.size(),
                  std::min<Index>(count, 30));
    }
}

// The first values are too high by more than the distance to the cutoff: only inertia tells that one is missing.
TEST(SpectrumHierarchical, ACutoffCloseBehindAPair) {
    const Mesh mesh = shapes::bumpy_sphere(5000);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const Vector exact =
        spectrum(problem, {.count = 41, .method = SpectrumMethod::bands, .tolerance = 1e-10}).values;
    const double cutoff = std::sqrt(exact[39] * (1.0 + 1e-6));
    ASSERT_LT(cutoff * cutoff, exact[40]);
    const Spectrum found =
        hierarchical(problem, hierarchy_of(mesh, laplacian, 500), {.cutoff = cutoff, .tolerance = 0.1});
    EXPECT_EQ(found.values.size(), 40);
    EXPECT_EQ(found.summary.bands[0].found, 40);
    EXPECT_GT(found.summary.bands[0].rounds, 1);
}

TEST(SpectrumHierarchical, TooManyPairsAreLeftToAnotherMethod) {
    const Mesh mesh = shapes::icosphere(2);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const Spectrum found = hierarchical(problem, hierarchy_of(mesh, laplacian), {.count = 162});
    EXPECT_EQ(found.summary.method, SpectrumMethod::full);
    EXPECT_TRUE(found.summary.complete);
    EXPECT_EQ(found.values.size(), 162);
}

TEST(SpectrumHierarchical, Refuses) {
    const Mesh mesh = shapes::icosphere(3);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const SharedHierarchy hierarchy = hierarchy_of(mesh, laplacian);
    EXPECT_THROW(spectrum(problem, {.count = 5, .method = SpectrumMethod::hierarchical}), InputError);
    EXPECT_THROW(hierarchical(problem, hierarchy, {.count = 5, .from = 1.0}), InputError);
    const SpectrumResume resume{};
    EXPECT_THROW(hierarchical(problem, hierarchy, {.count = 5, .resume = &resume}), InputError);
    const Mesh other = shapes::icosphere(2);
    EXPECT_THROW(hierarchical(problem, hierarchy_of(other, Laplacian(other)), {.count = 5}), InputError);
    EXPECT_EQ(name(SpectrumMethod::hierarchical), "hierarchical");
}

TEST(SpectrumHierarchical, WhatCannotBeCertifiedIsAnError) {
    const Mesh mesh = shapes::bumpy_sphere(1000);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const SharedHierarchy hierarchy = hierarchy_of(mesh, laplacian, 100);
    SpectrumOptions options{.count = 30, .method = SpectrumMethod::hierarchical, .tolerance = 1e-17};
    options.hierarchy = hierarchy;
    Index handed_over = 0;
    EXPECT_THROW(spectrum(problem, options, [&](const SpectralBand&) { ++handed_over; }), SolveError);
    EXPECT_EQ(handed_over, 0);
}

TEST(SpectrumHierarchical, CanBeCancelledAnywhere) {
    const Mesh mesh = shapes::bumpy_sphere(12000);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const SharedHierarchy hierarchy = hierarchy_of(mesh, laplacian, 300);
    int reports = 0;
    bool coarse = false;
    bool fine = false;
    const Progress counting([&](const ProgressReport& r) {
        ++reports;
        coarse = coarse || r.phase == "coarse level";
        fine = fine || r.phase == "eigenpairs";
    });
    const Spectrum whole =
        hierarchical(problem, hierarchy, {.count = 30, .tolerance = 1e-4, .progress = &counting});
    EXPECT_TRUE(coarse && fine);
    ASSERT_GT(reports, 12);
    for (const int at : {1, 3, reports / 3, reports / 2, reports - 4}) {
        int seen = 0;
        Progress* self = nullptr;
        Progress stopping([&](const ProgressReport&) {
            if (++seen == at) self->cancel();
        });
        self = &stopping;
        EXPECT_THROW(
            hierarchical(problem, hierarchy, {.count = 30, .tolerance = 1e-4, .progress = &stopping}),
            Cancelled);
        EXPECT_LE(seen, at + 1);
    }
    // The same every time.
    const Spectrum again = hierarchical(problem, hierarchy, {.count = 30, .tolerance = 1e-4});
    EXPECT_EQ((again.values - whole.values).cwiseAbs().maxCoeff(), 0.0);
}

TEST(Eigenproblem, OfMatrices) {
    const Laplacian laplacian(shapes::icosphere(1));
    const Eigenproblem problem(laplacian);
    const Eigen::SparseMatrix<double> K = problem.stiffness();
    const Eigen::SparseMatrix<double> M = problem.mass_matrix();
    const Eigenproblem same(K, M, problem.constants());
    EXPECT_EQ(same.rows(), problem.rows());
    EXPECT_FALSE(same.lumped());
    EXPECT_EQ(same.vertices(), problem.vertices());
    EXPECT_NEAR(same.total_mass(), problem.total_mass(), 1e-12);
    const Vector a = spectrum(problem, {.count = 42}).values;
    EXPECT_LT(testing::relative_difference(spectrum(same, {.count = 42}).values, a), 1e-12);

    const Columns none(problem.rows(), 0);
    EXPECT_THROW(Eigenproblem(K, M.topLeftCorner(3, 3), Columns(3, 0)), InputError);
    EXPECT_THROW(Eigenproblem(K, M, Columns(3, 0)), InputError);
    EXPECT_THROW(Eigenproblem(K, Eigen::SparseMatrix<double>(K.rows(), K.rows()), none), InputError);
    EXPECT_THROW(Eigenproblem(Eigen::SparseMatrix<double>(), Eigen::SparseMatrix<double>(), Columns()),
                 InputError);
}

}  // namespace
}  // namespace beltrami
