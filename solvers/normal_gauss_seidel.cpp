#include "beltrami/solvers/normal_gauss_seidel.hpp"

#include <Eigen/Cholesky>

namespace beltrami {

namespace {

// A patch is made where a vertex has less than so much of its neighbours' mean mass: with 0.6 instead of 0.5, 48 cycles instead
// of 63 on an irregular mesh of 150,000 vertices, with 0.8 still 45 (docs/solvers.md).
constexpr double little_mass = 0.6;

}  // namespace

NormalGaussSeidel::NormalGaussSeidel(const PdeOperator& A, const std::vector<char>& held) {
    const EdgeOperator<double>& K = A.laplacian().stiffness();
    const Index n = A.rows();
    const double gamma_1 = A.gamma()[0];
    const Vector d = (A.gamma()[1] * A.laplacian().inverse_mass()).cwiseSqrt();
    const Vector diagonal = A.diagonal();

    begin_.assign(1, 0);
    begin_.reserve(at(n) + 1);
    diagonal_.resize(at(n));
    own_.resize(at(n));
    mass_.resize(at(n));
    inverse_.resize(at(n));
    std::vector<Index> reach(at(n));
    Index last = 0;
    for (Index i = 0; i < n; ++i) {
        const auto neighbours = K.graph().neighbours(i);
        last = std::max(last, neighbours.empty() ? i + 1 : std::max(i, neighbours.back().vertex) + 1);
        reach[at(i)] = last;
        begin_.push_back(begin_.back() + (static_cast<Index>(neighbours.size()) + 3) / 4);
        entries_ += 1.0 + static_cast<double>(neighbours.size());
    }
    order_ = SweepOrder(reach, 4);
    entry_.resize(at(begin_.back()));
#pragma omp parallel for schedule(static) if (n > 20000)
    for (Index i = 0; i < n; ++i) {
        for (Index e = begin_[at(i)]; e < begin_[at(i) + 1]; ++e)
            entry_[at(e)] = no_entries(i);
        Index to = 4 * begin_[at(i)];
        for (const EdgeGraph::Neighbour& neighbour : K.graph().neighbours(i)) {
            entry_[at(to / 4)].column[at(to % 4)] = neighbour.vertex;
            entry_[at(to / 4)].value[at(to % 4)] =
                static_cast<float>(K.edges()[neighbour.edge] * d[neighbour.vertex]);
            ++to;
        }
        diagonal_[at(i)] = static_cast<float>(K.diagonal()[i] * d[i]);
        own_[at(i)] = diagonal_[at(i)] + (d[i] > 0.0 ? static_cast<float>(gamma_1 / d[i]) : 0.0F);
        mass_[at(i)] = static_cast<float>(A.sigma() * A.laplacian().mass()[i]);
        inverse_[at(i)] =
            held[at(i)] == 0 && diagonal[i] > 0.0 ? static_cast<float>(1.0 / diagonal[i]) : 0.0F;
    }
    make_patches(A);
}

void NormalGaussSeidel::make_patches(const PdeOperator& A) {
    const EdgeOperator<double>& K = A.laplacian().stiffness();
    const EdgeGraph& graph = K.graph();
    const Vector& M = A.laplacian().mass();
    const Vector D = A.gamma()[1] * A.laplacian().inverse_mass();
    const Index n = A.rows();
    patch_of_row_.assign(at(n), alone);
    std::vector<Index> local(at(n), -1);
    for (Index i = 0; i < n; ++i) {
        const auto neighbours = graph.neighbours(i);
        double mean = 0.0;
        for (const EdgeGraph::Neighbour& j : neighbours)
            mean += M[j.vertex] / static_cast<double>(neighbours.size());
        if (!(M[i] < little_mass * mean) || static_cast<Index>(neighbours.size()) + 1 > largest_patch)
            continue;
        const auto first = static_cast<Index>(patch_rows_.size());
        const auto take = [&](Index row) {
            if (!is_held(row)) patch_rows_.push_back(row);
        };
        take(i);
        for (const EdgeGraph::Neighbour& j : neighbours)
            take(j.vertex);
        const auto size = static_cast<Index>(patch_rows_.size()) - first;
        if (size < 2) {
            patch_rows_.resize(at(first));
            continue;
        }
        // Columns of K on the patch, on all rows that they reach.
        std::vector<Index> reached;
        const auto number = [&](Index row) {
            if (local[at(row)] < 0) {
                local[at(row)] = static_cast<Index>(reached.size());
                reached.push_back(row);
            }
            return local[at(row)];
        };
        Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(size * largest_patch, size);
        for (Index a = 0; a < size; ++a) {
            const Index row = patch_rows_[at(first + a)];
            const auto put = [&](Index to, double value) {
                const Index at_row = number(to);
                if (at_row >= columns.rows())
                    columns.conservativeResizeLike(Eigen::MatrixXd::Zero(2 * at_row, size));
                columns(at_row, a) = value;
            };
            put(row, K.diagonal()[row]);
            for (const EdgeGraph::Neighbour& j : graph.neighbours(row))
                put(j.vertex, K.edges()[j.edge]);
        }
        const auto count = static_cast<Eigen::Index>(reached.size());
        Eigen::VectorXd weight(count);
        for (Eigen::Index r = 0; r < count; ++r) {
            weight[r] = D[reached[at(static_cast<Index>(r))]];
        }
        Eigen::MatrixXd matrix =
            columns.topRows(count).transpose() * weight.asDiagonal() * columns.topRows(count);
        for (Index a = 0; a < size; ++a) {
            const Index row = patch_rows_[at(first + a)];
            for (Index c = 0; c < size; ++c) {
                const Index q = local[at(patch_rows_[at(first + c)])];
                matrix(c, a) += A.gamma()[0] * columns(q, a);
            }
            matrix(a, a) += A.sigma() * M[row];
        }
        for (const Index row : reached)
            local[at(row)] = -1;
        const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
        if (factor.info() != Eigen::Success) {
            patch_rows_.resize(at(first));
            continue;
        }
        const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(size, size));
        patch_of_row_[at(i)] = static_cast<Index>(patches_.size());
        patches_.push_back({first, size, patch_inverses_.size()});
        for (Index a = 0; a < size; ++a) {
            for (Index c = 0; c < size; ++c)
                patch_inverses_.push_back(static_cast<float>(inverse(a, c)));
        }
    }
    // What a patch solves for needs no step of its own.
    for (const Index row : patch_rows_) {
        if (patch_of_row_[at(row)] == alone) patch_of_row_[at(row)] = covered;
    }
}

}  // namespace beltrami
