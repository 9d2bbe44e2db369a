#include "beltrami/operators/gradient.hpp"

#include <fmt/format.h>

#include <cmath>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/operators/cell_gradients.hpp"

namespace beltrami {

namespace {

void require_rows(Eigen::Index rows, Index expected, const char* of) {
    if (rows == expected) return;
    throw InputError(fmt::format("{} values for {} {}", rows, expected, of),
                     fmt::format("give one for each of the {}", of));
}

}  // namespace

Points gradient(const Mesh& mesh, const Vector& u) {
    require_rows(u.size(), mesh.vertex_count(), "vertices");
    Points result = Points::Zero(mesh.cell_count(), 3);
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        const CellGradients hats = cell_gradients(mesh, c);
        for (Eigen::Index k = 0; k < mesh.cells().cols(); ++k)
            result.row(c) += u[mesh.cells()(c, k)] * hats.row(k);
    }
    return result;
}

Vector divergence(const Mesh& mesh, const Points& cell_vectors) {
    require_rows(cell_vectors.rows(), mesh.cell_count(), "cells");
    Vector result = Vector::Zero(mesh.vertex_count());
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        const CellGradients hats = cell_gradients(mesh, c);
        const double measure = std::abs(signed_measure(mesh, c));
        for (Eigen::Index k = 0; k < mesh.cells().cols(); ++k) {
            result[mesh.cells()(c, k)] -= measure * hats.row(k).dot(cell_vectors.row(c));
        }
    }
    return result;
}

Points cell_average(const Mesh& mesh, const Points& vertex_vectors) {
    require_rows(vertex_vectors.rows(), mesh.vertex_count(), "vertices");
    Points result = Points::Zero(mesh.cell_count(), 3);
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        for (Eigen::Index k = 0; k < mesh.cells().cols(); ++k) {
            result.row(c) +=
                vertex_vectors.row(mesh.cells()(c, k)) / static_cast<double>(mesh.cells().cols());
        }
    }
    return result;
}

}  // namespace beltrami
