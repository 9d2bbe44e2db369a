// The ten lines of the README, on a mesh that needs no file.
#include <fmt/format.h>
#include <beltrami/beltrami.hpp>

using namespace beltrami;

int main() {
    const Mesh mesh = shapes::icosphere(4);
    const Laplacian laplacian(mesh);
    const Constraints fixed{{0, 0.0}, {3, 1.0}};
    const auto [value, summary] = interpolate(laplacian, fixed, {.laplacian = 1.0, .bilaplacian = 0.1});
    write_mesh("out.ply", mesh, {{"value", value}});
    fmt::print("{}\n", summary.brief());
    return summary.converged && value(0) == 0.0 && value(3) == 1.0 ? 0 : 1;
}
