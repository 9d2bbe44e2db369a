#include "beltrami/operators/pde_operator.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// result = a x + b weight y, row by row; result may be x or y.
void combine(double a, const Block& x, double b, const Vector& weight, const Block& y, Block& result) {
    const Eigen::Index n = x.rows();
    const Eigen::Index k = x.cols();
    const double* const xs = x.data();
    const double* const ys = y.data();
    double* const out = result.data();
#pragma omp parallel for schedule(static) if (n > 20000)
    for (Eigen::Index v = 0; v < n; ++v) {
        const double scale = b * weight[v];
        for (Eigen::Index c = v * k; c < (v + 1) * k; ++c)
            out[c] = a * xs[c] + scale * ys[c];
    }
}

// The diagonal of K (D K)^(m - 1) for m >= 3, by walking the rings of each vertex. With s = (D K)^a e_i, a = (m - 1) / 2
// rounded down, and q = K s, the entry is q^T s for odd m and q^T D q for even m.
class RingDiagonal {
  public:
    RingDiagonal(const Laplacian& laplacian, int terms)
        : laplacian_(laplacian),
          terms_(terms),
          next_(Vector::Zero(laplacian.vertex_count())),
          reached_(static_cast<std::size_t>(laplacian.vertex_count()), 0) {}

    double entry(Index i) {
        support_ = {i};
        values_ = {1.0};
        for (int a = 0; a < (terms_ - 1) / 2; ++a) {
            multiply();
            for (std::size_t s = 0; s < support_.size(); ++s)
                values_[s] *= laplacian_.inverse_mass()[support_[s]];
        }
        const std::vector<Index> support = support_;
        const std::vector<double> values = values_;
        multiply();
        double sum = 0.0;
        if (terms_ % 2 == 0) {
            for (std::size_t s = 0; s < support_.size(); ++s) {
                sum += values_[s] * values_[s] * laplacian_.inverse_mass()[support_[s]];
            }
        } else {
            for (std::size_t s = 0; s < support_.size(); ++s)
                next_[support_[s]] = values_[s];
            for (std::size_t s = 0; s < support.size(); ++s)
                sum += values[s] * next_[support[s]];
            for (const Index j : support_)
                next_[j] = 0.0;
        }
        return sum;
    }

  private:
    // (support_, values_) <- K (support_, values_)
    void multiply() {
        const EdgeOperator<double>& K = laplacian_.stiffness();
        std::vector<Index> grown;
        const auto add = [&](Index j, double value) {
            if (reached_[static_cast<std::size_t>(j)] == 0) {
                reached_[static_cast<std::size_t>(j)] = 1;
                grown.push_back(j);
            }
            next_[j] += value;
        };
        for (std::size_t s = 0; s < support_.size(); ++s) {
            add(support_[s], K.diagonal()[support_[s]] * values_[s]);
            for (const auto& n : K.graph().neighbours(support_[s]))
                add(n.vertex, K.edges()[n.edge] * values_[s]);
        }
        support_ = std::move(grown);
        values_.clear();
        for (const Index j : support_) {
            values_.push_back(next_[j]);
            next_[j] = 0.0;
            reached_[static_cast<std::size_t>(j)] = 0;
        }
    }

    const Laplacian& laplacian_;
    int terms_;
    Vector next_;
    std::vector<char> reached_;
    std::vector<Index> support_;
    std::vector<double> values_;
};

}  // namespace

PdeOperator::PdeOperator(Laplacian laplacian, double sigma, std::vector<double> gamma)
    : laplacian_(std::move(laplacian)), sigma_(sigma), gamma_(std::move(gamma)) {
    for (const double coefficient : gamma_) {
        if (!std::isfinite(coefficient) || coefficient < 0.0) {
            throw InputError(fmt::format("a coefficient gamma is {}", coefficient),
                             "gamma must be finite and not negative, or the operator is not definite");
        }
    }
    if (!std::isfinite(sigma) || sigma < 0.0) {
        throw InputError(fmt::format("the coefficient sigma is {}", sigma),
                         "sigma must be finite and not negative");
    }
    while (!gamma_.empty() && gamma_.back() == 0.0)
        gamma_.pop_back();
}

void PdeOperator::apply(const Block& u, Block& y, Workspace& workspace) const {
    const EdgeOperator<double>& K = laplacian_.stiffness();
    const Eigen::Index n = u.rows();
    if (n != rows())
        throw InputError(fmt::format("an operator of {} rows got a field of {} rows", rows(), n),
                         "give one row a vertex, in the working order");
    y.resize(n, u.cols());
    if (gamma_.empty()) {
        y.noalias() = (sigma_ * laplacian_.mass()).asDiagonal() * u;
        return;
    }
    if (gamma_.size() == 1) {
        K.apply(u, y);
    } else {
        const Vector& D = laplacian_.inverse_mass();
        workspace.scaled.resize(n, u.cols());
        const Block* inner =
            &u;  // the innermost argument of K is gamma_m u; gamma_m is multiplied in afterwards
        double pending = gamma_.back();
        for (std::size_t i = gamma_.size() - 1; i-- > 0;) {
            K.apply(*inner, workspace.product);
            const double gamma = gamma_[i];
            combine(gamma, u, pending, D, workspace.product, workspace.scaled);
            inner = &workspace.scaled;
            pending = 1.0;
        }
        K.apply(workspace.scaled, y);
    }
    const double outer = gamma_.size() == 1 ? gamma_[0] : 1.0;
    if (outer == 1.0 && sigma_ == 0.0) return;
    combine(outer, y, sigma_, laplacian_.mass(), u, y);
}

void PdeOperator::apply(const Block& u, Block& y) const {
    Workspace workspace;
    apply(u, y, workspace);
}

Vector PdeOperator::diagonal() const {
    const EdgeOperator<double>& K = laplacian_.stiffness();
    const Vector& D = laplacian_.inverse_mass();
    Vector diagonal = sigma_ * laplacian_.mass();
    if (!gamma_.empty()) diagonal += gamma_[0] * K.diagonal();
    if (gamma_.size() >= 2 && gamma_[1] != 0.0) {
        for (Index i = 0; i < rows(); ++i) {
            double sum = D[i] * K.diagonal()[i] * K.diagonal()[i];
            for (const auto& n : K.graph().neighbours(i))
                sum += D[n.vertex] * K.edges()[n.edge] * K.edges()[n.edge];
            diagonal[i] += gamma_[1] * sum;
        }
    }
    for (std::size_t m = 3; m <= gamma_.size(); ++m) {
        if (gamma_[m - 1] == 0.0) continue;
        RingDiagonal ring(laplacian_, static_cast<int>(m));
        for (Index i = 0; i < rows(); ++i)
            diagonal[i] += gamma_[m - 1] * ring.entry(i);
    }
    return diagonal;
}

Eigen::SparseMatrix<double> PdeOperator::to_sparse() const {
    const Eigen::SparseMatrix<double> K = laplacian_.stiffness().to_sparse();
    Eigen::SparseMatrix<double> sum(rows(), rows());
    if (!gamma_.empty()) {
        // Horner: K (gamma_1 + D K (gamma_2 + ...)).
        sum = gamma_.back() * K;
        for (std::size_t i = gamma_.size() - 1; i-- > 0;) {
            const Eigen::SparseMatrix<double> scaled = laplacian_.inverse_mass().asDiagonal() * sum;
            sum = K * scaled;
            sum += gamma_[i] * K;
        }
    }
    if (sigma_ != 0.0) {
        Eigen::SparseMatrix<double> mass(rows(), rows());
        mass.reserve(Eigen::VectorXi::Ones(rows()));
        for (Index i = 0; i < rows(); ++i)
            mass.insert(i, i) = sigma_ * laplacian_.mass()[i];
        sum += mass;
    }
    sum.makeCompressed();
    return sum;
}

}  // namespace beltrami
