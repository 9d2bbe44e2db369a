#include "beltrami/operators/singularities.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

using Complex = std::complex<double>;

/// A vector at `from` transported along an edge to `to`.
class Transport {
  public:
    Transport(const Mesh& mesh, const TangentFrames& frames) : mesh_(mesh), frames_(frames) {}

    [[nodiscard]] Complex operator()(Index from, Index to, Complex z) const {
        const Vector3 normal = frames_.normal.row(from);
        const Vector3 other = frames_.normal.row(to);
        const Vector3 edge = mesh_.points().row(to) - mesh_.points().row(from);
        const Vector3 hinge = (edge - normal.dot(edge) * normal).stableNormalized();
        return frames_.to_number(to, turned(frames_.to_vector(from, z), normal, other, hinge));
    }

  private:
    const Mesh& mesh_;
    const TangentFrames& frames_;
};

// Unit numbers; 0 where the field vanishes at a vertex and on the mean around it.
std::vector<Complex> directions(const Mesh& mesh, const TangentFrames& frames, const Block& field) {
    const auto n = static_cast<std::size_t>(mesh.vertex_count());
    std::vector<Complex> numbers(n);
    double longest = 0.0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        numbers[static_cast<std::size_t>(v)] = frames.to_number(v, field.row(v).transpose());
        longest = std::max(longest, std::abs(numbers[static_cast<std::size_t>(v)]));
    }
    const auto is_zero = [&](Complex z) { return std::abs(z) <= 1e-9 * longest; };
    for (Complex& z : numbers)
        z = is_zero(z) ? Complex(0.0) : z / std::abs(z);

    const Transport transport(mesh, frames);
    std::vector<Complex> sum(n, 0.0);
    std::vector<Complex> first(n, 0.0);
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        if (frames.triangle_normal.row(c).isZero(0.0)) continue;
        for (int k = 0; k < 3; ++k) {
            const Index v = mesh.cells()(c, k);
            const auto at = static_cast<std::size_t>(v);
            if (numbers[at] != 0.0) continue;
            for (const int other : {(k + 1) % 3, (k + 2) % 3}) {
                const Index w = mesh.cells()(c, other);
                const Complex there = transport(w, v, numbers[static_cast<std::size_t>(w)]);
                sum[at] += there;
                if (first[at] == 0.0) first[at] = there;
            }
        }
    }
    for (std::size_t v = 0; v < n; ++v) {
        // Around a source directions cancel: any of them will do.
        if (std::abs(sum[v]) < 1e-6) sum[v] = first[v];
        if (sum[v] != 0.0) numbers[v] = sum[v] / std::abs(sum[v]);
    }
    return numbers;
}

// The signed area of the triangle of three unit vectors on the sphere.
double spherical_area(const Vector3& a, const Vector3& b, const Vector3& c) {
    return 2.0 * std::atan2(a.dot(b.cross(c)), 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
}

}  // namespace

Singularities singularities(const Mesh& mesh, const TangentFrames& frames, const Block& field) {
    if (field.rows() != mesh.vertex_count() || field.cols() != 3) {
        throw InputError(fmt::format("a vector field of {} x {} for {} vertices", field.rows(), field.cols(),
                                     mesh.vertex_count()),
                         "give three numbers a vertex");
    }
    if (frames.one_sided) {
        throw InputError("a one-sided surface has no sense of turning, so its singularities have no sign",
                         "cut it open");
    }
    const std::vector<Complex> direction = directions(mesh, frames, field);
    const Transport transport(mesh, frames);
    // From the lower vertex to the higher, so that the two triangles of an edge agree also at half a turn.
    const auto turning = [&](Index a, Index b) {
        const Index low = std::min(a, b);
        const Index high = std::max(a, b);
        const Complex there = transport(low, high, direction[static_cast<std::size_t>(low)]);
        const double angle = std::arg(std::conj(there) * direction[static_cast<std::size_t>(high)]);
        return a < b ? angle : -angle;
    };

    Singularities result;
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        const Vector3 normal = frames.triangle_normal.row(c);
        if (normal.isZero(0.0)) continue;
        Index i = mesh.cells()(c, 0);
        Index j = mesh.cells()(c, 1);
        const Index k = mesh.cells()(c, 2);
        const Vector3 p = mesh.points().row(i);
        const Vector3 q = mesh.points().row(j);
        const Vector3 r = mesh.points().row(k);
        // The triangle as its normal has it.
        if ((q - p).cross(r - p).dot(normal) < 0.0) std::swap(i, j);
        bool defined = true;
        for (const Index v : {i, j, k})
            defined = defined && direction[static_cast<std::size_t>(v)] != 0.0;
        if (!defined) {
            ++result.undefined_triangles;
            continue;
        }
        const double area = spherical_area(frames.normal.row(i), frames.normal.row(j), frames.normal.row(k));
        const double turns =
            (turning(i, j) + turning(j, k) + turning(k, i) + area) / (2.0 * std::numbers::pi);
        const int index = static_cast<int>(std::lround(turns));
        if (index == 0) continue;
        result.list.push_back({c, index, p / 3.0 + q / 3.0 + r / 3.0});
        result.index_sum += index;
    }
    return result;
}

}  // namespace beltrami
