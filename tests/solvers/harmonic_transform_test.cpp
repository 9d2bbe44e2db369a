#include "beltrami/solvers/harmonic_transform.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "meshes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::Scratch;

// A basis up to a frequency, in a scratch folder.
class HarmonicTransform : public ::testing::Test {
  protected:
    StoredBasis store(const std::string& name, const SpectrumOptions& options,
                      NpyType type = NpyType::float64) {
        BasisWriter writer(folder / name, mesh, laplacian, problem, {}, {.type = type});
        writer.finish(spectrum(problem, writer.continued(options), writer.sink()));
        return StoredBasis(folder / name);
    }
    // The field on the unknowns, and back: here every vertex is one.
    [[nodiscard]] Block to_unknowns(const Block& field) const { return laplacian.order().to_working(field); }

    Scratch folder;
    Mesh mesh = shapes::shuffled(shapes::bumpy_sphere(1500)).mesh;
    Laplacian laplacian{mesh};
    Eigenproblem problem{laplacian};
};

TEST_F(HarmonicTransform, IsTheProductWithTheBasis) {
    for (const NpyType type : {NpyType::float64, NpyType::float32}) {
        const StoredBasis basis = store(type == NpyType::float64 ? "d" : "f",
                                        {.count = 70, .method = SpectrumMethod::bands, .band = 30}, type);
        Columns H(mesh.vertex_count(), 70);
        for (Index k = 0; k < 70; ++k)
            H.col(k) = basis.function(k);
        for (const Index columns : {1, 2, 3, 4, 7}) {
            const Block field = testing::random_block(mesh.vertex_count(), columns);
            const Block expected = H.transpose() * basis.mass().asDiagonal() * field;
            const Block coefficients = forward_transform(basis, field);
            EXPECT_LT(testing::relative_difference(coefficients, expected), 1e-12);
            EXPECT_LT(
                testing::relative_difference(inverse_transform(basis, coefficients), Block(H * expected)),
                1e-12);
            EXPECT_LT(testing::relative_difference(inverse_transform(basis, coefficients.topRows(41)),
                                                   Block(H.leftCols(41) * expected.topRows(41))),
                      1e-12);
        }
    }
}

TEST_F(HarmonicTransform, AGainOf1ReturnsTheInput) {
    const StoredBasis basis = store("b", {.count = 50});
    const Block field = testing::random_block(mesh.vertex_count(), 3);
    EXPECT_EQ(HarmonicFilter(basis, field).apply(FilterCurve({{0.0, 1.0}})), field);
    // Not only where nothing is to do: a curve that is 1 everywhere but far below the first function.
    const FilterCurve nearly({{0.0, 1.0}, {1e-9, 1.0}, {2e-9, 2.0}, {3e-9, 1.0}});
    EXPECT_LT(testing::relative_difference(HarmonicFilter(basis, field).apply(nearly), field), 1e-14);
}

TEST_F(HarmonicTransform, AmplifiesEachFunctionByItsGain) {
    const StoredBasis basis = store("b", {.count = 60});
    const FilterCurve curve({{0.0, 2.0}, {4.0, 0.5}, {8.0, 3.0}});
    for (const Index k : {0, 1, 7, 33, 59}) {
        const Block h = basis.function(k);
        const double gain = curve(std::sqrt(std::max(basis.eigenvalues()[k], 0.0)));
        EXPECT_LT(testing::relative_difference(HarmonicFilter(basis, h).apply(curve), Block(gain * h)), 1e-8)
            << k;
    }
}

TEST_F(HarmonicTransform, TheRestIsAWavePacket) {
    const StoredBasis basis = store("b", {.count = 60});
    const Block field = testing::random_block(mesh.vertex_count(), 1);
    const Block low = inverse_transform(basis, forward_transform(basis, field));
    const double cutoff = cutoff_frequency(basis);
    const double nyquist = nyquist_frequency(basis.mean_edge());
    EXPECT_NEAR(nyquist * basis.mean_edge(), std::numbers::pi, 1e-12);
    EXPECT_GT(nyquist, cutoff);
    // 1 where the basis is, then linear from 1 to 0 at the Nyquist frequency: the mean is a half.
    const FilterCurve curve({{cutoff, 1.0}, {nyquist, 0.0}});
    EXPECT_LT(testing::relative_difference(HarmonicFilter(basis, field).apply(curve),
                                           Block(low + 0.5 * (field - low))),
              1e-12);
}

TEST_F(HarmonicTransform, LimitedMemoryEqualsTheStoredBasis) {
    const double cutoff = 9.0;
    const StoredBasis basis = store("b", {.cutoff = cutoff, .method = SpectrumMethod::bands});
    EXPECT_NEAR(cutoff_frequency(basis), cutoff, 1e-12);
    const Block field = mesh.points();
    for (const FilterCurve& curve :
         {FilterCurve::low_pass(4.0, 5.0), FilterCurve::notch(3.0, 6.0),
          FilterCurve::band_exaggeration(4.0, 6.0, 3.0), FilterCurve({{0.0, 1.0}, {30.0, 0.2}})}) {
        LimitedFilterOptions options{.cutoff = cutoff, .mean_edge = basis.mean_edge()};
        options.spectrum.method = SpectrumMethod::bands;
        const LimitedFilterResult limited =
            limited_memory_filter(problem, to_unknowns(field), curve, options);
        EXPECT_LT(testing::relative_difference(laplacian.order().to_user(limited.field),
                                               HarmonicFilter(basis, field).apply(curve)),
                  1e-8);
        EXPECT_LE(limited.pairs, basis.count());
    }
    // A notch needs the pairs of its own frequencies only.
    const LimitedFilterOptions options{.cutoff = cutoff, .mean_edge = basis.mean_edge()};
    const LimitedFilterResult notch =
        limited_memory_filter(problem, to_unknowns(field), FilterCurve::notch(5.0, 6.0), options);
    const auto inside =
        (basis.eigenvalues().array() >= 4.9 * 4.9 && basis.eigenvalues().array() <= 6.1 * 6.1).count();
    EXPECT_EQ(notch.pairs, inside);
    EXPECT_EQ(limited_memory_filter(problem, to_unknowns(field), FilterCurve({{0.0, 1.0}}), options).pairs,
              0);
}

TEST_F(HarmonicTransform, RefusesOtherLengths) {
    const StoredBasis basis = store("b", {.count = 10});
    EXPECT_THROW(forward_transform(basis, Block::Zero(5, 1)), InputError);
    EXPECT_THROW(inverse_transform(basis, Block::Zero(11, 1)), InputError);
    EXPECT_THROW(limited_memory_filter(problem, Block::Zero(5, 1), FilterCurve({{0.0, 1.0}}), {1.0, 1.0}),
                 InputError);
    EXPECT_THROW(
        limited_memory_filter(problem, Block::Zero(problem.rows(), 1), FilterCurve({{0.0, 1.0}}), {0.0, 1.0}),
        InputError);
}

}  // namespace
}  // namespace beltrami
