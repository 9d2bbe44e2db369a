// The eigenproblem K h = lambda M h of a mesh, on its unknowns.
//
//     const Eigenproblem problem(laplacian);                  // free, lumped mass
//     const Eigenproblem fixed(laplacian, held);              // h = 0 at the held vertices (Dirichlet)
//     const Eigenproblem full(laplacian, consistent_mass(...), held);
//
// K is the stiffness, M lumped or consistent mass: eq. (6) of Vallet & Levy 2007, and with h = M^(-1/2) g the
// symmetric operator of eq. (4) of Vallet & Levy 2008. The unknowns are the vertices with an edge that are not held:
// isolated vertices have no mass, and eigenfunctions are zero there.
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/operators/laplacian.hpp"

namespace beltrami {

/// Columns lie together here, unlike in a Block: a column is an eigenfunction.
using Columns = Eigen::MatrixXd;

/// Immutable.
class Eigenproblem {
  public:
    /// held: in the working order; their values do not matter. Throws InputError where no unknown is left, and for a
    /// mass that is not positive on an unknown.
    explicit Eigenproblem(const Laplacian& laplacian, const Constraints& held = Constraints());
    /// With a mass of its own on the same vertices, such as the consistent one.
    Eigenproblem(const Laplacian& laplacian, const EdgeOperator<double>& mass,
                 const Constraints& held = Constraints());
    /// Of matrices, such as a coarse level's: both size x size and symmetric with both triangles, M not lumped even where
    /// it is diagonal; constants: size x any, of M-norm 1. Every row is an unknown. Throws InputError for sizes that do
    /// not fit, no row, and a diagonal entry of M that is not positive.
    Eigenproblem(const Eigen::SparseMatrix<double>& K, const Eigen::SparseMatrix<double>& M,
                 const Columns& constants);

    /// The number of unknowns.
    [[nodiscard]] Index rows() const { return static_cast<Index>(vertices_.size()); }
    /// Of the mesh.
    [[nodiscard]] Index vertex_count() const { return vertex_count_; }
    /// The vertex of each unknown in the working order, ascending.
    [[nodiscard]] const std::vector<Index>& vertices() const { return vertices_; }

    /// rows() x rows(), both triangles.
    [[nodiscard]] const Eigen::SparseMatrix<double, Eigen::RowMajor>& stiffness() const { return stiffness_; }
    [[nodiscard]] bool lumped() const { return lumped_.size() > 0; }
    /// rows(); empty unless lumped().
    [[nodiscard]] const Vector& lumped_mass() const { return lumped_; }
    /// rows() x rows(); empty where lumped().
    [[nodiscard]] const Eigen::SparseMatrix<double, Eigen::RowMajor>& consistent_mass() const {
        return consistent_;
    }
    /// rows() x rows(), diagonal where it is lumped.
    [[nodiscard]] Eigen::SparseMatrix<double, Eigen::RowMajor> mass_matrix() const;
    /// The sum of all entries of M, held vertices left out: the area of a surface.
    [[nodiscard]] double total_mass() const;

    /// y = K x and y = M x, rows() x k.
    void apply_stiffness(const Eigen::Ref<const Columns>& x, Columns& y) const;
    void apply_mass(const Eigen::Ref<const Columns>& x, Columns& y) const;

    /// An M-orthonormal basis of the functions that are constant on each component with no held vertex, where K's rows
    /// sum to zero: these have the eigenvalue 0. rows() x their number.
    [[nodiscard]] const Columns& constants() const { return constants_; }

    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    void set(const Laplacian& laplacian, const EdgeOperator<double>* mass, const Constraints& held);

    Index vertex_count_ = 0;
    std::vector<Index> vertices_;
    Eigen::SparseMatrix<double, Eigen::RowMajor> stiffness_;
    Eigen::SparseMatrix<double, Eigen::RowMajor> consistent_;  // empty where lumped
    Vector lumped_;                                            // empty where consistent
    Columns constants_;
};

/// The vertex of each unknown in the user's order, which is laplacian.order().
std::vector<Index> user_vertices(const Eigenproblem& problem, const Renumbering& order);

}  // namespace beltrami
