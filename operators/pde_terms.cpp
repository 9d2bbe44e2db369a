#include "beltrami/operators/pde_terms.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

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

// K (gamma + D A), where A has its diagonal stored. A general library's product takes several times as long: it runs on one
// core, and sorts by transposing twice.
template <class Scalar>
Eigen::SparseMatrix<Scalar> wrapped(const Eigen::SparseMatrix<Scalar>& K, double gamma, const Vector& D,
                                    const Eigen::SparseMatrix<Scalar>& A) {
    using Entry = typename Eigen::SparseMatrix<Scalar>::InnerIterator;
    const auto n = static_cast<Index>(K.cols());
    struct Columns {
        std::vector<Index> size;
        std::vector<Index> row;
        std::vector<Scalar> value;
    };
    const int threads = n < 10000 ? 1 : omp_get_max_threads();
    std::vector<Columns> parts(static_cast<std::size_t>(threads));
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int t = 0; t < threads; ++t) {
        const auto begin = [&](int part) {
            return static_cast<Index>(static_cast<std::ptrdiff_t>(n) * part / threads);
        };
        auto& [size, row, value] = parts[static_cast<std::size_t>(t)];
        const auto expected = static_cast<std::size_t>(3 * A.nonZeros() / threads);  // of surfaces
        row.reserve(expected);
        value.reserve(expected);
        std::vector<Scalar> sum(static_cast<std::size_t>(n));
        std::vector<Index> reached(static_cast<std::size_t>(n), -1);  // the last column that has the row
        for (Index j = begin(t); j < begin(t + 1); ++j) {
            const auto first = static_cast<std::ptrdiff_t>(row.size());
            for (Entry a(A, j); a; ++a) {
                const auto k = static_cast<Index>(a.row());
                const Scalar factor = D[k] * a.value() + (k == j ? gamma : 0.0);
                for (Entry entry(K, k); entry; ++entry) {
                    const auto i = static_cast<std::size_t>(entry.row());
                    if (reached[i] != j) {
                        reached[i] = j;
                        sum[i] = 0.0;
                        row.push_back(static_cast<Index>(i));
                    }
                    sum[i] += entry.value() * factor;
                }
            }
            std::sort(row.begin() + first, row.end());
            for (auto i = row.begin() + first; i != row.end(); ++i)
                value.push_back(sum[static_cast<std::size_t>(*i)]);
            size.push_back(static_cast<Index>(row.end() - row.begin() - first));
        }
    }
    std::size_t entries = 0;
    for (const Columns& part : parts)
        entries += part.row.size();
    Eigen::SparseMatrix<Scalar> product(n, n);
    product.resizeNonZeros(static_cast<Eigen::Index>(entries));
    Index* end = product.outerIndexPtr();
    Index* to_row = product.innerIndexPtr();
    Scalar* to_value = product.valuePtr();
    for (const auto& [size, row, value] : parts) {
        for (const Index s : size) {
            end[1] = end[0] + s;
            ++end;
        }
        to_row = std::copy(row.begin(), row.end(), to_row);
        to_value = std::copy(value.begin(), value.end(), to_value);
    }
    return product;
}

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
    Sparse sum(n, n);
    if (!gamma.empty()) {
        // Horner: K (gamma_1 + D K (gamma_2 + ...)).
        const Sparse stiffness = K.to_sparse();
        sum = Scalar(gamma.back()) * stiffness;
        for (std::size_t i = gamma.size() - 1; i-- > 0;)
            sum = wrapped(stiffness, gamma[i], D, sum);
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
