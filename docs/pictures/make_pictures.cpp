// Makes the pictures of the README and of docs/: ./dev pictures
//
// Also an example: everything below is the public library.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"

namespace {

using namespace beltrami;

Index nearest_vertex(const Mesh& mesh, const Vector3& place) {
    Index nearest = 0;
    (mesh.points().rowwise() - place.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
    return nearest;
}

// The Stanford bunny of Debian's glmark2-data: heat, a wave and an interpolation.
Image overview() {
    const Mesh bunny = read_mesh("/usr/share/glmark2/models/bunny.obj");
    const Laplacian laplacian(bunny);
    const Index eye = nearest_vertex(bunny, {-0.62, 0.42, 0.42});
    const Index haunch = nearest_vertex(bunny, {0.45, -0.35, 0.7});
    const Index ear = nearest_vertex(bunny, {0.2, 0.95, 0.0});
    const Index tail = nearest_vertex(bunny, {1.0, -0.6, 0.0});
    const Block zero = Block::Zero(bunny.vertex_count(), 1);
    PictureOptions picture{.width = 640, .height = 560};

    const Block warm = heat(laplacian, zero, {{eye, 100.0}, {haunch, 100.0}},
                            {.time = 0.4, .steps = 20, .method = TimeMethod::bdf2})
                           .u;
    picture.title = "heat: u_t = Laplacian of u, two vertices held at 100";
    picture.range = {0.0, 40.0};
    const Image heat_picture = draw(bunny, &warm, picture);

    const Block moved =
        wave(laplacian, zero, {{haunch, 1.0}},
             {.time = 0.9, .steps = 150, .method = TimeMethod::implicit_midpoint}, {.beta_2 = 2e-3})
            .u;
    picture.title = "wave: u_tt = Laplacian of u, after an impulse";
    picture.range = {-0.8, 0.8};
    const Image wave_picture = draw(bunny, &moved, picture);

    const auto [value, summary] = interpolate(laplacian, {{eye, 1.0}, {haunch, 0.0}, {ear, 0.5}, {tail, 1.0}},
                                              {.laplacian = 1.0, .bilaplacian = 0.05});
    picture.title = "interpolation of four values";
    picture.range.reset();
    const Image interpolation_picture = draw(bunny, &value, picture);
    fmt::print("overview: {}\n", summary.brief());
    return side_by_side({heat_picture, wave_picture, interpolation_picture}, 3);
}

// Displacements of a plate whose rim is held, as in Figure 8 of Kim & Rossignac: two vertices are lifted by one.
Image figure_8() {
    constexpr int cells = 80;
    constexpr double width = 4.0;
    const Mesh plate = shapes::grid(cells, cells, width, width, true);
    const Laplacian laplacian(plate);
    Constraints lifted;
    for (const Index v : boundary_vertices(plate))
        lifted.fix(v, 0.0);
    lifted.fix(nearest_vertex(plate, {1.5, 2.0, 0.0}), 1.0);
    lifted.fix(nearest_vertex(plate, {2.5, 2.0, 0.0}), 1.0);

    const std::vector<std::pair<std::string, InterpolateOptions>> cases = {
        {"Laplacian", {.laplacian = 1.0, .bilaplacian = 0.0}},
        {"bi-Laplacian", {.laplacian = 0.0, .bilaplacian = 1.0}},
        {"mixed, 1 and 0.1", {.laplacian = 1.0, .bilaplacian = 0.1}},
    };
    std::vector<Image> images;
    for (const auto& [title, options] : cases) {
        const Block height = interpolate(laplacian, lifted, options).value;
        Points points = plate.points();
        points.col(2) = height.col(0);
        PictureOptions picture{.width = 640, .height = 480, .view = "-1,-2.2,1.2", .up = "z"};
        picture.title = fmt::format("{}: from {:.3f} to {:.3f}", title, height.minCoeff(), height.maxCoeff());
        picture.range = {0.0, 1.15};
        picture.edges = true;
        images.push_back(draw(plate.with_points(points), &height, picture));
        fmt::print("figure 8, {}\n", picture.title);
    }
    return side_by_side(images, 3);
}

// A vector field from four vectors, as in Figure 11 of Kim & Rossignac.
Image figure_11() {
    const Mesh bunny = read_mesh("/usr/share/glmark2/models/bunny.obj");
    const Laplacian laplacian(bunny);
    Constraints fixed(3);
    const auto fix = [&](const Vector3& place, const std::array<double, 3>& vector) {
        fixed.fix(nearest_vertex(bunny, place), vector);
    };
    fix({-0.62, 0.42, 0.42}, {0.3, -1.0, 0.0});
    fix({0.45, -0.35, 0.7}, {1.0, 0.0, 0.0});
    fix({-0.2, -0.3, 0.6}, {0.0, -1.0, 0.0});
    fix({1.0, -0.6, 0.0}, {0.0, 1.0, 0.0});

    const std::vector<std::pair<std::string, VectorsOptions>> cases = {
        {"coordinates", {.method = VectorMethod::coordinates, .bilaplacian = 0.05}},
        {"connection, lengths solved", {.lengths = VectorLengths::solved, .bilaplacian = 0.05}},
        {"connection, lengths interpolated", {.bilaplacian = 0.05}},
    };
    std::vector<Image> images;
    for (const auto& [title, options] : cases) {
        const VectorsResult result = vectors(bunny, laplacian, fixed, options);
        Block length = result.vectors.rowwise().norm();
        std::nth_element(length.data(), length.data() + length.size() / 2, length.data() + length.size());
        PictureOptions picture{.width = 560, .height = 490};
        picture.title = fmt::format("{}: median length {:.2f}", title, length(length.size() / 2, 0));
        picture.range = {0.0, 1.2};
        images.push_back(draw_vectors(bunny, result.vectors, fixed.vertices(), picture));
        fmt::print("figure 11, {}, {} singularities, sum {}, {:.0f} degrees off\n", picture.title,
                   result.singularities.list.size(), result.singularities.index_sum, result.largest_tilt);
    }
    return side_by_side(images, 3);
}

// An egg whose lower half is fixed, as in Figure 6 of Kim & Rossignac.
Image figure_6() {
    Points tall = shapes::icosphere(4).points();
    tall.col(2) = tall.col(2).unaryExpr([](double z) { return z > 0.0 ? 1.5 * z : z; });
    const Mesh egg = shapes::icosphere(4).with_points(tall);
    std::vector<Image> images;
    const Laplacian laplacian(egg);
    std::vector<Index> upper;
    for (Index v = 0; v < egg.vertex_count(); ++v) {
        if (egg.points()(v, 2) > 1e-9) upper.push_back(v);
    }
    const auto add = [&](const std::string& title, const Points& points) {
        PictureOptions picture{.width = 480, .height = 480, .view = "1,-2,1.6", .up = "z"};
        picture.title = title;
        picture.edges = true;
        images.push_back(draw(egg.with_points(points), nullptr, picture));
    };
    add("an egg", egg.points());
    add("fair: Laplacian", fair(egg, laplacian, upper, {.laplacian = 1.0}).points);
    add("fair: bi-Laplacian", fair(egg, laplacian, upper, {.bilaplacian = 1.0}).points);
    add("membrane", membrane(egg, laplacian, upper, {}).points);
    return side_by_side(images, 4);
}

// Chladni figures of a square plate with a free rim: what `beltrami nodal` draws.
Image nodal() {
    const Mesh plate = shapes::grid(80, 80);
    const Laplacian laplacian(plate);
    const Spectrum found = spectrum(Eigenproblem(laplacian), {.count = 40});
    std::vector<Image> images;
    for (const Index k : {10, 17, 24, 31}) {
        const Block function = laplacian.order().to_user(Block(found.vectors.col(k)));
        PictureOptions picture{.width = 380, .height = 340};
        picture.title = fmt::format("function {}, eigenvalue {:.4g}", k, found.values[k]);
        images.push_back(draw_lines(plate, &function, nodal_lines(plate, function).lines.segments, picture));
    }
    return side_by_side(images, 4);
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const std::filesystem::path folder = argc > 1 ? argv[1] : ".";
        write_picture(folder / "overview.png", overview());
        write_picture(folder / "nodal.png", nodal());
        write_picture(folder / "figure_6.png", figure_6());
        write_picture(folder / "figure_8.png", figure_8());
        write_picture(folder / "figure_11.png", figure_11());
    } catch (const Error& error) {
        fmt::print(stderr, "error: {}\nhint: {}\n", error.what(), error.hint());
        return error.exit_status();
    }
}
