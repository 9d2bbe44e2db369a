#include "beltrami/solvers/linear_summary.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

bool is_iterative(std::string_view solver) {
    return solver == "cg" || solver == "multigrid";
}

}  // namespace

std::string_view name(StoppingNorm norm) {
    switch (norm) {
        case StoppingNorm::automatic:
            return "automatic";
        case StoppingNorm::residual:
            return "residual";
        case StoppingNorm::scaled_residual:
            return "scaled residual";
        case StoppingNorm::energy_error:
            return "energy error";
        case StoppingNorm::refinement:
            return "last refinement";
    }
    return "";
}

std::string_view sentence(StopReason reason) {
    switch (reason) {
        case StopReason::converged:
            return "converged";
        case StopReason::iteration_limit:
            return "the limit of iterations was reached";
        case StopReason::stagnated:
            return "rounding keeps the error from falling further";
        case StopReason::not_definite:
            return "the operator is not positive definite on the free vertices";
    }
    return "";
}

std::string LinearSummary::brief() const {
    return fmt::format("{}: {}{} {} to {:.1e} ({}) for {} unknowns x {} in {:.2f} s", solver,
                       converged ? "" : "NOT CONVERGED, ", iterations,
                       is_iterative(solver) ? "iterations" : "refinements", error, name(norm), unknowns,
                       columns, setup_seconds + solve_seconds);
}

std::string LinearSummary::full() const {
    return fmt::format(
        "solver             {} ({})\n"
        "stopped            {}\n"
        "error              {:.3e} in the {}, tolerance {:.1e}\n"
        "relative residual  {:.3e} (scaled)\n"
        "iterations         {}, products {}, factorizations {}\n"
        "unknowns           {} x {}\n"
        "seconds            {:.3f} set-up, {:.3f} solve\n"
        "memory             {:.1f} MB\n",
        solver, why, sentence(reason), error, name(norm), tolerance, relative_residual, iterations, products,
        factorizations, unknowns, columns, setup_seconds, solve_seconds,
        static_cast<double>(memory_bytes) / 1e6);
}

void LinearSummary::add(const LinearSummary& later) {
    if (solver.empty()) {
        *this = later;
        return;
    }
    solver = later.solver;
    why = later.why;
    norm = later.norm;
    history = later.history;
    if (!later.converged) {
        converged = false;
        reason = later.reason;
    }
    error = std::max(error, later.error);
    relative_residual = std::max(relative_residual, later.relative_residual);
    iterations += later.iterations;
    products += later.products;
    factorizations += later.factorizations;
    setup_seconds += later.setup_seconds;
    solve_seconds += later.solve_seconds;
    memory_bytes = std::max(memory_bytes, later.memory_bytes);
}

void require_converged(const LinearSummary& summary) {
    if (summary.converged) return;
    throw SolveError(
        fmt::format("the {} solve stopped at {:.1e} ({}) after {} iterations, short of {:.1e}: {}",
                    summary.solver, summary.error, name(summary.norm), summary.iterations, summary.tolerance,
                    sentence(summary.reason)),
        is_iterative(summary.solver)
            ? "try the solver cholesky, a larger tolerance or more iterations"
            : "look at the mesh with `beltrami info`: slivers make operators singular");
}

}  // namespace beltrami
