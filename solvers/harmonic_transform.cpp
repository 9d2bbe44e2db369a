#include "beltrami/solvers/harmonic_transform.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/dense_kernels.hpp"
#include "beltrami/solvers/vectorized.hpp"

namespace beltrami {

namespace {

using Size = std::ptrdiff_t;

// Vertices that are worked on at once: of all columns they stay in the first-level cache while a band runs through.
constexpr Size chunk = 1024;
// Columns that one sweep takes.
constexpr Size group = 4;

// y[c] += gain[c] h over some vertices, columns apart by `chunk`. GCC makes vectors of these loops.
template <int C, class Scalar>
__attribute__((always_inline)) inline void add_function(Size size, const Scalar* h, const double* gain,
                                                        double* y) {
    for (Size i = 0; i < size; ++i) {
        const auto value = static_cast<double>(h[i]);
        for (int c = 0; c < C; ++c)
            y[c * chunk + i] += gain[c] * value;
    }
}

template <class Scalar>
__attribute__((always_inline)) inline void add_functions_of(Size size, const Scalar* const* functions,
                                                            Size count, Size first, const double* gains,
                                                            Size columns, double* y) {
    for (Size k = 0; k < count; ++k) {
        const Scalar* const h = functions[k] + first;
        const double* const gain = gains + k * group;
        switch (columns) {
            case 1:
                add_function<1>(size, h, gain, y);
                break;
            case 2:
                add_function<2>(size, h, gain, y);
                break;
            case 3:
                add_function<3>(size, h, gain, y);
                break;
            default:
                add_function<4>(size, h, gain, y);
        }
    }
}
BELTRAMI_VECTORIZED void add_functions(Size size, const double* const* functions, Size count, Size first,
                                       const double* gains, Size columns, double* y) {
    add_functions_of(size, functions, count, first, gains, columns, y);
}
BELTRAMI_VECTORIZED void add_functions(Size size, const float* const* functions, Size count, Size first,
                                       const double* gains, Size columns, double* y) {
    add_functions_of(size, functions, count, first, gains, columns, y);
}

// field += sum of gains(k, .) H^k over the functions whose gains are not all zero.
template <class Scalar>
void add_band(const NpyArray& band, const Eigen::Ref<const Block>& gains, Block& field) {
    for (Size start = 0; start < gains.cols(); start += group) {
        const Size columns = std::min(group, static_cast<Size>(gains.cols()) - start);
        std::vector<const Scalar*> functions;
        std::vector<double> used;
        for (Eigen::Index k = 0; k < gains.rows(); ++k) {
            if (gains.row(k).middleCols(start, columns).isZero(0.0)) continue;
            functions.push_back(band.row<Scalar>(k));
            used.resize(functions.size() * group, 0.0);
            for (Size c = 0; c < columns; ++c)
                used[(functions.size() - 1) * group + static_cast<std::size_t>(c)] = gains(k, start + c);
        }
        const Size vertices = field.rows();
#pragma omp parallel for schedule(static)
        for (Size first = 0; first < vertices; first += chunk) {
            std::array<double, group * chunk> y{};
            const Size size = std::min(chunk, vertices - first);
            add_functions(size, functions.data(), static_cast<Size>(functions.size()), first, used.data(),
                          columns, y.data());
            for (Size i = 0; i < size; ++i) {
                for (Size c = 0; c < columns; ++c)
                    field(first + i, start + c) += y[static_cast<std::size_t>(c * chunk + i)];
            }
        }
    }
}

void add_functions_of_band(const NpyArray& band, const Eigen::Ref<const Block>& gains, Block& field) {
    if (band.type() == NpyType::float64) {
        add_band<double>(band, gains, field);
    } else {
        add_band<float>(band, gains, field);
    }
}

// Row k of the result: (H^k)^T field.
template <class Scalar>
Block products(const NpyArray& band, const Columns& field) {
    Block result(band.rows(), field.cols());
#pragma omp parallel for schedule(dynamic, 1)
    for (Eigen::Index k = 0; k < band.rows(); ++k) {
        const Eigen::Map<const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>> h(band.row<Scalar>(k),
                                                                           band.columns());
        for (Eigen::Index c = 0; c < field.cols(); ++c)
            result(k, c) = h.template cast<double>().dot(field.col(c));
    }
    return result;
}

// band(i, first pair of band i, its number of pairs)
template <class Work>
void for_each_band(const StoredBasis& basis, const Progress* progress, Work work) {
    Index first = 0;
    for (const NpyArray& band : basis.bands()) {
        report(progress, "harmonics", static_cast<double>(first) / std::max<Index>(basis.count(), 1));
        work(band, first);
        first += static_cast<Index>(band.rows());
    }
}

}  // namespace

Block forward_transform(const StoredBasis& basis, const Block& field, const Progress* progress) {
    const Columns weighted = basis.apply_mass(field);
    Block coefficients(basis.count(), field.cols());
    for_each_band(basis, progress, [&](const NpyArray& band, Index first) {
        coefficients.middleRows(first, band.rows()) = band.type() == NpyType::float64
                                                          ? products<double>(band, weighted)
                                                          : products<float>(band, weighted);
    });
    return coefficients;
}

Block inverse_transform(const StoredBasis& basis, const Block& coefficients, const Progress* progress) {
    if (coefficients.rows() > basis.count()) {
        throw InputError(
            fmt::format("{} coefficients meet a basis of {} functions", coefficients.rows(), basis.count()),
            "give one row a function, or fewer");
    }
    Block field = Block::Zero(basis.vertex_count(), coefficients.cols());
    for_each_band(basis, progress, [&](const NpyArray& band, Index first) {
        const auto rows = std::min<Eigen::Index>(band.rows(), coefficients.rows() - first);
        if (rows > 0) add_functions_of_band(band, coefficients.middleRows(first, rows), field);
    });
    return field;
}

double cutoff_frequency(const StoredBasis& basis) {
    if (basis.certificates().empty()) return 0.0;
    const BandCertificate& last = basis.certificates().back();
    const double value = last.kept < last.found ? basis.eigenvalues()[basis.count() - 1] : last.upper.value;
    return std::sqrt(std::max(value, 0.0));
}

double nyquist_frequency(double mean_edge) {
    return frequency_of_edges(mean_edge, 2.0);
}

double frequency_of_edges(double mean_edge, double edges) {
    return 2.0 * std::numbers::pi / (edges * mean_edge);
}

HarmonicFilter::HarmonicFilter(const StoredBasis& basis, Block field, const Progress* progress)
    : basis_(basis), field_(std::move(field)), coefficients_(forward_transform(basis, field_, progress)) {}

double HarmonicFilter::high_frequency_gain(const FilterCurve& curve) const {
    return curve.mean(cutoff_frequency(basis_), nyquist_frequency(basis_.mean_edge()));
}

Block HarmonicFilter::apply(const FilterCurve& curve) const {
    // sum F x~ H + f^hf (x - sum x~ H)  =  f^hf x + sum (F - f^hf) x~ H.
    const double rest = high_frequency_gain(curve);
    Block gains = coefficients_;
    for (Index k = 0; k < basis_.count(); ++k)
        gains.row(k) *= curve(std::sqrt(std::max(basis_.eigenvalues()[k], 0.0))) - rest;
    Block result = rest * field_;
    for_each_band(basis_, nullptr, [&](const NpyArray& band, Index first) {
        add_functions_of_band(band, gains.middleRows(first, band.rows()), result);
    });
    return result;
}

LimitedFilterResult limited_memory_filter(const Eigenproblem& problem, const Block& field,
                                          const FilterCurve& curve, const LimitedFilterOptions& options) {
    if (!(options.cutoff > 0.0) || !(options.mean_edge > 0.0)) {
        throw InputError("a filter needs a cutoff frequency and a mean edge length above 0",
                         "give positive numbers");
    }
    if (field.rows() != problem.rows()) {
        throw InputError(
            fmt::format("a field of {} rows meets an eigenproblem of {}", field.rows(), problem.rows()),
            "give one row an unknown");
    }
    const double rest = curve.mean(options.cutoff, nyquist_frequency(options.mean_edge));
    LimitedFilterResult result;
    Columns filtered = rest * field;
    Columns weighted;
    problem.apply_mass(Columns(field), weighted);
    for (const auto& [from, to] : curve.differs_from(rest, options.cutoff)) {
        SpectrumOptions spectrum_options = options.spectrum;
        spectrum_options.count = 0;
        spectrum_options.from = from;
        spectrum_options.cutoff = to;
        spectrum_options.resume = nullptr;
        result.summaries.push_back(spectrum(problem, spectrum_options, [&](const SpectralBand& band) {
            Columns gains = transposed_product(band.vectors, weighted);
            for (Eigen::Index k = 0; k < gains.rows(); ++k)
                gains.row(k) *= curve(std::sqrt(std::max(band.values[k], 0.0))) - rest;
            add_product(1.0, band.vectors, gains, filtered);
        }));
        result.pairs += result.summaries.back().count;
    }
    result.field = filtered;
    return result;
}

}  // namespace beltrami
