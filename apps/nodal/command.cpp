#include "beltrami/apps/nodal/nodal.hpp"

#include <algorithm>
#include <numeric>

#include "../program/spectral.hpp"

namespace beltrami::program {

namespace {

// One mesh of all lines, with the function and the line that each point is of, both counted from 0.
Mesh all_lines(const std::vector<NodalLines>& found, const std::vector<Index>& functions) {
    std::vector<Mesh> parts;
    for (std::size_t f = 0; f < found.size(); ++f)
        parts.push_back(found[f].lines.segments);
    const Mesh joined = shapes::together(parts);
    Block function(joined.vertex_count(), 1);
    Block line = Block::Zero(joined.vertex_count(), 1);
    Index first = 0;
    Index number = 0;
    for (std::size_t f = 0; f < found.size(); ++f) {
        const Index points = found[f].lines.segments.vertex_count();
        function.middleRows(first, points).setConstant(functions[f]);
        for (const Polyline& polyline : found[f].lines.lines) {
            for (const Index p : polyline.points)
                line(first + p, 0) = number;
            ++number;
        }
        first += points;
    }
    return {joined.points(), joined.cells(), {{"line", line}, {"function", function}}};
}

/// Nodal domains and lengths of the functions, with the bound on the number of domains.
void gather(Report& report, const std::vector<NodalLines>& found, const std::vector<Index>& functions) {
    std::vector<std::size_t> order(functions.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return functions[a] < functions[b]; });
    std::vector<double> numbers;
    std::vector<double> domains;
    std::vector<double> bounds;
    std::vector<double> lengths;
    for (const std::size_t i : order) {
        numbers.push_back(functions[i]);
        domains.push_back(found[i].domains);
        bounds.push_back(functions[i] + 1.0);
        lengths.push_back(found[i].lines.length);
    }
    ChartLine courant = line_of("Courant's bound", numbers, bounds);
    courant.dashed = true;
    report.chart({.title = "nodal domains",
                  .across = "function",
                  .up = "domains",
                  .lines = {line_of("domains", numbers, domains), courant}});
    report.chart({.title = "length of the lines",
                  .across = "function",
                  .up = "length",
                  .lines = {line_of("", numbers, lengths)}});
}

}  // namespace

void add_nodal(CLI::App& program, Run& run) {
    struct Options {
        std::string basis;
        std::vector<Index> functions;
        double level = 0.0;
    };
    auto* const command =
        program.add_subcommand("nodal", "Chladni figures: where eigenfunctions are 0, as lines on the mesh");
    run.add_options(*command, {.output = true, .solver = false});
    auto options = std::make_shared<Options>();
    add_basis_option(*command, options->basis);
    command->add_option("--function", options->functions, "numbers of functions, from 0")
        ->required()
        ->option_text("K ...");
    command->add_option("--level", options->level, "where functions have this value (default: 0)")
        ->option_text("L");
    command->callback([&run, options] {
        const Mesh mesh = run.load_mesh();
        if (mesh.kind() != CellKind::triangle) {
            throw InputError(
                fmt::format("nodal lines are drawn on triangles, not on {}", plural(mesh.kind())),
                "give a surface");
        }
        const StoredBasis basis = open_basis(run, options->basis, mesh);
        std::vector<NodalLines> found;
        nlohmann::json entries = nlohmann::json::array();
        double length = 0.0;
        std::size_t count = 0;
        for (const Index k : options->functions) {
            const Vector function = basis.function(k);
            found.push_back(run.timed("solve", [&] { return nodal_lines(mesh, function, options->level); }));
            const Isolines& lines = found.back().lines;
            const auto closed = std::count_if(lines.lines.begin(), lines.lines.end(),
                                              [](const Polyline& l) { return l.closed; });
            entries.push_back({{"function", k},
                               {"eigenvalue", basis.eigenvalues()[k]},
                               {"lines", lines.lines.size()},
                               {"closed", closed},
                               {"length", lines.length},
                               {"domains", found.back().domains}});
            run.say("nodal", fmt::format("function {}: {} lines ({} closed) of length {:.6g}, {} domains", k,
                                         lines.lines.size(), closed, lines.length, found.back().domains));
            if (lines.lines.empty()) {
                run.warn(fmt::format("function {} is nowhere {}: it goes from {:.6g} to {:.6g}", k,
                                     options->level, function.minCoeff(), function.maxCoeff()));
            }
            length += lines.length;
            count += lines.lines.size();
        }
        if (count == 0) {
            throw InputError("there are no lines to write",
                             "ask for another function (0 is constant) or another --level");
        }
        run.result()["functions"] = entries;
        run.result()["length"] = length;
        run.result()["lines"] = count;
        if (Report* const report = run.for_report()) {
            gather(*report, found, options->functions);
            for (const Index k : options->functions)
                report->also_show({{fmt::format("function-{}", k), basis.function(k)}});
        }
        const Mesh lines = all_lines(found, options->functions);
        run.write(lines, lines.fields(), [&](PictureOptions picture) {
            if (found.size() > 1) {
                picture.width = 640;
                picture.height = 560;
            }
            std::vector<Image> images;
            for (std::size_t f = 0; f < found.size(); ++f) {
                const Index k = options->functions[f];
                const Block function = basis.function(k);
                picture.title = fmt::format("function {}, eigenvalue {:.4g}", k, basis.eigenvalues()[k]);
                images.push_back(draw_lines(mesh, &function, found[f].lines.segments, picture));
            }
            return side_by_side(images, static_cast<int>(std::min<std::size_t>(images.size(), 4)));
        });
        run.finish();
    });
}

}  // namespace beltrami::program
