#include <fmt/ranges.h>

#include <algorithm>

#include "../program/spectral.hpp"
#include "../program/text.hpp"

namespace beltrami::program {

namespace {

struct Options {
    std::string basis;
    std::string kind;
    std::string times;
    std::string energies;
    std::optional<int> count;
    std::optional<double> sigma;
    bool by_trace = false;
    std::vector<Index> from;
    std::string initial;
    std::string velocity;
};

/// What an option gives that goes with some kinds only.
void check_options(const Options& options) {
    struct Rule {
        const char* option;
        bool given;
        std::vector<std::string> kinds;
    };
    const bool propagates = options.kind == "heat" || options.kind == "wave";
    for (const Rule& rule :
         {Rule{"--times", !options.times.empty(), {"hks", "diffusion", "heat", "wave"}},
          Rule{"--energies", !options.energies.empty(), {"wks"}},
          Rule{"--sigma", options.sigma.has_value(), {"wks"}},
          Rule{"--count", options.count.has_value(), {"hks", "wks"}},
          Rule{"--by-trace", options.by_trace, {"hks"}},
          Rule{"--from", !options.from.empty(), {"diffusion", "biharmonic", "commute", "heat", "wave"}},
          Rule{"--initial", !options.initial.empty(), {"heat", "wave"}},
          Rule{"--velocity", !options.velocity.empty(), {"wave"}}}) {
        if (!rule.given || std::find(rule.kinds.begin(), rule.kinds.end(), options.kind) != rule.kinds.end())
            continue;
        throw InputError(fmt::format("{} does not go with --kind {}", rule.option, options.kind),
                         fmt::format("it goes with {}", fmt::join(rule.kinds, ", ")));
    }
    if (options.count && (!options.times.empty() || !options.energies.empty())) {
        throw InputError("--count goes with times and energies that are chosen for you",
                         "leave it out, or --times and --energies");
    }
    if (propagates && options.times.empty())
        throw InputError(fmt::format("--kind {} without a time", options.kind),
                         "give --times T or T1,T2,...");
    const bool is_distance =
        options.kind == "diffusion" || options.kind == "biharmonic" || options.kind == "commute";
    if (is_distance && options.from.empty())
        throw InputError("a distance is from somewhere", "give a vertex with --from V");
    const int states = (options.from.empty() ? 0 : 1) + (options.initial.empty() ? 0 : 1);
    if (propagates && (states > 1 || (states == 0 && options.velocity.empty()))) {
        throw InputError(fmt::format("--kind {} needs one initial state", options.kind),
                         "give a field with --initial FIELD, or vertices that are 1 with --from V ...");
    }
}

Vector numbers_of(const std::string& option, const std::string& text) {
    const std::vector<double> numbers = parse_numbers(text);
    if (numbers.empty()) {
        throw InputError(fmt::format("{} {} cannot be understood", option, text),
                         "write numbers parted by commas");
    }
    return Eigen::Map<const Vector>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

nlohmann::json to_array(const Vector& values) {
    return std::vector<double>(values.begin(), values.end());
}

void check_vertices(const std::vector<Index>& vertices, const Mesh& mesh) {
    for (const Index v : vertices) {
        if (v >= 0 && v < mesh.vertex_count()) continue;
        throw InputError(
            fmt::format("--from {}: there is no such vertex, they are 0 to {}", v, mesh.vertex_count() - 1),
            "vertex numbers are those of the file, from 0");
    }
}

/// To the nearest of the vertices.
template <class Distance>
Block nearest(const std::vector<Index>& from, Distance distance) {
    Block result = distance(from.front());
    for (std::size_t i = 1; i < from.size(); ++i)
        result = result.cwiseMin(distance(from[i]));
    return result;
}

Fields propagated(Run& run, const Mesh& mesh, const StoredBasis& basis, const Options& options) {
    Block initial;
    if (!options.initial.empty()) {
        initial = mesh.field(options.initial).values;
    } else {
        const Eigen::Index columns =
            options.velocity.empty() ? 1 : mesh.field(options.velocity).values.cols();
        initial = Block::Zero(mesh.vertex_count(), columns);
        for (const Index v : options.from)
            initial.row(v).setOnes();
    }
    std::optional<Block> velocity;
    if (!options.velocity.empty()) velocity = mesh.field(options.velocity).values;
    const Vector times = numbers_of("--times", options.times);
    run.result()["times"] = to_array(times);
    return run.timed("solve", [&] {
        const SpectralPropagation state(basis, initial, velocity, run.progress());
        run.result()["left_out"] = state.left_out();
        if (state.left_out() > 0.01) {
            run.warn(
                fmt::format("{:.3g} of the initial state is not in the basis of {} functions and is left "
                            "out",
                            state.left_out(), basis.count()));
        }
        Fields fields;
        for (Eigen::Index i = 0; i < times.size(); ++i) {
            fields.push_back({times.size() == 1 ? options.kind : fmt::format("{}_{}", options.kind, i),
                              options.kind == "heat" ? state.heat(times[i]) : state.wave(times[i])});
        }
        return fields;
    });
}

Fields signature(Run& run, const Mesh& mesh, const StoredBasis& basis, const Options& options) {
    if (options.kind == "heat" || options.kind == "wave") return propagated(run, mesh, basis, options);
    const auto of = [&](const auto& work) { return Fields{{options.kind, run.timed("solve", work)}}; };
    if (options.kind == "wks") {
        SignatureEnergies energies = wave_signature_energies(basis, options.count.value_or(100));
        if (!options.energies.empty()) energies.energies = numbers_of("--energies", options.energies);
        if (options.sigma) energies.sigma = *options.sigma;
        run.result()["energies"] = to_array(energies.energies);
        run.result()["sigma"] = energies.sigma;
        return of([&] { return wave_kernel_signature(basis, energies, run.progress()); });
    }
    if (options.kind == "hks") {
        const Vector times = options.times.empty() ? heat_signature_times(basis, options.count.value_or(100))
                                                   : numbers_of("--times", options.times);
        run.result()["times"] = to_array(times);
        return of([&] { return heat_kernel_signature(basis, times, options.by_trace, run.progress()); });
    }
    if (basis.zero_modes() > 1 && options.kind != "diffusion") {
        run.warn(fmt::format(
            "distances between the {} components are infinite; what is written there leaves that out",
            basis.zero_modes()));
    }
    if (options.kind == "diffusion") {
        const Vector times = options.times.empty()
                                 ? Vector::Constant(1, 1.0 / first_nonzero_eigenvalue(basis))
                                 : numbers_of("--times", options.times);
        run.result()["times"] = to_array(times);
        return of([&] {
            return nearest(options.from,
                           [&](Index v) { return diffusion_distance(basis, v, times, run.progress()); });
        });
    }
    return of([&] {
        return nearest(options.from, [&](Index v) {
            return options.kind == "biharmonic" ? biharmonic_distance(basis, v, run.progress())
                                                : commute_time_distance(basis, v, run.progress());
        });
    });
}

/// Of signatures and states: the least, mean and greatest value over the vertices, along times or energies. Of distances: the
/// share of the vertices that are within each.
Chart chart_of(const Options& options, const Fields& fields, const nlohmann::json& result) {
    const auto along = result.find(options.kind == "wks" ? "energies" : "times");
    if (options.kind == "diffusion" || along == result.end()) {
        Vector distances = fields.front().values.reshaped();
        std::sort(distances.begin(), distances.end());
        const Eigen::Index n = distances.size();
        return {
            .title = "vertices within a distance",
            .across = options.kind + " distance",
            .up = "share of the vertices",
            .lines = {
                {.name = {}, .x = distances, .y = Vector::LinSpaced(n, 1.0 / static_cast<double>(n), 1.0)}}};
    }
    std::vector<double> least;
    std::vector<double> mean;
    std::vector<double> greatest;
    for (const Field& field : fields) {
        // A state is a field for each time; of a signature all times are columns of one.
        const bool whole = options.kind == "heat" || options.kind == "wave";
        for (Eigen::Index c = 0; c < (whole ? 1 : field.values.cols()); ++c) {
            const Block values = whole ? field.values : Block(field.values.col(c));
            least.push_back(values.minCoeff());
            mean.push_back(values.mean());
            greatest.push_back(values.maxCoeff());
        }
    }
    std::vector<double> x = along->get<std::vector<double>>();
    x.resize(least.size(), x.back());
    return {
        .title = options.kind + " over the vertices",
        .across = options.kind == "wks" ? "energy (logarithm of an eigenvalue)" : "time",
        .up = options.kind,
        .logarithmic = options.kind == "hks",
        .lines = {line_of("least", x, least), line_of("mean", x, mean), line_of("greatest", x, greatest)}};
}

/// Up to four columns side by side, the first and the last among them.
Image draw_columns(const Mesh& mesh, const Fields& fields, PictureOptions picture) {
    std::vector<std::pair<const Field*, Eigen::Index>> columns;
    for (const Field& field : fields) {
        for (Eigen::Index c = 0; c < field.values.cols(); ++c)
            columns.emplace_back(&field, c);
    }
    const std::size_t shown = std::min<std::size_t>(columns.size(), 4);
    if (shown > 1) {
        picture.width = 640;
        picture.height = 560;
    }
    std::vector<Image> images;
    for (std::size_t i = 0; i < shown; ++i) {
        const auto& [field, c] = columns[shown == 1 ? 0 : i * (columns.size() - 1) / (shown - 1)];
        const Block values = field->values.col(c);
        picture.title = field->values.cols() == 1 ? field->name : fmt::format("{}_{}", field->name, c);
        images.push_back(draw(mesh, &values, picture));
    }
    return side_by_side(images, static_cast<int>(shown));
}

}  // namespace

void add_signature(CLI::App& program, Run& run) {
    auto* const command = program.add_subcommand(
        "signature", "heat and wave kernel signatures, spectral distances, heat and waves exact in time");
    run.add_options(*command, {.output = true, .solver = false});
    auto options = std::make_shared<Options>();
    add_basis_option(*command, options->basis);
    command
        ->add_option("--kind", options->kind,
                     "signatures: hks, wks; distances from --from: diffusion, biharmonic, commute; states "
                     "at --times: heat, wave")
        ->required()
        ->check(CLI::IsMember({"hks", "wks", "diffusion", "biharmonic", "commute", "heat", "wave"}))
        ->option_text("KIND");
    command
        ->add_option("--times", options->times,
                     "of hks (default: as its paper chooses them), diffusion (default: 1 / the first nonzero "
                     "eigenvalue), heat and wave")
        ->option_text("T1,T2,...");
    command
        ->add_option("--energies", options->energies,
                     "of wks: logarithms of eigenvalues (default: as its paper chooses them)")
        ->option_text("E1,E2,...");
    command->add_option("--sigma", options->sigma, "of wks: the width of its windows (default: as its paper)")
        ->option_text("S");
    command->add_option("--count", options->count, "so many times or energies (default: 100)")
        ->option_text("N");
    command->add_flag("--by-trace", options->by_trace, "hks over the heat trace, so that its integral is 1");
    command
        ->add_option("--from", options->from,
                     "vertices: distances are to the nearest, heat and waves start as 1 there")
        ->option_text("V ...");
    command->add_option("--initial", options->initial, "heat and wave: the field at time 0")
        ->option_text("FIELD");
    command->add_option("--velocity", options->velocity, "wave: the velocity at time 0 (default: none)")
        ->option_text("FIELD");
    command->callback([&run, options] {
        check_options(*options);
        const Mesh mesh = run.load_mesh();
        check_vertices(options->from, mesh);
        const StoredBasis basis = open_basis(run, options->basis, mesh);
        run.result()["kind"] = options->kind;
        const Fields fields = signature(run, mesh, basis, *options);
        if (Report* const report = run.for_report()) report->chart(chart_of(*options, fields, run.result()));
        run.write(mesh, fields,
                  [&](const PictureOptions& picture) { return draw_columns(mesh, fields, picture); });
        run.finish();
    });
}

}  // namespace beltrami::program
