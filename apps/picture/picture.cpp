#include "beltrami/apps/picture/picture.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "beltrami/apps/picture/arrows.hpp"
#include "beltrami/apps/picture/camera.hpp"
#include "beltrami/apps/picture/lettering.hpp"
#include "beltrami/apps/picture/rasterizer.hpp"
#include "beltrami/apps/picture/sheet.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/sides.hpp"

namespace beltrami {

namespace {

constexpr int fewest_pixels = 16;
constexpr int most_pixels = 16384;
constexpr int most_pixels_of_sheet = 32767;

constexpr Colour plain_surface{0.70F, 0.76F, 0.85F};
constexpr Colour plain_line{0.22F, 0.37F, 0.58F};  // thin things need more contrast
constexpr Colour ink{0.08F, 0.08F, 0.10F};         // of lines drawn over a surface

void check(const Mesh& mesh, const Block* field, const PictureOptions& options) {
    for (const int pixels : {options.width, options.height}) {
        if (pixels < fewest_pixels || pixels > most_pixels) {
            throw InputError(
                fmt::format("a picture of {} x {} pixels cannot be drawn", options.width, options.height),
                fmt::format("give {} to {} pixels in both directions", fewest_pixels, most_pixels));
        }
    }
    if (options.range) {
        const auto [low, high] = *options.range;
        if (!std::isfinite(low) || !std::isfinite(high) || low > high) {
            throw InputError(fmt::format("colours cannot range from {} to {}", low, high),
                             "give two finite numbers, the smaller first");
        }
    }
    if (field == nullptr) return;
    if (field->rows() != mesh.vertex_count()) {
        throw InputError(
            fmt::format("the field has {} rows for {} vertices", field->rows(), mesh.vertex_count()),
            "give one row a vertex");
    }
    if (field->cols() != 1 && field->cols() != 3) {
        throw InputError(fmt::format("a field of {} columns cannot be drawn", field->cols()),
                         "give one column of numbers, or three of red, green and blue");
    }
}

void check(const Image& image) {
    const bool has_pixels = image.width > 0 && image.height > 0;
    if (has_pixels && image.rgb.size() == static_cast<std::size_t>(image.width) *
                                              static_cast<std::size_t>(image.height) * 3) {
        return;
    }
    throw InputError(fmt::format("an image of {} x {} pixels with {} bytes is none", image.width,
                                 image.height, image.rgb.size()),
                     "give at least one pixel and three bytes for each");
}

/// What there is to draw: triangles, or rods and balls.
struct Shape {
    Cells triangles{0, 3};
    Cells capsules{0, 2};
    std::vector<Index> vertices;  // that it uses, ascending
};

std::vector<Index> used_vertices(const Cells& cells, Index vertex_count) {
    std::vector<char> used(static_cast<std::size_t>(vertex_count), 0);
    for (Eigen::Index i = 0; i < cells.size(); ++i)
        used[static_cast<std::size_t>(cells.data()[i])] = 1;
    std::vector<Index> vertices;
    for (Index v = 0; v < vertex_count; ++v) {
        if (used[static_cast<std::size_t>(v)] != 0) vertices.push_back(v);
    }
    return vertices;
}

Shape shape_of(const Mesh& mesh) {
    Shape shape;
    switch (mesh.kind()) {
        case CellKind::point:
            shape.capsules.resize(mesh.vertex_count(), 2);
            for (Index v = 0; v < mesh.vertex_count(); ++v)
                shape.capsules.row(v).setConstant(v);
            break;
        case CellKind::segment:
            shape.capsules = mesh.cells();
            break;
        case CellKind::triangle:
            shape.triangles = mesh.cells();
            break;
        case CellKind::tetrahedron:
            shape.triangles = boundary(Sides(proper_cells(mesh), mesh.vertex_count()));
            break;
    }
    const Cells& cells = shape.capsules.rows() > 0 ? shape.capsules : shape.triangles;
    shape.vertices = used_vertices(cells, mesh.vertex_count());
    return shape;
}

/// Triangles that are all seen from the side cover no pixel: their edges, so that there is something to see.
void to_edges(Shape& shape) {
    const Eigen::Index count = shape.triangles.rows();
    shape.capsules.resize(3 * count, 2);
    for (Eigen::Index t = 0; t < count; ++t) {
        for (int k = 0; k < 3; ++k) {
            shape.capsules.row(3 * t + k) << shape.triangles(t, k), shape.triangles(t, (k + 1) % 3);
        }
    }
    shape.triangles.resize(0, 3);
}

bool seen_from_the_side(const Points& positions, const Cells& triangles, const std::vector<Index>& vertices) {
    double area = 0.0;
    double area_in_picture = 0.0;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const Vector3 p = positions.row(triangles(t, 0));
        const Vector3 q = positions.row(triangles(t, 1));
        const Vector3 r = positions.row(triangles(t, 2));
        const Vector3 normal = (q - p).cross(r - p);
        area += normal.norm();
        area_in_picture += std::abs(normal.z());
    }
    if (area_in_picture <= 1e-4 * area) return true;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Eigen::Array2d low(infinity, infinity);
    Eigen::Array2d high = -low;
    for (const Index v : vertices) {
        low = low.min(positions.row(v).head<2>().transpose().array());
        high = high.max(positions.row(v).head<2>().transpose().array());
    }
    return (high - low).minCoeff() < 1.0;
}

/// Nothing where no value is finite.
std::optional<ColourScale> scale_of(const Block& values, const std::vector<Index>& vertices,
                                    const PictureOptions& options) {
    if (options.range) return ColourScale(options.range->first, options.range->second);
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const Index v : vertices) {
        if (!std::isfinite(values(v, 0))) continue;
        low = std::min(low, values(v, 0));
        high = std::max(high, values(v, 0));
    }
    if (low > high) return std::nullopt;
    return ColourScale(low, high);
}

Paint paint_for(const Block* field, const std::optional<ColourScale>& scale, bool thin) {
    if (field == nullptr) return Paint::plain(thin ? plain_line : plain_surface);
    if (field->cols() == 3) return Paint::colours(*field);
    return scale ? Paint::scalar(*field, *scale) : Paint::plain(no_value_colour);
}

double radius_for(const Mesh& mesh, const Shape& shape, int width, int height) {
    const double size = std::min(width, height);
    const double line = std::max(1.0, size / 480.0);
    if (mesh.kind() != CellKind::point) return line;
    // Balls so large that those of a closed surface hide the ones behind it.
    const double count = std::max<double>(1.0, static_cast<double>(shape.vertices.size()));
    return std::clamp(1.15 * std::sqrt(0.5 * width * height / count), line, size / 45.0);
}

/// A picture being made: the title and the bar are in place, the mesh fills the rest.
class Page {
  public:
    Page(const Mesh& mesh, Shape shape, const std::optional<ColourScale>& scale,
         const PictureOptions& options)
        : shape_(std::move(shape)),
          camera_(camera_from(options.view, options.up)),
          edges_(options.edges),
          whole_(blank_image(options.width, options.height)),
          width_(options.width) {
        // Title above and bar beside the drawing, where they leave it most of the picture.
        const double font = std::max(9.0, std::min(options.width, options.height) / 40.0);
        if (!options.title.empty()) {
            const Image title = draw_title(options.title, options.width, 1.15 * font);
            if (4 * title.height <= options.height) {
                place(title, whole_, 0, 0);
                top_ = title.height;
            }
        }
        height_ = options.height - top_;
        if (scale && options.bar && height_ >= 10.0 * font) {
            const Image bar = draw_colour_bar(*scale, height_, font);
            if (3 * bar.width <= options.width) {
                width_ -= bar.width;
                place(bar, whole_, width_, top_);
            }
        }
        radius_ = radius_for(mesh, shape_, width_, height_);
        margin_ = 0.05 * std::min(width_, height_) + (shape_.capsules.rows() > 0 ? radius_ : 0.0);
        positions_ = fit(mesh.points(), shape_.vertices, camera_, width_, height_, margin_);
        if (shape_.triangles.rows() > 0 && seen_from_the_side(positions_, shape_.triangles, shape_.vertices))
            to_edges(shape_);
    }

    /// Vectors (n x 3) at a part of the vertices. Returns the colours of all points there are then.
    Block add_arrows(const Block& vectors, const std::vector<Index>& given, const ColourScale& scale) {
        Eigen::Matrix3d turn;
        turn << camera_.right.transpose(), -camera_.up.transpose(), camera_.toward.transpose();
        const Block seen = vectors * turn.transpose();
        const double spacing = std::max(6.0, std::min(width_, height_) / 26.0);
        Arrows added = arrows(positions_, shape_.vertices, seen, given, scale, spacing, 0.1 * spacing);
        const Eigen::Index n = positions_.rows();
        const Eigen::Index more = added.ends.rows();
        Block colours(n + more, 3);
        colours.topRows(n).rowwise() = Eigen::RowVector3d(0.86, 0.87, 0.89);
        colours.bottomRows(more) = added.colours;
        positions_.conservativeResize(n + more, 3);
        positions_.bottomRows(more) = added.ends;
        added.rods.array() += static_cast<Index>(n);
        const Eigen::Index before = shape_.capsules.rows();
        shape_.capsules.conservativeResize(before + added.rods.rows(), 2);
        shape_.capsules.bottomRows(added.rods.rows()) = added.rods;
        return colours;
    }

    /// Segments between points in the mesh's coordinates, behind those there are.
    void add_lines(const Mesh& mesh, const Mesh& lines) {
        const Eigen::Index n = positions_.rows();
        Points all(n + lines.vertex_count(), 3);
        all << mesh.points(), lines.points();
        std::vector<Index> seen = shape_.vertices;
        for (Index v = 0; v < lines.vertex_count(); ++v)
            seen.push_back(static_cast<Index>(n) + v);
        positions_ = fit(all, seen, camera_, width_, height_, margin_);
        // Half out of the surface that they lie on.
        positions_.bottomRows(lines.vertex_count()).col(2).array() += 0.5 * radius_;
        const Eigen::Index before = shape_.capsules.rows();
        shape_.capsules.conservativeResize(before + lines.cell_count(), 2);
        shape_.capsules.bottomRows(lines.cell_count()) = lines.cells().array() + static_cast<Index>(n);
    }

    Image draw(const Paint& paint, float contrast) {
        const double edge_width = edges_ ? std::max(1.0, std::min(width_, height_) / 800.0) : 0.0;
        std::vector<CornerNormals> normals = corner_normals(positions_, shape_.triangles);
        const Scene scene{positions_, shape_.triangles, std::move(normals),
                          edge_width, shape_.capsules,  radius_,
                          paint,      contrast};
        place(rasterize(scene, width_, height_), whole_, 0, top_);
        return whole_;
    }

  private:
    Shape shape_;
    Camera camera_;
    bool edges_;
    Image whole_;
    int top_ = 0;
    int width_;
    int height_ = 0;
    double radius_ = 0.0;
    double margin_ = 0.0;
    Points positions_;
};

}  // namespace

namespace {

Image draw(const Mesh& mesh, const Block* field, const Mesh* lines, const PictureOptions& options) {
    check(mesh, field, options);
    const Shape shape = shape_of(mesh);
    std::optional<ColourScale> scale;
    if (field != nullptr && field->cols() == 1) scale = scale_of(*field, shape.vertices, options);
    const Paint paint = paint_for(field, scale, shape.capsules.rows() > 0);
    Page page(mesh, shape, scale, options);
    if (lines != nullptr) page.add_lines(mesh, *lines);
    // Light must not be taken for a change of the values.
    return page.draw(paint.with_ink(mesh.vertex_count(), ink), field == nullptr ? 0.6F : 0.4F);
}

}  // namespace

Image draw(const Mesh& mesh, const Block* field, const PictureOptions& options) {
    return draw(mesh, field, nullptr, options);
}

Image draw_lines(const Mesh& mesh, const Block* field, const Mesh& lines, const PictureOptions& options) {
    if (lines.kind() != CellKind::segment) {
        throw InputError(fmt::format("lines of {} cannot be drawn", plural(lines.kind())),
                         "give a mesh of segments");
    }
    return draw(mesh, field, &lines, options);
}

Image draw_vectors(const Mesh& mesh, const Block& vectors, const std::vector<Index>& given,
                   const PictureOptions& options) {
    check(mesh, &vectors, options);
    if (vectors.cols() != 3) {
        throw InputError(fmt::format("vectors of {} columns cannot be drawn", vectors.cols()),
                         "give three numbers a vertex");
    }
    for (const Index v : given) {
        if (v >= 0 && v < mesh.vertex_count()) continue;
        throw InputError(fmt::format("there is no vertex {}", v), "give vertices of the mesh");
    }
    const Shape shape = shape_of(mesh);
    const Block lengths = vectors.rowwise().norm();
    const std::optional<ColourScale> scale = scale_of(lengths, shape.vertices, options);
    Page page(mesh, shape, scale, options);
    if (!scale) return page.draw(Paint::plain(no_value_colour), 0.6F);
    const Paint paint = Paint::colours(page.add_arrows(vectors, given, *scale));
    return page.draw(paint, 0.6F);
}

Image side_by_side(const std::vector<Image>& images, int columns) {
    if (images.empty()) throw InputError("there are no pictures to put side by side", "give at least one");
    if (columns < 1) {
        throw InputError(fmt::format("pictures cannot stand in {} columns", columns),
                         "give at least one column");
    }
    const std::size_t across = std::min(static_cast<std::size_t>(columns), images.size());
    const std::size_t down = (images.size() + across - 1) / across;
    int width = 0;
    int height = 0;
    for (const Image& image : images) {
        check(image);
        width = std::max(width, image.width);
        height = std::max(height, image.height);
    }
    const std::size_t whole_width = across * static_cast<std::size_t>(width);
    const std::size_t whole_height = down * static_cast<std::size_t>(height);
    if (std::max(whole_width, whole_height) > most_pixels_of_sheet) {
        throw InputError(
            fmt::format("{} pictures in {} columns make {} x {} pixels", images.size(), across, whole_width,
                        whole_height),
            fmt::format("draw fewer or smaller pictures: {} pixels are possible in both directions",
                        most_pixels_of_sheet));
    }
    Image whole = blank_image(static_cast<int>(whole_width), static_cast<int>(whole_height));
    for (std::size_t i = 0; i < images.size(); ++i) {
        const int left = static_cast<int>(i % across) * width + (width - images[i].width) / 2;
        const int upper = static_cast<int>(i / across) * height + (height - images[i].height) / 2;
        place(images[i], whole, left, upper);
    }
    return whole;
}

std::string encode_png(const Image& image) {
    check(image);
    return Sheet(image).png();
}

}  // namespace beltrami
