// Gradient per cell and divergence per vertex of piecewise linear fields.
//
//     Points grad = gradient(mesh, u);              // one vector a cell
//     Vector div = divergence(mesh, grad);          // integrated over each vertex's hat function; equals -K u
//
// With G the gradient and |c| the cells' measures, divergence = -G^T |c|, so K = -div M grad with M = |c| inside.
#pragma once

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

/// m x 3: the constant gradient in each cell, tangent to it, in unit of u / length. u: n values in the mesh's order.
/// Zero in degenerate cells. Throws InputError for a wrong number of values.
Points gradient(const Mesh& mesh, const Vector& u);

/// n: -sum over cells c of |c| (grad hat_i) . X_c, the integral of div X against the hat function of vertex i (with no
/// flux through the boundary). X: m x 3, one vector a cell.
Vector divergence(const Mesh& mesh, const Points& cell_vectors);

/// m x 3: the mean of the vectors (n x 3) at each cell's corners.
Points cell_average(const Mesh& mesh, const Points& vertex_vectors);

}  // namespace beltrami
