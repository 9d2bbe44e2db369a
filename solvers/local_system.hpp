// (mass M + stiffness K~) x = b on the active vertices of a domain, and how much is missing to the equation of the whole
// mesh: what the local solvers share.
//
// Points are held by constraints sum_j w_j x(v_j) = value: a vertex (one weight of 1), or a point inside a cell (its
// barycentric coordinates), so that a contact can slide over the mesh without jumping from vertex to vertex. They are kept
// by conjugate gradients in their null space, with the Jacobi preconditioner projected on it (Gould, Hribar & Nocedal
// 2001); a held vertex is the masking of section 4.1 of Kim & Rossignac.
//
// The bound: with A = mass M + stiffness K~ on the whole mesh, x the local field continued by zero, r = b - A x - C^T f
// the residual of the whole mesh, f any forces at the held points, and x* the global solution,
//     |x - x*|_A^2 <= r^T A^-1 r <= r^T M^-1 r / sigma,        sigma = mass + stiffness * foundation,
// because A >= sigma M. r is zero beyond the rings that the domain keeps, so the bound costs one local product.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "beltrami/framework/active_domain.hpp"
#include "beltrami/operators/local_operator.hpp"
#include "beltrami/solvers/cholesky.hpp"

namespace beltrami {

/// sum of weights[j] x(vertices[j]) = value, in the working order; the vertices differ, the weights sum to one.
struct Hold {
    std::vector<Index> vertices;
    std::vector<double> weights = {1.0};
    std::vector<double> value;  ///< k numbers
};

class LocalSystem {
  public:
    using Clock = std::chrono::steady_clock;

    /// K~ = stiffness, whose sigma is the foundation. k columns. Throws InputError for no columns, and for a mesh with a
    /// vertex that has edges but no mass.
    LocalSystem(PdeOperator stiffness, Index columns);

    [[nodiscard]] const ActiveDomain& domain() const { return domain_; }
    [[nodiscard]] LocalOperator& op() { return operator_; }
    [[nodiscard]] const LocalOperator& op() const { return operator_; }
    [[nodiscard]] Index columns() const { return x.columns(); }

    /// The unknown, the right-hand side (on all slots) and b - A x (on all slots after compute_residual(), on the active ones
    /// while solving).
    SlotField x, b, r;

    /// The vertices that points are held at: to be activated before prepare(). Throws InputError for a hold without
    /// vertices, with a vertex twice, one that is not of the mesh or has no edges, weights that are not one a vertex and of
    /// sum 1, and values that are not k numbers of a size between 1e-100 and 1e100 (or 0).
    [[nodiscard]] std::vector<Index> vertices_of(std::span<const Hold> holds) const;

    /// Fields of the caller that follow the domain with the system's own.
    template <class... Fields>
    void activate(std::span<const Index> vertices, Fields&... fields) {
        domain_.activate(vertices);
        follow(fields...);
    }
    /// x and the caller's fields become zero there.
    template <class... Fields>
    void deactivate(std::span<const Index> vertices, Fields&... fields) {
        for (const Index v : vertices) {
            const Index s = domain_.slot(v);
            x.fill_zero(s, s + 1);
            (fields.fill_zero(s, s + 1), ...);
        }
        domain_.deactivate(vertices);
        follow(fields...);
    }
    template <class... Fields>
    void clear(Fields&... fields) {
        domain_.clear();
        follow(fields...);
    }

    /// Sets the coefficients and the held points, all of whose vertices are active. To be called again when the domain has
    /// changed. Throws InputError for a vertex that is not active.
    void prepare(LocalOperator::Weights weights, std::span<const Hold> holds);

    /// Changes x the least (in the preconditioner's norm) so that the held points have their values. Throws InputError
    /// where they cannot have: two points in the same place with different values.
    void impose();

    /// The residual on all slots, by one product.
    void compute_residual();

    /// What is missing, each as the square of its part of r^T M^-1 r without the forces at held points.
    struct Missing {
        double inside = 0.0;   ///< at active vertices: what the iteration has left
        double outside = 0.0;  ///< in the rings: what the rest of the mesh would have done
        [[nodiscard]] double total() const { return inside + outside; }
    };
    /// After compute_residual().
    [[nodiscard]] Missing missing() const;
    /// The same, after factorize(), with the factor of all active vertices, by one product more: with z = A_SS^-1 r_S,
    ///     r^T A^-1 r = r^T z + (r - A z)^T A^-1 (r - A z),
    /// and r - A z lies in the rings but for rounding. Sharper than missing() where cells are thin.
    [[nodiscard]] Missing missing_by_factor();
    /// Vertices of the rings whose share in `outside` is above `budget` / (their number): where to grow so that less
    /// than the budget is left, as far as this residual tells.
    [[nodiscard]] std::vector<Index> growth(double budget) const;

    /// Factors the matrix of the active vertices: from now on it preconditions iterate(), together with Jacobi for those
    /// that have become active since. Worth it where Jacobi alone takes hundreds of iterations: K D K, slivers. False
    /// where it is not positive definite to double precision.
    bool factorize();
    void forget_factor() { factor_.reset(); }

    struct Iterations {
        int count = 0;
        bool in_time = true;   ///< false: stopped by the deadline
        bool definite = true;  ///< false: broke down
    };
    /// Conjugate gradients from x, whose residual compute_residual() has left in r, until Missing::inside <= target, or
    /// the limit, or the deadline; at least `least` steps are taken where there is a residual at all.
    Iterations iterate(double target, int most, std::optional<Clock::time_point> deadline, int least = 0);

    /// For an iteration that was stopped: scales what x has beyond the held values so that x^T r does no work, which a
    /// converged x and every iterate that started from zero have. The residual is that of x before and after.
    void balance();

    /// The forces at the held points (c x k) that balance r best: rows of eq. (16).
    [[nodiscard]] Block forces() const;

    /// What can be let go: the active vertices of least size, of a total below the budget, none of them in a hold, whose
    /// neighbours are of that kind too or not active. size(slot): an energy of the vertex.
    template <class Size>
    [[nodiscard]] std::vector<Index> quiet_vertices(double budget, Size size);

    /// Of the part d of a field u that lies at some active vertices, by one product.
    struct Part {
        double own = 0.0;  ///< d^T K~ d
        double all = 0.0;  ///< u^T K~ d
    };
    [[nodiscard]] Part part(std::span<const Index> vertices, const SlotField& u);

    /// a^T b over the active vertices, all columns.
    [[nodiscard]] double dot(const SlotField& a, const SlotField& b) const;

    [[nodiscard]] double sigma() const { return weights_.mass + weights_.stiffness * operator_.op().sigma(); }
    /// Bytes of compact storage streamed through so far.
    [[nodiscard]] double bytes() const { return bytes_ + operator_.bytes(); }
    /// Of everything that grows with the domain.
    [[nodiscard]] std::size_t memory_bytes() const;

  private:
    // The held points: C over the h slots that they name (the residual there is mostly force, so those rows are always
    // projected before they are squared), and the inverse of C W C^T for the weights W of the two norms.
    struct Held {
        std::vector<Index> slots;
        Eigen::MatrixXd C;                             // c x h
        Eigen::MatrixXd value;                         // c x k
        Eigen::VectorXd preconditioner, inverse_mass;  // h
        Eigen::MatrixXd inverse_gram_preconditioner, inverse_gram_mass;
    };

    template <class... Fields>
    void follow(Fields&... fields) {
        domain_.replay(together(operator_, x, b, r, p_, q_, z_, fields...));
    }
    [[nodiscard]] Eigen::MatrixXd at_held(const SlotField& field) const;
    void lift(const Eigen::MatrixXd& values, SlotField& field) const;
    void fit_factor();
    void apply_factor(Block& block) const;
    double precondition();
    [[nodiscard]] Eigen::MatrixXd projected(const Eigen::VectorXd& weight,
                                            const Eigen::MatrixXd& inverse_gram) const;

    ActiveDomain domain_;
    LocalOperator operator_;
    SlotField p_, q_;
    LocalOperator::Weights weights_;
    Held held_;
    std::vector<double> preconditioner_, inverse_mass_;  // of the active slots, 0 at held ones
    struct Factor {
        Cholesky cholesky;
        std::vector<Index> vertices;  // of each row
        std::vector<Index> slots;     // of each row now, 0 where the vertex is no longer active
        std::vector<char> has_row;    // of each slot below end(0)
        Block spread;                 // B C^T over the slots below end(0)
        Eigen::MatrixXd inverse_gram;
    };
    std::optional<Factor> factor_;
    SlotField z_;
    std::vector<char> quiet_;
    std::vector<double> sizes_;
    double bytes_ = 0.0;
};

template <class Size>
std::vector<Index> LocalSystem::quiet_vertices(double budget, Size size) {
    const Index end = domain_.end(0);
    sizes_.assign(static_cast<std::size_t>(domain_.slot_count()), 0.0);
    std::array<double, 256> sums{};  // of the sizes of each power of two below the budget
    const auto bucket = [&](double part) {
        return part < std::ldexp(budget, -254) ? 255 : std::min(255, -std::ilogb(part / budget));
    };
    std::vector<Index> quiet;
    for (Index s = 1; s < end; ++s) {
        const double own = size(s);
        sizes_[static_cast<std::size_t>(s)] = own;
        if (own > 0.0 && own < budget) sums[static_cast<std::size_t>(bucket(own))] += own;
    }
    // From the smallest sizes up, as far as the budget goes.
    double limit = 0.0;
    double sum = 0.0;
    for (int b = 255; b >= 1 && sum + sums[static_cast<std::size_t>(b)] <= budget; --b) {
        sum += sums[static_cast<std::size_t>(b)];
        limit = std::ldexp(budget, 1 - b);
    }
    quiet_.assign(static_cast<std::size_t>(domain_.slot_count()), 1);
    for (Index s = 1; s < end; ++s)
        quiet_[static_cast<std::size_t>(s)] = sizes_[static_cast<std::size_t>(s)] < limit ? 1 : 0;
    for (const Index s : held_.slots)
        quiet_[static_cast<std::size_t>(s)] = 0;
    for (Index s = 1; s < end; ++s) {
        bool alone = quiet_[static_cast<std::size_t>(s)] != 0;
        if (!alone) continue;
        for (const Index q : domain_.row(s))
            alone = alone && quiet_[static_cast<std::size_t>(q)] != 0;
        if (alone) quiet.push_back(domain_.vertex(s));
    }
    return quiet;
}

}  // namespace beltrami
