// Second order in the mesh width for heat and waves on the sphere, and the orders of the time methods.
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>

#include "beltrami/apps/heat/heat.hpp"
#include "beltrami/apps/wave/wave.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/mass.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::fitted_order;
using testing::l2_norm;

struct Harmonic {
    int l;
    std::function<double(double x, double y, double z)> value;
    [[nodiscard]] double eigenvalue() const { return l * (l + 1.0); }
    [[nodiscard]] Vector on(const Mesh& sphere) const {
        Vector values(sphere.vertex_count());
        for (Index v = 0; v < sphere.vertex_count(); ++v) {
            values[v] = value(sphere.points()(v, 0), sphere.points()(v, 1), sphere.points()(v, 2));
        }
        return values;
    }
};
const std::vector<Harmonic> harmonics{
    {1, [](double x, double y, double z) { return x + 2.0 * y - z; }},
    {2, [](double x, double y, double z) { return x * y + z * z - x * x; }},
    {3, [](double x, double /*y*/, double z) { return x * (5.0 * z * z - 1.0); }}};

void expect_order_two(const std::vector<double>& widths, const std::vector<double>& errors,
                      const std::string& name) {
    const double order = fitted_order(widths, errors);
    EXPECT_GE(order, 1.9) << name << fmt::format(": {}", fmt::join(errors, " "));
    // The coarsest meshes may do better than the order; the finest two must not do worse.
    const std::size_t n = errors.size();
    const double last = std::log(errors[n - 2] / errors[n - 1]) / std::log(widths[n - 2] / widths[n - 1]);
    EXPECT_GE(last, 1.9) << name << fmt::format(": {}", fmt::join(errors, " "));
    ::testing::Test::RecordProperty("order_" + name, std::to_string(order));
}

TEST(EvolutionConvergence, HarmonicsDecayUnderHeat) {
    for (const Harmonic& harmonic : harmonics) {
        const double time = 1.0 / harmonic.eigenvalue();
        std::vector<double> widths;
        std::vector<double> errors;
        for (const int level : {1, 2, 3, 4}) {
            const Mesh sphere = shapes::icosphere(level);
            const Vector initial = harmonic.on(sphere);
            // Steps so small that their error is far below that of the finest mesh.
            const Block u = heat(Laplacian(sphere), initial, Constraints(),
                                 {.time = time, .steps = 400, .method = TimeMethod::bdf2})
                                .u;
            widths.push_back(std::pow(0.5, level));
            errors.push_back(l2_norm(lumped_mass(sphere), Vector(u.col(0) - std::exp(-1.0) * initial)));
        }
        expect_order_two(widths, errors, "heat_l" + std::to_string(harmonic.l));
    }
}

TEST(EvolutionConvergence, HarmonicsSwingAtTheirFrequency) {
    for (const Harmonic& harmonic : harmonics) {
        const double omega = std::sqrt(harmonic.eigenvalue());
        const double time = 2.0 / omega;
        std::vector<double> widths;
        std::vector<double> errors;
        std::vector<double> frequency_errors;
        for (const int level : {1, 2, 3, 4}) {
            const Mesh sphere = shapes::icosphere(level);
            const Vector initial = harmonic.on(sphere);
            const Block u = wave(Laplacian(sphere), initial, Constraints(),
                                 {.time = time, .steps = 400, .method = TimeMethod::implicit_midpoint})
                                .u;
            const Vector mass = lumped_mass(sphere);
            const double amplitude =
                initial.dot(mass.asDiagonal() * u.col(0)) / initial.dot(mass.asDiagonal() * initial);
            widths.push_back(std::pow(0.5, level));
            errors.push_back(l2_norm(mass, Vector(u.col(0) - std::cos(2.0) * initial)));
            // Midpoint turns a frequency w into 2/dt atan(w dt/2): taken back, what is left is of the mesh.
            const double dt = time / 400;
            const double frequency = 2.0 / dt * std::tan(0.5 * dt * std::acos(amplitude) / time);
            frequency_errors.push_back(std::abs(frequency - omega));
        }
        expect_order_two(widths, errors, "wave_l" + std::to_string(harmonic.l));
        expect_order_two(widths, frequency_errors, "frequency_l" + std::to_string(harmonic.l));
    }
}

// Against the exact evolution of the semi-discrete problem, so that nothing but the time steps errs.
class TimeOrder : public ::testing::TestWithParam<TimeMethod> {
  protected:
    static double measured(const Pde& pde, const std::function<double(double, double)>& mode) {
        const Mesh sphere = shapes::icosphere(2);
        const Laplacian laplacian(sphere, {.renumber = false});
        const Eigen::MatrixXd K = dense(laplacian.stiffness().to_sparse());
        const Eigen::MatrixXd M = laplacian.mass().asDiagonal();
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(K, M);
        const Vector initial = harmonics[0].on(sphere) + harmonics[1].on(sphere);
        const double time = 0.5;
        Vector coefficients = eigen.eigenvectors().transpose() * (M * initial);
        for (Eigen::Index i = 0; i < coefficients.size(); ++i)
            coefficients[i] *= mode(std::max(0.0, eigen.eigenvalues()[i]), time);
        const Vector exact = eigen.eigenvectors() * coefficients;
        std::vector<double> steps;
        std::vector<double> errors;
        for (const int count : {20, 40, 80, 160}) {
            const EvolveOptions options{
                .time = time, .steps = count, .method = GetParam(), .linear = {.tolerance = 1e-13}};
            const Block still = Block::Zero(sphere.vertex_count(), 1);
            const Block u = evolve(laplacian, pde, initial, still, Constraints(), options).u;
            steps.push_back(time / count);
            errors.push_back(l2_norm(laplacian.mass(), Vector(u.col(0) - exact)));
        }
        return fitted_order(steps, errors);
    }
    static double expected() { return GetParam() == TimeMethod::backward_euler ? 1.0 : 2.0; }
};

TEST_P(TimeOrder, OfHeat) {
    const double order =
        measured({.beta_1 = 1.0}, [](double lambda, double t) { return std::exp(-lambda * t); });
    EXPECT_NEAR(order, expected(), 0.12);
    RecordProperty("order", std::to_string(order));
}

TEST_P(TimeOrder, OfWaves) {
    const double order =
        measured({.alpha = 1.0}, [](double lambda, double t) { return std::cos(std::sqrt(lambda) * t); });
    EXPECT_NEAR(order, expected(), 0.12);
    RecordProperty("order", std::to_string(order));
}

// u'' + 2 c u' + lambda u = 0 from rest, with c = (beta_1 + beta_2 lambda) / 2.
TEST_P(TimeOrder, OfDampedWaves) {
    const double order = measured({.alpha = 1.0, .beta_1 = 0.5, .beta_2 = 0.05}, [](double lambda, double t) {
        const double c = 0.5 * (0.5 + 0.05 * lambda);
        const double square = lambda - c * c;
        const double s = std::sqrt(std::abs(square));
        if (square > 0.0) return std::exp(-c * t) * (std::cos(s * t) + c / s * std::sin(s * t));
        return std::exp(-c * t) * (std::cosh(s * t) + c / s * std::sinh(s * t));
    });
    EXPECT_NEAR(order, expected(), 0.12);
    RecordProperty("order", std::to_string(order));
}

INSTANTIATE_TEST_SUITE_P(All, TimeOrder,
                         ::testing::Values(TimeMethod::backward_euler, TimeMethod::implicit_midpoint,
                                           TimeMethod::bdf2),
                         [](const auto& info) {
                             return info.param == TimeMethod::backward_euler      ? "backward_euler"
                                    : info.param == TimeMethod::implicit_midpoint ? "midpoint"
                                                                                  : "bdf2";
                         });

}  // namespace
}  // namespace beltrami
