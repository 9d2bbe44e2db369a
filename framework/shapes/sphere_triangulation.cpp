// CGAL compiles slowly, so it keeps to this file.
#include "beltrami/framework/shapes/sphere_triangulation.hpp"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/hilbert_sort.h>

#include <utility>
#include <vector>

namespace beltrami::shapes {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangulation = CGAL::Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<CGAL::Triangulation_vertex_base_with_info_2<Index, Kernel>>>;

}  // namespace

void sort_along_curve(Points& points) {
    std::vector<Kernel::Point_3> sorted;
    sorted.reserve(static_cast<std::size_t>(points.rows()) - 1);
    for (Eigen::Index i = 1; i < points.rows(); ++i)
        sorted.emplace_back(points(i, 0), points(i, 1), points(i, 2));
    CGAL::hilbert_sort(sorted.begin(), sorted.end());
    Eigen::Index row = 0;
    for (const Kernel::Point_3& p : sorted)
        points.row(++row) << p.x(), p.y(), p.z();
}

Cells triangulate_sphere(const Points& points) {
    // Stereographic projection from the pole takes circles to circles: the hull's triangles that avoid the pole are the
    // Delaunay triangles of the plane, and the plane's vertex at infinity is the pole.
    std::vector<std::pair<Kernel::Point_2, Index>> plane;
    plane.reserve(static_cast<std::size_t>(points.rows()) - 1);
    for (Eigen::Index i = 1; i < points.rows(); ++i) {
        const double x = points(i, 0);
        const double y = points(i, 1);
        const double z = points(i, 2);
        // 1 / (1 - z) without cancellation.
        const double scale = z > 0.0 ? (1.0 + z) / (x * x + y * y) : 1.0 / (1.0 - z);
        plane.emplace_back(Kernel::Point_2(scale * x, scale * y), static_cast<Index>(i));
    }
    Triangulation triangulation(plane.begin(), plane.end());
    triangulation.infinite_vertex()->info() = 0;
    Cells cells(static_cast<Eigen::Index>(triangulation.tds().number_of_faces()), 3);
    Eigen::Index row = 0;
    for (auto face = triangulation.all_faces_begin(); face != triangulation.all_faces_end(); ++face) {
        // The plane is seen from the pole, so from inside.
        cells.row(row++) << face->vertex(0)->info(), face->vertex(2)->info(), face->vertex(1)->info();
    }
    return cells;
}

}  // namespace beltrami::shapes
