#include "beltrami/apps/picture/rasterizer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace beltrami {

namespace {

using Eigen::Vector3f;

constexpr int samples = 2;     // a pixel's, in both directions
constexpr int band_rows = 32;  // output rows that are drawn together: bounds the memory of depths and samples

std::size_t at(Index i) {
    return static_cast<std::size_t>(i);
}

/// How light a surface appears whose unit normal (x right, y down, z toward the viewer) is n; 1 where it
/// faces the viewer, so that flat pieces have the very colours of the bar. contrast: how much is lost where
/// no light falls.
float brightness(const Vector3f& n, float contrast) {
    static const Vector3f light = Vector3f(-0.40F, -0.55F, 0.75F).normalized();
    constexpr float key = 0.55F;  // the rest comes from the viewer
    const float lit = key * std::max(0.0F, n.dot(light)) + (1.0F - key * light.z()) * std::max(0.0F, n.z());
    return 1.0F + contrast * (lit - 1.0F);
}

/// A strip of samples with their depths.
class Band {
  public:
    Band(int width, int first_row, int rows)
        : width_(width),
          first_(first_row),
          rows_(rows),
          depth_(static_cast<std::size_t>(width) * static_cast<std::size_t>(rows),
                 -std::numeric_limits<float>::infinity()),
          colour_(depth_.size() * 3, 255) {}

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int first_row() const { return first_; }
    [[nodiscard]] int end_row() const { return first_ + rows_; }

    [[nodiscard]] std::size_t place(int x, int y) const {
        return static_cast<std::size_t>(y - first_) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(x);
    }
    [[nodiscard]] bool hides(std::size_t place, float depth) const { return depth <= depth_[place]; }

    void put(std::size_t place, float depth, const Colour& colour, float light) {
        depth_[place] = depth;
        for (std::size_t k = 0; k < 3; ++k) {
            const float rounded = 0.5F + 255.0F * std::clamp(colour[k] * light, 0.0F, 1.0F);
            colour_[3 * place + k] = static_cast<std::uint8_t>(rounded);
        }
    }

    /// The mean of the samples of each pixel, to the rows of the picture that the band covers.
    void resolve(Image& image) const {
        for (int y = first_ / samples; y < end_row() / samples; ++y) {
            for (int x = 0; x < image.width; ++x) {
                for (std::size_t k = 0; k < 3; ++k) {
                    unsigned sum = samples * samples / 2;
                    for (int s = 0; s < samples * samples; ++s) {
                        sum += colour_[3 * place(samples * x + s % samples, samples * y + s / samples) + k];
                    }
                    const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                                       static_cast<std::size_t>(x);
                    image.rgb[3 * pixel + k] = static_cast<std::uint8_t>(sum / (samples * samples));
                }
            }
        }
    }

  private:
    int width_;
    int first_;
    int rows_;
    std::vector<float> depth_;
    std::vector<std::uint8_t> colour_;
};

/// The samples whose middles lie in [low, high], cut to 0 .. count - 1.
struct Span {
    int first, end;
};
Span span(double low, double high, int first, int end) {
    const double from =
        std::clamp(std::ceil(low - 0.5), static_cast<double>(first), static_cast<double>(end));
    const double to = std::clamp(std::floor(high - 0.5) + 1.0, from, static_cast<double>(end));
    return {static_cast<int>(from), static_cast<int>(to)};
}

/// Where the middle of a line along the rows lies inside all of several half planes a x + b y + c >= 0.
struct HalfPlane {
    double a, b, c;
    [[nodiscard]] double operator()(double x, double y) const { return a * x + b * y + c; }
};

void draw_triangle(const Scene& scene, Index t, Band& band) {
    const Index* vertices = scene.triangles.data() + 3 * static_cast<std::ptrdiff_t>(t);
    std::array<Vector3, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
        p[k] = samples * scene.positions.row(vertices[k]).transpose();
    const double area =
        (p[1] - p[0]).head<2>().x() * (p[2] - p[0]).y() - (p[1] - p[0]).y() * (p[2] - p[0]).x();
    if (!(std::abs(area) > 1e-12)) return;

    // Barycentric coordinates; a sliver of tolerance closes the seams between neighbours.
    constexpr double tolerance = 1e-9;
    std::array<HalfPlane, 3> weight{};
    std::array<double, 3> height{};
    for (std::size_t k = 0; k < 3; ++k) {
        const Vector3& q = p[(k + 1) % 3];
        const Vector3& r = p[(k + 2) % 3];
        weight[k] = {(q.y() - r.y()) / area, (r.x() - q.x()) / area, (q.x() * r.y() - r.x() * q.y()) / area};
        height[k] = std::abs(area) / std::max((r - q).head<2>().norm(), 1e-12);
    }
    const double edge = 0.5 * scene.edge_width * samples;
    const double narrowest = std::min({height[0], height[1], height[2]});
    // Where edges are about as dense as pixels they would only blacken the surface: fade them out.
    float edge_strength = 0.0F;
    if (edge > 0.0) {
        edge_strength = static_cast<float>(0.65 * std::clamp((narrowest / edge - 2.5) / 8.0, 0.0, 1.0));
    }

    const auto [low, high] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
    const Span rows = span(low, high, band.first_row(), band.end_row());
    const CornerNormals& normals = scene.normals[at(t)];
    for (int row = rows.first; row < rows.end; ++row) {
        const double y = row + 0.5;
        double left = 0.0;
        double right = band.width();
        for (const HalfPlane& w : weight) {
            const double rest = w.b * y + w.c + tolerance;
            if (w.a > 0.0) {
                left = std::max(left, -rest / w.a);
            } else if (w.a < 0.0) {
                right = std::min(right, -rest / w.a);
            } else if (rest < 0.0) {
                right = -1.0;
            }
        }
        if (right < left) continue;
        const Span columns = span(left, right, 0, band.width());
        for (int column = columns.first; column < columns.end; ++column) {
            const double x = column + 0.5;
            const std::array<double, 3> w{weight[0](x, y), weight[1](x, y), weight[2](x, y)};
            const auto depth = static_cast<float>(w[0] * p[0].z() + w[1] * p[1].z() + w[2] * p[2].z());
            const std::size_t place = band.place(column, row);
            if (band.hides(place, depth)) continue;
            Vector3f normal = static_cast<float>(w[0]) * normals[0] + static_cast<float>(w[1]) * normals[1] +
                              static_cast<float>(w[2]) * normals[2];
            normal.normalize();
            float light = brightness(normal, scene.contrast);
            if (edge_strength > 0.0F) {
                const double distance = std::min({w[0] * height[0], w[1] * height[1], w[2] * height[2]});
                const auto cover = static_cast<float>(std::clamp(edge + 0.5 - distance, 0.0, 1.0));
                light *= 1.0F - edge_strength * cover;
            }
            band.put(place, depth, scene.paint.mix(vertices, w.data(), 3), light);
        }
    }
}

void draw_capsule(const Scene& scene, Index c, Band& band) {
    const Index* vertices = scene.capsules.data() + 2 * static_cast<std::ptrdiff_t>(c);
    const Vector3 p = samples * scene.positions.row(vertices[0]).transpose();
    const Vector3 q = samples * scene.positions.row(vertices[1]).transpose();
    const double radius = samples * scene.capsule_radius;
    const Vector3 along = q - p;
    const double length_squared = along.head<2>().squaredNorm();
    const auto [low, high] = std::minmax({p.y(), q.y()});
    const Span rows = span(low - radius, high + radius, band.first_row(), band.end_row());
    for (int row = rows.first; row < rows.end; ++row) {
        const double y = row + 0.5;
        // The part of the axis that can be within the radius of this row.
        double s0 = 0.0;
        double s1 = 1.0;
        if (std::abs(along.y()) > 1e-9) {
            const double a = (y - radius - p.y()) / along.y();
            const double b = (y + radius - p.y()) / along.y();
            s0 = std::clamp(std::min(a, b), 0.0, 1.0);
            s1 = std::clamp(std::max(a, b), 0.0, 1.0);
        }
        const auto [left, right] = std::minmax({p.x() + s0 * along.x(), p.x() + s1 * along.x()});
        const Span columns = span(left - radius, right + radius, 0, band.width());
        for (int column = columns.first; column < columns.end; ++column) {
            const Eigen::Vector2d r = Eigen::Vector2d(column + 0.5, y) - p.head<2>();
            const double s =
                length_squared > 0.0 ? std::clamp(r.dot(along.head<2>()) / length_squared, 0.0, 1.0) : 0.0;
            const Eigen::Vector2d offset = (r - s * along.head<2>()) / radius;
            const double outside = offset.squaredNorm();
            if (outside > 1.0) continue;
            const double bulge = std::sqrt(1.0 - outside);
            const auto depth = static_cast<float>(p.z() + s * along.z() + radius * bulge);
            const std::size_t place = band.place(column, row);
            if (band.hides(place, depth)) continue;
            const Vector3f normal(static_cast<float>(offset.x()), static_cast<float>(offset.y()),
                                  static_cast<float>(bulge));
            const std::array<double, 2> w{1.0 - s, s};
            band.put(place, depth, scene.paint.mix(vertices, w.data(), 2),
                     brightness(normal, scene.contrast));
        }
    }
}

/// The primitives (rows of cells) that reach into each band, in ascending order.
std::vector<std::vector<Index>> by_band(const Points& positions, const Cells& cells, double radius,
                                        int height) {
    const int bands = (height + band_rows - 1) / band_rows;
    std::vector<std::vector<Index>> members(static_cast<std::size_t>(bands));
    for (Eigen::Index c = 0; c < cells.rows(); ++c) {
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        for (const Index v : cells.row(c)) {
            low = std::min(low, positions(v, 1) - radius);
            high = std::max(high, positions(v, 1) + radius);
        }
        const double last = bands - 1;
        const int from = static_cast<int>(std::clamp(std::floor(low / band_rows), 0.0, last));
        const int to = static_cast<int>(std::clamp(std::floor(high / band_rows), 0.0, last));
        for (int b = from; b <= to; ++b)
            members[static_cast<std::size_t>(b)].push_back(static_cast<Index>(c));
    }
    return members;
}

}  // namespace

Paint Paint::plain(const Colour& colour) {
    return Paint(colour);
}

Paint Paint::colours(const Block& rgb) {
    Paint paint(no_value_colour);
    paint.colours_.resize(static_cast<std::size_t>(rgb.rows()), no_value_colour);
    for (Eigen::Index i = 0; i < rgb.rows(); ++i) {
        if (!rgb.row(i).allFinite()) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const double c = std::clamp(rgb(i, static_cast<Eigen::Index>(k)), 0.0, 1.0);
            paint.colours_[static_cast<std::size_t>(i)][k] = static_cast<float>(c);
        }
    }
    return paint;
}

Paint Paint::scalar(const Block& values, const ColourScale& scale) {
    Paint paint(no_value_colour);
    paint.scale_ = scale;
    paint.positions_.reserve(static_cast<std::size_t>(values.rows()));
    for (Eigen::Index i = 0; i < values.rows(); ++i)
        paint.positions_.push_back(scale.position(values(i, 0)));
    return paint;
}

Paint Paint::with_ink(Index first, const Colour& ink) const {
    Paint paint = *this;
    paint.first_ink_ = first;
    paint.ink_ = ink;
    return paint;
}

Colour Paint::mix(const Index* vertices, const double* weights, int k) const {
    if (vertices[0] >= first_ink_) return ink_;
    if (scale_) {
        double position = 0.0;
        for (int i = 0; i < k; ++i)
            position += weights[i] * positions_[at(vertices[i])];
        return scale_->colour_at(position);
    }
    if (colours_.empty()) return plain_;
    Colour mean{};
    for (int i = 0; i < k; ++i) {
        const Colour& colour = colours_[at(vertices[i])];
        for (std::size_t j = 0; j < 3; ++j)
            mean[j] += static_cast<float>(weights[i]) * colour[j];
    }
    return mean;
}

std::vector<CornerNormals> corner_normals(const Points& positions, const Cells& triangles) {
    // In units of the largest triangle's size single precision is enough and small triangles do not vanish.
    const Eigen::Index count = triangles.rows();
    std::vector<Vector3f> face(static_cast<std::size_t>(count));  // length: the area
    std::vector<Index> begin(static_cast<std::size_t>(positions.rows()) + 1, 0);
    for (Eigen::Index t = 0; t < count; ++t) {
        const Vector3 p = positions.row(triangles(t, 0));
        const Vector3 q = positions.row(triangles(t, 1));
        const Vector3 r = positions.row(triangles(t, 2));
        face[static_cast<std::size_t>(t)] = (q - p).cross(r - p).cast<float>();
        for (const Index v : triangles.row(t))
            ++begin[at(v) + 1];
    }
    for (std::size_t v = 0; v + 1 < begin.size(); ++v)
        begin[v + 1] += begin[v];
    std::vector<Index> around(static_cast<std::size_t>(3 * count));
    std::vector<Index> next(begin.begin(), begin.end() - 1);
    for (Eigen::Index t = 0; t < count; ++t) {
        for (const Index v : triangles.row(t))
            around[at(next[at(v)]++)] = static_cast<Index>(t);
    }

    constexpr float crease = 0.643F;       // cos 50 degrees
    constexpr Index most_neighbours = 64;  // every triangle looks at all others of its vertices: not at a hub
    std::vector<CornerNormals> normals(static_cast<std::size_t>(count));
#pragma omp parallel for schedule(static)
    for (Eigen::Index t = 0; t < count; ++t) {
        const auto own = static_cast<std::size_t>(t);
        Vector3f n = face[own];
        const float length = n.norm();
        if (!(length > 0.0F)) {
            normals[own].fill(Vector3f::Zero());
            continue;
        }
        n /= n.z() < 0.0F ? -length : length;
        for (int k = 0; k < 3; ++k) {
            const Index v = triangles(t, k);
            Vector3f sum = Vector3f::Zero();
            if (begin[at(v) + 1] - begin[at(v)] <= most_neighbours) {
                for (Index i = begin[at(v)]; i < begin[at(v) + 1]; ++i) {
                    const Vector3f& other = face[at(around[at(i)])];
                    const float cosine = other.dot(n);
                    if (std::abs(cosine) < crease * other.norm()) continue;
                    sum += cosine < 0.0F ? Vector3f(-other) : other;
                }
            }
            const float sum_length = sum.norm();
            normals[own][static_cast<std::size_t>(k)] = sum_length > 0.0F ? Vector3f(sum / sum_length) : n;
        }
    }
    return normals;
}

Image rasterize(const Scene& scene, int width, int height) {
    const auto triangles = by_band(scene.positions, scene.triangles, 0.0, height);
    const auto capsules = by_band(scene.positions, scene.capsules, scene.capsule_radius, height);
    Image image = blank_image(width, height);
    const int bands = static_cast<int>(triangles.size());
    // Bands share nothing, so the picture does not depend on the number of threads.
#pragma omp parallel for schedule(dynamic, 1)
    for (int b = 0; b < bands; ++b) {
        const int first = b * band_rows;
        const int rows = std::min(band_rows, height - first);
        Band band(samples * width, samples * first, samples * rows);
        for (const Index t : triangles[static_cast<std::size_t>(b)])
            draw_triangle(scene, t, band);
        for (const Index c : capsules[static_cast<std::size_t>(b)])
            draw_capsule(scene, c, band);
        band.resolve(image);
    }
    return image;
}

}  // namespace beltrami
