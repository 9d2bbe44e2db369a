// The gradients of the linear hat functions on one cell: what stiffness, gradient and divergence are made of.
#pragma once

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

/// Row k is the gradient of the hat function of corner k, constant over the cell: the matrix B of eq. (20) of Kim &
/// Rossignac. (corners x 3), in 1 / (unit of length). All zero for a degenerate cell.
using CellGradients = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, 4, 3>;

CellGradients cell_gradients(const Mesh& mesh, Index cell);

}  // namespace beltrami
