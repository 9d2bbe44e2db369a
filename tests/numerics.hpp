// What the tests of operators and solvers compute with: random fields, fitted orders, dense references made
// another way.
#pragma once

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "beltrami/framework/edge_graph.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/framework/types.hpp"

namespace beltrami::testing {

/// Numbers in [-1, 1], the same on every machine.
inline Block random_block(Index rows, Index columns, std::uint32_t seed = 1) {
    std::mt19937 engine(seed);
    return Block::NullaryExpr(rows, columns, [&] { return 2.0 * (engine() / 4294967295.0) - 1.0; });
}
inline Vector random_vector(Index rows, std::uint32_t seed = 1) {
    return random_block(rows, 1, seed).col(0);
}

/// The slope of log(error) over log(width) by least squares.
inline double fitted_order(const std::vector<double>& widths, const std::vector<double>& errors) {
    const auto n = static_cast<Eigen::Index>(widths.size());
    const Eigen::ArrayXd x = Eigen::Map<const Eigen::ArrayXd>(widths.data(), n).log();
    const Eigen::ArrayXd y = Eigen::Map<const Eigen::ArrayXd>(errors.data(), n).log();
    return ((x - x.mean()) * (y - y.mean())).sum() / (x - x.mean()).square().sum();
}

/// The discrete L2 norm: (sum of mass_i e_i^2)^(1/2), over all columns.
template <class Mass, class Error>
double l2_norm(const Mass& mass, const Error& error) {
    return std::sqrt((mass.asDiagonal() * error.cwiseAbs2()).sum());
}

/// The largest |a - b|, relative to the largest |b|.
template <class A, class B>
double relative_difference(const A& a, const B& b) {
    if (a.rows() != b.rows() || a.cols() != b.cols()) return INFINITY;
    if (b.size() == 0) return 0.0;
    const double difference = (a - b).cwiseAbs().maxCoeff();
    const double scale = b.cwiseAbs().maxCoeff();
    return scale > 0.0 ? difference / scale : difference;
}

inline std::shared_ptr<const EdgeGraph> graph_of(const Mesh& mesh) {
    return std::make_shared<const EdgeGraph>(mesh.vertex_count(), mesh.cells());
}

template <class Scalar>
auto dense(const Eigen::SparseMatrix<Scalar>& matrix) {
    return Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>(matrix);
}

/// Length, area or volume from the Gram matrix of a cell's edges, and with it the stiffness of a linear
/// element of any dimension: the inner products of barycentric gradients are the inverse Gram matrix.
struct ReferenceElement {
    double measure;
    Eigen::MatrixXd stiffness;
};
inline ReferenceElement reference_element(const Mesh& mesh, Index cell) {
    const Eigen::Index d = mesh.cells().cols() - 1;
    Eigen::MatrixXd edges(d, 3);
    for (Eigen::Index k = 0; k < d; ++k) {
        edges.row(k) =
            mesh.points().row(mesh.cells()(cell, k + 1)) - mesh.points().row(mesh.cells()(cell, 0));
    }
    const Eigen::MatrixXd gram = edges * edges.transpose();
    const double measure = std::sqrt(gram.determinant()) / std::tgamma(static_cast<double>(d) + 1.0);
    Eigen::MatrixXd differences(d, d + 1);  // barycentric coordinates 1..d from the values at corners 0..d
    differences << Eigen::VectorXd::Constant(d, -1.0), Eigen::MatrixXd::Identity(d, d);
    return {measure, measure * (differences.transpose() * gram.inverse() * differences)};
}

/// The stiffness of the mesh, element by element into a dense matrix; each element times its measure to a
/// power.
inline Eigen::MatrixXd reference_stiffness(const Mesh& mesh, int power_of_measure = 0) {
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(mesh.vertex_count(), mesh.vertex_count());
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        const auto [measure, element] = reference_element(mesh, c);
        for (Eigen::Index a = 0; a < element.rows(); ++a) {
            for (Eigen::Index b = 0; b < element.cols(); ++b) {
                K(mesh.cells()(c, a), mesh.cells()(c, b)) +=
                    std::pow(measure, power_of_measure) * element(a, b);
            }
        }
    }
    return K;
}

/// Turned about a skew axis and moved away.
inline Mesh rigidly_moved(const Mesh& mesh) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.7, Vector3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
    const Points moved = (mesh.points() * turn.transpose()).rowwise() + Eigen::RowVector3d(3.0, -1.0, 2.0);
    return mesh.with_points(moved);
}

inline Mesh scaled(const Mesh& mesh, double factor) {
    return mesh.with_points(factor * mesh.points());
}

}  // namespace beltrami::testing
