// Blocks of eight columns, and the products that orthogonalization takes: the eight values of a row lie together, so a
// sweep over a panel runs through memory once and computes in registers.
//
//     Panels V(rows, 40);                                  // room for 40 panels
//     project(V, 0, 12, MW, C);                            // C = V^T MW, of 12 panels
//     subtract(V, 0, 12, C, W);                            // W -= V C
#pragma once

#include <utility>

#include "beltrami/solvers/eigenproblem.hpp"
#include "beltrami/solvers/large_array.hpp"

namespace beltrami {

constexpr Index panel_width = 8;

/// Products of panels: 8 rows for each panel, 8 columns, row-major.
using PanelProduct = Eigen::Matrix<double, Eigen::Dynamic, panel_width, Eigen::RowMajor>;

class Panels {
  public:
    /// In `room`, where that is large enough.
    Panels(Index rows, Index count, LargeArray room = {});

    [[nodiscard]] Index rows() const { return rows_; }
    [[nodiscard]] Index count() const { return count_; }
    /// rows x 8, row-major.
    [[nodiscard]] double* panel(Index i) { return values_.data() + offset(i); }
    [[nodiscard]] const double* panel(Index i) const { return values_.data() + offset(i); }
    [[nodiscard]] std::size_t memory_bytes() const { return values_.bytes(); }
    /// Leaves no panels.
    [[nodiscard]] LargeArray release() { return std::move(values_); }

    /// Panel i from columns (rows x at most 8; the rest becomes zero).
    void set(Index i, const Eigen::Ref<const Columns>& columns);

  private:
    [[nodiscard]] std::size_t offset(Index i) const {
        return static_cast<std::size_t>(rows_) * panel_width * static_cast<std::size_t>(i);
    }
    Index rows_;
    Index count_;
    LargeArray values_;
};

/// y = M x of panels x and y (rows x 8), M diagonal; returns x^T M x.
PanelProduct weigh(const Vector& mass, const double* x, double* y);

/// C = V^T W for panels begin ... end - 1 of V and a panel W (rows x 8).
void project(const Panels& V, Index begin, Index end, const double* W, PanelProduct& C);

/// W -= V C for panels begin ... end - 1 of V.
void subtract(const Panels& V, Index begin, Index end, const PanelProduct& C, double* W);

/// W <- W X, X 8 x 8.
void transform(Index rows, double* W, const PanelProduct& X);

/// V C for panels 0 to count - 1 of V: C is 8 count x k, the result rows x k.
Columns combination(const Panels& V, Index count, const Columns& C);

}  // namespace beltrami
