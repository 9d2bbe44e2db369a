#include "beltrami/solvers/block_lanczos.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "beltrami/solvers/dense_kernels.hpp"

namespace beltrami {

namespace {

Index panels_for(Index columns) {
    return (columns + panel_width - 1) / panel_width;
}

Index space_panels(const Eigenproblem& problem, Index locked, Index capacity) {
    return panels_for(std::max(std::min(capacity, problem.rows() - locked), 1));
}

}  // namespace

BlockLanczos::BlockLanczos(const Eigenproblem& problem, const ShiftInvert& pencil, const Columns& locked,
                           const BlockLanczosOptions& options)
    : problem_(problem),
      pencil_(pencil),
      locked_(panels_for(static_cast<Index>(locked.cols()))),
      blocks_(locked_),
      space_(problem.rows(),
             locked_ + space_panels(problem, static_cast<Index>(locked.cols()), options.capacity) + 2) {
    for (Index i = 0; i < locked_; ++i) {
        const Index first = panel_width * i;
        space_.set(i, locked.middleCols(
                          first, std::min<Index>(panel_width, static_cast<Index>(locked.cols()) - first)));
    }
    const Index capacity = panel_width * (space_.count() - 2 - locked_);
    projected_ = Columns::Zero(capacity, capacity);
    std::mt19937 engine(options.seed);
    // Even numbers in [-1, 1]: the same on every machine, which the standard's normal distribution is not.
    double* const start = space_.panel(blocks_);
    std::generate_n(start, static_cast<std::size_t>(problem.rows()) * panel_width,
                    [&] { return 2.0 * (static_cast<double>(engine()) / 4294967295.0) - 1.0; });
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
// columns of Q. A second projection is computed in the sweep that
// subtracts the first, so that a further sweep is only made where it is needed.
PanelProduct BlockLanczos::orthonormalize(double* W, PanelProduct* last) {
    const Index n = problem_.rows();
    const double* const mass = problem_.lumped() ? problem_.lumped_mass().data() : nullptr;
    double* const MW = space_.panel(space_.count() - 1);
    PanelProduct C;
    PanelProduct again;
    PanelProduct gram;
    const double reference = multiply_mass(W, MW).diagonal().maxCoeff();
    project(space_, blocks_, MW, C);
    if (last != nullptr) *last = C.bottomRows(panel_width);
    const auto remove = [&] {
        subtract(space_, blocks_, C, W, mass, &again, &gram);
        if (mass != nullptr) return;
        gram = multiply_mass(W, MW);
        project(space_, blocks_, MW, again);
    };
    remove();
    PanelProduct R = PanelProduct::Identity(panel_width, panel_width);
    for (int round = 0; round < 6; ++round) {
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 8, 8>> eigen(gram);
        const auto& values = eigen.eigenvalues();
        const double largest = values[panel_width - 1];
        if (round == 0 && !(largest > 1e-26 * reference)) {
            invariant_ = true;
            return PanelProduct::Zero(panel_width, panel_width);
        }
        // Entries of a Gram matrix are good to 1e-16 of its largest: smaller directions show in the second round.
        Eigen::Matrix<double, 8, 1> size;
        Eigen::Matrix<double, 8, 1> inverse;
        for (Index i = 0; i < panel_width; ++i) {
            const bool null = round > 0 && values[i] < 1e-10;
            size[i] = null ? 0.0 : std::sqrt(round == 0 ? std::max(values[i], 1e-14 * largest) : values[i]);
            inverse[i] = null ? 0.0 : 1.0 / size[i];
        }
        const PanelProduct X = eigen.eigenvectors() * inverse.asDiagonal();
        transform(n, W, X);
        R = (size.asDiagonal() * eigen.eigenvectors().transpose() * R).eval();
        C = again * X;
        const bool well_conditioned = values[0] > 1e-6 * largest;
        if (round > 0 && (size.array() * inverse.array()).sum() < 0.5) {
            invariant_ = true;
            return PanelProduct::Zero(panel_width, panel_width);
        }
        const bool orthogonal = C.size() == 0 || C.cwiseAbs().maxCoeff() < 1e-13;
        if (orthogonal && well_conditioned) break;
        remove();
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
