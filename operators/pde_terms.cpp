#include "beltrami/operators/pde_terms.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// The diagonal of K (D K)^(m - 1) for m >= 3, by walking the rings of each vertex. With s = (D K)^a e_i, a = (m - 1) / 2
// rounded down, and q = K s, the entry is s^* q for odd m and q^* D q for even m.
template <class Scalar>
class RingDiagonal {
  public:
    RingDiagonal(const EdgeOperator<Scalar>& K, const Vector& D, int terms)
        : K_(K),
          D_(D),
          terms_(terms),
          next_(EdgeOperator<Scalar>::Array::Zero(K.rows())),
          reached_(static_cast<std::size_t>(K.rows()), 0) {}

    double entry(Index i) {
        support_ = {i};
        values_ = {Scalar(1.0)};
        for (int a = 0; a < (terms_ - 1) / 2; ++a) {
            multiply();
            for (std::size_t s = 0; s < support_.size(); ++s)
                values_[s] *= D_[support_[s]];
        }
        const std::vector<Index> support = support_;
        const std::vector<Scalar> values = values_;
        multiply();
        double sum = 0.0;
        if (terms_ % 2 == 0) {
            for (std::size_t s = 0; s < support_.size(); ++s)
                sum += Eigen::numext::abs2(values_[s]) * D_[support_[s]];
        } else {
            for (std::size_t s = 0; s < support_.size(); ++s)
                next_[support_[s]] = values_[s];
            for (std::size_t s = 0; s < support.size(); ++s)
                sum += Eigen::numext::real(Eigen::numext::conj(values[s]) * next_[support[s]]);
            for (const Index j : support_)
                next_[j] = Scalar(0.0);
        }
        return sum;
    }

  private:
    // (support_, values_) <- K (support_, values_)
    void multiply() {
        std::vector<Index> grown;
        const auto add = [&](Index j, Scalar value) {
            if (reached_[static_cast<std::size_t>(j)] == 0) {
                reached_[static_cast<std::size_t>(j)] = 1;
                grown.push_back(j);
            }
            next_[j] += value;
        };
        for (std::size_t s = 0; s < support_.size(); ++s) {
            const Index i = support_[s];
            add(i, K_.diagonal()[i] * values_[s]);
            for (const auto& n : K_.graph().neighbours(i)) {
                // An edge holds the entry of its lower row.
                const Scalar entry = K_.edges()[n.edge];
                add(n.vertex, (n.vertex < i ? entry : Eigen::numext::conj(entry)) * values_[s]);
            }
        }
        support_ = std::move(grown);
        values_.clear();
        for (const Index j : support_) {
            values_.push_back(next_[j]);
            next_[j] = Scalar(0.0);
            reached_[static_cast<std::size_t>(j)] = 0;
        }
    }

    const EdgeOperator<Scalar>& K_;
    const Vector& D_;
    int terms_;
    typename EdgeOperator<Scalar>::Array next_;
    std::vector<char> reached_;
    std::vector<Index> support_;
    std::vector<Scalar> values_;
};

}  // namespace

std::vector<double> checked_coefficients(double sigma, std::vector<double> gamma) {
    for (const double coefficient : gamma) {
        if (!std::isfinite(coefficient) || coefficient < 0.0) {
            throw InputError(fmt::format("a coefficient gamma is {}", coefficient),
                             "gamma must be finite and not negative, or the operator is not definite");
        }
    }
    if (!std::isfinite(sigma) || sigma < 0.0) {
        throw InputError(fmt::format("the coefficient sigma is {}", sigma),
                         "sigma must be finite and not negative");
    }
    while (!gamma.empty() && gamma.back() == 0.0)
        gamma.pop_back();
    return gamma;
}

template <class Scalar>
void PdeTerms<Scalar>::apply(const BlockOf<Scalar>& u, BlockOf<Scalar>& y,
                             PdeWorkspace<Scalar>& workspace) const {
    const Eigen::Index n = u.rows();
    if (n != K.rows())
        throw InputError(fmt::format("an operator of {} rows got a field of {} rows", K.rows(), n),
                         "give one row a vertex, in the working order");
    y.resize(n, u.cols());
    if (gamma.empty()) {
        y.noalias() = (sigma * M).asDiagonal() * u;
        return;
    }
    // Horner, from the inside: x <- gamma_i u + D K x, where the innermost x is gamma_m u. gamma_m is multiplied in
    // after the first product.
    std::vector<ChainLink> links;
    double pending = gamma.back();
    for (std::size_t i = gamma.size() - 1; i-- > 0;) {
        links.push_back({pending, &D, gamma[i], nullptr});
        pending = 1.0;
    }
    links.push_back({pending, nullptr, sigma, &M});
    K.apply_chain(links, u, y, workspace);
}

template <class Scalar>
Vector PdeTerms<Scalar>::diagonal() const {
    Vector diagonal = sigma * M;
    if (!gamma.empty()) diagonal += gamma[0] * K.diagonal().real();
    if (gamma.size() >= 2 && gamma[1] != 0.0) {
        for (Index i = 0; i < K.rows(); ++i) {
            double sum = D[i] * Eigen::numext::abs2(K.diagonal()[i]);
            for (const auto& n : K.graph().neighbours(i))
                sum += D[n.vertex] * Eigen::numext::abs2(K.edges()[n.edge]);
            diagonal[i] += gamma[1] * sum;
        }
    }
    for (std::size_t m = 3; m <= gamma.size(); ++m) {
        if (gamma[m - 1] == 0.0) continue;
        RingDiagonal<Scalar> ring(K, D, static_cast<int>(m));
        for (Index i = 0; i < K.rows(); ++i)
            diagonal[i] += gamma[m - 1] * ring.entry(i);
    }
    return diagonal;
}

template <class Scalar>
Eigen::SparseMatrix<Scalar> PdeTerms<Scalar>::to_sparse() const {
    using Sparse = Eigen::SparseMatrix<Scalar>;
    const Index n = K.rows();
    const Sparse stiffness = K.to_sparse();
    Sparse sum(n, n);
    if (!gamma.empty()) {
        // Horner: K (gamma_1 + D K (gamma_2 + ...)).
        sum = Scalar(gamma.back()) * stiffness;
        for (std::size_t i = gamma.size() - 1; i-- > 0;) {
            const Sparse scaled = D.template cast<Scalar>().asDiagonal() * sum;
            sum = stiffness * scaled;
            sum += Scalar(gamma[i]) * stiffness;
        }
    }
    if (sigma != 0.0) {
        Sparse mass(n, n);
        mass.reserve(Eigen::VectorXi::Ones(n));
        for (Index i = 0; i < n; ++i)
            mass.insert(i, i) = sigma * M[i];
        sum += mass;
    }
    sum.makeCompressed();
    return sum;
}

template struct PdeTerms<double>;
template struct PdeTerms<std::complex<double>>;

}  // namespace beltrami
