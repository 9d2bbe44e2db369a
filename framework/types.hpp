// Number types and dense arrays shared by every room.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace beltrami {

/// Vertices, edges and cells are numbered from 0 with 32-bit integers.
using Index = std::int32_t;

/// One number a vertex (n) or an edge (m).
using Vector = Eigen::VectorXd;

/// k numbers a vertex: n x k, row-major, so that the k values of a vertex lie together.
template <class Scalar>
using BlockOf = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Block = BlockOf<double>;

/// Positions, n x 3, in the length unit of the file.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Vector3 = Eigen::Vector3d;

/// Vertex numbers of the cells, m x (1 point | 2 segment | 3 triangle | 4 tetrahedron).
using Cells = Eigen::Matrix<Index, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A value on every vertex under a name: n x 1 for a scalar, n x 3 for a vector or a colour.
struct Field {
    std::string name;
    Block values;
};
using Fields = std::vector<Field>;

}  // namespace beltrami
