#include "beltrami/solvers/block_lanczos.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "beltrami/solvers/dense_kernels.hpp"

namespace beltrami {

namespace {

Index panels_for(Index columns) {
    return (columns + panel_width - 1) / panel_width;
}

Index space_panels(const Eigenproblem& problem, Index locked, Index capacity) {
    return panels_for(std::max(std::min(capacity, problem.rows() - locked), 1));
}

// Of a panel W with a Gram matrix: Q = W normalizer is orthonormal, W = Q part.
struct Directions {
    double largest = 0.0;           // eigenvalue of the Gram matrix; 0 where none counts
    bool well_conditioned = false;  // but for directions that do not count
    PanelProduct normalizer;
    PanelProduct part;
};

// Entries of a Gram matrix are good to 1e-16 of its largest: smaller directions of W show once it is normalized, and
// become zero columns then.
Directions directions_of(const PanelProduct& gram, bool normalized) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, panel_width, panel_width>> eigen(gram);
    const auto& values = eigen.eigenvalues();
    Directions w;
    w.largest = values[panel_width - 1];
    w.well_conditioned = true;
    Eigen::Matrix<double, panel_width, 1> size;
    Eigen::Matrix<double, panel_width, 1> inverse;
    for (Index i = 0; i < panel_width; ++i) {
        const bool null = normalized && values[i] < 1e-10;
        w.well_conditioned = w.well_conditioned && (null || values[i] > 1e-6 * w.largest);
        size[i] = null ? 0.0 : std::sqrt(normalized ? values[i] : std::max(values[i], 1e-14 * w.largest));
        inverse[i] = null ? 0.0 : 1.0 / size[i];
    }
    if (normalized && w.largest < 1e-10) w.largest = 0.0;
    w.normalizer = eigen.eigenvectors() * inverse.asDiagonal();
    w.part = size.asDiagonal() * eigen.eigenvectors().transpose();
    return w;
}

}  // namespace

BlockLanczos::BlockLanczos(const Eigenproblem& problem, const ShiftInvert& pencil, const Columns& locked,
                           const BlockLanczosOptions& options, LargeArray room)
    : problem_(problem),
      pencil_(pencil),
      locked_(panels_for(static_cast<Index>(locked.cols()))),
      blocks_(locked_),
      space_(problem.rows(),
             locked_ + space_panels(problem, static_cast<Index>(locked.cols()), options.capacity) + 2,
             std::move(room)) {
    for (Index i = 0; i < locked_; ++i) {
        const Index first = panel_width * i;
        space_.set(i, locked.middleCols(
                          first, std::min<Index>(panel_width, static_cast<Index>(locked.cols()) - first)));
    }
    const Index capacity = panel_width * (space_.count() - 2 - locked_);
    projected_ = Columns::Zero(capacity, capacity);
    double* const start = space_.panel(blocks_);
    fill_random(start, static_cast<std::size_t>(problem.rows()) * panel_width, options.seed);
    out_ = orthonormalize(start, nullptr);
}

PanelProduct BlockLanczos::multiply_mass(const double* x, double* y) const {
    if (problem_.lumped()) return weigh(problem_.lumped_mass(), x, y);
    const Eigen::Map<const Block> from(x, problem_.rows(), panel_width);
    Eigen::Map<Block> to(y, problem_.rows(), panel_width);
    to.noalias() = problem_.consistent_mass() * from;
    return from.transpose() * to;
}

// W becomes Q of W = (space) C + Q R with Q M-orthonormal and M-orthogonal to locked vectors and space; returns R, and
// in `last` the part of C of the last block. Directions of W outside the space that are rounding against W become zero
// columns of Q. In exact arithmetic only the last two blocks have a part in W: that is taken away first, so that the
// sweep over all finds what rounding has let in, and a second sweep subtracts it only where it matters.
PanelProduct BlockLanczos::orthonormalize(double* W, PanelProduct* last) {
    constexpr double negligible = 1e-13;  // entries of V^T M Q
    constexpr double slight = 1e-3;       // one subtraction leaves nothing of it
    const Index n = problem_.rows();
    double* const MW = space_.panel(space_.count() - 1);
    PanelProduct gram = multiply_mass(W, MW);
    const double reference = gram.diagonal().maxCoeff();
    PanelProduct C;
    if (last != nullptr) {
        const Index near = std::max(blocks_ - 2, locked_);
        project(space_, near, blocks_, MW, C);
        *last = C.bottomRows(panel_width);
        subtract(space_, near, blocks_, C, W);
        gram = multiply_mass(W, MW);
    }
    PanelProduct R = PanelProduct::Identity(panel_width, panel_width);
    bool normalized = false;
    for (int round = 0; round < 8; ++round) {
        if (round > 0) gram = multiply_mass(W, MW);
        Directions w = directions_of(gram, normalized);
        if (!(w.largest > (normalized ? 0.0 : 1e-26 * reference))) {
            invariant_ = true;
            return PanelProduct::Zero(panel_width, panel_width);
        }
        project(space_, 0, blocks_, MW, C);
        const double part = C.size() == 0 ? 0.0 : (C * w.normalizer).cwiseAbs().maxCoeff();
        if (part > negligible) {
            subtract(space_, 0, blocks_, C, W);
            if (last != nullptr && !normalized) *last += C.bottomRows(panel_width);
            if (part > slight) continue;
            gram -= C.transpose() * C;
            w = directions_of(gram, normalized);
        }
        transform(n, W, w.normalizer);
        R = (w.part * R).eval();
        if (w.well_conditioned) break;
        normalized = true;
    }
    return R;
}

bool BlockLanczos::extend() {
    if (invariant_ || blocks_ + 2 >= space_.count()) return false;
    const Index n = problem_.rows();
    const Index at = dimension();
    double* const W = space_.panel(blocks_ + 1);
    multiply_mass(space_.panel(blocks_), W);
    pencil_.solve(Eigen::Map<Block>(W, n, panel_width));
    if (at > 0) {
        projected_.block(at, at - panel_width, panel_width, panel_width) = out_;
        projected_.block(at - panel_width, at, panel_width, panel_width) = out_.transpose();
    }
    ++blocks_;
    PanelProduct diagonal;
    out_ = orthonormalize(W, &diagonal);
    projected_.block(at, at, panel_width, panel_width) = 0.5 * (diagonal + diagonal.transpose());
    return true;
}

RitzValues BlockLanczos::ritz() {
    SymmetricEigen eigen = symmetric_eigen(projected_.topLeftCorner(dimension(), dimension()));
    theta_ = std::move(eigen.values);
    coefficients_ = std::move(eigen.vectors);
    const Vector out = (out_ * coefficients_.bottomRows(panel_width)).colwise().norm();
    const Vector lambda = pencil_.shift() + theta_.cwiseInverse().array();
    RitzValues ritz;
    ritz.vector.resize(static_cast<std::size_t>(dimension()));
    std::iota(ritz.vector.begin(), ritz.vector.end(), 0);
    std::sort(ritz.vector.begin(), ritz.vector.end(),
              [&](Index a, Index b) { return lambda[a] < lambda[b]; });
    ritz.values = lambda(ritz.vector);
    ritz.residuals = out.cwiseQuotient(theta_.cwiseAbs2())(ritz.vector);
    return ritz;
}

Columns BlockLanczos::vectors(const std::vector<Index>& chosen) const {
    const Columns s = coefficients_(Eigen::all, chosen);
    Columns C = Columns::Zero(panel_width * (blocks_ + 1), s.cols());
    C.middleRows(panel_width * locked_, dimension()) = s;
    if (!invariant_) {
        C.bottomRows(panel_width) =
            out_ * s.bottomRows(panel_width) * theta_(chosen).cwiseInverse().asDiagonal();
    }
    return combination(space_, blocks_ + (invariant_ ? 0 : 1),
                       invariant_ ? C.topRows(panel_width * blocks_) : C);
}

}  // namespace beltrami
