#include "beltrami/solvers/shift_invert.hpp"

#include <fmt/format.h>

#include <cmath>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/pivoted_ldlt.hpp"
#include "beltrami/solvers/supernodal_ldlt.hpp"

namespace beltrami {

ShiftInvert::ShiftInvert(const Eigenproblem& problem, const ShiftInvertOptions& options)
    : problem_(problem),
      supernodal_(std::make_unique<SupernodalLdlt>(problem,
                                                   SupernodalLdltOptions{.few_solves = options.few_solves})) {
    if (!(options.memory_limit > 0.0) || static_cast<double>(memory_bytes()) <= options.memory_limit) return;
    supernodal_.reset();
    pivoted_ = std::make_unique<PivotedLdlt>(problem, PivotedLdltOptions{true, options.scratch});
    const auto needed = static_cast<double>(pivoted_->memory_bytes());
    if (needed > options.memory_limit) {
        throw InputError(
            fmt::format("even with its factor on disk, K - lambda M of {} unknowns needs {:.0f} MB of memory",
                        problem.rows(), needed / 1e6),
            fmt::format("allow more with --memory, at least {:.0f}M", std::ceil(needed / 1e6)));
    }
}

ShiftInvert::~ShiftInvert() = default;

void ShiftInvert::factor(double shift) {
    shift_ = shift;
    pivoted_now_ = supernodal_ == nullptr;
    if (!pivoted_now_) {
        try {
            supernodal_->factor(shift);
            return;
        } catch (const SolveError&) {
            // Its pivots are too small without exchanges.
            pivoted_now_ = true;
        }
    }
    if (!pivoted_) pivoted_ = std::make_unique<PivotedLdlt>(problem_);
    pivoted_->factor(shift);
}

Index ShiftInvert::eigenvalues_below() const {
    return pivoted_now_ ? pivoted_->negative_pivots() : supernodal_->negative_pivots();
}

void ShiftInvert::solve(Columns& columns) const {
    if (pivoted_now_) {
        pivoted_->solve(columns);
    } else {
        supernodal_->solve(columns);
    }
}

void ShiftInvert::solve(Eigen::Ref<Block> block) const {
    if (!pivoted_now_) return supernodal_->solve(block);
    Columns columns = block;
    pivoted_->solve(columns);
    block = columns;
}

int ShiftInvert::factorizations() const {
    return (supernodal_ ? supernodal_->factorizations() : 0) + (pivoted_ ? pivoted_->factorizations() : 0);
}
long ShiftInvert::solved_columns() const {
    return (supernodal_ ? supernodal_->solved_columns() : 0) + (pivoted_ ? pivoted_->solved_columns() : 0);
}
std::size_t ShiftInvert::memory_bytes() const {
    return (supernodal_ ? supernodal_->memory_bytes() + supernodal_->working_bytes() : 0) +
           (pivoted_ ? pivoted_->memory_bytes() : 0);
}
std::size_t ShiftInvert::disk_bytes() const {
    return pivoted_ ? pivoted_->disk_bytes() : 0;
}

}  // namespace beltrami
