// A V-cycle over the hierarchy of a mesh's graph: about A^-1 r, for A = sigma M + gamma K with held vertices.
//
//     const Hierarchy hierarchy(laplacian.graph(), points);       // serves every operator and every set of held vertices
//     const Multigrid cycle(A, hierarchy, held);
//     cycle.apply(r, z);                                          // z = B r, B ~ A^-1 on the rows that are not held
//     conjugate_gradients(product, inverse_diagonal, held, b, x, {.preconditioner = cycle.preconditioner()});
//
// Coarse operators are Galerkin's, P^T A P; one sweep of Gauss-Seidel goes down, its transpose up, and the coarsest level
// is factored: B is symmetric and positive definite (Briggs, Henson & McCormick, A Multigrid Tutorial, 2000). Numbers are
// floats but for those of the coarsest level, so B is linear to about 1e-7: conjugate gradients must be flexible.
// Sweeps run over a few stretches of rows at once, whose number depends on the mesh only, so results do not depend on the
// number of threads.
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <span>

#include "beltrami/framework/progress.hpp"
#include "beltrami/framework/types.hpp"
#include "beltrami/operators/pde_operator.hpp"
#include "beltrami/solvers/hierarchy.hpp"

namespace beltrami {

class Multigrid {
  public:
    /// A: n x n, symmetric positive semidefinite, both triangles; n = hierarchy.size(0). held: ascending. Rows of A that are
    /// zero are taken as held. Throws InputError for another n, SolveError where A is not positive semidefinite on the coarsest
    /// level, Cancelled.
    Multigrid(const PdeOperator& A, const Hierarchy& hierarchy, std::span<const Index> held,
              const Progress* progress = nullptr);
    Multigrid(Multigrid&&) noexcept;
    Multigrid& operator=(Multigrid&&) noexcept;
    ~Multigrid();

    /// z = B r, n x k; held rows of r are not used, and of z zero. One thread of callers at a time.
    void apply(const Block& r, Block& z) const;
    /// apply(), while this lives.
    [[nodiscard]] Product preconditioner() const;

    /// With the finest.
    [[nodiscard]] int level_count() const;
    /// Unknowns of a level, and entries of its operator a row.
    [[nodiscard]] Index size(int level) const;
    [[nodiscard]] double entries_per_row(int level) const;
    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    struct Levels;
    std::unique_ptr<Levels> levels_;
};

}  // namespace beltrami
