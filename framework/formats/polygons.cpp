#include "beltrami/framework/formats/polygons.hpp"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Projection_traits_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <fmt/format.h>
#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <exception>
#include <numbers>
#include <optional>
#include <unordered_set>

namespace beltrami::formats {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Plane = CGAL::Projection_traits_3<Kernel>;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::size_t, Plane>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Plane>;
using Cdt = CGAL::Constrained_Delaunay_triangulation_2<
    Plane, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>, CGAL::No_constraint_intersection_tag>;
using Triangle = std::array<std::size_t, 3>;

class Triangulator {
  public:
    Triangulator(const Polygons& polygons, const std::vector<double>& positions)
        : polygons_(polygons), positions_(positions) {}

    Triangulation run() {
        triangles_.reserve(3 * polygons_.count());
        for (std::size_t p = 0; p < polygons_.count(); ++p) {
            const auto polygon = polygons_[p];
            if (polygon.size() == 3) {
                triangles_.insert(triangles_.end(), polygon.begin(), polygon.end());
            } else {
                split(polygon);
            }
        }
        const auto count = static_cast<Eigen::Index>(triangles_.size() / 3);
        return {Eigen::Map<const Cells>(triangles_.data(), count, 3), notes()};
    }

  private:
    [[nodiscard]] Vector3 position(Index v) const { return Eigen::Map<const Vector3>(&positions_[3 * v]); }

    void split(std::span<const Index> polygon) {
        corners_.clear();
        for (const Index v : polygon) {
            if (corners_.empty() || corners_.back() != v) corners_.push_back(v);
        }
        while (corners_.size() > 1 && corners_.back() == corners_.front())
            corners_.pop_back();
        if (corners_.size() < 3) {
            ++dropped_;
        } else if (corners_.size() == 3) {
            add({0, 1, 2});
            ++reduced_;
        } else {
            ++(corners_.size() == 4 ? quads_ : larger_);
            split_corners();
        }
    }

    void split_corners() {
        std::vector<Triangle> triangles;
        if (corners_.size() == 4) {
            triangles = split_quad();
        } else if (auto delaunay = split_on_plane()) {
            triangles = std::move(*delaunay);
        } else {
            for (std::size_t i = 1; i + 1 < corners_.size(); ++i)
                triangles.push_back({0, i, i + 1});
        }
        for (const Triangle& triangle : triangles)
            add(triangle);
        pieces_ += triangles.size();
    }

    void add(const Triangle& triangle) {
        for (const std::size_t corner : triangle)
            triangles_.push_back(corners_[corner]);
    }

    [[nodiscard]] std::vector<Triangle> split_quad() const {
        const std::array<Vector3, 4> p{position(corners_[0]), position(corners_[1]), position(corners_[2]),
                                       position(corners_[3])};
        const auto normal = [&](int a, int b, int c) { return Vector3((p[b] - p[a]).cross(p[c] - p[a])); };
        const bool first_unfolded = normal(0, 1, 2).dot(normal(0, 2, 3)) > 0;
        const bool second_unfolded = normal(0, 1, 3).dot(normal(1, 2, 3)) > 0;
        const auto angle = [&](int before, int at, int after) {
            const Vector3 u = p[before] - p[at];
            const Vector3 w = p[after] - p[at];
            return std::atan2(u.cross(w).norm(), u.dot(w));
        };
        bool second = second_unfolded;
        if (first_unfolded == second_unfolded) {
            // The angles that a diagonal faces: Delaunay wants their sum small. The margin keeps squares,
            // whose sums differ by rounding alone, from being split at random.
            constexpr double margin = 1e-9;
            const double facing_first = angle(0, 1, 2) + angle(2, 3, 0);
            const double facing_second = angle(3, 0, 1) + angle(1, 2, 3);
            const double difference = facing_first - facing_second;
            second = std::abs(difference) > margin
                         ? difference > 0
                         : (p[1] - p[3]).norm() < (p[0] - p[2]).norm() * (1 - margin);
        }
        if (second) return {{0, 1, 3}, {1, 2, 3}};
        return {{0, 1, 2}, {0, 2, 3}};
    }

    // Newell's normal: twice the vector area, the best plane's for any closed polygon.
    [[nodiscard]] Vector3 vector_area() const {
        Vector3 sum = Vector3::Zero();
        const Vector3 origin = position(corners_[0]);
        for (std::size_t i = 1; i + 1 < corners_.size(); ++i) {
            sum += (position(corners_[i]) - origin).cross(position(corners_[i + 1]) - origin);
        }
        return sum;
    }

    // nullopt where the polygon is not simple on its plane.
    [[nodiscard]] std::optional<std::vector<Triangle>> split_on_plane() const {
        const Vector3 normal = vector_area().normalized();
        if (!normal.allFinite() || normal.isZero()) return std::nullopt;
        try {
            Cdt cdt(Plane(Kernel::Vector_3(normal.x(), normal.y(), normal.z())));
            std::vector<Cdt::Vertex_handle> handles;
            for (std::size_t i = 0; i < corners_.size(); ++i) {
                const Vector3 p = position(corners_[i]);
                handles.push_back(cdt.insert(Kernel::Point_3(p.x(), p.y(), p.z())));
                handles.back()->info() = i;
            }
            if (cdt.number_of_vertices() != corners_.size() || cdt.dimension() != 2) return std::nullopt;
            for (std::size_t i = 0; i < handles.size(); ++i) {
                cdt.insert_constraint(handles[i], handles[(i + 1) % handles.size()]);
            }
            std::vector<Triangle> triangles = inside(cdt);
            if (triangles.size() != corners_.size() - 2) return std::nullopt;
            return triangles;
        } catch (const std::exception&) {  // edges that cross on the plane
            return std::nullopt;
        }
    }

    // The faces that cannot be reached from outside without crossing the polygon.
    static std::vector<Triangle> inside(const Cdt& cdt) {
        std::unordered_set<const void*> outside;
        std::vector<Cdt::Face_handle> stack{cdt.infinite_face()};
        while (!stack.empty()) {
            const Cdt::Face_handle face = stack.back();
            stack.pop_back();
            if (!outside.insert(&*face).second) continue;
            for (int side = 0; side < 3; ++side) {
                if (!cdt.is_constrained({face, side})) stack.push_back(face->neighbor(side));
            }
        }
        std::vector<Triangle> triangles;
        for (const Cdt::Face_handle face : cdt.finite_face_handles()) {
            if (outside.contains(&*face)) continue;
            triangles.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
        }
        return triangles;
    }

    [[nodiscard]] std::vector<std::string> notes() const {
        std::vector<std::string> notes;
        const auto counted = [](std::size_t count, std::string_view one, std::string_view many) {
            return fmt::format("{} {}", count, count == 1 ? one : many);
        };
        const std::string quads = counted(quads_, "quadrilateral", "quadrilaterals");
        if (quads_ + larger_ > 0) {
            const std::string larger = quads_ > 0 ? counted(larger_, "larger polygon", "larger polygons")
                                                  : counted(larger_, "polygon", "polygons");
            notes.push_back(fmt::format("{}{}{} {} split into {} triangles", quads_ > 0 ? quads : "",
                                        quads_ > 0 && larger_ > 0 ? " and " : "", larger_ > 0 ? larger : "",
                                        quads_ + larger_ == 1 ? "was" : "were", pieces_));
        }
        if (reduced_ > 0) {
            notes.push_back(fmt::format("{} with repeated corners became triangles",
                                        counted(reduced_, "polygon", "polygons")));
        }
        if (dropped_ > 0) {
            notes.push_back(fmt::format("{} with fewer than three different corners {} left out",
                                        counted(dropped_, "polygon", "polygons"),
                                        dropped_ == 1 ? "was" : "were"));
        }
        return notes;
    }

    const Polygons& polygons_;
    const std::vector<double>& positions_;
    std::vector<Index> triangles_;
    std::vector<Index> corners_;  ///< of the polygon at hand
    std::size_t quads_ = 0, larger_ = 0, pieces_ = 0, reduced_ = 0, dropped_ = 0;
};

}  // namespace

Triangulation triangulate(const Polygons& polygons, const std::vector<double>& positions) {
    return Triangulator(polygons, positions).run();
}

}  // namespace beltrami::formats
