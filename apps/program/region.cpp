#include "region.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "text.hpp"

namespace beltrami::program {

namespace {

std::vector<Index> read_numbers(const std::filesystem::path& path, Index vertex_count) {
    constexpr const char* hint = "write vertex numbers, one a line or parted by commas";
    std::vector<Index> vertices;
    bool header = false;  // one line of names may come first
    for_each_line(path, hint, [&](const std::string& place, std::string_view text) {
        while (!text.empty()) {
            const std::string_view word = text.substr(0, text.find_first_of(", ;\t"));
            text.remove_prefix(std::min(text.size(), word.size() + 1));
            if (word.empty()) continue;
            Index vertex = 0;
            if (!parse(word, vertex)) {
                if (vertices.empty() && !header) {
                    header = true;
                    return;
                }
                throw InputError(fmt::format("{} holds '{}', which is not a vertex number", place, word),
                                 hint);
            }
            if (vertex < 0 || vertex >= vertex_count) {
                throw InputError(fmt::format("{} names vertex {}, but the vertices are 0 to {}", place,
                                             vertex, vertex_count - 1),
                                 "vertex numbers are those of the file, from 0");
            }
            vertices.push_back(vertex);
        }
    });
    if (vertices.empty()) throw InputError(fmt::format("{} names no vertices", path.string()), hint);
    return vertices;
}

template <class Predicate>
std::vector<Index> vertices_where(const Mesh& mesh, Predicate predicate) {
    std::vector<Index> vertices(static_cast<std::size_t>(mesh.vertex_count()));
    std::iota(vertices.begin(), vertices.end(), 0);
    std::erase_if(vertices, [&](Index v) { return !predicate(v); });
    return vertices;
}

}  // namespace

void add_region_options(CLI::App& command, RegionOptions& options) {
    command.add_option("--region-file", options.file, "the region that moves: a file of vertex numbers")
        ->option_text("FILE");
    command
        .add_option("--region-field", options.field,
                    "the region that moves: where this vertex field of the file is not 0")
        ->option_text("NAME");
    command.add_option("--box", options.box, "the region that moves: the vertices within a box")
        ->delimiter(',')
        ->expected(6)
        ->option_text("X0,Y0,Z0,X1,Y1,Z1");
}

std::vector<Index> region(const Mesh& mesh, const RegionOptions& options) {
    const int ways = (options.file.empty() ? 0 : 1) + (options.field.empty() ? 0 : 1) +
                     (options.box.empty() ? 0 : 1) + (options.all ? 1 : 0) + (options.off_boundary ? 1 : 0);
    if (ways != 1) {
        throw InputError(
            ways == 0 ? "no region is given: what may move?" : "the region is given in more than one way",
            "name it by one of --region-file FILE, --region-field NAME, --box X0,Y0,Z0,X1,Y1,Z1 and " +
                options.fourth_way);
    }
    if (!options.file.empty()) return read_numbers(options.file, mesh.vertex_count());
    std::vector<Index> vertices;
    std::string hint = "vertices of the region are those that may move";
    if (!options.field.empty()) {
        const Block& values = mesh.field(options.field).values;
        vertices = vertices_where(mesh, [&](Index v) { return !values.row(v).isZero(0.0); });
        hint = fmt::format("the field {} is 0 everywhere", options.field);
    } else if (!options.box.empty()) {
        const Vector3 low(options.box[0], options.box[1], options.box[2]);
        const Vector3 high(options.box[3], options.box[4], options.box[5]);
        if (!(low.array() <= high.array()).all()) {
            throw InputError(fmt::format("--box {} is no box", fmt::join(options.box, ",")),
                             "give X0,Y0,Z0,X1,Y1,Z1 with X0 <= X1, Y0 <= Y1, Z0 <= Z1");
        }
        vertices = vertices_where(mesh, [&](Index v) {
            const auto p = mesh.points().row(v).transpose().array();
            return (p >= low.array()).all() && (p <= high.array()).all();
        });
        const Eigen::RowVector3d lower = mesh.points().colwise().minCoeff();
        const Eigen::RowVector3d upper = mesh.points().colwise().maxCoeff();
        hint = fmt::format("the mesh lies within {:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g}", lower[0],
                           lower[1], lower[2], upper[0], upper[1], upper[2]);
    } else if (options.off_boundary) {
        std::vector<char> on_boundary(static_cast<std::size_t>(mesh.vertex_count()), 0);
        for (const Index v : boundary_vertices(mesh))
            on_boundary[static_cast<std::size_t>(v)] = 1;
        vertices =
            vertices_where(mesh, [&](Index v) { return on_boundary[static_cast<std::size_t>(v)] == 0; });
        hint = "all vertices lie on the boundary";
    } else {
        vertices = vertices_where(mesh, [](Index) { return true; });
    }
    if (vertices.empty()) throw InputError("the region has no vertices", hint);
    return vertices;
}

}  // namespace beltrami::program
