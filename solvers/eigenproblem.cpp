#include "beltrami/solvers/eigenproblem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// The rows and columns of the unknowns. unknown[v]: its number, or -1.
RowMatrix restricted(const EdgeOperator<double>& A, const std::vector<Index>& vertices,
                     const std::vector<Index>& unknown) {
    const EdgeGraph& graph = A.graph();
    std::vector<Index> row_lengths;
    row_lengths.reserve(vertices.size());
    for (const Index v : vertices) {
        Index length = 1;
        for (const EdgeGraph::Neighbour n : graph.neighbours(v))
            length += unknown[static_cast<std::size_t>(n.vertex)] >= 0 ? 1 : 0;
        row_lengths.push_back(length);
    }
    const auto size = static_cast<Eigen::Index>(vertices.size());
    RowMatrix matrix(size, size);
    matrix.reserve(row_lengths);
    for (Eigen::Index row = 0; row < size; ++row) {
        const Index v = vertices[static_cast<std::size_t>(row)];
        bool diagonal_done = false;
        const auto put_diagonal = [&] {
            matrix.insert(row, row) = A.diagonal()[v];
            diagonal_done = true;
        };
        for (const EdgeGraph::Neighbour n : graph.neighbours(v)) {
            const Index column = unknown[static_cast<std::size_t>(n.vertex)];
            if (column < 0) continue;
            if (!diagonal_done && column > row) put_diagonal();
            matrix.insert(row, column) = A.edges()[n.edge];
        }
        if (!diagonal_done) put_diagonal();
    }
    matrix.makeCompressed();
    return matrix;
}

}  // namespace

Eigenproblem::Eigenproblem(const Laplacian& laplacian, const Constraints& held) {
    set(laplacian, nullptr, held);
}

Eigenproblem::Eigenproblem(const Laplacian& laplacian, const EdgeOperator<double>& mass,
                           const Constraints& held) {
    set(laplacian, &mass, held);
}

Eigenproblem::Eigenproblem(const Eigen::SparseMatrix<double>& K, const Eigen::SparseMatrix<double>& M,
                           const Columns& constants)
    : vertex_count_(static_cast<Index>(K.rows())),
      vertices_(static_cast<std::size_t>(K.rows())),
      stiffness_(K),
      consistent_(M),
      constants_(constants) {
    if (K.rows() == 0 || K.cols() != K.rows() || M.rows() != K.rows() || M.cols() != K.rows() ||
        constants.rows() != K.rows()) {
        throw InputError(
            fmt::format("an eigenproblem of matrices {} x {} and {} x {}, with constants of {} rows",
                        K.rows(), K.cols(), M.rows(), M.cols(), constants.rows()),
            "give square matrices of the same size");
    }
    if (!(consistent_.diagonal().minCoeff() > 0.0)) {
        throw InputError(
            fmt::format("a mass matrix has {} on its diagonal", consistent_.diagonal().minCoeff()),
            "eigenfunctions need a positive mass at every unknown");
    }
    std::iota(vertices_.begin(), vertices_.end(), Index{0});
}

void Eigenproblem::set(const Laplacian& laplacian, const EdgeOperator<double>* mass,
                       const Constraints& held) {
    const EdgeGraph& graph = laplacian.graph();
    vertex_count_ = laplacian.vertex_count();
    held.check_range(vertex_count_);
    if (mass != nullptr && mass->rows() != vertex_count_) {
        throw InputError(
            fmt::format("the mass has {} rows and the stiffness {}", mass->rows(), vertex_count_),
            "build both on the same mesh");
    }
    std::vector<Index> unknown(static_cast<std::size_t>(vertex_count_), -1);
    for (Index v = 0; v < vertex_count_; ++v) {
        if (graph.degree(v) == 0 || held.is_fixed(v)) continue;
        unknown[static_cast<std::size_t>(v)] = rows();
        vertices_.push_back(v);
    }
    if (vertices_.empty()) {
        throw InputError("no vertex is free: the eigenproblem has no unknown",
                         "hold fewer vertices, or give a mesh with cells");
    }
    stiffness_ = restricted(laplacian.stiffness(), vertices_, unknown);
    if (mass == nullptr) {
        lumped_.resize(rows());
        for (Index i = 0; i < rows(); ++i)
            lumped_[i] = laplacian.mass()[vertices_[static_cast<std::size_t>(i)]];
    } else {
        consistent_ = restricted(*mass, vertices_, unknown);
    }
    for (Index i = 0; i < rows(); ++i) {
        const double m = lumped() ? lumped_[i] : consistent_.coeff(i, i);
        if (m > 0.0) continue;
        throw InputError(fmt::format("vertex {} has the mass {}",
                                     laplacian.order().user(vertices_[static_cast<std::size_t>(i)]), m),
                         "eigenfunctions need a positive mass at every vertex that has an edge");
    }

    const Components components = connected_components(graph);
    std::vector<char> is_free(static_cast<std::size_t>(components.count), 1);
    const auto component = [&](Index v) {
        return static_cast<std::size_t>(components.of_vertex[static_cast<std::size_t>(v)]);
    };
    for (const Index v : held.vertices())
        is_free[component(v)] = 0;
    std::vector<Index> column(static_cast<std::size_t>(components.count), -1);
    Index columns = 0;
    for (const Index v : vertices_) {
        const std::size_t c = component(v);
        if (is_free[c] != 0 && column[c] < 0) column[c] = columns++;
    }
    constants_ = Columns::Zero(rows(), columns);
    for (Index i = 0; i < rows(); ++i) {
        const Index j = column[component(vertices_[static_cast<std::size_t>(i)])];
        if (j >= 0) constants_(i, j) = 1.0;
    }
    Columns product;
    apply_mass(constants_, product);
    for (Index j = 0; j < columns; ++j)
        constants_.col(j) /= std::sqrt(constants_.col(j).dot(product.col(j)));
}

std::vector<Index> user_vertices(const Eigenproblem& problem, const Renumbering& order) {
    std::vector<Index> vertices(problem.vertices().size());
    std::transform(problem.vertices().begin(), problem.vertices().end(), vertices.begin(),
                   [&](Index v) { return order.user(v); });
    return vertices;
}

RowMatrix Eigenproblem::mass_matrix() const {
    if (!lumped()) return consistent_;
    RowMatrix matrix(rows(), rows());
    matrix.reserve(Eigen::VectorXi::Ones(rows()));
    for (Index i = 0; i < rows(); ++i)
        matrix.insert(i, i) = lumped_[i];
    matrix.makeCompressed();
    return matrix;
}

double Eigenproblem::total_mass() const {
    return lumped() ? lumped_.sum() : consistent_.sum();
}

void Eigenproblem::apply_stiffness(const Eigen::Ref<const Columns>& x, Columns& y) const {
    y.noalias() = stiffness_ * x;
}

void Eigenproblem::apply_mass(const Eigen::Ref<const Columns>& x, Columns& y) const {
    if (lumped()) {
        y.noalias() = lumped_.asDiagonal() * x;
    } else {
        y.noalias() = consistent_ * x;
    }
}

std::size_t Eigenproblem::memory_bytes() const {
    const auto entries = static_cast<std::size_t>(stiffness_.nonZeros() + consistent_.nonZeros());
    return entries * (sizeof(double) + sizeof(int)) +
           static_cast<std::size_t>(lumped_.size() + constants_.size()) * sizeof(double) +
           vertices_.size() * sizeof(Index);
}

}  // namespace beltrami
