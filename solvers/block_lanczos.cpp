#include "beltrami/solvers/block_lanczos.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "beltrami/solvers/dense_kernels.hpp"

namespace beltrami {

BlockLanczos::BlockLanczos(const Eigenproblem& problem, const ShiftInvert& pencil, const Columns& locked,
                           const BlockLanczosOptions& options)
    : problem_(problem), pencil_(pencil), locked_(locked) {
    const Index room = problem.rows() - static_cast<Index>(locked.cols());
    capacity_ = std::min(options.capacity, room);
    const Index block = std::min(options.block, room);
    basis_.resize(problem.rows(), capacity_ + block);
    projected_ = Columns::Zero(capacity_, capacity_);
    std::mt19937 engine(options.seed);
    // Even numbers in [-1, 1]: the same on every machine, which the standard's normal distribution is not.
    Columns start = Columns::NullaryExpr(problem.rows(), block,
                                         [&] { return 2.0 * (static_cast<double>(engine()) / 4294967295.0) - 1.0; });
    remove_space(start, nullptr);
    orthonormalize(start, 0.0);
    next_ = static_cast<Index>(start.cols());
    basis_.leftCols(next_) = start;
    invariant_ = next_ == 0;
}

// W <- W - L (L^T M W) - V (V^T M W); with_last: what W had of the last block.
void BlockLanczos::remove_space(Eigen::Ref<Columns> W, Columns* with_last) {
    if (locked_.cols() > 0) {
        problem_.apply_mass(W, product_);
        add_product(-1.0, locked_, transposed_product(locked_, product_), W);
    }
    if (dimension_ == 0) return;
    problem_.apply_mass(W, product_);
    const Columns C = transposed_product(basis(0, dimension_), product_);
    add_product(-1.0, basis(0, dimension_), C, W);
    if (with_last != nullptr) *with_last = C.bottomRows(last_);
}

// W = Q R with Q^T M Q = I, by the eigenvectors of the Gram matrix, as often as it takes; W becomes Q. Directions that
// are rounding against `reference` (an M-norm; 0: against the largest) are left out, so R may have fewer rows.
Columns BlockLanczos::orthonormalize(Columns& W, double reference) {
    Columns R = Columns::Identity(W.cols(), W.cols());
    for (int round = 0; round < 5 && W.cols() > 0; ++round) {
        problem_.apply_mass(W, product_);
        const Columns gram = transposed_product(W, product_);
        if (round > 0 && (gram - Columns::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff() < 1e-14) break;
        const SymmetricEigen eigen = symmetric_eigen(gram);
        const double largest = eigen.values[eigen.values.size() - 1];
        // Entries of a Gram matrix are good to 1e-16 of its largest: smaller directions show in the second round.
        const double least = round == 0 ? 0.0 : 1e-10;
        if (round == 0 && !(largest > 1e-26 * reference * reference)) {
            W.resize(W.rows(), 0);
            return Columns(0, R.cols());
        }
        std::vector<Index> kept;
        for (Index i = 0; i < eigen.values.size(); ++i) {
            if (round != 1 || eigen.values[i] > least) kept.push_back(i);
        }
        const Vector size =
            eigen.values(kept).cwiseMax(round == 0 ? 1e-14 * largest : 0.0).cwiseSqrt();
        const Columns V = eigen.vectors(Eigen::all, kept);
        Columns Q = Columns::Zero(W.rows(), static_cast<Eigen::Index>(kept.size()));
        add_product(1.0, W, V * size.cwiseInverse().asDiagonal(), Q);
        W = std::move(Q);
        R = size.asDiagonal() * (V.transpose() * R);
        // What was small was mostly rounding that lies in the space.
        if (round < 2) remove_space(W, nullptr);
    }
    return R;
}

bool BlockLanczos::extend() {
    if (invariant_ || dimension_ + next_ > capacity_) return false;
    Columns W;
    problem_.apply_mass(basis(dimension_, next_), W);
    pencil_.solve(W);
    problem_.apply_mass(W, product_);
    const double reference = std::sqrt(W.cwiseProduct(product_).colwise().sum().maxCoeff());
    if (dimension_ > 0) {
        projected_.block(dimension_, dimension_ - last_, next_, last_) = out_;
        projected_.block(dimension_ - last_, dimension_, last_, next_) = out_.transpose();
    }
    last_ = next_;
    dimension_ += last_;
    Columns diagonal;
    remove_space(W, &diagonal);
    projected_.block(dimension_ - last_, dimension_ - last_, last_, last_) =
        0.5 * (diagonal + diagonal.transpose());
    out_ = orthonormalize(W, reference);
    next_ = static_cast<Index>(W.cols());
    invariant_ = next_ == 0;
    basis_.middleCols(dimension_, next_) = W;
    return true;
}

RitzValues BlockLanczos::ritz() {
    SymmetricEigen eigen = symmetric_eigen(projected_.topLeftCorner(dimension_, dimension_));
    theta_ = std::move(eigen.values);
    coefficients_ = std::move(eigen.vectors);
    const Vector out = (out_ * coefficients_.bottomRows(last_)).colwise().norm();
    const Vector lambda = pencil_.shift() + theta_.cwiseInverse().array();
    RitzValues ritz;
    ritz.vector.resize(static_cast<std::size_t>(dimension_));
    std::iota(ritz.vector.begin(), ritz.vector.end(), 0);
    std::sort(ritz.vector.begin(), ritz.vector.end(), [&](Index a, Index b) { return lambda[a] < lambda[b]; });
    ritz.values = lambda(ritz.vector);
    ritz.residuals = out.cwiseQuotient(theta_.cwiseAbs2())(ritz.vector);
    return ritz;
}

Columns BlockLanczos::vectors(const std::vector<Index>& chosen) const {
    const Columns s = coefficients_(Eigen::all, chosen);
    Columns h = Columns::Zero(basis_.rows(), static_cast<Eigen::Index>(chosen.size()));
    add_product(1.0, basis(0, dimension_), s, h);
    add_product(1.0, basis(dimension_, next_),
                out_ * s.bottomRows(last_) * theta_(chosen).cwiseInverse().asDiagonal(), h);
    return h;
}

std::size_t BlockLanczos::memory_bytes() const {
    return static_cast<std::size_t>(basis_.size() + product_.size()) * sizeof(double);
}

}  // namespace beltrami
