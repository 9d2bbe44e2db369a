// The ten lines of the README, on a mesh that is made first.
#include <fmt/format.h>
#include <beltrami/beltrami.hpp>

using namespace beltrami;

int main() {
    write_mesh("in.obj", shapes::bumpy_sphere(2000));
    const Mesh mesh = read_mesh("in.obj");
    const Laplacian laplacian(mesh);
    const Constraints fixed{{0, 0.0}, {3, 1.0}};
    const auto [value, summary] = interpolate(laplacian, fixed, {.laplacian = 1.0, .bilaplacian = 0.1});
    write_mesh("out.ply", mesh, {{"value", value}});
    fmt::print("{}\n", summary.brief());
    return summary.converged && value(0) == 0.0 && value(3) == 1.0 ? 0 : 1;
}
