// The Laplacian of a mesh, ready for solvers: stiffness K and lumped mass M in the working order, and the order itself.
//
//     const Laplacian laplacian(mesh);
//     laplacian.stiffness().apply(u, y);               // u in the working order
//     Block u = laplacian.order().to_working(field);   // the door from the user's order
//
// -D K u, with D = M^-1, approximates the Laplace-Beltrami operator at each vertex (eq. (7) of Kim & Rossignac).
#pragma once

#include <memory>

#include "beltrami/framework/mesh.hpp"
#include "beltrami/framework/renumbering.hpp"
#include "beltrami/operators/edge_operator.hpp"
#include "beltrami/operators/mass.hpp"

namespace beltrami {

enum class Weights { cotangent, area_weighted, combinatorial };

struct LaplacianOptions {
    Mass mass = Mass::barycentric;
    /// `cotangent` is the linear-element stiffness of whatever cells the mesh has.
    Weights weights = Weights::cotangent;
    /// Cuthill-McKee: makes products 3 to 4 times faster on meshes whose vertices come in no order.
    bool renumber = true;
};

/// Immutable, and cheap to copy: copies share the numbers.
class Laplacian {
  public:
    /// Degenerate cells are left out and counted. Throws InputError for a mesh without cells.
    explicit Laplacian(const Mesh& mesh, const LaplacianOptions& options = {});

    /// From an operator of your own; mass: n, in the numbering of the operator's graph, as working numbers of `order`.
    Laplacian(EdgeOperator<double> stiffness, Vector mass, Renumbering order);

    [[nodiscard]] Index vertex_count() const { return stiffness_->rows(); }
    [[nodiscard]] const EdgeGraph& graph() const { return stiffness_->graph(); }
    [[nodiscard]] const EdgeOperator<double>& stiffness() const { return *stiffness_; }
    [[nodiscard]] const Vector& mass() const { return lumped_->mass; }
    /// D: 1 / mass, and 0 where the mass is 0.
    [[nodiscard]] const Vector& inverse_mass() const { return lumped_->inverse; }
    [[nodiscard]] const Renumbering& order() const { return *order_; }
    /// n x 3 in the working order, for who coarsens the mesh; null for an operator of your own.
    [[nodiscard]] const std::shared_ptr<const Points>& points() const { return points_; }

    [[nodiscard]] Index left_out_cells() const { return left_out_cells_; }
    /// Vertices without an edge: in no cell, or in degenerate cells only. Solves leave them as they are.
    [[nodiscard]] Index isolated_vertices() const { return isolated_vertices_; }

    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    struct Lumped {
        Vector mass;
        Vector inverse;
    };
    void set(EdgeOperator<double> stiffness, Vector mass, Renumbering order);

    std::shared_ptr<const EdgeOperator<double>> stiffness_;
    std::shared_ptr<const Lumped> lumped_;
    std::shared_ptr<const Renumbering> order_;
    std::shared_ptr<const Points> points_;
    Index left_out_cells_ = 0;
    Index isolated_vertices_ = 0;
};

/// 1/2 u^T K u, summed over the columns: how rough a field is. u: n x k in the working order.
double dirichlet_energy(const Laplacian& laplacian, const Block& u);

}  // namespace beltrami
