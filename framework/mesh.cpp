#include "beltrami/framework/mesh.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <limits>
#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

std::string_view plural(CellKind kind) {
    switch (kind) {
        case CellKind::point:
            return "points";
        case CellKind::segment:
            return "segments";
        case CellKind::triangle:
            return "triangles";
        case CellKind::tetrahedron:
            return "tetrahedra";
    }
    return "cells";
}

Mesh::Mesh(Points points, Fields fields)
    : points_(std::move(points)), cells_(0, 1), fields_(std::move(fields)), kind_(CellKind::point) {
    validate();
}

Mesh::Mesh(Points points, Cells cells, Fields fields)
    : points_(std::move(points)), cells_(std::move(cells)), fields_(std::move(fields)), kind_() {
    if (cells_.cols() < 2 || cells_.cols() > 4) {
        throw InputError(fmt::format("cells have {} vertices each", cells_.cols()),
                         "give segments (2), triangles (3) or tetrahedra (4)");
    }
    kind_ = static_cast<CellKind>(cells_.cols());
    validate();
}

void Mesh::validate() const {
    constexpr auto most = std::numeric_limits<Index>::max();
    if (points_.rows() > most || cells_.rows() > most) {
        throw InputError("the mesh has more than 2^31 - 1 vertices or cells", "split it into parts");
    }
    for (Eigen::Index i = 0; i < points_.rows(); ++i) {
        if (!points_.row(i).allFinite()) {
            throw InputError(fmt::format("vertex {} has a coordinate that is not a finite number", i),
                             "remove the vertex or mend its position in the file");
        }
    }
    for (Eigen::Index c = 0; c < cells_.rows(); ++c) {
        for (Eigen::Index k = 0; k < cells_.cols(); ++k) {
            const Index v = cells_(c, k);
            if (v < 0 || v >= points_.rows()) {
                throw InputError(fmt::format("cell {} names vertex {}, but the vertices are 0 to {}", c, v,
                                             points_.rows() - 1),
                                 "the file is damaged or its numbering does not start where its format says");
            }
        }
    }
    for (std::size_t f = 0; f < fields_.size(); ++f) {
        if (fields_[f].values.rows() != points_.rows()) {
            throw InputError(fmt::format("field '{}' has {} values for {} vertices", fields_[f].name,
                                         fields_[f].values.rows(), points_.rows()),
                             "give one row a vertex");
        }
        for (std::size_t g = 0; g < f; ++g) {
            if (fields_[g].name == fields_[f].name) {
                throw InputError(fmt::format("two fields are named '{}'", fields_[f].name),
                                 "rename one of them");
            }
        }
    }
}

const Field* Mesh::find_field(std::string_view name) const {
    for (const Field& field : fields_) {
        if (field.name == name) return &field;
    }
    return nullptr;
}

const Field& Mesh::field(std::string_view name) const {
    if (const Field* found = find_field(name)) return *found;
    std::vector<std::string> names;
    for (const Field& field : fields_)
        names.push_back(field.name);
    throw InputError(fmt::format("the mesh carries no vertex field '{}'", name),
                     names.empty()
                         ? std::string("its file carries no vertex fields at all; PLY and VTU files can")
                         : fmt::format("it carries: {}", fmt::join(names, ", ")));
}

Mesh Mesh::with_notes(std::vector<std::string> notes) const {
    Mesh copy = *this;
    copy.notes_ = std::move(notes);
    return copy;
}

Mesh Mesh::with_points(Points points) const {
    if (points.rows() != points_.rows()) {
        throw InputError(fmt::format("{} positions for {} vertices", points.rows(), points_.rows()),
                         "give a position for each vertex");
    }
    Mesh copy = *this;
    copy.points_ = std::move(points);
    copy.validate();
    return copy;
}

std::size_t Mesh::memory_bytes() const {
    auto bytes = sizeof(double) * static_cast<std::size_t>(points_.size()) +
                 sizeof(Index) * static_cast<std::size_t>(cells_.size());
    for (const Field& field : fields_)
        bytes += sizeof(double) * static_cast<std::size_t>(field.values.size());
    return bytes;
}

}  // namespace beltrami
