// The flow of a surface to a membrane: K is evaluated anew at every step, each triangle weighted by its area.
//
//     MembraneFlow flow(mesh, held);               // held at a displacement of zero
//     while (!flow.at_rest())
//         flow.advance();
//     flow.points();
//
// One step solves (M + dt W) x^{n+1} = M x^n with M and W = sum of A_e K_e those of x^n: section 5.2 of Kim & Rossignac,
// with beta_1 = 1. Since K_e x is the gradient of the triangle's area (Pinkall & Polthier 1993), W x is that of
//
//     E = 1/2 sum of A_e^2,
//
// so every step goes down the slope of E; one that would raise it is taken with half the dt, and again. Where E is
// least, the normal part of its slope is A_e times the mean curvature and the tangential part the gradient of A_e: a
// minimal surface of equal triangles, as far as the mesh allows. With cotangent weights W = K, E is the area itself,
// which no step of any size can raise, and nothing keeps triangles from collapsing.
#pragma once

#include <memory>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/framework/mesh.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "beltrami/solvers/linear_solver.hpp"

namespace beltrami {

struct MembraneFlowOptions {
    Weights weights = Weights::area_weighted;  ///< or cotangent
    /// Without a unit, so that it means the same on every scale and resolution: in time 1, smoothing reaches about
    /// across the part that moves. dt = step x (number of moving triangles), which has no unit since W and M are both
    /// areas; with cotangent weights step x (their area at the start).
    double step = 1.0;
    /// At rest when E falls by less than this share of what it was at the start, in a step or a time of 1, whichever is
    /// longer.
    double rest = 1e-5;
    /// Solves stop at a tolerance of 1e-8 at the least: what a step did is measured afterwards.
    LinearSolverOptions linear = {};
};

class MembraneFlow {
  public:
    /// held: three columns of zeros. Mesh and held in the same order, whose bandwidth the solves profit from. Throws
    /// InputError for cells that are not triangles, a step or rest that is not positive, weights that are neither, a
    /// held vertex out of range, and nothing held.
    MembraneFlow(const Mesh& mesh, Constraints held, const MembraneFlowOptions& options = {});

    /// One step, halved until it lowers E; nothing where no step does, and then the flow is at rest. Vertices all of
    /// whose triangles are degenerate stay where they are. Throws Cancelled.
    void advance();

    [[nodiscard]] const Points& points() const { return moving_.points(); }
    [[nodiscard]] bool at_rest() const { return at_rest_; }
    /// How near rest the last step came, 1 at rest: by the logarithm of the fall of E.
    [[nodiscard]] double nearness() const { return nearness_; }
    [[nodiscard]] double time() const { return time_; }  ///< the sum of the steps taken
    [[nodiscard]] int step_count() const { return step_count_; }
    [[nodiscard]] double area() const { return now_.area; }      ///< of the triangles that move
    [[nodiscard]] double energy() const { return now_.energy; }  ///< E
    /// All linear solves so far, those of steps that were halved too.
    [[nodiscard]] const LinearSummary& summary() const { return summary_; }

  private:
    struct Size {
        double area;
        double energy;
    };
    [[nodiscard]] Size size_of(const Mesh& mesh) const;

    Constraints held_;
    MembraneFlowOptions options_;
    Mesh moving_;  // all vertices, and the triangles of which a corner is free
    std::shared_ptr<const EdgeGraph> graph_;
    double unit_;  // of time, in dt
    double step_;
    Size now_;
    double energy_at_start_;
    bool at_rest_ = false;
    double nearness_ = 0.0;
    double time_ = 0.0;
    int step_count_ = 0;
    LinearSummary summary_;
};

}  // namespace beltrami
