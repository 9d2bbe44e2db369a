#include "beltrami/apps/filter/filter.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "beltrami/apps/interpolate/interpolate.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/operators/tangent_frames.hpp"

namespace beltrami {

namespace {

constexpr const char* how =
    "write low-pass:PASS[,STOP], high-pass:STOP[,PASS], band:LOW,HIGH, notch:LOW,HIGH, "
    "enhance:LOW,HIGH,GAIN, "
    "exaggerate:LOW,HIGH,GAIN, curve:W=G,W=G,... or identity; frequencies are radians a unit of length, 20e "
    "for waves "
    "of 20 mean edges, or #100 for that of pair 100";

double parse_number(std::string_view text, std::string_view whole) {
    double number = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc() && end == text.data() + text.size() && std::isfinite(number)) return number;
    throw InputError(fmt::format("'{}' in the filter '{}' is not a number", text, whole), how);
}

std::vector<std::string_view> split(std::string_view text) {
    std::vector<std::string_view> parts;
    for (;;) {
        const auto comma = text.find(',');
        parts.push_back(text.substr(0, comma));
        if (comma == std::string_view::npos) return parts;
        text.remove_prefix(comma + 1);
    }
}

}  // namespace

double parse_frequency(std::string_view text, const FilterUnits& units) {
    if (text.starts_with('#')) {
        const double number = parse_number(text.substr(1), text);
        if (units.eigenvalues == nullptr) {
            throw InputError(fmt::format("the frequency {} is that of a pair, but there is no basis", text),
                             "give a basis, or a frequency as a number or as 20e");
        }
        if (number != std::floor(number) || number < 0.0 ||
            number >= static_cast<double>(units.eigenvalues->size())) {
            throw InputError(fmt::format("the frequency {} is of no pair: the basis has {}", text,
                                         units.eigenvalues->size()),
                             "count from 0");
        }
        return std::sqrt(std::max((*units.eigenvalues)[static_cast<Index>(number)], 0.0));
    }
    if (text.ends_with('e')) {
        const double edges = parse_number(text.substr(0, text.size() - 1), text);
        if (!(edges > 0.0)) {
            throw InputError(fmt::format("waves of {} edges have no frequency", edges),
                             "give a positive number");
        }
        return frequency_of_edges(units.mean_edge, edges);
    }
    return parse_number(text, text);
}

FilterCurve parse_filter(std::string_view text, const FilterUnits& units) {
    const auto colon = text.find(':');
    const std::string_view name = text.substr(0, colon);
    if (text == "identity") return FilterCurve({{0.0, 1.0}});
    if (colon == std::string_view::npos)
        throw InputError(fmt::format("the filter '{}' cannot be understood", text), how);
    const std::vector<std::string_view> parts = split(text.substr(colon + 1));
    if (name == "curve") {
        std::vector<FilterCurve::Point> points;
        for (const std::string_view part : parts) {
            const auto equal = part.find('=');
            if (equal == std::string_view::npos)
                throw InputError(fmt::format("'{}' in the filter '{}' is not FREQUENCY=GAIN", part, text),
                                 how);
            points.push_back(
                {parse_frequency(part.substr(0, equal), units), parse_number(part.substr(equal + 1), text)});
        }
        return FilterCurve(std::move(points));
    }
    const auto expect = [&](std::size_t least, std::size_t most) {
        if (parts.size() >= least && parts.size() <= most) return;
        throw InputError(fmt::format("the filter '{}' has {} numbers", text, parts.size()), how);
    };
    const auto frequency = [&](std::size_t i) { return parse_frequency(parts[i], units); };
    if (name == "low-pass" || name == "high-pass") {
        expect(1, 2);
        const double low = frequency(0);
        const double high = parts.size() == 2 ? frequency(1) : 1.25 * low;
        return name == "low-pass" ? FilterCurve::low_pass(low, high) : FilterCurve::high_pass(low, high);
    }
    if (name == "band" || name == "notch") {
        expect(2, 2);
        return name == "band" ? FilterCurve::band_pass(frequency(0), frequency(1))
                              : FilterCurve::notch(frequency(0), frequency(1));
    }
    if (name == "enhance" || name == "exaggerate") {
        expect(3, 3);
        const double gain = parse_number(parts[2], text);
        return name == "enhance" ? FilterCurve::enhancement(frequency(0), frequency(1), gain)
                                 : FilterCurve::band_exaggeration(frequency(0), frequency(1), gain);
    }
    throw InputError(fmt::format("there is no filter '{}'", name), how);
}

Block filter_field(const Mesh& mesh, FilterTarget target, const std::string& name) {
    switch (target) {
        case FilterTarget::positions:
            return mesh.points();
        case FilterTarget::normals:
            return tangent_frames(mesh).normal;
        case FilterTarget::colors:
            return mesh.field("color").values;
        case FilterTarget::field:
            return mesh.field(name).values;
    }
    return {};
}

namespace {

Mesh with_field(const Mesh& mesh, const std::string& name, Block values) {
    Fields fields;
    for (const Field& field : mesh.fields()) {
        if (field.name != name) fields.push_back(field);
    }
    fields.push_back({name, std::move(values)});
    return {mesh.points(), mesh.cells(), std::move(fields)};
}

}  // namespace

Mesh filtered(const Mesh& mesh, FilterTarget target, Block field, const std::string& name) {
    switch (target) {
        case FilterTarget::positions:
            return mesh.with_points(Points(field));
        case FilterTarget::normals: {
            const Vector lengths = field.rowwise().norm();
            for (Eigen::Index v = 0; v < field.rows(); ++v) {
                if (lengths[v] > 0.0) field.row(v) /= lengths[v];
            }
            return with_field(mesh, "normal", std::move(field));
        }
        case FilterTarget::colors:
            return with_field(mesh, "color", clamped(field, 0.0, 1.0).value);
        case FilterTarget::field:
            return with_field(mesh, name, std::move(field));
    }
    return mesh;
}

double enclosed_volume(const Mesh& mesh) {
    if (mesh.kind() != CellKind::triangle) return 0.0;
    const Vector3 middle = mesh.points().colwise().mean();
    double volume = 0.0;
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        const auto at = [&](int corner) -> Vector3 {
            return mesh.points().row(mesh.cells()(c, corner)).transpose() - middle;
        };
        volume += at(0).dot(at(1).cross(at(2))) / 6.0;
    }
    return std::abs(volume);
}

}  // namespace beltrami
