#include "beltrami/operators/local_operator.hpp"

#include <fmt/format.h>

#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// out_s = (own + own_mass M_s) u_s + scale D_s^(0 or 1) (K z)_s for slots 1 to end - 1.
struct Sweep {
    const ActiveDomain* domain;
    const double* K_diagonal;
    const double* edges;
    const double* mass;
    const double* inverse_mass;  // null for no D
    const double* u;
    const double* z;
    double* out;
    double own;
    double own_mass;
    double scale;
    Index width;
    Index end;
};

// Returns the number of row entries that it walked over.
template <int W>
std::size_t sweep(const Sweep& a) {
    using Row = Eigen::Array<double, W, 1>;
    using In = Eigen::Map<const Row>;
    using Out = Eigen::Map<Row>;
    const Index width = W == Eigen::Dynamic ? a.width : W;
    const auto at = [&](Index slot) { return static_cast<std::ptrdiff_t>(slot) * width; };
    const Index* const entries = a.domain->entries();
    Row sum(width);
    std::size_t walked = 0;
    for (Index s = 1; s < a.end; ++s) {
        const Index begin = a.domain->row_begin(s);
        const Index end = begin + a.domain->row_size(s);
        walked += static_cast<std::size_t>(end - begin);
        sum = a.K_diagonal[s] * In(a.z + at(s), width);
        for (Index e = begin; e < end; ++e)
            sum += a.edges[e] * In(a.z + at(entries[e]), width);
        const double scale = a.inverse_mass != nullptr ? a.scale * a.inverse_mass[s] : a.scale;
        const double own = a.own + a.own_mass * a.mass[s];
        Out(a.out + at(s), width) = own * In(a.u + at(s), width) + scale * sum;
    }
    return walked;
}

std::size_t run(const Sweep& a) {
    return with_width(a.width,
                      [&](auto fixed) { return sweep < fixed() == 0 ? Eigen::Dynamic : fixed() > (a); });
}

}  // namespace

LocalOperator::LocalOperator(PdeOperator stiffness)
    : stiffness_(std::move(stiffness)),
      full_diagonal_(stiffness_.diagonal()),
      K_diagonal_{0.0},
      diagonal_{0.0},
      mass_{0.0},
      inverse_mass_{0.0} {}

void LocalOperator::apply(const ActiveDomain& domain, Weights weights, const SlotField& u, SlotField& y,
                          int to_level) {
    const int terms = order();
    if (domain.rings() < terms || u.slot_count() != domain.slot_count() || y.slot_count() != u.slot_count() ||
        static_cast<Index>(mass_.size()) != domain.slot_count() || u.width() != y.width() || &u == &y) {
        throw InputError(
            fmt::format("a local product of {} slots with {} rings got fields of {} and {} slots",
                        domain.slot_count(), domain.rings(), u.slot_count(), y.slot_count()),
            "let the operator and the fields follow the domain, and give it a ring for each term");
    }
    if (between_.size() < 2 || between_.front().width() != u.width()) {
        between_.assign(2, SlotField(u.columns()));
    }
    for (SlotField& field : between_)
        field.resize(domain.slot_count());

    const std::vector<double>& gamma = stiffness_.gamma();
    Sweep a{&domain,
            K_diagonal_.data(),
            edges_.data(),
            mass_.data(),
            nullptr,
            u.data(),
            u.data(),
            nullptr,
            0.0,
            weights.mass + weights.stiffness * stiffness_.sigma(),
            0.0,
            u.width(),
            domain.end(std::min(to_level, domain.rings()))};
    // A slot's own numbers and its row's place, the entries of its row, and three fields.
    const auto run_counted = [&](const Sweep& work) {
        ++products_;
        bytes_ += static_cast<double>(
            run(work) * (sizeof(double) + sizeof(Index)) +
            static_cast<std::size_t>(work.end - 1) *
                ((3 * static_cast<std::size_t>(u.width()) + 2) * sizeof(double) + 3 * sizeof(Index)));
    };
    if (terms == 0) {
        for (Index s = 1; s < a.end; ++s) {
            for (Index c = 0; c < u.width(); ++c)
                y[s][c] = a.own_mass * mass_[static_cast<std::size_t>(s)] * u[s][c];
        }
        return;
    }
    // Horner's rule from the innermost term outwards; product j can reach j rings and is wanted only as far as the ones
    // after it read.
    const auto reach = [&](int product) { return std::min(product, to_level + terms - product); };
    double pending = gamma.back();
    for (int product = 1; product < terms; ++product) {
        SlotField& out = between_[static_cast<std::size_t>(product % 2)];
        Sweep inner = a;
        inner.inverse_mass = inverse_mass_.data();
        inner.own_mass = 0.0;
        inner.own = gamma[static_cast<std::size_t>(terms - product - 1)];
        inner.scale = std::exchange(pending, 1.0);
        inner.out = out.data();
        inner.end = domain.end(std::min(reach(product), domain.rings()));
        run_counted(inner);
        const Index read_to = domain.end(std::min(reach(product + 1) + 1, domain.rings()));
        if (read_to > inner.end) out.fill_zero(inner.end, read_to);
        a.z = out.data();
    }
    a.scale = weights.stiffness * pending;
    a.out = y.data();
    run_counted(a);
}

Eigen::SparseMatrix<double> LocalOperator::to_sparse(const ActiveDomain& domain, Weights weights) const {
    using Sparse = Eigen::SparseMatrix<double>;
    const Index slots = domain.slot_count();
    std::vector<Eigen::Triplet<double>> entries;
    for (Index s = 1; s < slots; ++s) {
        entries.emplace_back(s, s, K_diagonal_[static_cast<std::size_t>(s)]);
        const auto row = domain.row(s);
        for (std::size_t k = 0; k < row.size(); ++k) {
            const auto e = static_cast<std::size_t>(domain.row_begin(s)) + k;
            if (row[k] != 0) entries.emplace_back(s, row[k], edges_[e]);
        }
    }
    Sparse K(slots, slots);
    K.setFromTriplets(entries.begin(), entries.end());
    Sparse from_active(slots, domain.active_count());
    for (Index s = 1; s < domain.end(0); ++s)
        from_active.insert(s, s - 1) = 1.0;
    from_active.makeCompressed();
    const Eigen::Map<const Vector> D(inverse_mass_.data(), slots);
    const Eigen::Map<const Vector> M(mass_.data(), slots);
    // Only columns of active vertices are carried along.
    const std::vector<double>& gamma = stiffness_.gamma();
    Sparse sum(slots, domain.active_count());
    for (auto g = gamma.rbegin(); g != gamma.rend(); ++g) {
        if (sum.nonZeros() > 0) sum = D.asDiagonal() * sum;
        sum = Sparse(K * Sparse(sum + weights.stiffness * *g * from_active));
    }
    sum += (weights.mass + weights.stiffness * stiffness_.sigma()) * Sparse(M.asDiagonal() * from_active);
    return Sparse(from_active.transpose() * sum);
}

void LocalOperator::push(Index, Index vertex, Index row_begin) {
    const EdgeOperator<double>& K = stiffness_.laplacian().stiffness();
    K_diagonal_.push_back(K.diagonal()[vertex]);
    diagonal_.push_back(full_diagonal_[vertex]);
    mass_.push_back(stiffness_.laplacian().mass()[vertex]);
    inverse_mass_.push_back(stiffness_.laplacian().inverse_mass()[vertex]);
    const auto neighbours = K.graph().neighbours(vertex);
    const auto begin = static_cast<std::size_t>(row_begin);
    if (edges_.size() < begin + neighbours.size()) edges_.resize(begin + neighbours.size());
    for (std::size_t k = 0; k < neighbours.size(); ++k)
        edges_[begin + k] = K.edges()[neighbours[k].edge];
}

void LocalOperator::swap(Index a, Index b) {
    for (std::vector<double>* values : {&K_diagonal_, &diagonal_, &mass_, &inverse_mass_})
        std::swap((*values)[static_cast<std::size_t>(a)], (*values)[static_cast<std::size_t>(b)]);
}

void LocalOperator::pop() {
    for (std::vector<double>* values : {&K_diagonal_, &diagonal_, &mass_, &inverse_mass_})
        values->pop_back();
}

std::size_t LocalOperator::memory_bytes() const {
    std::size_t bytes = 4 * mass_.capacity() * sizeof(double) + edges_.capacity() * sizeof(double);
    for (const SlotField& field : between_)
        bytes += field.memory_bytes();
    return bytes;
}

}  // namespace beltrami
