#include "beltrami/solvers/sliced_rows.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>

namespace beltrami {
namespace {

using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Rows of very different lengths, some empty.
FloatRows random_matrix(Index rows, Index columns) {
    std::mt19937 random(7);
    FloatRows A = FloatRows::Zero(rows, columns);
    for (Index i = 0; i < rows; ++i) {
        const auto length = static_cast<Index>(random() % 9);
        for (Index e = 0; e < length; ++e)
            A(i, static_cast<Index>(random() % static_cast<unsigned>(columns))) =
                static_cast<float>(random() % 1000) / 500.0F - 1.0F;
    }
    return A;
}

SlicedRows sliced(const FloatRows& A) {
    return SlicedRows(static_cast<Index>(A.rows()), [&](Index i, auto f) {
        for (Index j = 0; j < A.cols(); ++j) {
            if (A(i, j) != 0.0F) f(j, static_cast<double>(A(i, j)));
        }
    });
}

FloatRows padded(const FloatRows& x) {
    FloatRows result = FloatRows::Zero(SlicedRows::padded(static_cast<Index>(x.rows())), x.cols());
    result.topRows(x.rows()) = x;
    return result;
}

TEST(SlicedRows, MultipliesLikeTheMatrix) {
    for (const Index rows : {1, 15, 16, 17, 100}) {
        const FloatRows A = random_matrix(rows, 70);
        const SlicedRows S = sliced(A);
        EXPECT_EQ(S.rows(), rows);
        EXPECT_EQ(S.entry_count(), static_cast<std::size_t>((A.array() != 0.0F).count()));
        for (const int k : {1, 2, 3, 4}) {
            const FloatRows x = FloatRows::Random(70, k);
            FloatRows y = FloatRows::Constant(S.padded_rows(), k, 5.0F);
            S.multiply({0, S.padded_rows()}, k, x.data(), y.data());
            EXPECT_LT((y - padded(A * x)).cwiseAbs().maxCoeff(), 1e-5F) << rows << " x " << k;
        }
    }
}

TEST(SlicedRows, MultipliesTheRowsAskedForAlone) {
    const FloatRows A = random_matrix(64, 64);
    const SlicedRows S = sliced(A);
    const FloatRows x = FloatRows::Random(64, 1);
    FloatRows y = FloatRows::Constant(64, 1, 5.0F);
    S.multiply({16, 48}, 1, x.data(), y.data());
    EXPECT_EQ(y.topRows(16), FloatRows::Constant(16, 1, 5.0F));
    EXPECT_LT((y - A * x).middleRows(16, 32).cwiseAbs().maxCoeff(), 1e-5F);
    EXPECT_EQ(y.bottomRows(16), FloatRows::Constant(16, 1, 5.0F));
}

TEST(SlicedRows, StepsOfChebyshevAreWhatTheySay) {
    const Index n = 48;
    const FloatRows A = random_matrix(n, n);
    const SlicedRows S = sliced(A);
    for (const int k : {1, 2, 3, 4}) {
        const FloatRows source = FloatRows::Random(n, k);
        const FloatRows d = FloatRows::Random(n, k);
        const FloatRows r = FloatRows::Random(n, k);
        const FloatRows x = FloatRows::Random(n, k);
        const FloatRows own = FloatRows::Random(n, 1);
        for (const bool scaled : {false, true}) {
            const FloatRows own_d = scaled ? FloatRows(own.col(0).asDiagonal() * d) : d;
            for (const int kind : {0, 1, 2}) {
                const ChebyshevStep step{
                    .before = 0.7F, .d = 0.3F, .r = 1.9F, .first = kind == 1, .last = kind == 2};
                const FloatRows residual = (step.first ? d : r) - 0.7F * (A * source + own_d);
                const FloatRows correction = 0.3F * 0.7F * d + 1.9F * residual;
                FloatRows value = 0.7F * d;
                if (!step.first) value += x;
                if (step.last) value += correction;

                FloatRows new_r = r;
                FloatRows new_x = x;
                FloatRows next = FloatRows::Zero(n, k);
                S.chebyshev_step({0, n}, k, step,
                                 {.source = source.data(),
                                  .own = scaled ? own.data() : nullptr,
                                  .d = d.data(),
                                  .r = new_r.data(),
                                  .x = new_x.data(),
                                  .next = next.data()});
                EXPECT_LT((new_x - value).cwiseAbs().maxCoeff(), 1e-5F);
                EXPECT_LT((new_r - (step.last ? r : residual)).cwiseAbs().maxCoeff(), 1e-5F);
                EXPECT_LT((next - (step.last ? FloatRows(FloatRows::Zero(n, k)) : correction))
                              .cwiseAbs()
                              .maxCoeff(),
                          1e-5F);
            }
        }
    }
}

TEST(SlicedRows, KnowsTheColumnsOfRows) {
    const SlicedRows S(64, [](Index i, auto f) {
        if (i < 16) return;
        f(i - 3, 1.0);
        f(i + 5, 1.0);
    });
    EXPECT_EQ((S.columns_of({16, 48})), (std::pair<Index, Index>(13, 52)));
    EXPECT_EQ((S.columns_of({0, 16})), (std::pair<Index, Index>(0, 0)));
    // Empty rows at the end of a slice are filled up with its own columns.
    const SlicedRows some(64, [](Index i, auto f) {
        if (i % 16 < 10) f(i + 5, 1.0);
    });
    EXPECT_EQ((some.columns_of({16, 48})), (std::pair<Index, Index>(21, 46)));
}

TEST(SlicedRows, OrderByLengthStaysInBlocks) {
    EXPECT_EQ(order_by_length({1, 3, 2, 3, 0, 9, 9, 1}, 4), (std::vector<Index>{1, 3, 2, 0, 5, 6, 7, 4}));
    EXPECT_EQ(order_by_length({}, 4), std::vector<Index>());
}

// Filled up with zeros rows take little more room than their entries.
TEST(SlicedRows, SortedRowsAreHardlyFilledUp) {
    const Index n = 4096;
    std::mt19937 random(3);
    std::vector<Index> length;
    std::size_t entries = 0;
    for (Index i = 0; i < n; ++i) {
        length.push_back(3 + static_cast<Index>(random() % 6));
        entries += static_cast<std::size_t>(length.back());
    }
    const std::vector<Index> order = order_by_length(length, 1024);
    const SlicedRows S(n, [&](Index place, auto f) {
        const Index row = order[static_cast<std::size_t>(place)];
        for (Index e = 0; e < length[static_cast<std::size_t>(row)]; ++e)
            f(e, 1.0);
    });
    EXPECT_EQ(S.entry_count(), entries);
    EXPECT_LT(static_cast<double>(S.memory_bytes()), 1.1 * 8.0 * static_cast<double>(entries));
}

}  // namespace
}  // namespace beltrami
