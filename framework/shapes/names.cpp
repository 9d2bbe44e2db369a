#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"

namespace beltrami::shapes {

namespace {

/// An argument as it stands in a name: whole numbers or lengths, `NxM` for two whole numbers in one argument.
enum class Argument { whole, whole_pair, length };

struct Parameter {
    std::string_view form;  // as shown to people: "NXxNY"
    Argument kind;
    std::optional<double> otherwise = {};  // what it is when left out; those without come first
};

/// The values of all parameters, in order, a pair as two. Doubles hold every Index and seed exactly.
class Values {
  public:
    void add(double value) { values_.push_back(value); }
    [[nodiscard]] double length(std::size_t i) const { return values_[i]; }
    [[nodiscard]] int whole(std::size_t i) const { return static_cast<int>(values_[i]); }
    [[nodiscard]] std::uint32_t seed(std::size_t i) const { return static_cast<std::uint32_t>(whole(i)); }

  private:
    std::vector<double> values_;
};

struct Shape {
    std::string_view name;
    std::vector<Parameter> parameters;
    std::string_view about;
    std::string_view example;
    Mesh (*make)(const Values&);
};

const std::vector<Shape>& shape_table() {
    using enum Argument;
    const Parameter radius{"RADIUS", length, 1.0};
    static const std::vector<Shape> table{
        {"icosphere",
         {{"LEVELS", whole}, radius},
         "sphere, the icosahedron split in four LEVELS times",
         "icosphere:5",
         [](const Values& v) { return icosphere(v.whole(0), v.length(1)); }},
        {"latlong",
         {{"RINGS", whole}, radius},
         "sphere of two poles and RINGS circles of latitude",
         "latlong:14",
         [](const Values& v) { return latlong_sphere(v.whole(0), v.length(1)); }},
        {"geodesic-icosahedron",
         {{"FREQUENCY", whole}, radius},
         "sphere, the faces of the icosahedron cut in FREQUENCY^2",
         "geodesic-icosahedron:5",
         [](const Values& v) { return geodesic_icosahedron(v.whole(0), v.length(1)); }},
        {"geodesic-tetrahedron",
         {{"FREQUENCY", whole}, radius},
         "sphere, the faces of the tetrahedron cut in FREQUENCY^2",
         "geodesic-tetrahedron:4",
         [](const Values& v) { return geodesic_tetrahedron(v.whole(0), v.length(1)); }},
        {"bumpy-sphere",
         {{"VERTICES", whole}, {"SEED", whole, 1.0}},
         "sphere with hills, irregular triangles and slivers",
         "bumpy-sphere:150000:7",
         [](const Values& v) { return bumpy_sphere(v.whole(0), v.seed(1)); }},
        {"grid",
         {{"NXxNY", whole_pair}, {"WIDTH", length, 1.0}, {"HEIGHT", length, 1.0}},
         "rectangle of NX x NY squares, each split in two",
         "grid:200x100:2:1",
         [](const Values& v) { return grid(v.whole(0), v.whole(1), v.length(2), v.length(3)); }},
        {"disk",
         {{"RINGS", whole}, radius},
         "flat disc of RINGS rings",
         "disk:20",
         [](const Values& v) { return disk(v.whole(0), v.length(1)); }},
        {"cylinder",
         {{"RADIUS", length}, {"HEIGHT", length}, {"NUxNV", whole_pair}},
         "open cylinder, NU squares around and NV along",
         "cylinder:1:2:64x32",
         [](const Values& v) { return cylinder(v.length(0), v.length(1), v.whole(2), v.whole(3)); }},
        {"torus",
         {{"MAJOR", length}, {"MINOR", length}, {"NUxNV", whole_pair}},
         "torus of radii MAJOR and MINOR, NU vertices around and NV along the tube",
         "torus:1:0.4:200x80",
         [](const Values& v) { return torus(v.length(0), v.length(1), v.whole(2), v.whole(3)); }},
        {"genus",
         {{"HOLES", whole}, {"SUBDIVISIONS", whole}},
         "closed slab with HOLES square holes, its squares cut in SUBDIVISIONS^2",
         "genus:3:4",
         [](const Values& v) { return genus(v.whole(0), v.whole(1)); }},
        {"fins",
         {{"FINS", whole}, {"N", whole}},
         "FINS unit squares of N x N squares that meet along one non-manifold line",
         "fins:3:10",
         [](const Values& v) { return fins(v.whole(0), v.whole(1)); }},
        {"pinched-spheres",
         {{"LEVELS", whole}},
         "two icospheres that share one vertex",
         "pinched-spheres:2",
         [](const Values& v) { return pinched_spheres(v.whole(0)); }},
        {"circle",
         {{"N", whole}, radius},
         "closed polygon of N segments",
         "circle:100",
         [](const Values& v) { return circle(v.whole(0), v.length(1)); }},
        {"tetrahedral-cube",
         {{"N", whole}},
         "unit cube of N^3 cubes of six tetrahedra",
         "tetrahedral-cube:10",
         [](const Values& v) { return tetrahedral_cube(v.whole(0)); }},
        {"tetrahedral-ball",
         {{"N", whole}, radius},
         "ball of tetrahedra, that cube made round",
         "tetrahedral-ball:10",
         [](const Values& v) { return tetrahedral_ball(v.whole(0), v.length(1)); }},
    };
    return table;
}

/// "grid:NXxNY[:WIDTH[:HEIGHT]]"
std::string form(const Shape& shape) {
    std::string text(shape.name);
    std::string close;
    for (const Parameter& parameter : shape.parameters) {
        if (parameter.otherwise) {
            text += '[';
            close += ']';
        }
        text += ':';
        text += parameter.form;
    }
    return text + close;
}

std::vector<std::string_view> split(std::string_view text, char at) {
    std::vector<std::string_view> parts;
    while (true) {
        const auto end = text.find(at);
        parts.push_back(text.substr(0, end));
        if (end == std::string_view::npos) return parts;
        text.remove_prefix(end + 1);
    }
}

template <class Number>
bool parse(std::string_view text, Values& values) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size()) return false;
    values.add(static_cast<double>(number));
    return true;
}

bool parse(Argument kind, std::string_view text, Values& values) {
    switch (kind) {
        case Argument::whole:
            return parse<int>(text, values);
        case Argument::length:
            return parse<double>(text, values);
        case Argument::whole_pair: {
            const auto parts = split(text, 'x');
            return parts.size() == 2 && parse<int>(parts[0], values) && parse<int>(parts[1], values);
        }
    }
    return false;
}

std::string_view described(Argument kind) {
    switch (kind) {
        case Argument::whole:
            return "a whole number";
        case Argument::length:
            return "a number";
        case Argument::whole_pair:
            return "two whole numbers like 20x10";
    }
    return {};
}

}  // namespace

Mesh from_name(std::string_view name) {
    auto texts = split(name, ':');
    const auto& table = shape_table();
    const auto shape = std::ranges::find(table, texts.front(), &Shape::name);
    if (shape == table.end()) {
        std::string known;
        for (const Shape& other : table)
            known += (known.empty() ? "" : ", ") + form(other);
        throw InputError(fmt::format("there is no shape '{}'", texts.front()), "the shapes are " + known);
    }
    const std::string hint = fmt::format("write {}, for example {}", form(*shape), shape->example);
    texts.erase(texts.begin());
    if (texts.size() > shape->parameters.size()) {
        throw InputError(fmt::format("shape '{}' has {} arguments, but {} takes at most {}", name,
                                     texts.size(), shape->name, shape->parameters.size()),
                         hint);
    }
    Values values;
    for (std::size_t i = 0; i < shape->parameters.size(); ++i) {
        const Parameter& parameter = shape->parameters[i];
        if (i < texts.size()) {
            if (!parse(parameter.kind, texts[i], values)) {
                throw InputError(fmt::format("shape '{}' has '{}' where {} belongs, {}", name, texts[i],
                                             parameter.form, described(parameter.kind)),
                                 hint);
            }
        } else if (parameter.otherwise) {
            values.add(*parameter.otherwise);
        } else {
            throw InputError(
                fmt::format("shape '{}' lacks {}, {}", name, parameter.form, described(parameter.kind)),
                hint);
        }
    }
    return shape->make(values);
}

std::string list() {
    std::size_t width = 0;
    for (const Shape& shape : shape_table())
        width = std::max(width, form(shape).size());
    std::string text;
    for (const Shape& shape : shape_table()) {
        text += fmt::format("{:<{}}  {}\n", form(shape), width, shape.about);
    }
    return text;
}

}  // namespace beltrami::shapes
