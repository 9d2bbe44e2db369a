// Figures of Vallet & Levy, "Spectral Geometry Processing with Manifold Harmonics" (2007, 2008), and of Ozer, "Mesh
// Smoothing with Manifold Harmonics".
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "beltrami/apps/filter/filter.hpp"
#include "beltrami/framework/read_mesh.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/spectral_laplacian.hpp"
#include "meshes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::Scratch;
using testing::shared_mesh;

// Ozer, Figure 3: the Stanford bunny of 3,485 vertices with all functions, 1024, 97 and 6.
TEST(ManifoldHarmonics, ReconstructTheBunny) {
    const auto path = shared_mesh("bunny_3485.off");
    BELTRAMI_SKIP_WITHOUT(path);
    if (BELTRAMI_LARGEST_LOCAL_MESH < 10000) GTEST_SKIP() << "a minute in a dense library";
    const Mesh mesh = read_mesh(path);
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const Spectrum all = spectrum(problem, {.count = problem.rows()});
    ASSERT_EQ(all.values.size(), 3485);
    EXPECT_EQ(all.summary.method, SpectrumMethod::full);
    EXPECT_LT(all.summary.max_orthogonality_error, 1e-10);
    const Columns x = laplacian.order().to_working(Block(mesh.points()));
    const Columns coefficients = all.vectors.transpose() * laplacian.mass().asDiagonal() * x;
    const auto error = [&](Index k) {
        const Columns again = all.vectors.leftCols(k) * coefficients.topRows(k);
        const Columns centred = x.rowwise() - x.colwise().mean();
        return testing::l2_norm(laplacian.mass(), again - x) / testing::l2_norm(laplacian.mass(), centred);
    };
    EXPECT_LT(error(3485), 1e-10);
    // As in the figure: hardly to be told from the original, all of the shape, a blob of ears and body.
    EXPECT_LT(error(1024), 0.005);
    EXPECT_GT(error(1024), 1e-6);
    EXPECT_LT(error(97), 0.05);
    EXPECT_GT(error(97), 2.0 * error(1024));
    EXPECT_LT(error(6), 0.5);
    EXPECT_GT(error(6), 2.0 * error(97));
}

Mesh low_passed(const Mesh& mesh, double edges) {
    const Laplacian laplacian(mesh);
    const Eigenproblem problem(laplacian);
    const Scratch folder;
    BasisWriter writer(folder / "b", mesh, laplacian, problem, {}, {});
    SpectrumOptions options;
    options.count = mesh.vertex_count() / 16;
    writer.finish(spectrum(problem, writer.continued(options), writer.sink()));
    const StoredBasis stored(folder / "b");
    const FilterCurve curve = FilterCurve::low_pass(frequency_of_edges(stored.mean_edge(), edges),
                                                    1.25 * frequency_of_edges(stored.mean_edge(), edges));
    return mesh.with_points(Points(HarmonicFilter(stored, mesh.points()).apply(curve)));
}

// 2007, Figure 7: a sphere and a surface of genus 4 with random noise, and the low-pass filter's result.
TEST(ManifoldHarmonics, LowPassRemovesNoiseWithoutShrinking) {
    struct Case {
        Mesh clean;
        double noise;
        double edges;
    };
    // Creases hold all frequencies (2007, Figure 11): the slab with holes is rounded first.
    const Mesh rounded = low_passed(shapes::genus(4, 6), 10.0);
    for (const Case& each : {Case{shapes::icosphere(4), 0.2, 12.0}, Case{rounded, 0.2, 8.0}}) {
        const Mesh noisy = shapes::with_noise(each.clean, each.noise);
        const Mesh smooth = low_passed(noisy, each.edges);
        const double volume = enclosed_volume(each.clean);
        EXPECT_LT(std::abs(enclosed_volume(smooth) / volume - 1.0), 0.005);
        const auto roughness = [&](const Mesh& mesh) {
            // How far the normals of the cells are from those of the clean mesh, in the mean.
            double sum = 0.0;
            for (Index c = 0; c < mesh.cell_count(); ++c) {
                const auto normal = [&](const Mesh& m) -> Vector3 {
                    const Vector3 a = m.points().row(m.cells()(c, 0));
                    const Vector3 b = m.points().row(m.cells()(c, 1));
                    const Vector3 d = m.points().row(m.cells()(c, 2));
                    return (b - a).cross(d - a).normalized();
                };
                sum += 1.0 - normal(mesh).dot(normal(each.clean));
            }
            return sum / mesh.cell_count();
        };
        EXPECT_LT(roughness(smooth), 0.35 * roughness(noisy));
    }
}

// 2008, Figure 2: a shape that is its own mirror image in x, its vertices twice as dense along x on the right.
Mesh half_denser(Index rings, Index around) {
    std::vector<double> angles;  // from the left pole to the right one, 0 to pi
    const double middle = 0.5 * std::numbers::pi;
    for (Index i = 1; i < rings; ++i)
        angles.push_back(middle * i / rings);
    for (Index i = 0; i < 2 * rings; ++i)
        angles.push_back(middle + middle * i / (2.0 * rings));
    const auto count = static_cast<Index>(angles.size());
    Points points(count * around + 2, 3);
    for (Index i = 0; i < count; ++i) {
        const double a = angles[static_cast<std::size_t>(i)];
        // Two lobes, as a dumb-bell: something that a filter can deform.
        const double radius = std::sin(a) * (0.45 + 0.55 * std::cos(a) * std::cos(a));
        for (Index j = 0; j < around; ++j) {
            const double b = 2.0 * std::numbers::pi * j / around;
            points.row(i * around + j) << -1.5 * std::cos(a), radius * std::cos(b), radius * std::sin(b);
        }
    }
    const Index left = count * around;
    points.row(left) << -1.5, 0.0, 0.0;
    points.row(left + 1) << 1.5, 0.0, 0.0;
    std::vector<std::array<Index, 3>> triangles;
    for (Index j = 0; j < around; ++j) {
        const Index k = (j + 1) % around;
        triangles.push_back({left, k, j});
        triangles.push_back({left + 1, (count - 1) * around + j, (count - 1) * around + k});
        for (Index i = 0; i + 1 < count; ++i) {
            triangles.push_back({i * around + j, i * around + k, (i + 1) * around + k});
            triangles.push_back({i * around + j, (i + 1) * around + k, (i + 1) * around + j});
        }
    }
    Cells cells(static_cast<Eigen::Index>(triangles.size()), 3);
    for (Eigen::Index c = 0; c < cells.rows(); ++c) {
        for (int corner = 0; corner < 3; ++corner)
            cells(c, corner) = triangles[static_cast<std::size_t>(c)][static_cast<std::size_t>(corner)];
    }
    return {points, cells};
}

struct Deformation {
    double asymmetry;  // how much thicker the right lobe is than the left one, relative
    double error;      // of the reconstruction, over the shape's size
};

// The shape from its lowest functions, as each of the five Laplacians has them.
Deformation deformation(const Mesh& mesh, SpectralLaplacian kind, Index functions) {
    const Laplacian laplacian = spectral_laplacian(mesh, kind);
    const Eigenproblem problem(laplacian);
    Spectrum found = spectrum(problem, {.count = functions});
    Vector mass = laplacian.mass();
    if (kind == SpectralLaplacian::weighted) {
        found.vectors.colwise().normalize();
        mass.setOnes();
    }
    const Columns x = laplacian.order().to_working(Block(mesh.points()));
    const Columns again = found.vectors * (found.vectors.transpose() * mass.asDiagonal() * x);
    // Volume-like moments of both lobes: the mean squared distance from the axis, by area.
    const Laplacian areas(mesh);
    double moments[2] = {0.0, 0.0};  // NOLINT(modernize-avoid-c-arrays)
    double sizes[2] = {0.0, 0.0};    // NOLINT(modernize-avoid-c-arrays)
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const int side = x(v, 0) > 0.0 ? 1 : 0;
        moments[side] += areas.mass()[v] * again.row(v).tail(2).squaredNorm();
        sizes[side] += areas.mass()[v];
    }
    const double left = std::sqrt(moments[0] / sizes[0]);
    const double right = std::sqrt(moments[1] / sizes[1]);
    return {std::abs(right / left - 1.0),
            testing::l2_norm(areas.mass(), again - x) / testing::l2_norm(areas.mass(), x)};
}

TEST(ManifoldHarmonics, OnlyTheSymmetricWeightsKeepAMirrorImage) {
    const Mesh mesh = half_denser(14, 24);
    constexpr Index functions = 12;
    const Deformation dec = deformation(mesh, SpectralLaplacian::dec, functions);
    EXPECT_LT(dec.asymmetry, 0.01);
    EXPECT_LT(dec.error, 0.25);
    for (const SpectralLaplacian kind :
         {SpectralLaplacian::combinatorial, SpectralLaplacian::cotangent, SpectralLaplacian::symmetrized}) {
        // The right, denser half gets more of the functions; least so with A_i + A_j.
        EXPECT_GT(deformation(mesh, kind, functions).asymmetry,
                  (kind == SpectralLaplacian::symmetrized ? 2.0 : 5.0) * dec.asymmetry)
            << name(kind);
    }
    // Functions that are not orthogonal do not give the shape back.
    EXPECT_GT(deformation(mesh, SpectralLaplacian::weighted, functions).error, 1.5 * dec.error);
    for (const SpectralLaplacian kind :
         {SpectralLaplacian::combinatorial, SpectralLaplacian::cotangent, SpectralLaplacian::weighted,
          SpectralLaplacian::symmetrized, SpectralLaplacian::dec}) {
        const Deformation d = deformation(mesh, kind, functions);
        RecordProperty(std::string(name(kind)), std::to_string(d.asymmetry) + " " + std::to_string(d.error));
    }
}

}  // namespace
}  // namespace beltrami
