#include <cmath>

#include "../program/moving.hpp"
#include "../program/values.hpp"

namespace beltrami::program {

namespace {

void require_columns(const Constraints& fixed, const char* option) {
    if (fixed.columns() == 3) return;
    throw InputError(fmt::format("{}: the values have {} column{}", option, fixed.columns(),
                                 fixed.columns() == 1 ? "" : "s"),
                     "give three numbers a vertex, V=x,y,z");
}

// Colours from 0 to `most` as colours from 0 to 1.
Constraints unit_colours(const Constraints& fixed, double most) {
    require_columns(fixed, "--colours");
    Constraints colours(3);
    for (const Index v : fixed.vertices()) {
        std::vector<double> colour(fixed.value(v).begin(), fixed.value(v).end());
        for (double& channel : colour) {
            if (channel < 0.0 || channel > most) {
                throw InputError(fmt::format("vertex {} has the colour {}, which is not within 0 to {}", v,
                                             fmt::join(fixed.value(v), ","), most),
                                 "say --colours 255 for colours from 0 to 255");
            }
            channel /= most;
        }
        colours.fix(v, colour);
    }
    return colours;
}

Bounds bounds_of(const std::vector<double>& given, const Constraints& fixed) {
    if (given.empty()) return range_of(fixed);
    return {Vector::Constant(fixed.columns(), given[0]), Vector::Constant(fixed.columns(), given[1])};
}

// The vertices that are not fixed and lie at a bound in some column.
Index count_at_bounds(const Block& value, const Constraints& fixed, const Bounds& bounds) {
    Index count = 0;
    for (Index v = 0; v < value.rows(); ++v) {
        const Vector at = value.row(v).transpose();
        count += !fixed.is_fixed(v) &&
                         (at.array() == bounds.low.array() || at.array() == bounds.high.array()).any()
                     ? 1
                     : 0;
    }
    return count;
}

}  // namespace

void add_interpolate(CLI::App& program, Run& run) {
    struct Options {
        std::vector<std::string> fix;
        std::string fix_file;
        TermWeights weights;
        bool bounded = false;
        std::vector<double> bounds;
        bool displace = false;
        std::optional<int> colours;
        bool keep = false;
    };
    auto* const command = program.add_subcommand(
        "interpolate", "the smoothest field that takes given values at given vertices");
    run.add_options(*command, {});
    auto options = std::make_shared<Options>();
    command->add_option("--fix", options->fix, "a vertex and its value")->option_text("V=x[,y,z] ...");
    command->add_option("--fix-file", options->fix_file, "rows vertex,x[,y,z]")->option_text("FILE.csv");
    add_term_weights(*command, options->weights);
    command->add_flag("--bounded", options->bounded,
                      "do not overshoot: stay between the least and greatest given value of each column");
    command->add_option("--bounds", options->bounds, "stay between these (implies --bounded)")
        ->delimiter(',')
        ->expected(2)
        ->option_text("LOW,HIGH");
    auto* const displace = command->add_flag("--displace", options->displace,
                                             "the values are displacements: write the mesh moved by them");
    command->add_option("--colours", options->colours, "the values are colours from 0 to 1, or 0 to 255")
        ->check(CLI::IsMember({1, 255}))
        ->excludes(displace)
        ->option_text("1|255");
    add_free_components(*command, options->keep);
    command->callback([&run, options] {
        const Mesh mesh = run.load_mesh();
        Constraints fixed = parse_values("--fix", options->fix, options->fix_file, 0, mesh.vertex_count());
        if (options->displace) require_columns(fixed, "--displace");
        if (options->colours) fixed = unit_colours(fixed, *options->colours);
        InterpolateOptions interpolation;
        interpolation.laplacian = options->weights.of_laplacian();
        interpolation.bilaplacian = options->weights.of_bilaplacian();
        const bool bounded = options->bounded || !options->bounds.empty();
        if (bounded) interpolation.bounds = bounds_of(options->bounds, fixed);
        interpolation.free_components = free_components(options->keep);
        interpolation.linear = run.linear_options();
        const Laplacian laplacian = run.build(mesh);
        const InterpolateResult result =
            run.timed("solve", [&] { return interpolate(laplacian, fixed, interpolation); });
        run.record(result.summary);
        if (bounded) {
            const Index at_bounds = count_at_bounds(result.value, fixed, *interpolation.bounds);
            run.say("bounds", fmt::format("{} vertices are kept at a bound", at_bounds));
            run.result()["at_bounds"] = at_bounds;
        } else if (interpolation.bilaplacian == 0.0) {
            // What is not given is NaN; components that are kept at zero hold zeros.
            Block given = Block::Constant(result.value.rows(), result.value.cols(), NAN);
            hold_free_components(laplacian, fixed, interpolation.free_components).impose(given);
            run.warn_outside(laplacian, result.value, given);
        }
        if (options->displace) {
            write_moved(run, mesh, displaced(mesh, result.value).points());
        } else if (options->colours) {
            const Clamped colours = clamped(result.value, 0.0, 1.0);
            run.result()["clamped_vertices"] = colours.vertices;
            if (colours.vertices > 0) {
                run.warn(fmt::format(
                    "{} vertices overshot the range of colours, by {:.1f} % of it at most, and are clamped: "
                    "--bounded finds the smoothest colours within the range",
                    colours.vertices, 100.0 * colours.farthest));
            }
            run.write(mesh, {{"color", colours.value}});
        } else {
            run.write(mesh, {{"value", result.value}});
        }
        run.finish();
    });
}

}  // namespace beltrami::program
