#include "beltrami/solvers/panels.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "beltrami/solvers/vectorized.hpp"

namespace beltrami {

namespace {

using Size = std::ptrdiff_t;

// Rows that are worked on at once: of forty panels they fit the second-level cache.
constexpr Size chunk = 256;

Size chunks(Size rows) {
    return (rows + chunk - 1) / chunk;
}

// C (8 x 8) += V^T W over some rows.
BELTRAMI_VECTORIZED void project_rows(Size rows, const double* V, const double* W, double* C) {
    std::array<Lanes, 8> even{};
    std::array<Lanes, 8> odd{};
    Size r = 0;
    for (; r + 2 <= rows; r += 2) {
        const Lanes w = lanes_at(W + 8 * r);
        const Lanes x = lanes_at(W + 8 * r + 8);
        for (int i = 0; i < 8; ++i) {
            even[i].v += V[8 * r + i] * w.v;
            odd[i].v += V[8 * r + 8 + i] * x.v;
        }
    }
    for (; r < rows; ++r) {
        const Lanes w = lanes_at(W + 8 * r);
        for (int i = 0; i < 8; ++i)
            even[i].v += V[8 * r + i] * w.v;
    }
    for (int i = 0; i < 8; ++i)
        lanes_at(C + 8 * i).v += even[i].v + odd[i].v;
}

// W += scale V C over some rows; C is 8 x 8.
BELTRAMI_VECTORIZED void add_rows(Size rows, double scale, const double* V, const double* C, double* W) {
    std::array<Lanes, 8> c{};
    for (int i = 0; i < 8; ++i)
        c[i].v = scale * lanes_at(C + 8 * i).v;
    for (Size r = 0; r < rows; ++r) {
        Lanes a{lanes_at(W + 8 * r).v + V[8 * r] * c[0].v};
        Lanes b{V[8 * r + 1] * c[1].v};
        for (int i = 2; i < 8; i += 2) {
            a.v += V[8 * r + i] * c[i].v;
            b.v += V[8 * r + i + 1] * c[i + 1].v;
        }
        lanes_at(W + 8 * r).v = a.v + b.v;
    }
}

void scale_rows(Size rows, const double* mass, const double* W, double* MW) {
    for (Size r = 0; r < rows; ++r) {
        for (int i = 0; i < 8; ++i)
            MW[8 * r + i] = mass[r] * W[8 * r + i];
    }
}

// Runs of chunks with partial sums of their own, which depend on the number of rows only.
struct Runs {
    explicit Runs(Size rows) : all(chunks(rows)), count(std::min<Size>(all, 8)) {}
    Size all;
    Size count;
    [[nodiscard]] Size begin(Size run) const { return all * run / count; }
};

}  // namespace

Panels::Panels(Index rows, Index count, LargeArray room)
    : rows_(rows), count_(count), values_(std::move(room)) {
    if (values_.size() >= offset(count)) return;
    values_ = {};
    values_ = LargeArray(offset(count));
}

void Panels::set(Index i, const Eigen::Ref<const Columns>& columns) {
    Eigen::Map<BlockOf<double>> target(panel(i), rows_, panel_width);
    target.leftCols(columns.cols()) = columns;
    target.rightCols(panel_width - columns.cols()).setZero();
}

PanelProduct weigh(const Vector& mass, const double* x, double* y) {
    const Size rows = mass.size();
    const Runs runs(rows);
    std::vector<PanelProduct> partial(static_cast<std::size_t>(runs.count));
#pragma omp parallel for schedule(dynamic, 1) if (rows > 10000)
    for (Size run = 0; run < runs.count; ++run) {
        PanelProduct& sum = partial[static_cast<std::size_t>(run)];
        sum = PanelProduct::Zero(panel_width, panel_width);
        for (Size c = runs.begin(run); c < runs.begin(run + 1); ++c) {
            const Size first = c * chunk;
            const Size size = std::min(chunk, rows - first);
            scale_rows(size, mass.data() + first, x + 8 * first, y + 8 * first);
            project_rows(size, x + 8 * first, y + 8 * first, sum.data());
        }
    }
    PanelProduct total = PanelProduct::Zero(panel_width, panel_width);
    for (const PanelProduct& sum : partial)
        total += sum;
    return total;
}

void project(const Panels& V, Index begin, Index end, const double* W, PanelProduct& C) {
    const Size rows = V.rows();
    const Runs runs(rows);
    const Index count = end - begin;
    std::vector<PanelProduct> partial(static_cast<std::size_t>(runs.count));
#pragma omp parallel for schedule(dynamic, 1) if (rows * count > 4000)
    for (Size run = 0; run < runs.count; ++run) {
        PanelProduct& sum = partial[static_cast<std::size_t>(run)];
        sum = PanelProduct::Zero(panel_width * count, panel_width);
        for (Size c = runs.begin(run); c < runs.begin(run + 1); ++c) {
            const Size first = c * chunk;
            const Size size = std::min(chunk, rows - first);
            for (Index i = 0; i < count; ++i)
                project_rows(size, V.panel(begin + i) + 8 * first, W + 8 * first, sum.data() + 64 * i);
        }
    }
    C = PanelProduct::Zero(panel_width * count, panel_width);
    for (const PanelProduct& sum : partial)
        C += sum;
}

void subtract(const Panels& V, Index begin, Index end, const PanelProduct& C, double* W) {
    const Size rows = V.rows();
    const Index count = end - begin;
#pragma omp parallel for schedule(static) if (rows * count > 4000)
    for (Size c = 0; c < chunks(rows); ++c) {
        const Size first = c * chunk;
        const Size size = std::min(chunk, rows - first);
        for (Index i = 0; i < count; ++i)
            add_rows(size, -1.0, V.panel(begin + i) + 8 * first, C.data() + 64 * i, W + 8 * first);
    }
}

void transform(Index rows, double* W, const PanelProduct& X) {
#pragma omp parallel for schedule(static) if (rows > 10000)
    for (Size c = 0; c < chunks(rows); ++c) {
        const Size first = c * chunk;
        const Size size = std::min<Size>(chunk, rows - first);
        std::vector<double> old(W + 8 * first, W + 8 * (first + size));
        std::fill(W + 8 * first, W + 8 * (first + size), 0.0);
        add_rows(size, 1.0, old.data(), X.data(), W + 8 * first);
    }
}

Columns combination(const Panels& V, Index count, const Columns& C) {
    const Size rows = V.rows();
    const Size k = C.cols();
    const Size outputs = (k + panel_width - 1) / panel_width;
    std::vector<PanelProduct> coefficients;
    for (Size o = 0; o < outputs; ++o) {
        const Size width = std::min<Size>(panel_width, k - panel_width * o);
        PanelProduct& c = coefficients.emplace_back(PanelProduct::Zero(C.rows(), panel_width));
        c.leftCols(width) = C.middleCols(panel_width * o, width);
    }
    Columns result(rows, k);
    use_large_pages(result.data(), static_cast<std::size_t>(result.size()));
#pragma omp parallel for schedule(dynamic, 8)
    for (Size c = 0; c < chunks(rows); ++c) {
        const Size first = c * chunk;
        const Size size = std::min(chunk, rows - first);
        BlockOf<double> part(size, panel_width);
        for (Size o = 0; o < outputs; ++o) {
            part.setZero();
            for (Index i = 0; i < count; ++i) {
                add_rows(size, 1.0, V.panel(i) + 8 * first,
                         coefficients[static_cast<std::size_t>(o)].data() + 64 * i, part.data());
            }
            const Size width = std::min<Size>(panel_width, k - panel_width * o);
            result.block(first, panel_width * o, size, width) = part.leftCols(width);
        }
    }
    return result;
}

}  // namespace beltrami
