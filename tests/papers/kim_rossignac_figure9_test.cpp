// Figure 9 of Kim & Rossignac, "Localized bi-Laplacian Solver on a Triangle Mesh and Its Applications": displacements
// interpolated by the bi-Laplacian over a surface that is no manifold, sheets that meet along a line.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "beltrami/apps/interpolate/interpolate.hpp"
#include "beltrami/framework/boundary.hpp"
#include "beltrami/framework/shapes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

const InterpolateOptions bilaplacian_only{.laplacian = 0.0, .bilaplacian = 1.0};

Index nearest_vertex(const Mesh& mesh, const Vector3& place) {
    Index nearest = 0;
    (mesh.points().rowwise() - place.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
    return nearest;
}

class Figure9 : public ::testing::TestWithParam<int> {
  protected:
    // The outer rims stay, the middle of the line where the fins meet is moved.
    [[nodiscard]] Constraints pushed(const Vector3& displacement) const {
        Constraints fixed(3);
        for (const Index v : boundary_vertices(fins_)) {
            if (fins_.points().row(v).head<2>().norm() > 1.0 - 1e-9) fixed.fix(v, std::array{0.0, 0.0, 0.0});
        }
        fixed.fix(nearest_vertex(fins_, Vector3(0.0, 0.0, 0.5)),
                  std::array{displacement[0], displacement[1], displacement[2]});
        return fixed;
    }

    Mesh fins_ = shapes::fins(GetParam(), 8);
    Laplacian laplacian_{fins_};
};

TEST_P(Figure9, IsTheDenseSolution) {
    const Constraints fixed = pushed({0.1, -0.2, 0.3});
    const InterpolateResult result = interpolate(laplacian_, fixed, bilaplacian_only);
    const Eigen::MatrixXd K = testing::reference_stiffness(fins_);
    const Eigen::MatrixXd A = K * lumped_mass(fins_).cwiseInverse().asDiagonal() * K;
    Block expected = Block::Zero(fins_.vertex_count(), 3);
    fixed.impose(expected);
    std::vector<Index> free;
    for (Index v = 0; v < fins_.vertex_count(); ++v) {
        if (!fixed.is_fixed(v)) free.push_back(v);
    }
    const Eigen::MatrixXd A_ff = A(free, free);
    const Eigen::MatrixXd all = -A * expected;
    const Eigen::MatrixXd load = all(free, Eigen::all);
    const Eigen::MatrixXd solved = A_ff.partialPivLu().solve(load);
    for (std::size_t i = 0; i < free.size(); ++i)
        expected.row(free[i]) = solved.row(static_cast<Eigen::Index>(i));
    EXPECT_LT(testing::relative_difference(result.value, expected), 1e-8);
}

// A turn about the line takes each fin to the next, and the answer with it.
TEST_P(Figure9, AllFinsAnswerAlike) {
    const Block value = interpolate(laplacian_, pushed({0.0, 0.0, 0.3}), bilaplacian_only).value;
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(2.0 * M_PI / GetParam(), Vector3::UnitZ()).toRotationMatrix();
    double largest = 0.0;
    for (Index v = 0; v < fins_.vertex_count(); ++v) {
        const Vector3 place = turn * fins_.points().row(v).transpose();
        const Index other = nearest_vertex(fins_, place);
        ASSERT_LT((fins_.points().row(other).transpose() - place).norm(), 1e-9);
        EXPECT_LT((value.row(other) - value.row(v)).norm(), 1e-10);
        if (fins_.points().row(v).head<2>().norm() > 0.4) largest = std::max(largest, value(v, 2));
    }
    EXPECT_GT(largest, 0.1) << "the push reaches far into the fins";
    EXPECT_NEAR(value.leftCols(2).cwiseAbs().maxCoeff(), 0.0, 1e-12);
}

// Smooth at the point that is pushed, line or no line: the bi-Laplacian falls less than the Laplacian beside it.
TEST_P(Figure9, ThereIsNoSpikeOnTheLine) {
    const Constraints fixed = pushed({0.0, 0.0, 1.0});
    const Index beside = nearest_vertex(fins_, Vector3(0.0, 0.0, 0.5 + 1.0 / 8.0));
    const double plate = interpolate(laplacian_, fixed, bilaplacian_only).value(beside, 2);
    const double film = interpolate(laplacian_, fixed).value(beside, 2);
    EXPECT_GT(plate, 0.9);
    EXPECT_LT(film, 0.8);
}

INSTANTIATE_TEST_SUITE_P(Fins, Figure9, ::testing::Values(3, 4, 5));

}  // namespace
}  // namespace beltrami
