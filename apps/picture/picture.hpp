// Pictures of meshes and the fields on them.
//
//     const Mesh mesh = shapes::icosphere(5);
//     const Block height = mesh.points().col(1);
//     write_picture("sphere.png", draw(mesh, &height, {.view = "iso", .title = "height"}));
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "beltrami/apps/picture/image.hpp"
#include "beltrami/framework/mesh.hpp"

namespace beltrami {

struct PictureOptions {
    int width = 1000;  ///< pixels, 16 to 16384
    int height = 800;
    /// From where to look: front, back, left, right, top, bottom or iso, as `up` has them, or "x,y,z", a
    /// direction in the mesh's coordinates. Front is from +z with y up, from -y with z up.
    std::string view = "front";
    std::string up = "y";  ///< the axis that points up in the picture: x, y or z
    /// The ends of the colour scale of a scalar field; values beyond have the colours of the ends. Without
    /// it, the smallest and largest finite value among the vertices drawn. Pictures to be compared should
    /// share one.
    std::optional<std::pair<double, double>> range = {};
    std::string title = {};  ///< UTF-8, at the top left
    bool edges = false;      ///< draw the edges of the triangles
    bool bar = true;         ///< a colour bar beside scalar fields, if there is room for it
};

/// The mesh on white, seen from infinitely far, as large as it fits; vertices in no cell are left out.
/// Triangles and the surface of tetrahedra are lit on both sides, segments are drawn as lines and points as
/// little balls.
///
/// field: nothing for a plain mesh, n x 1 numbers for colours of the scale (diverging around zero for values
/// of both signs, colour_map.hpp), n x 3 for red, green, blue in [0, 1] as they are. Grey where a value is
/// not finite.
///
/// Throws InputError for options out of range and for a field of another shape. The same input gives the same
/// bytes, whatever the number of threads.
Image draw(const Mesh& mesh, const Block* field, const PictureOptions& options = {});

/// As draw(), with the cells of `lines`, a mesh of segments in the same place, drawn over it as dark lines. Throws as
/// draw(), and InputError for lines of another kind.
Image draw_lines(const Mesh& mesh, const Block* field, const Mesh& lines, const PictureOptions& options = {});

/// A mesh in grey with arrows for the vectors (n x 3) at as many vertices as there is room for, of the colour of their
/// length in the scale, and larger red ones at the vertices `given`; none where a vector is not finite. Throws as
/// draw(), and InputError for vectors of other than three columns and a vertex out of range.
Image draw_vectors(const Mesh& mesh, const Block& vectors, const std::vector<Index>& given,
                   const PictureOptions& options = {});

/// Images row by row in so many columns, each in the middle of a tile as large as the largest needs. Throws
/// InputError for no images, no columns, and more than 32767 pixels in either direction.
Image side_by_side(const std::vector<Image>& images, int columns);

/// A PNG file's content, 8 bits a channel. Throws InputError for an image without pixels, with more than
/// 32767 in either direction, or whose bytes do not match its size.
std::string encode_png(const Image& image);

/// Throws InputError for a name that does not end in .png, a folder that does not exist or cannot be written,
/// a full disk; nothing half-written is left.
void write_picture(const std::filesystem::path& png, const Image& image);

}  // namespace beltrami
