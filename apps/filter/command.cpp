#include "../program/spectral.hpp"

namespace beltrami::program {

namespace {

/// The gain over the frequencies that a mesh can hold.
void draw_gain(Report* report, const FilterCurve& curve, double nyquist) {
    if (report == nullptr) return;
    std::vector<double> frequencies = {0.0};
    std::vector<double> gains = {curve.points().front().gain};
    for (const FilterCurve::Point& point : curve.points()) {
        frequencies.push_back(point.frequency);
        gains.push_back(point.gain);
    }
    if (frequencies.back() < nyquist) {
        frequencies.push_back(nyquist);
        gains.push_back(gains.back());
    }
    report->chart({.title = "filter",
                   .across = "frequency, radians a unit of length",
                   .up = "gain",
                   .lines = {line_of("", frequencies, gains)}});
}

}  // namespace

void add_filter(CLI::App& program, Run& run) {
    struct Options {
        std::string basis;
        bool limited_memory = false;
        std::string filter;
        std::string on = "positions";
        std::string cutoff = "10e";
        OperatorOptions op;
        SpectrumCommandOptions spectrum;
    };
    auto* const command =
        program.add_subcommand("filter", "positions, normals, colours or a field, filtered by frequency");
    run.add_options(*command, {.output = true, .solver = false});
    auto options = std::make_shared<Options>();
    auto* const basis = command->add_option("--basis", options->basis, "a folder made by beltrami harmonics")
                            ->option_text("BASIS");
    auto* const limited = command->add_flag("--limited-memory", options->limited_memory,
                                            "store no basis: find and forget only what the filter changes");
    basis->excludes(limited);
    command
        ->add_option(
            "--filter", options->filter,
            "low-pass:W, high-pass:W, band:A,B, notch:A,B, enhance:A,B,GAIN, exaggerate:A,B,GAIN, "
            "curve:W=GAIN,... or identity; W is radians a unit of length, 20e (waves of 20 mean edges) or "
            "#100 (the frequency of pair 100)")
        ->required()
        ->option_text("SPEC");
    command
        ->add_option("--on", options->on, "positions, normals, colors or a field's name (default: positions)")
        ->option_text("WHAT");
    command
        ->add_option("--cutoff", options->cutoff,
                     "with --limited-memory: the frequency from which all is one wave packet (default: 10e)")
        ->option_text("W");
    add_spectrum_options(*command, options->spectrum);
    add_operator_options(*command, options->op);
    command->callback([&run, options] {
        if (options->basis.empty() != options->limited_memory) {
            throw InputError("a filter needs a basis, or to work without",
                             "give --basis BASIS, made by beltrami harmonics, or --limited-memory");
        }
        const Mesh mesh = run.load_mesh();
        const NamedTarget target = target_of(options->on);
        const Block field = filter_field(mesh, target.kind, target.field);
        FilterUnits units{.mean_edge = run.mesh_report().mean_edge};
        Block result;
        if (options->limited_memory) {
            const FilterCurve curve = parse_filter(options->filter, units);
            draw_gain(run.for_report(), curve, nyquist_frequency(units.mean_edge));
            const SpectralProblem made = spectral_problem(run, mesh, options->op);
            LimitedFilterOptions limited;
            limited.cutoff = parse_frequency(options->cutoff, units);
            limited.mean_edge = units.mean_edge;
            limited.spectrum = spectrum_options(run, options->spectrum, mesh, made.laplacian,
                                                std::filesystem::temp_directory_path());
            const std::vector<Index> vertices = user_vertices(made.problem, made.laplacian.order());
            const Block unknowns = field(vertices, Eigen::all);
            const LimitedFilterResult filter = run.timed(
                "solve", [&] { return limited_memory_filter(made.problem, unknowns, curve, limited); });
            for (const SpectrumSummary& summary : filter.summaries)
                record(run, summary);
            // Vertices that are isolated or held are in no function: all of their field is the wave packet's.
            result = curve.mean(limited.cutoff, nyquist_frequency(units.mean_edge)) * field;
            result(vertices, Eigen::all) = filter.field;
            run.result()["pairs"] = filter.pairs;
            run.say("filter", fmt::format("{} pairs were found, used and forgotten", filter.pairs));
        } else {
            const StoredBasis basis = open_basis(run, options->basis, mesh);
            units.eigenvalues = &basis.eigenvalues();
            units.mean_edge = basis.mean_edge();
            const FilterCurve curve = parse_filter(options->filter, units);
            draw_gain(run.for_report(), curve, nyquist_frequency(units.mean_edge));
            result = run.timed("solve", [&] {
                const HarmonicFilter filter(basis, field, run.progress());
                run.result()["high_frequency_gain"] = filter.high_frequency_gain(curve);
                return filter.apply(curve);
            });
        }
        const Mesh written = filtered(mesh, target.kind, result, target.field);
        if (target.kind == FilterTarget::positions) {
            const double before = enclosed_volume(mesh);
            const double after = enclosed_volume(written);
            if (run.mesh_report().boundary_edges == 0 && before > 0.0) {
                run.result()["volume"] = {{"before", before}, {"after", after}};
                run.say("volume", fmt::format("{:.6g} before, {:.6g} after ({:+.3f} %)", before, after,
                                              100.0 * (after / before - 1.0)));
            }
            const Fields moved{{"displacement", Block(written.points() - mesh.points())}};
            run.write(written, moved, [&](const PictureOptions& picture) {
                return side_by_side({draw(mesh, nullptr, picture), draw(written, nullptr, picture)}, 2);
            });
        } else {
            const std::string name = target.kind == FilterTarget::normals  ? "normal"
                                     : target.kind == FilterTarget::colors ? "color"
                                                                           : target.field;
            run.write(mesh, {written.field(name)});
        }
        run.finish();
    });
}

}  // namespace beltrami::program
