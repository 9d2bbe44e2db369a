#include "beltrami/apps/vectors/vectors.hpp"

#include <utility>

#include "beltrami/apps/term_weights.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/operators/tangent_frames.hpp"
#include "beltrami/solvers/tangent_field.hpp"

namespace beltrami {

VectorsResult vectors(const Mesh& mesh, const Laplacian& laplacian, const Constraints& fixed,
                      const VectorsOptions& options) {
    if (fixed.empty())
        throw InputError("no vector is given, so there is nothing to interpolate", "fix at least one");
    const std::vector<double> gamma = term_weights(options.laplacian, options.bilaplacian);
    const TangentFrames frames = tangent_frames(mesh);
    const TangentVectors given = project(frames, fixed);
    const Constraints held = hold_free_components(laplacian, given.vectors, options.free_components);
    TangentField field = options.method == VectorMethod::coordinates
                             ? solve_by_coordinates(laplacian, frames, held, gamma, options.linear)
                             : solve_by_connection(mesh, laplacian, frames, held, gamma, options.linear);
    const VectorLengths lengths = options.lengths.value_or(
        options.method == VectorMethod::connection ? VectorLengths::interpolated : VectorLengths::solved);
    if (lengths == VectorLengths::interpolated)
        field = with_interpolated_lengths(field, laplacian, held, gamma, options.linear);
    VectorsResult result;
    result.vectors = std::move(field.vectors);
    result.summary = field.summary;
    if (frames.one_sided) {
        result.singularities.undefined_triangles = mesh.cell_count();
    } else {
        result.singularities = singularities(mesh, frames, result.vectors);
    }
    result.largest_tilt = given.largest_tilt;
    result.most_tilted = given.most_tilted;
    result.without_plane = frames.cancelled();
    return result;
}

}  // namespace beltrami
