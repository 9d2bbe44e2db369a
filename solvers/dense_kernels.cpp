#include "beltrami/solvers/dense_kernels.hpp"

#include <cblas.h>
#include <omp.h>

#include <algorithm>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/blas_threads.hpp"

extern "C" void dsyevd_(const char* jobz, const char* uplo, const int* n, double* a, const int* lda, double* w,
                        double* work, const int* lwork, int* iwork, const int* liwork, int* info);

namespace beltrami {

namespace {

// A chunk of a column is a page or a few, and a chunk of two hundred columns fits the second-level cache.
constexpr Eigen::Index chunk = 1024;

Eigen::Index chunks(Eigen::Index rows) {
    return (rows + chunk - 1) / chunk;
}

int stride(Eigen::Index outer) {
    return static_cast<int>(outer);
}

}  // namespace

Columns transposed_product(const TallColumns& X, const TallColumns& Y) {
    const Eigen::Index a = X.cols();
    const Eigen::Index b = Y.cols();
    Columns total = Columns::Zero(a, b);
    if (a == 0 || b == 0) return total;
    const BlasThreads one(1);
    // Partial sums over runs of chunks that depend on the number of rows only.
    const Eigen::Index runs = std::min<Eigen::Index>(chunks(X.rows()), 8);
    std::vector<Columns> partial(static_cast<std::size_t>(runs));
#pragma omp parallel for schedule(dynamic, 1)
    for (Eigen::Index run = 0; run < runs; ++run) {
        Columns& sum = partial[static_cast<std::size_t>(run)];
        sum = Columns::Zero(a, b);
        const Eigen::Index end = chunks(X.rows()) * (run + 1) / runs;
        for (Eigen::Index c = chunks(X.rows()) * run / runs; c < end; ++c) {
            const Eigen::Index first = c * chunk;
            const auto rows = static_cast<int>(std::min(chunk, X.rows() - first));
            cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, static_cast<int>(a), static_cast<int>(b), rows,
                        1.0, X.data() + first, stride(X.outerStride()), Y.data() + first,
                        stride(Y.outerStride()), 1.0, sum.data(), static_cast<int>(a));
        }
    }
    for (const Columns& sum : partial)
        total += sum;
    return total;
}

void add_product(double scale, const TallColumns& X, const Eigen::Ref<const Columns>& C,
                 Eigen::Ref<Columns, 0, Eigen::OuterStride<>> Y) {
    if (X.cols() == 0 || Y.cols() == 0) return;
    const BlasThreads one(1);
#pragma omp parallel for schedule(static)
    for (Eigen::Index c = 0; c < chunks(X.rows()); ++c) {
        const Eigen::Index first = c * chunk;
        const auto rows = static_cast<int>(std::min(chunk, X.rows() - first));
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, rows, static_cast<int>(Y.cols()),
                    static_cast<int>(X.cols()), scale, X.data() + first, stride(X.outerStride()), C.data(),
                    stride(C.outerStride()), 1.0, Y.data() + first, stride(Y.outerStride()));
    }
}

SymmetricEigen symmetric_eigen(Columns A) {
    const auto n = static_cast<int>(A.rows());
    SymmetricEigen eigen{Vector(n), {}};
    if (n == 0) return eigen;
    const BlasThreads threads(n < 1000 ? 1 : omp_get_max_threads());
    double work_size = 0.0;
    int integer_size = 0;
    int info = 0;
    const int query = -1;
    dsyevd_("V", "L", &n, A.data(), &n, eigen.values.data(), &work_size, &query, &integer_size, &query, &info);
    const auto size = static_cast<int>(work_size);
    std::vector<double> work(static_cast<std::size_t>(size));
    std::vector<int> integers(static_cast<std::size_t>(integer_size));
    dsyevd_("V", "L", &n, A.data(), &n, eigen.values.data(), work.data(), &size, integers.data(), &integer_size,
            &info);
    if (info != 0) {
        throw SolveError("a dense eigenproblem of " + std::to_string(n) + " rows did not converge",
                         "look for values that are not finite");
    }
    eigen.vectors = std::move(A);
    return eigen;
}

}  // namespace beltrami
