#include "../program/run.hpp"
#include "../program/values.hpp"

namespace beltrami::program {

namespace {

/// Singularities in the summary, at most so many.
constexpr std::size_t most_listed = 1000;

nlohmann::json to_json(const Singularities& found) {
    nlohmann::json list = nlohmann::json::array();
    for (const Singularity& s : found.list) {
        if (list.size() == most_listed) break;
        list.push_back({{"triangle", s.triangle},
                        {"index", s.index},
                        {"position", {s.position.x(), s.position.y(), s.position.z()}}});
    }
    return {{"count", found.list.size()},
            {"index_sum", found.index_sum},
            {"undefined_triangles", found.undefined_triangles},
            {"list", list}};
}

void tell(Run& run, const VectorsResult& result) {
    if (result.largest_tilt > 5.0) {
        run.warn(
            fmt::format("given vectors are off the surface, that at vertex {} by {:.1f} degrees: their "
                        "parts along it are taken",
                        result.most_tilted, result.largest_tilt));
    }
    if (result.without_plane > 0) {
        run.warn(
            fmt::format("{} vertices have no tangent plane, since normals cancel there: their vectors are 0",
                        result.without_plane));
    }
    const MeshReport& mesh = run.mesh_report();
    if (!mesh.orientable) {
        run.say("turns", "the surface is one-sided: its singularities have no sign and are not counted");
        return;
    }
    const Singularities& found = result.singularities;
    const bool closed = mesh.manifold && mesh.boundary_edges == 0 && mesh.degenerate_cells == 0;
    run.say("turns",
            fmt::format("{} singularities, their indices add up to {}{}", found.list.size(), found.index_sum,
                        closed && found.undefined_triangles == 0
                            ? fmt::format(" (Euler characteristic {})", mesh.euler_characteristic)
                            : ""));
    run.result()["singularities"] = to_json(found);
    run.result()["largest_tilt_degrees"] = result.largest_tilt;
}

}  // namespace

void add_vectors(CLI::App& program, Run& run) {
    struct Options {
        std::vector<std::string> fix;
        std::string fix_file;
        std::string method = "connection";
        std::string lengths;
        TermWeights weights;
        bool keep = false;
    };
    auto* const command = program.add_subcommand(
        "vectors", "the smoothest tangent vector field that takes given vectors at given vertices");
    run.add_options(*command, {});
    auto options = std::make_shared<Options>();
    command->add_option("--fix", options->fix, "a vertex and its vector")->option_text("V=x,y,z ...");
    command->add_option("--fix-file", options->fix_file, "rows vertex,x,y,z")->option_text("FILE.csv");
    command
        ->add_option("--method", options->method,
                     "connection, which turns vectors with the surface, or coordinates, which interpolates "
                     "x, y and z by themselves (default: connection)")
        ->check(CLI::IsMember({"connection", "coordinates"}))
        ->option_text("NAME");
    command
        ->add_option(
            "--lengths", options->lengths,
            "interpolated: those of the given vectors, as numbers; solved: those of the solution, which "
            "few vectors leave short on curved surfaces (default: interpolated, with coordinates solved)")
        ->check(CLI::IsMember({"solved", "interpolated"}))
        ->option_text("NAME");
    add_term_weights(*command, options->weights);
    add_free_components(*command, options->keep);
    command->callback([&run, options] {
        const Mesh mesh = run.load_mesh();
        const Constraints fixed =
            parse_values("--fix", options->fix, options->fix_file, 3, mesh.vertex_count());
        VectorsOptions interpolation;
        interpolation.method =
            options->method == "coordinates" ? VectorMethod::coordinates : VectorMethod::connection;
        if (!options->lengths.empty()) {
            interpolation.lengths =
                options->lengths == "solved" ? VectorLengths::solved : VectorLengths::interpolated;
        }
        interpolation.laplacian = options->weights.of_laplacian();
        interpolation.bilaplacian = options->weights.of_bilaplacian();
        interpolation.free_components = free_components(options->keep);
        interpolation.linear = run.linear_options();
        const Laplacian laplacian = run.build(mesh);
        const VectorsResult result =
            run.timed("solve", [&] { return vectors(mesh, laplacian, fixed, interpolation); });
        run.record(result.summary);
        tell(run, result);
        run.result()["method"] = options->method;
        run.write(mesh, {{"vectors", result.vectors}}, [&](const PictureOptions& picture) {
            return draw_vectors(mesh, result.vectors, fixed.vertices(), picture);
        });
        run.finish();
    });
}

}  // namespace beltrami::program
