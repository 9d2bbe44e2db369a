// The point of a surface that is closest to a point in space: where a contact or a click lands.
//
//     const SurfaceSearch search(mesh);                      // O(n log n)
//     const SurfacePoint hit = search.closest({0.1, 0.2, 0.3});
//     u = hit.weights[0] * u.row(hit.vertices[0]) + ...      // any field there
//
// Triangles, and the boundary of tetrahedra; cells without area are passed over. CGAL's AABB tree does the search.
#pragma once

#include <array>
#include <memory>

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

struct SurfacePoint {
    std::array<Index, 3> vertices{};  ///< of the triangle, in the user's order
    std::array<double, 3> weights{};  ///< barycentric: not negative, sum 1
    Vector3 point = Vector3::Zero();
    double distance = 0.0;  ///< from the point that was asked for
};

class SurfaceSearch {
  public:
    /// Throws InputError for a mesh without a surface: points, segments, or nothing but degenerate cells.
    explicit SurfaceSearch(const Mesh& mesh);
    SurfaceSearch(SurfaceSearch&&) noexcept;
    SurfaceSearch& operator=(SurfaceSearch&&) noexcept;
    SurfaceSearch(const SurfaceSearch&) = delete;
    SurfaceSearch& operator=(const SurfaceSearch&) = delete;
    ~SurfaceSearch();

    /// Safe from several threads at once. Throws InputError for coordinates that are not finite.
    [[nodiscard]] SurfacePoint closest(const Vector3& point) const;

  private:
    struct Tree;
    std::unique_ptr<const Tree> tree_;
};

}  // namespace beltrami
