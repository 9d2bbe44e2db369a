#include "beltrami/operators/cell_gradients.hpp"

#include <Eigen/Geometry>

#include "beltrami/framework/cell_geometry.hpp"

namespace beltrami {

CellGradients cell_gradients(const Mesh& mesh, Index cell) {
    const Eigen::Index corners = mesh.cells().cols();
    CellGradients gradients = CellGradients::Zero(corners, 3);
    if (is_degenerate(mesh, cell)) return gradients;
    const auto corner = [&](Eigen::Index k) -> Vector3 {
        return mesh.points().row(mesh.cells()(cell, k)).transpose();
    };
    switch (mesh.kind()) {
        case CellKind::point:
            break;
        case CellKind::segment: {
            const Vector3 along = corner(1) - corner(0);
            gradients.row(1) = (along / along.squaredNorm()).transpose();
            gradients.row(0) = -gradients.row(1);
            break;
        }
        case CellKind::triangle: {
            // The edge opposite to a corner, turned by a quarter in the triangle's plane, over twice the area.
            const Vector3 doubled_area = (corner(1) - corner(0)).cross(corner(2) - corner(0));
            const Vector3 normal = doubled_area / doubled_area.squaredNorm();
            for (Eigen::Index k = 0; k < 3; ++k) {
                gradients.row(k) = normal.cross(corner((k + 2) % 3) - corner((k + 1) % 3)).transpose();
            }
            break;
        }
        case CellKind::tetrahedron: {
            // The inward area vector of the face opposite to a corner, over three times the volume.
            const Vector3 a = corner(1) - corner(0);
            const Vector3 b = corner(2) - corner(0);
            const Vector3 c = corner(3) - corner(0);
            const double six_volumes = a.cross(b).dot(c);
            gradients.row(1) = (b.cross(c) / six_volumes).transpose();
            gradients.row(2) = (c.cross(a) / six_volumes).transpose();
            gradients.row(3) = (a.cross(b) / six_volumes).transpose();
            gradients.row(0) = -(gradients.row(1) + gradients.row(2) + gradients.row(3));
            break;
        }
    }
    return gradients;
}

}  // namespace beltrami
