#include "beltrami/solvers/tangent_field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "beltrami/operators/connection_laplacian.hpp"
#include "beltrami/operators/hermitian_pde_operator.hpp"

namespace beltrami {

namespace {

Vector3 vector_at(const Constraints& constraints, Index v) {
    const auto value = constraints.value(v);
    return {value[0], value[1], value[2]};
}

bool has_plane(const TangentFrames& frames, Index v) {
    return frames.has_plane[static_cast<std::size_t>(v)] != 0;
}

// A x = 0 but at the held rows, from zero; in the order of the operator.
std::pair<Block, LinearSummary> solve_without_load(LinearSolver solver, const Constraints& held) {
    Block x = Block::Zero(solver.op().rows(), held.columns());
    const Block no_load = x;
    LinearSummary summary = solver.solve(no_load, held, x);
    require_converged(summary);
    return {std::move(x), std::move(summary)};
}

}  // namespace

TangentVectors project(const TangentFrames& frames, const Constraints& given) {
    if (given.columns() != 3) {
        throw InputError(fmt::format("a vector has three coordinates, but {} {} given", given.columns(),
                                     given.columns() == 1 ? "is" : "are"),
                         "give x,y,z");
    }
    given.check_range(static_cast<Index>(frames.normal.rows()));
    TangentVectors result{Constraints(3)};
    for (const Index v : given.vertices()) {
        if (!has_plane(frames, v)) {
            const bool isolated = frames.normal.row(v).isZero(0.0);
            throw InputError(fmt::format("vertex {} has no tangent plane: {}", v,
                                         isolated ? "it is in no triangle with an area"
                                                  : "the normals of the triangles around it cancel"),
                             "give the vector at another vertex");
        }
        const Vector3 vector = vector_at(given, v);
        const double length = vector.stableNorm();
        Vector3 along = Vector3::Zero();
        if (length > 0.0) {
            const Vector3 direction = vector / length;
            const Vector3 part = frames.to_vector(v, frames.to_number(v, direction));
            if (part.norm() < 1e-6) {
                throw InputError(
                    fmt::format("the vector {:g},{:g},{:g} at vertex {} is at a right angle to the surface",
                                vector.x(), vector.y(), vector.z(), v),
                    fmt::format("give one with a part along the surface, whose normal there is "
                                "{:.3g},{:.3g},{:.3g}",
                                frames.normal(v, 0), frames.normal(v, 1), frames.normal(v, 2)));
            }
            along = length * part;
            const double tilt =
                std::atan2(std::abs(direction.dot(frames.normal.row(v).transpose())), part.norm()) * 180.0 /
                std::numbers::pi;
            if (result.most_tilted < 0 || tilt > result.largest_tilt) {
                result.largest_tilt = tilt;
                result.most_tilted = v;
            }
        }
        result.vectors.fix(v, std::array{along.x(), along.y(), along.z()});
    }
    return result;
}

TangentField solve_by_coordinates(const Laplacian& laplacian, const TangentFrames& frames,
                                  const Constraints& held, const std::vector<double>& gamma,
                                  const LinearSolverOptions& options) {
    const Renumbering& order = laplacian.order();
    const auto [u, summary] =
        solve_without_load(LinearSolver(PdeOperator(laplacian, 0.0, gamma), options), order.to_working(held));
    TangentField field{order.to_user(u), summary};
    for (Index v = 0; v < laplacian.vertex_count(); ++v) {
        const Vector3 vector = field.vectors.row(v).transpose();
        field.vectors.row(v).setZero();
        if (has_plane(frames, v)) field.vectors.row(v) = frames.to_vector(v, frames.to_number(v, vector));
    }
    return field;
}

TangentField solve_by_connection(const Mesh& mesh, const Laplacian& laplacian, const TangentFrames& frames,
                                 const Constraints& held, const std::vector<double>& gamma,
                                 const LinearSolverOptions& options) {
    LinearSolver solver(
        HermitianPdeOperator(connection_laplacian(mesh, laplacian, frames), laplacian, 0.0, gamma), options);
    const Renumbering& order = laplacian.order();
    Constraints parts;
    for (const Index v : held.vertices()) {
        const std::complex<double> z = frames.to_number(v, vector_at(held, v));
        parts.fix(2 * order.working(v), z.real());
        parts.fix(2 * order.working(v) + 1, z.imag());
    }
    const auto [x, summary] = solve_without_load(std::move(solver), parts);
    const auto z = HermitianPdeOperator::to_complex(x);
    TangentField field{Block::Zero(laplacian.vertex_count(), 3), summary};
    for (Index v = 0; v < laplacian.vertex_count(); ++v) {
        if (has_plane(frames, v)) field.vectors.row(v) = frames.to_vector(v, z(order.working(v), 0));
    }
    return field;
}

TangentField with_interpolated_lengths(const TangentField& field, const Laplacian& laplacian,
                                       const Constraints& held, const std::vector<double>& gamma,
                                       const LinearSolverOptions& options) {
    Constraints lengths;
    for (const Index v : held.vertices())
        lengths.fix(v, vector_at(held, v).stableNorm());
    const Renumbering& order = laplacian.order();
    const auto [u, summary] = solve_without_load(LinearSolver(PdeOperator(laplacian, 0.0, gamma), options),
                                                 order.to_working(lengths));
    TangentField result = field;
    result.summary.add(summary);
    for (Index v = 0; v < laplacian.vertex_count(); ++v) {
        const double length = std::max(0.0, u(order.working(v), 0));
        result.vectors.row(v) = length * field.vectors.row(v).stableNormalized();
    }
    return result;
}

}  // namespace beltrami
