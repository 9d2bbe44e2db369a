#include "../program/run.hpp"
#include "../program/values.hpp"

namespace beltrami::program {

void add_poisson(CLI::App& program, Run& run) {
    struct Options {
        std::vector<std::string> fix;
        std::string fix_file;
        std::optional<double> fix_boundary;
        std::string rhs_field;
        std::string rhs_gradient;
        bool keep = false;
    };
    auto* const command =
        program.add_subcommand("poisson", "Laplacian of u = f, with u given at some vertices");
    run.add_options(*command, {});
    auto options = std::make_shared<Options>();
    command->add_option("--fix", options->fix, "a vertex and its value")->option_text("V=x ...");
    command->add_option("--fix-file", options->fix_file, "rows vertex,x")->option_text("FILE.csv");
    command->add_option("--fix-boundary", options->fix_boundary, "the value on the whole boundary")
        ->option_text("X");
    auto* const field =
        command->add_option("--rhs-field", options->rhs_field, "f: a vertex field of the file")
            ->option_text("NAME");
    command
        ->add_option("--rhs-gradient", options->rhs_gradient,
                     "f = div of this vector field of the file: u is what it is closest to the gradient of")
        ->option_text("NAME")
        ->excludes(field);
    add_free_components(*command, options->keep);
    command->callback([&run, options] {
        const Mesh mesh = run.load_mesh();
        const bool from_gradient = !options->rhs_gradient.empty();
        const Block rhs = from_gradient ? mesh.field(options->rhs_gradient).values
                                        : field_or_zero(mesh, options->rhs_field, 1);
        if (from_gradient && rhs.cols() != 3) {
            throw InputError(
                fmt::format("--rhs-gradient {} has {} columns", options->rhs_gradient, rhs.cols()),
                "give a field of vectors, or use --rhs-field");
        }
        const Index columns = from_gradient ? 1 : static_cast<Index>(rhs.cols());
        Constraints fixed =
            parse_values("--fix", options->fix, options->fix_file, columns, mesh.vertex_count());
        if (options->fix_boundary) {
            const std::vector<Index> boundary = boundary_vertices(mesh);
            if (boundary.empty()) {
                throw InputError("--fix-boundary on a mesh that has no boundary", "use --fix VERTEX=VALUE");
            }
            const std::vector<double> value(static_cast<std::size_t>(columns), *options->fix_boundary);
            for (const Index v : boundary) {
                // A value given for the vertex itself wins over that of the whole boundary.
                if (!fixed.is_fixed(v)) fixed.fix(v, value);
            }
        }
        const PoissonOptions poisson_options{free_components(options->keep), run.linear_options()};
        const Laplacian laplacian = run.build(mesh);
        const PoissonResult result = run.timed("solve", [&] {
            return from_gradient ? poisson_from_gradient(mesh, laplacian, Points(rhs), fixed, poisson_options)
                                 : poisson(laplacian, rhs, fixed, poisson_options);
        });
        run.record(result.summary);
        run.write(mesh, {{"u", result.u}});
        run.finish();
    });
}

}  // namespace beltrami::program
