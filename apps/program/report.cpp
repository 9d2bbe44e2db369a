#include "report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "beltrami/framework/write_mesh.hpp"
#include "view/page.hpp"

namespace beltrami::program {

namespace {

// Together with the page and the largest mesh that is drawn, a file of at most about 40 MB.
constexpr std::size_t most_bytes_of_moments = 24'000'000;
constexpr std::size_t most_bytes_of_fields = 9'000'000;
constexpr std::size_t most_moments = 60;
constexpr Eigen::Index most_columns = 16;

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

/// Fields that can be drawn: of one column, or of three that belong together.
Fields drawable(const Field& field) {
    const Eigen::Index columns = field.values.cols();
    if (columns == 1 || columns == 3) return {field};
    const Eigen::Index shown = std::min(columns, most_columns);
    Fields parts;
    for (Eigen::Index i = 0; i < shown; ++i) {
        const Eigen::Index c = i * (columns - 1) / std::max<Eigen::Index>(shown - 1, 1);
        parts.push_back({fmt::format("{}_{}", field.name, c), field.values.col(c)});
    }
    return parts;
}

bool is_named(const Fields& fields, const std::string& name) {
    return std::any_of(fields.begin(), fields.end(), [&](const Field& field) { return field.name == name; });
}

/// As many pieces at equal distances as are together no larger than that, the first and the last among them.
std::vector<std::string> every_nth_that_fit(std::vector<std::string> pieces, std::size_t most_bytes) {
    for (std::size_t n = 1;; ++n) {
        std::vector<std::size_t> chosen;
        for (std::size_t i = 0; i + 1 < pieces.size(); i += n)
            chosen.push_back(i);
        if (!pieces.empty()) chosen.push_back(pieces.size() - 1);
        std::size_t bytes = 0;
        for (const std::size_t i : chosen)
            bytes += pieces[i].size();
        if (bytes > most_bytes && n < pieces.size()) continue;
        std::vector<std::string> kept;
        kept.reserve(chosen.size());
        for (const std::size_t i : chosen)
            kept.push_back(std::move(pieces[i]));
        return kept;
    }
}

/// Leaves every second one, from the first.
template <class T>
void thin(std::vector<T>& items) {
    std::vector<T> kept;
    for (std::size_t i = 0; i < items.size(); i += 2)
        kept.push_back(std::move(items[i]));
    items = std::move(kept);
}

}  // namespace

Report::Report(const Mesh& mesh, std::string name, MeshReport found, Index most_vertices)
    : mesh_(mesh),
      name_(std::move(name)),
      found_(std::move(found)),
      most_vertices_(most_vertices),
      shown_(view::shown(mesh, most_vertices)) {}

void Report::show(const Mesh& mesh, const Fields& fields) {
    if (mesh_.kind() == CellKind::triangle && mesh.kind() == CellKind::segment)
        return show_lines(mesh, fields);
    if (mesh.vertex_count() == mesh_.vertex_count() && mesh.cells() == mesh_.cells()) {
        if (!displaced_) shown_ = view::moved(std::move(shown_), mesh.points());
    } else {
        shown_ = view::shown(mesh, most_vertices_);
        found_ = beltrami::report(mesh);
    }
    mesh_ = mesh;
    also_show(fields);
}

// Their points are vertices of the page after those of the surface; fields of the one have no value on the other.
void Report::show_lines(const Mesh& lines, const Fields& fields) {
    const view::Shown drawn = view::shown(lines, most_vertices_);
    points_of_lines_ = drawn.mesh.vertex_count();
    shown_ = view::with_lines(shown_, drawn.mesh, mesh_.vertex_count());
    for (const Field& field : fields) {
        const Block on_lines = view::at_shown(field.values, drawn);
        Block values = Block::Constant(mesh_.vertex_count() + on_lines.rows(), on_lines.cols(), no_value);
        values.bottomRows(on_lines.rows()) = on_lines;
        also_show({{field.name, values}});
    }
}

void Report::also_show(const Fields& fields) {
    for (const Field& field : fields) {
        for (Field& part : drawable(field)) {
            if (!is_named(fields_, part.name)) fields_.push_back(std::move(part));
        }
    }
}

void Report::chart(Chart chart) {
    charts_.push_back(std::move(chart));
}

void Report::moment(const std::string& name, bool displaced, double time,
                    const std::function<Block()>& values) {
    series_ = name;
    displaced_ = displaced;
    if (states_++ % stride_ != 0) return;
    keep(time, values());
    // The number of states is not known before: when there are too many, every second one goes.
    if (moments_.size() < most_moments) return;
    thin(moments_);
    stride_ *= 2;
}

void Report::last_moment(double time, const Block& values) {
    if (states_ == 0 || (!moments_.empty() && moments_.back().time == time)) return;
    keep(time, values);
}

void Report::keep(double time, const Block& values) {
    const Block there = view::at_shown(values, shown_);
    columns_ = there.cols();
    const BlockOf<float> floats = there.cast<float>();
    moments_.push_back({time, std::vector<float>(floats.data(), floats.data() + floats.size())});
}

void Report::pack_mesh() {
    embedded_.push_back(
        view::embedded({view::mesh_parcel(shown_, name_, mesh_, found_), /*is_parcel=*/true}));
}

nlohmann::json Report::pack_fields() {
    for (const Field& carried : mesh_.fields())
        also_show({carried});
    std::size_t bytes = 0;
    nlohmann::json left_out = nlohmann::json::array();
    const Eigen::Index rows = mesh_.vertex_count() + points_of_lines_;
    for (Field& field : fields_) {
        if (bytes > most_bytes_of_fields) {
            left_out.push_back(field.name);
            continue;
        }
        const Eigen::Index missing = rows - field.values.rows();
        field.values.conservativeResize(rows, Eigen::NoChange);
        field.values.bottomRows(missing).setConstant(no_value);
        embedded_.push_back(
            view::embedded({view::field_parcel(field, shown_, view::meaning_of(field)), /*is_parcel=*/true}));
        bytes += embedded_.back().size();
    }
    if (!left_out.empty()) {
        notes_.push_back(fmt::format("{} of {} fields are left out of the report to keep it small",
                                     left_out.size(), fields_.size()));
    }
    return left_out;
}

nlohmann::json Report::pack_moments(const Progress* progress) {
    std::vector<std::string> packed(moments_.size());
#pragma omp parallel for schedule(dynamic)
    for (std::size_t i = 0; i < moments_.size(); ++i) {
        packed[i] =
            view::embedded({view::moment_parcel(series_, moments_[i].time, static_cast<Index>(columns_),
                                                moments_[i].values, displaced_),
                            /*is_parcel=*/true});
    }
    if (progress != nullptr) progress->check();
    moments_.clear();
    packed = every_nth_that_fit(std::move(packed), most_bytes_of_moments);
    if (packed.size() < states_)
        notes_.push_back(fmt::format("{} of {} moments are in the report", packed.size(), states_));
    const std::size_t kept = packed.size();
    std::move(packed.begin(), packed.end(), std::back_inserter(embedded_));
    return {{"kept", kept}, {"of", states_}};
}

nlohmann::json Report::pack(const Progress* progress) {
    nlohmann::json about = {{"vertices_shown", shown_.mesh.vertex_count()},
                            {"decimated", !shown_.vertex_of.empty()},
                            {"decimation", shown_.decimation}};
    if (!shown_.decimation.empty()) notes_.push_back(shown_.decimation);
    pack_mesh();
    about["fields_left_out"] = pack_fields();
    if (states_ > 0) about["moments"] = pack_moments(progress);
    about["notes"] = notes_;
    return about;
}

void Report::write(const std::filesystem::path& path, const std::string& command_line,
                   const nlohmann::json& summary) const {
    nlohmann::json charts = nlohmann::json::array();
    for (const Chart& chart : charts_)
        charts.push_back(view::to_json(chart));
    const nlohmann::json message = {
        {"kind", "report"}, {"command", command_line}, {"summary", summary}, {"charts", charts}};
    std::vector<std::string> pieces = embedded_;
    pieces.insert(pieces.begin() + 1,  // after the mesh
                  view::embedded({message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)}));
    const std::string title = fmt::format("{}: {}", name_, summary.value("command", "report"));
    const std::string page = view::self_contained_page(title, pieces);
    write_whole(path, [&](std::ostream& out) { out << page; });
}

ChartLine line_of(std::string name, const std::vector<double>& x, const std::vector<double>& y) {
    const auto vector = [](const std::vector<double>& numbers) -> Vector {
        return Eigen::Map<const Vector>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
    };
    return {.name = std::move(name), .x = vector(x), .y = vector(y)};
}

}  // namespace beltrami::program
