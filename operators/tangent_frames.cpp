#include "beltrami/operators/tangent_frames.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/orientation.hpp"

namespace beltrami {

namespace {

/// Normals whose sum is shorter than this part of the sum of their lengths cancel.
constexpr double cancelling = 1e-6;

// Degenerate triangles are in nobody's neighbourhood, so that orientation does not pass through them.
std::vector<Index> proper_triangles(const Mesh& mesh) {
    std::vector<Index> proper;
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (!is_degenerate(mesh, c)) proper.push_back(c);
    }
    return proper;
}

}  // namespace

std::complex<double> TangentFrames::to_number(Index v, const Vector3& vector) const {
    const Vector3 n = normal.row(v);
    const Vector3 x = axis.row(v);
    return {x.dot(vector), n.cross(x).dot(vector)};
}

Vector3 TangentFrames::to_vector(Index v, std::complex<double> number) const {
    const Vector3 n = normal.row(v);
    const Vector3 x = axis.row(v);
    return number.real() * x + number.imag() * n.cross(x);
}

Index TangentFrames::cancelled() const {
    Index count = 0;
    for (Index v = 0; v < static_cast<Index>(normal.rows()); ++v) {
        count += has_plane[static_cast<std::size_t>(v)] == 0 && !normal.row(v).isZero(0.0) ? 1 : 0;
    }
    return count;
}

TangentFrames tangent_frames(const Mesh& mesh) {
    if (mesh.kind() != CellKind::triangle) {
        throw InputError(
            fmt::format("tangent vectors need triangles, but the mesh has {}", plural(mesh.kind())),
            "give a surface of triangles");
    }
    const Index n = mesh.vertex_count();
    const std::vector<Index> proper = proper_triangles(mesh);
    const Cells triangles = mesh.cells()(proper, Eigen::all);
    const Orientation sense = orientation(triangles, Sides(triangles, n));

    TangentFrames frames{Points::Zero(n, 3), Points::Zero(n, 3),
                         std::vector<char>(static_cast<std::size_t>(n), 0),
                         Points::Zero(mesh.cell_count(), 3), sense.one_sided};
    Vector total = Vector::Zero(n);
    Vector largest = Vector::Zero(n);
    Points of_largest = Points::Zero(n, 3);
    for (std::size_t t = 0; t < proper.size(); ++t) {
        const auto triangle = mesh.cells().row(proper[t]);
        const Eigen::RowVector3d p = mesh.points().row(triangle[0]);
        const Eigen::RowVector3d a = mesh.points().row(triangle[1]) - p;
        const Eigen::RowVector3d b = mesh.points().row(triangle[2]) - p;
        const Eigen::RowVector3d doubled = sense.sense[t] * a.cross(b);
        const double size = doubled.norm();
        frames.triangle_normal.row(proper[t]) = doubled / size;
        for (const Index v : triangle) {
            frames.normal.row(v) += doubled;
            total[v] += size;
            if (size > largest[v]) {
                largest[v] = size;
                of_largest.row(v) = doubled / size;
            }
        }
    }
    for (Index v = 0; v < n; ++v) {
        if (total[v] == 0.0) continue;
        const double length = frames.normal.row(v).norm();
        if (length > cancelling * total[v]) {
            frames.normal.row(v) /= length;
            frames.has_plane[static_cast<std::size_t>(v)] = 1;
        } else {
            frames.normal.row(v) = of_largest.row(v);
        }
        const Vector3 normal = frames.normal.row(v);
        int coordinate = 0;
        normal.cwiseAbs().minCoeff(&coordinate);
        frames.axis.row(v) = normal.cross(Vector3::Unit(coordinate)).normalized();
    }
    return frames;
}

Vector3 turned(const Vector3& tangent, const Vector3& from, const Vector3& to, const Vector3& hinge) {
    const double cosine = from.dot(to);
    if (cosine < -1.0 + 1e-12) return 2.0 * hinge.dot(tangent) * hinge - tangent;
    return tangent - to.dot(tangent) / (1.0 + cosine) * (from + to);
}

}  // namespace beltrami
