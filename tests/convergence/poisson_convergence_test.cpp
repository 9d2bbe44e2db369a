// Second order in the mesh width for Poisson's equation in the plane, on the sphere and on the torus.
#include <cmath>
#include <numbers>

#include "beltrami/apps/poisson/poisson.hpp"
#include "beltrami/framework/boundary.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/mass.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using std::numbers::pi;
using testing::fitted_order;
using testing::l2_norm;

class Levels {
  public:
    void add(double width, double error) {
        widths_.push_back(width);
        errors_.push_back(error);
    }
    void expect_order_two(const char* name) const {
        ASSERT_GE(widths_.size(), 4U);
        const double order = fitted_order(widths_, errors_);
        EXPECT_GE(order, 1.9) << name;
        EXPECT_LE(order, 2.3) << name << ": so good that something else is measured";
        EXPECT_LT(errors_.back(), 0.02);
        ::testing::Test::RecordProperty(std::string("order_") + name, std::to_string(order));
    }

  private:
    std::vector<double> widths_;
    std::vector<double> errors_;
};

// On closed surfaces u is known up to a constant: one vertex is held, and the means are taken off.
double error_on_closed_surface(const Mesh& mesh, const Vector& exact, const Vector& f) {
    const Laplacian laplacian(mesh);
    const Block u = poisson(laplacian, f, Constraints{{0, exact[0]}}).u;
    const Vector mass = lumped_mass(mesh);
    Vector error = u.col(0) - exact;
    error.array() -= mass.dot(error) / mass.sum();
    return l2_norm(mass, error);
}

TEST(PoissonConvergence, InThePlane) {
    for (const double jitter : {0.0, 0.25}) {
        Levels levels;
        for (const int n : {8, 16, 32, 64}) {
            const Mesh mesh = shapes::jittered(shapes::grid(n, n), jitter);
            const Vector exact =
                (pi * mesh.points().col(0)).array().sin() * (2.0 * pi * mesh.points().col(1)).array().sin();
            const Block f = -5.0 * pi * pi * exact;
            Constraints rim;
            for (const Index v : boundary_vertices(mesh))
                rim.fix(v, exact[v]);
            const Block u = poisson(Laplacian(mesh), f, rim).u;
            levels.add(1.0 / n, l2_norm(lumped_mass(mesh), Vector(u.col(0) - exact)));
        }
        levels.expect_order_two(jitter > 0.0 ? "jittered_plane" : "plane");
    }
}

TEST(PoissonConvergence, OnTheSphere) {
    Levels levels;
    for (const int level : {1, 2, 3, 4, 5}) {
        const Mesh sphere = shapes::icosphere(level);
        const auto x = sphere.points().col(0).array();
        const auto y = sphere.points().col(1).array();
        const auto z = sphere.points().col(2).array();
        // l = 1, 2 and 3 at once.
        const Vector l1 = z;
        const Vector l2 = x * y + x * x - z * z;
        const Vector l3 = x * (5.0 * z * z - 1.0);
        levels.add(std::pow(0.5, level),
                   error_on_closed_surface(sphere, l1 + l2 + l3, -2.0 * l1 - 6.0 * l2 - 12.0 * l3));
    }
    levels.expect_order_two("sphere");
}

TEST(PoissonConvergence, OnTheTorus) {
    const double R = 1.0;
    const double r = 0.4;
    Levels levels;
    for (const int n : {8, 16, 32, 64}) {
        const Mesh torus = shapes::torus(R, r, 3 * n, n);
        Vector exact(torus.vertex_count());
        Vector f(torus.vertex_count());
        for (Index v = 0; v < torus.vertex_count(); ++v) {
            const Vector3 p = torus.points().row(v).transpose();
            const double theta = std::atan2(p.y(), p.x());
            const double phi = std::atan2(p.z(), p.head<2>().norm() - R);
            const double w = R + r * std::cos(phi);
            exact[v] = std::sin(theta) + std::cos(phi);
            // 1 / w^2 u_theta,theta + 1 / (r^2 w) (w u_phi),phi
            f[v] = -std::sin(theta) / (w * w) -
                   (w * std::cos(phi) - r * std::sin(phi) * std::sin(phi)) / (r * r * w);
        }
        levels.add(1.0 / n, error_on_closed_surface(torus, exact, f));
    }
    levels.expect_order_two("torus");
}

TEST(PoissonConvergence, InTheBall) {
    Levels levels;
    for (const int n : {4, 6, 8, 12, 16}) {
        const Mesh ball = shapes::tetrahedral_ball(n);
        const Vector exact = ball.points().rowwise().squaredNorm().array() * ball.points().col(0).array();
        const Block f = 10.0 * ball.points().col(0);  // Laplacian of x r^2
        Constraints skin;
        for (const Index v : boundary_vertices(ball))
            skin.fix(v, exact[v]);
        const Block u = poisson(Laplacian(ball), f, skin).u;
        levels.add(1.0 / n, l2_norm(lumped_mass(ball), Vector(u.col(0) - exact)));
    }
    levels.expect_order_two("ball");
}

}  // namespace
}  // namespace beltrami
