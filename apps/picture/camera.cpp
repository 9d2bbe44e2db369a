#include "beltrami/apps/picture/camera.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

Camera front_with(std::string_view up) {
    const Vector3 x = Vector3::UnitX();
    const Vector3 y = Vector3::UnitY();
    const Vector3 z = Vector3::UnitZ();
    if (up == "y") return {x, y, z};
    if (up == "z") return {x, z, -y};
    if (up == "x") return {-y, x, z};
    throw InputError(fmt::format("a picture cannot have '{}' up", up), "give x, y or z");
}

std::optional<Vector3> direction_of(std::string_view text) {
    Vector3 direction;
    const char* at = text.data();
    const char* const end = at + text.size();
    for (int k = 0; k < 3; ++k) {
        if (k > 0 && (at == end || *at++ != ',')) return std::nullopt;
        const auto [next, error] = std::from_chars(at, end, direction[k]);
        if (error != std::errc() || !std::isfinite(direction[k])) return std::nullopt;
        at = next;
    }
    const double longest = direction.cwiseAbs().maxCoeff();
    if (at != end || longest == 0.0) return std::nullopt;
    return (direction / longest).normalized();
}

}  // namespace

Camera camera_from(std::string_view view, std::string_view up) {
    const Camera front = front_with(up);
    if (view == "front") return {front.right, front.up, front.toward};
    if (view == "back") return {-front.right, front.up, -front.toward};
    if (view == "right") return {-front.toward, front.up, front.right};
    if (view == "left") return {front.toward, front.up, -front.right};
    if (view == "top") return {front.right, -front.toward, front.up};
    if (view == "bottom") return {front.right, front.toward, -front.up};
    std::optional<Vector3> toward;
    if (view == "iso") {
        toward = (front.right + front.up + front.toward).normalized();
    } else {
        toward = direction_of(view);
    }
    if (!toward) {
        throw InputError(fmt::format("there is no view '{}'", view),
                         "give front, back, left, right, top, bottom, iso, or a direction such as 1,0.5,2");
    }
    Vector3 right = front.up.cross(*toward);
    // Straight from above or below nothing points up; be as top and bottom are.
    if (right.norm() < 1e-9) right = front.right;
    right.normalize();
    return {right, toward->cross(right), *toward};
}

Points fit(const Points& points, const std::vector<Index>& seen, const Camera& camera, double width,
           double height, double margin) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Vector3 low = Vector3::Constant(infinity);
    Vector3 high = -low;
    for (const Index v : seen) {
        low = low.cwiseMin(points.row(v).transpose());
        high = high.cwiseMax(points.row(v).transpose());
    }
    Points placed(points.rows(), 3);
    placed.setZero();
    if (seen.empty()) return placed;

    // To [-1, 1] first, so that neither very large nor very small coordinates leave the range of doubles
    // below.
    const Vector3 centre = 0.5 * low + 0.5 * high;
    const double reach = (0.5 * high - 0.5 * low).maxCoeff();
    if (reach > 0.0) {
        for (const Index v : seen) {
            const Vector3 p = (points.row(v).transpose() - centre) / reach;
            placed.row(v) << camera.right.dot(p), -camera.up.dot(p), camera.toward.dot(p);
        }
    }
    low.setConstant(infinity);
    high = -low;
    for (const Index v : seen) {
        low = low.cwiseMin(placed.row(v).transpose());
        high = high.cwiseMax(placed.row(v).transpose());
    }
    const Vector3 size = high - low;
    const double room_right = std::max(width - 2.0 * margin, 1.0);
    const double room_down = std::max(height - 2.0 * margin, 1.0);
    const double scale = size.head<2>().maxCoeff() > 1e-12 ? std::min(room_right / std::max(size.x(), 1e-12),
                                                                      room_down / std::max(size.y(), 1e-12))
                                                           : 1.0;
    const Vector3 middle = 0.5 * (low + high);
    for (const Index v : seen) {
        const Vector3 p = scale * (placed.row(v).transpose() - middle);
        placed.row(v) << 0.5 * width + p.x(), 0.5 * height + p.y(), p.z();
    }
    return placed;
}

}  // namespace beltrami
