#include "beltrami/solvers/supernodal_ldlt.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/mass.hpp"
#include "beltrami/solvers/shift_invert.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::random_block;
using testing::relative_difference;
using Dense = Eigen::MatrixXd;

struct Sample {
    const char* name;
    Eigenproblem problem;
};

Constraints holding(const std::vector<Index>& vertices) {
    Constraints held;
    for (const Index v : vertices)
        held.fix(v, 0.0);
    return held;
}
Eigenproblem lumped(const Mesh& mesh, const std::vector<Index>& held = {}) {
    return Eigenproblem(Laplacian(mesh), holding(held));
}
Eigenproblem consistent(const Mesh& mesh, const std::vector<Index>& held = {}) {
    const Laplacian laplacian(mesh);
    // The mass must have the vertices' working order.
    const Mesh ordered(laplacian.order().to_working(Block(mesh.points())),
                       mesh.cells().unaryExpr([&](Index v) { return laplacian.order().working(v); }));
    return Eigenproblem(laplacian, consistent_mass(ordered, testing::graph_of(ordered)), holding(held));
}

// Multiple eigenvalues, boundaries, several components, cells of every kind, held vertices, both kinds of mass.
const std::vector<Sample>& samples() {
    static const std::vector<Sample> all{
        {"icosphere", lumped(shapes::icosphere(2))},
        {"icosphere, consistent", consistent(shapes::icosphere(2))},
        {"grid", lumped(shapes::grid(14, 9))},
        {"grid, held", lumped(shapes::with_noise(shapes::grid(14, 9), 0.1), {0, 17, 80, 81})},
        {"torus, consistent, held", consistent(shapes::torus(1.0, 0.4, 20, 9), {3, 4, 100})},
        {"together",
         lumped(shapes::together({shapes::icosphere(1), shapes::grid(6, 5), shapes::torus(1.0, 0.3, 9, 5)}))},
        {"tetrahedra", lumped(shapes::tetrahedral_cube(5))},
        {"tetrahedra, consistent", consistent(shapes::tetrahedral_ball(4), {0, 5})},
        {"fins", lumped(shapes::fins(4, 6))},
        {"circle", lumped(shapes::circle(41))},
        {"bumpy", lumped(shapes::bumpy_sphere(300))},
        {"one", lumped(shapes::grid(1, 1), {0, 1, 2})},
    };
    return all;
}

Dense stiffness(const Eigenproblem& problem) {
    return Dense(problem.stiffness());
}
Dense mass(const Eigenproblem& problem) {
    return Dense(problem.mass_matrix());
}
Vector eigenvalues(const Eigenproblem& problem) {
    return Eigen::GeneralizedSelfAdjointEigenSolver<Dense>(stiffness(problem), mass(problem),
                                                           Eigen::EigenvaluesOnly)
        .eigenvalues();
}
Index below(const Vector& values, double shift) {
    return static_cast<Index>((values.array() < shift).count());
}
// |A x - b| / (|A| |x| + |b|) in the norm of the largest entry.
double backward_error(const Dense& A, const Columns& x, const Columns& b) {
    const double norm = A.cwiseAbs().rowwise().sum().maxCoeff();
    return (A * x - b).cwiseAbs().maxCoeff() / (norm * x.cwiseAbs().maxCoeff() + b.cwiseAbs().maxCoeff());
}
// The middle of the widest gap, relative to where it is, among eigenvalues first ... last.
double in_a_gap(const Vector& values, Eigen::Index first, Eigen::Index last) {
    double best = 0.0;
    double shift = values[0] - 1.0;
    for (Eigen::Index i = first; i < std::min(last, values.size() - 1); ++i) {
        const double gap = (values[i + 1] - values[i]) / (std::abs(values[i]) + std::abs(values[i + 1]));
        if (gap <= best) continue;
        best = gap;
        shift = 0.5 * (values[i] + values[i + 1]);
    }
    return shift;
}

TEST(SupernodalLdlt, CountsEigenvaluesBelow) {
    for (const Sample& sample : samples()) {
        SCOPED_TRACE(sample.name);
        const Vector values = eigenvalues(sample.problem);
        const double largest = values[values.size() - 1];
        std::vector<double> shifts{-1.0, -1e-3 * largest, 1.01 * largest, 2.0 * largest};
        for (Eigen::Index i = 0; i < values.size(); i += 1 + values.size() / 50) {
            shifts.push_back(values[i] * (1.0 + 1e-4));
            shifts.push_back(values[i] * (1.0 - 1e-4));
            if (i > 0) shifts.push_back(0.5 * (values[i] + values[i - 1]));
        }
        SupernodalLdlt ldlt(sample.problem);
        int tried = 0;
        for (const double shift : shifts) {
            // Neither reference nor factor can tell an eigenvalue from a shift that agrees with it to rounding.
            if ((values.array() - shift).abs().minCoeff() < 1e-10 * largest) continue;
            ldlt.factor(shift);
            EXPECT_EQ(ldlt.negative_pivots(), below(values, shift)) << shift;
            EXPECT_EQ(ldlt.shift(), shift);
            EXPECT_EQ(ldlt.factorizations(), ++tried);
        }
        EXPECT_GE(tried, 3);
    }
}

TEST(SupernodalLdlt, SolvesAsDenseElimination) {
    for (const Sample& sample : samples()) {
        SCOPED_TRACE(sample.name);
        const Vector values = eigenvalues(sample.problem);
        SupernodalLdlt ldlt(sample.problem);
        for (const double shift :
             {-0.5, in_a_gap(values, 1, 30), in_a_gap(values, values.size() / 2, values.size())}) {
            const Dense A = stiffness(sample.problem) - shift * mass(sample.problem);
            ldlt.factor(shift);
            EXPECT_LT(ldlt.backward_error(), 1e-11);
            const Eigen::PartialPivLU<Dense> reference(A);
            for (const Index k : {1, 2, 3, 4, 5, 8, 12, 16, 17, 24, 32, 33, 65}) {
                const Columns b = random_block(ldlt.rows(), k, static_cast<std::uint32_t>(k));
                Columns x = b;
                ldlt.solve(x);
                EXPECT_LT(relative_difference(x, Columns(reference.solve(b))), 1e-9) << shift << " " << k;
            }
        }
        Columns none(ldlt.rows(), 0);
        ldlt.solve(none);
        EXPECT_EQ(ldlt.solved_columns(), 3 * (1 + 2 + 3 + 4 + 5 + 8 + 12 + 16 + 17 + 24 + 32 + 33 + 65));
    }
}

// Several panels a front, and an update that shares blocks of rows with them.
TEST(SupernodalLdlt, WideFronts) {
    const Eigenproblem problem = lumped(shapes::with_noise(shapes::tetrahedral_cube(8), 0.1));
    const Vector values = eigenvalues(problem);
    SupernodalLdlt ldlt(problem);
    for (const double shift :
         {in_a_gap(values, 1, 40), in_a_gap(values, 300, 400), in_a_gap(values, 600, 700)}) {
        ldlt.factor(shift);
        EXPECT_EQ(ldlt.negative_pivots(), below(values, shift));
        const Dense A = stiffness(problem) - shift * mass(problem);
        const Columns b = random_block(ldlt.rows(), 5);
        Columns x = b;
        ldlt.solve(x);
        EXPECT_LT(relative_difference(x, Columns(Eigen::PartialPivLU<Dense>(A).solve(b))), 1e-9);
    }
}

// Every set of inner loops, on fronts of every shape.
TEST(SupernodalLdlt, InstructionsAgree) {
    const Eigenproblem surface = lumped(shapes::bumpy_sphere(3000));
    const Eigenproblem solid = lumped(shapes::with_noise(shapes::tetrahedral_cube(10), 0.1));
    for (const Eigenproblem* problem : {&surface, &solid}) {
        const double shift = 40.0 / problem->total_mass();
        SupernodalLdlt best(*problem);
        best.factor(shift);
        int found = 0;
        for (const char* instructions : {"avx512", "avx2", "any"}) {
            try {
                SupernodalLdlt other(*problem, {.instructions = instructions});
                EXPECT_EQ(other.instructions(), instructions);
                other.factor(shift);
                EXPECT_EQ(other.negative_pivots(), best.negative_pivots());
                for (const Index k : {1, 7, 16, 24, 32}) {
                    Columns x = random_block(other.rows(), k);
                    Columns y = x;
                    other.solve(x);
                    best.solve(y);
                    EXPECT_LT(relative_difference(x, y), 1e-9);
                }
                ++found;
            } catch (const InputError&) {
                continue;
            }
        }
        EXPECT_GE(found, 1);
    }
    EXPECT_THROW(SupernodalLdlt(surface, {.instructions = "mmx"}), InputError);
}

TEST(SupernodalLdlt, AQuickOrderingFillsMoreAndSolvesTheSame) {
    const Eigenproblem surface = lumped(shapes::bumpy_sphere(20000));
    const double shift = 40.0 / surface.total_mass();
    SupernodalLdlt metis(surface);
    SupernodalLdlt amd(surface, {.few_solves = true});
    metis.factor(shift);
    amd.factor(shift);
    EXPECT_EQ(amd.negative_pivots(), metis.negative_pivots());
    EXPECT_GT(amd.nonzeros(), metis.nonzeros());
    EXPECT_LT(amd.nonzeros(), 2.0 * metis.nonzeros());
    Columns x = random_block(surface.rows(), 8);
    Block y = x;
    metis.solve(x);
    amd.solve(y);
    EXPECT_LT(relative_difference(x, Columns(y)), 1e-9);
}

TEST(SupernodalLdlt, ThreadsDoNotMatter) {
    const int before = omp_get_max_threads();
    const Eigenproblem surface = lumped(shapes::bumpy_sphere(20000));
    const Eigenproblem solid = lumped(shapes::with_noise(shapes::tetrahedral_cube(14), 0.1));
    for (const Eigenproblem* problem : {&surface, &solid}) {
        for (const double eigenvalues : {10.0, 300.0}) {
            const double shift = 4.0 * M_PI * eigenvalues / problem->total_mass();
            const Columns b = random_block(problem->rows(), 21);
            std::vector<Columns> x;
            std::vector<Index> negative;
            for (const int threads : {1, 2, 3}) {
                omp_set_num_threads(threads);
                SupernodalLdlt ldlt(*problem);
                ldlt.factor(shift);
                negative.push_back(ldlt.negative_pivots());
                x.push_back(b);
                ldlt.solve(x.back());
            }
            omp_set_num_threads(before);
            EXPECT_EQ(negative[1], negative[0]);
            EXPECT_EQ(negative[2], negative[0]);
            EXPECT_EQ(x[1], x[0]);
            EXPECT_EQ(x[2], x[0]);
        }
    }
}

TEST(SupernodalLdlt, AgreesWithMumps) {
    const Eigenproblem surface = lumped(shapes::bumpy_sphere(20000));
    const Eigenproblem solid =
        consistent(shapes::with_noise(shapes::tetrahedral_cube(14), 0.1), {0, 1, 2, 500});
    const Eigenproblem pieces = lumped(
        shapes::together({shapes::bumpy_sphere(9000), shapes::grid(60, 50), shapes::bumpy_sphere(8000, 2)}));
    for (const Eigenproblem* problem : {&surface, &solid, &pieces}) {
        SupernodalLdlt ldlt(*problem);
        ShiftInvert mumps(*problem);
        for (const double eigenvalues : {-1.0, 50.0, 157.0, 1000.0}) {
            const double shift = 4.0 * M_PI * eigenvalues / problem->total_mass();
            ldlt.factor(shift);
            mumps.factor(shift);
            EXPECT_EQ(ldlt.negative_pivots(), mumps.eigenvalues_below());
            EXPECT_LT(ldlt.backward_error(), 1e-11);
            for (const Index k : {1, 10, 40}) {
                Columns x = random_block(ldlt.rows(), k);
                Columns y = x;
                ldlt.solve(x);
                mumps.solve(y);
                EXPECT_LT(relative_difference(x, y), 1e-8) << eigenvalues << " " << k;
            }
        }
    }
}

// There the factor exists by rounding only; what it then says must still hold for a matrix close by.
TEST(SupernodalLdlt, AtAnEigenvalueEitherFailsOrIsStable) {
    for (const Sample& sample : samples()) {
        SCOPED_TRACE(sample.name);
        const Vector values = eigenvalues(sample.problem);
        SupernodalLdlt ldlt(sample.problem);
        for (Eigen::Index i = 0; i < values.size(); i += 1 + values.size() / 12) {
            const Dense A = stiffness(sample.problem) - values[i] * mass(sample.problem);
            Columns b = random_block(ldlt.rows(), 6);
            Columns x = b;
            try {
                ldlt.factor(values[i]);
            } catch (const SolveError& error) {
                EXPECT_EQ(error.hint(), "take another shift");
                EXPECT_THROW(ldlt.solve(x), InputError);
                continue;
            }
            EXPECT_LE(ldlt.backward_error(), 1e-8);
            ldlt.solve(x);
            EXPECT_LT(backward_error(A, x, b), 1e-7) << values[i];
        }
    }
}

// Where a row's own K_ii - shift M_ii is zero elimination may begin with that pivot, though the matrix is regular.
TEST(SupernodalLdlt, TinyPivotsAreNoticed) {
    int failed = 0;
    for (const Sample& sample : samples()) {
        SCOPED_TRACE(sample.name);
        SupernodalLdlt ldlt(sample.problem);
        const Dense K = stiffness(sample.problem);
        const Dense M = mass(sample.problem);
        for (Index i = 0; i < ldlt.rows(); i += 1 + ldlt.rows() / 40) {
            const double shift = K(i, i) / M(i, i);
            try {
                ldlt.factor(shift);
            } catch (const SolveError&) {
                ++failed;
                continue;
            }
            const Columns b = random_block(ldlt.rows(), 4);
            Columns x = b;
            ldlt.solve(x);
            EXPECT_LT(backward_error(K - shift * M, x, b), 1e-7) << shift;
        }
    }
    EXPECT_GT(failed, 0);
}

TEST(SupernodalLdlt, RecoversFromAFailure) {
    const Eigenproblem problem = lumped(shapes::grid(1, 1), {0, 1, 2});
    SupernodalLdlt ldlt(problem);
    ASSERT_EQ(ldlt.rows(), 1);
    const double k = problem.stiffness().coeff(0, 0);
    const double m = problem.lumped_mass()[0];
    Columns x = Columns::Constant(1, 3, 2.0);
    EXPECT_THROW(ldlt.solve(x), InputError);
    EXPECT_THROW(ldlt.factor(k / m), SolveError);
    EXPECT_THROW(ldlt.factor(std::numeric_limits<double>::quiet_NaN()), SolveError);
    EXPECT_THROW(ldlt.factor(std::numeric_limits<double>::infinity()), SolveError);
    EXPECT_THROW(ldlt.solve(x), InputError);
    EXPECT_EQ(ldlt.factorizations(), 0);
    ldlt.factor(2.0 * k / m);
    EXPECT_EQ(ldlt.negative_pivots(), 1);
    ldlt.solve(x);
    EXPECT_NEAR(x(0, 2), -2.0 / k, 1e-15);
    Columns wrong(2, 1);
    EXPECT_THROW(ldlt.solve(wrong), InputError);
}

TEST(SupernodalLdlt, ReportsItsSize) {
    const Eigenproblem problem = lumped(shapes::bumpy_sphere(5000));
    SupernodalLdlt ldlt(problem);
    const double lower = 0.5 * static_cast<double>(problem.stiffness().nonZeros() + problem.rows());
    EXPECT_GE(ldlt.nonzeros(), lower);
    EXPECT_LT(ldlt.nonzeros(), 20.0 * lower);
    EXPECT_GE(ldlt.flops(), ldlt.nonzeros());
    EXPECT_GE(static_cast<double>(ldlt.memory_bytes()), 8.0 * ldlt.nonzeros());
    EXPECT_LT(static_cast<double>(ldlt.memory_bytes()), 40.0 * ldlt.nonzeros());
    EXPECT_GT(ldlt.working_bytes(), 0U);
    // It can be moved.
    ldlt.factor(1.0);
    SupernodalLdlt other = std::move(ldlt);
    EXPECT_EQ(other.factorizations(), 1);
}

}  // namespace
}  // namespace beltrami
