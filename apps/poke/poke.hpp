// Touching a surface: points are pressed, pulled and slid along paths, and the surface gives way where it is touched.
//
//     const SurfaceSearch surface(mesh);
//     ContactPath finger = {{{0.0, p, {0, 0, 0}}, {0.1, p, {0, 0, -0.05}}, {0.3, q, {0, 0, -0.05}}}};
//     PokeOptions options{.skin = skin_of(mesh)};
//     options.on_step = [](const PokeStep& step) { use(step.contacts[0].force, step.local.active); };
//     PokeResult result = poke(mesh, laplacian, {finger}, options);
//
// Solves alpha M u'' + (beta_1 M + beta_2 K~) u' + K~ u = f for the displacement u on a domain that adjusts itself
// (solvers/local_integrator.hpp): section 5.4 of Kim & Rossignac. A contact holds the point of the surface that it touches,
// inside a triangle if need be, so that forces do not jump while it slides.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "beltrami/framework/surface_search.hpp"
#include "beltrami/solvers/local_integrator.hpp"

namespace beltrami {

/// Where a contact is, on the surface at rest, and how far it moves that point.
struct Waypoint {
    double time = 0.0;
    Vector3 point = Vector3::Zero();
    Vector3 displacement = Vector3::Zero();
    std::string place = {};  ///< for messages: where the waypoint was written, such as "poke.csv, line 3,"
};

/// Piecewise linear in between; the point is brought to the surface at each step. The contact takes hold at the first
/// waypoint and lets go after the last.
using ContactPath = std::vector<Waypoint>;

struct PokeOptions {
    Pde skin;              ///< skin_of(mesh), or your own
    double rate = 1000.0;  ///< steps per unit of time
    /// How long to go on: by default until the surface is at rest after the last contact, at most as long again as the
    /// paths took or ten swings of the foundation, whichever is longer.
    std::optional<double> time = {};
    /// Gives each step 1 / rate seconds, of which late steps borrow from the next ones; a step that would overrun stops at
    /// its last iterate, scaled so that it adds no energy. One unit of time is then a second.
    bool real_time = false;
    /// Waypoints may lie off the surface by this part of the diagonal of the mesh's box.
    double reach = 0.01;
    LocalOptions local = {.tolerance = 1e-2};
    const Progress* progress = nullptr;
    std::function<void(const struct PokeStep&)> on_step = {};
};

struct ContactState {
    bool touching = false;
    SurfacePoint at;  ///< vertices in the user's order
    Vector3 displacement = Vector3::Zero();
    Vector3 force = Vector3::Zero();  ///< that the contact exerts, in units of K~ u
};

struct PokeStep {
    int step;
    int steps;  ///< the most that there will be
    double time;
    const LocalStep& local;
    double lag;  ///< seconds behind the clock after this step; 0 without real_time
    const std::vector<ContactState>& contacts;
    /// What is active at this moment, in slots and in the working order of the Laplacian.
    const LocalIntegrator& motion;
};

/// What a contact does to the surface during one step.
struct Contact {
    Vector3 point;  ///< is brought to the surface at rest
    Vector3 displacement;
};

/// A surface under contacts that nobody knows beforehand, such as those of a person who drags it:
///
///     TouchedSurface skin(mesh, laplacian, options);
///     const LocalStep step = skin.advance(std::array{std::optional(Contact{point, displacement})});
///     skin.contacts()[0].force;
class TouchedSurface {
  public:
    /// Of the options: skin, rate and local. Throws InputError for a rate that is not positive, a skin that has no mass, and
    /// as SurfaceSearch and LocalIntegrator do. mesh may go; laplacian is copied.
    TouchedSurface(const Mesh& mesh, const Laplacian& laplacian, const PokeOptions& options);

    /// One step of 1 / rate, with a contact, or none, in each place. Throws as LocalIntegrator::advance.
    LocalStep advance(std::span<const std::optional<Contact>> contacts,
                      std::optional<LocalIntegrator::Clock::time_point> deadline = {});

    /// Of the last step, in the order of its contacts.
    [[nodiscard]] const std::vector<ContactState>& contacts() const { return contacts_; }
    [[nodiscard]] const LocalIntegrator& motion() const { return motion_; }
    [[nodiscard]] const SurfaceSearch& surface() const { return surface_; }

  private:
    Laplacian laplacian_;
    SurfaceSearch surface_;
    LocalIntegrator motion_;
    std::vector<ContactState> contacts_;
};

struct PokeResult {
    Block displacement;  ///< n x 3 in the user's order, at the end
    int steps = 0;
    bool at_rest = false;  ///< the domain is empty
    Index most_active = 0;
    bool whole = false;       ///< at some time nothing lay outside the domain: those were global steps
    bool whole_mesh = false;  ///< and it was all of the mesh, not only the components that are touched
    int late_steps = 0;
    int unconverged_steps = 0;  ///< for another reason than the clock
    double largest_force = 0.0;
    double largest_put_in =
        0.0;  ///< LocalStep::put_in of one step, relative to the largest energy norm at that time
    double error_bound = 0.0;  ///< LocalStep::error_bound at the end, relative to the largest energy norm
    double median_seconds = 0.0;
    double percentile_99_seconds = 0.0;
    double most_seconds = 0.0;
    double work = 0.0;
    double dissipated = 0.0;
    long iterations = 0;
};

/// A skin that suits any mesh: mass 1 for each unit of area, swings back 10 times in a unit of time, critically damped, and
/// takes its surroundings along over l = 1.5 % of the diagonal of the mesh's box. With omega = 20 pi: foundation omega^2,
/// gamma_1 = omega^2 l^2 / 5, gamma_2 = omega^2 l^4, beta_1 = 2 omega.
Pde skin_of(const Mesh& mesh);

/// Throws InputError for no paths, an empty one, times that do not ascend, waypoints and ways between them that are off the surface, a rate or
/// time that is not positive, a rate that this machine cannot meet in real time even on the smallest domain, a skin that
/// has no mass, contacts in one place that are moved apart; SolveError for numbers that overflow; Cancelled after steps
/// that on_step has seen.
PokeResult poke(const Mesh& mesh, const Laplacian& laplacian, const std::vector<ContactPath>& paths,
                const PokeOptions& options);

}  // namespace beltrami
