#include "beltrami/solvers/local_system.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <utility>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

// sum of weight_s a_sc b_sc for slots begin to end - 1.
double weighted_dot(const std::vector<double>& weight, const SlotField& a, const SlotField& b, Index begin,
                    Index end) {
    return with_width(a.width(), [&](auto fixed) {
        const Index width = fixed() > 0 ? fixed() : a.width();
        double sum = 0.0;
        for (Index s = begin; s < end; ++s) {
            double row = 0.0;
            for (Index c = 0; c < width; ++c)
                row += a[s][c] * b[s][c];
            sum += weight[static_cast<std::size_t>(s)] * row;
        }
        return sum;
    });
}

// Throws InputError for a hold that is not one.
void check_holds(const Laplacian& laplacian, std::span<const Hold> holds, Index columns) {
    for (const Hold& hold : holds) {
        double sum = 0.0;
        for (const double weight : hold.weights)
            sum += weight;
        if (hold.vertices.empty() || hold.vertices.size() != hold.weights.size() ||
            !(std::abs(sum - 1.0) < 1e-9)) {
            throw InputError(fmt::format("a held point of {} vertices has {} weights of sum {}",
                                         hold.vertices.size(), hold.weights.size(), sum),
                             "give a weight for each vertex, of sum 1");
        }
        if (static_cast<Index>(hold.value.size()) != columns) {
            throw InputError(fmt::format("a held point has {} values, but the field has {} columns",
                                         hold.value.size(), columns),
                             "make both of the same width");
        }
        for (const double value : hold.value) {
            // Squares of squares must neither overflow nor vanish.
            if (value == 0.0 || (std::abs(value) > 1e-100 && std::abs(value) < 1e100)) continue;
            throw InputError(fmt::format("a point is held at the value {}", value),
                             "give 0 or a number between 1e-100 and 1e100 in size");
        }
        for (std::size_t j = 0; j < hold.vertices.size(); ++j) {
            const Index v = hold.vertices[j];
            if (v < 0 || v >= laplacian.vertex_count()) {
                throw InputError(
                    fmt::format("a point is held at vertex {} of {}", v, laplacian.vertex_count()),
                    "hold vertices of the mesh");
            }
            if (std::find(hold.vertices.begin(), hold.vertices.begin() + static_cast<std::ptrdiff_t>(j), v) !=
                hold.vertices.begin() + static_cast<std::ptrdiff_t>(j)) {
                throw InputError(fmt::format("a held point names vertex {} twice", laplacian.order().user(v)),
                                 "name each vertex once");
            }
            if (laplacian.graph().degree(v) > 0) continue;
            throw InputError(fmt::format("vertex {} is isolated: a contact there moves nothing",
                                         laplacian.order().user(v)),
                             "touch a vertex of a cell that has an area");
        }
    }
}

// Of a Gram matrix of held points, where two of them may come to lie in the same place.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& gram) {
    if (gram.rows() <= 1) return gram.cwiseInverse();
    const Eigen::VectorXd scale = gram.diagonal().cwiseSqrt().cwiseInverse();
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition(gram.rows(), gram.cols());
    decomposition.setThreshold(1e-10);
    decomposition.compute(scale.asDiagonal() * gram * scale.asDiagonal());
    return scale.asDiagonal() * decomposition.pseudoInverse() * scale.asDiagonal();
}

}  // namespace

LocalSystem::LocalSystem(PdeOperator stiffness, Index columns)
    : x(columns),
      b(columns),
      r(columns),
      domain_(stiffness.laplacian().graph(), std::max(1, stiffness.order())),
      operator_(std::move(stiffness)),
      p_(columns),
      q_(columns),
      z_(columns) {
    if (columns < 1) throw InputError(fmt::format("a field of {} columns", columns), "give it one or more");
    const Laplacian& laplacian = operator_.op().laplacian();
    for (Index v = 0; v < laplacian.vertex_count(); ++v) {
        if (laplacian.graph().degree(v) > 0 && !(laplacian.mass()[v] > 0.0)) {
            throw InputError(fmt::format("vertex {} has edges but no mass", laplacian.order().user(v)),
                             "local solves need a positive mass at every vertex: use the barycentric mass");
        }
    }
}

std::vector<Index> LocalSystem::vertices_of(std::span<const Hold> holds) const {
    check_holds(operator_.op().laplacian(), holds, columns());
    std::vector<Index> vertices;
    for (const Hold& hold : holds)
        vertices.insert(vertices.end(), hold.vertices.begin(), hold.vertices.end());
    return vertices;
}

void LocalSystem::prepare(LocalOperator::Weights weights, std::span<const Hold> holds) {
    weights_ = weights;
    const auto count = static_cast<Eigen::Index>(holds.size());
    held_.slots.clear();
    held_.value.resize(count, columns());
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index h = 0; h < count; ++h) {
        const Hold& hold = holds[static_cast<std::size_t>(h)];
        held_.value.row(h) = Eigen::Map<const Eigen::RowVectorXd>(hold.value.data(), columns());
        for (std::size_t j = 0; j < hold.vertices.size(); ++j) {
            if (!domain_.is_active(hold.vertices[j])) {
                throw InputError(fmt::format("a point is held at vertex {}, which is not active",
                                             operator_.op().laplacian().order().user(hold.vertices[j])),
                                 "activate the vertices of held points first");
            }
            const Index slot = domain_.slot(hold.vertices[j]);
            const auto found = std::find(held_.slots.begin(), held_.slots.end(), slot);
            entries.emplace_back(h, found - held_.slots.begin(), hold.weights[j]);
            if (found == held_.slots.end()) held_.slots.push_back(slot);
        }
    }
    held_.C = Eigen::MatrixXd::Zero(count, std::ssize(held_.slots));
    for (const auto& entry : entries)
        held_.C(entry.row(), entry.col()) += entry.value();

    const auto end = static_cast<std::size_t>(domain_.end(0));
    preconditioner_.assign(end, 0.0);
    for (std::size_t s = 1; s < end; ++s) {
        const double diagonal =
            weights_.mass * operator_.mass()[s] + weights_.stiffness * operator_.diagonal()[s];
        preconditioner_[s] = diagonal > 0.0 ? 1.0 / diagonal : 0.0;
    }
    inverse_mass_.assign(operator_.inverse_mass().begin(),
                         operator_.inverse_mass().begin() + static_cast<std::ptrdiff_t>(end));
    const auto move_held = [&](std::vector<double>& weight) {
        Eigen::VectorXd moved(std::ssize(held_.slots));
        for (Eigen::Index j = 0; j < moved.size(); ++j)
            moved[j] = std::exchange(
                weight[static_cast<std::size_t>(held_.slots[static_cast<std::size_t>(j)])], 0.0);
        return moved;
    };
    held_.preconditioner = move_held(preconditioner_);
    held_.inverse_mass = move_held(inverse_mass_);
    const auto inverse_gram = [&](const Eigen::VectorXd& weight) -> Eigen::MatrixXd {
        return pseudo_inverse(held_.C * weight.asDiagonal() * held_.C.transpose());
    };
    held_.inverse_gram_preconditioner = inverse_gram(held_.preconditioner);
    held_.inverse_gram_mass = inverse_gram(held_.inverse_mass);
    if (factor_) fit_factor();
}

bool LocalSystem::factorize() {
    factor_.reset();
    try {
        factor_.emplace(Factor{Cholesky(operator_.to_sparse(domain_, weights_)), {}, {}, {}, {}, {}});
    } catch (const SolveError&) {
        return false;
    }
    for (Index s = 1; s < domain_.end(0); ++s)
        factor_->vertices.push_back(domain_.vertex(s));
    fit_factor();
    return true;
}

// After the domain or the held points have changed: where the factor's rows lie now, and B C^T.
void LocalSystem::fit_factor() {
    factor_->slots.clear();
    factor_->has_row.assign(static_cast<std::size_t>(domain_.end(0)), 0);
    for (const Index v : factor_->vertices) {
        const Index slot = domain_.is_active(v) ? domain_.slot(v) : 0;
        factor_->slots.push_back(slot);
        if (slot != 0) factor_->has_row[static_cast<std::size_t>(slot)] = 1;
    }
    const Eigen::Index count = held_.C.rows();
    factor_->spread = Block::Zero(domain_.end(0), count);
    factor_->spread(held_.slots, Eigen::all) = held_.C.transpose();
    apply_factor(factor_->spread);
    factor_->inverse_gram = pseudo_inverse(held_.C * factor_->spread(held_.slots, Eigen::all));
}

// B times a block over the slots below end(0): the factor for its rows, Jacobi for the others.
void LocalSystem::apply_factor(Block& block) const {
    if (block.cols() == 0) return;
    Block rows(std::ssize(factor_->slots), block.cols());
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
        rows.row(i) = block.row(factor_->slots[static_cast<std::size_t>(i)]);
    Block solution;
    factor_->cholesky.solve(rows, solution);
    for (Index s = 1; s < domain_.end(0); ++s) {
        if (factor_->has_row[static_cast<std::size_t>(s)] == 0)
            block.row(s) *= preconditioner_[static_cast<std::size_t>(s)];
    }
    for (std::size_t j = 0; j < held_.slots.size(); ++j) {
        if (factor_->has_row[static_cast<std::size_t>(held_.slots[j])] == 0)
            block.row(held_.slots[j]).setZero();
    }
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
        block.row(factor_->slots[static_cast<std::size_t>(i)]) = solution.row(i);
    block.row(0).setZero();
}

// z = the projection of B r, and r^T z.
double LocalSystem::precondition() {
    Block block = Block::Zero(domain_.end(0), columns());
    for (Index s = 1; s < domain_.end(0); ++s)
        block.row(s) = Eigen::Map<const Eigen::RowVectorXd>(r[s], columns());
    block(held_.slots, Eigen::all) = projected(held_.inverse_mass, held_.inverse_gram_mass);
    const Block residual = block;
    apply_factor(block);
    const Eigen::MatrixXd moments = held_.C * block(held_.slots, Eigen::all);
    block -= factor_->spread * (factor_->inverse_gram * moments);
    for (Index s = 1; s < domain_.end(0); ++s)
        std::copy_n(block.row(s).data(), columns(), z_[s]);
    return block.cwiseProduct(residual).sum();
}

Eigen::MatrixXd LocalSystem::at_held(const SlotField& field) const {
    Eigen::MatrixXd rows(std::ssize(held_.slots), columns());
    for (Eigen::Index j = 0; j < rows.rows(); ++j)
        rows.row(j) =
            Eigen::Map<const Eigen::RowVectorXd>(field[held_.slots[static_cast<std::size_t>(j)]], columns());
    return rows;
}

// The rows of r - C^T f at held slots, f the forces that make it smallest in the norm of the weight.
Eigen::MatrixXd LocalSystem::projected(const Eigen::VectorXd& weight,
                                       const Eigen::MatrixXd& inverse_gram) const {
    const Eigen::MatrixXd rows = at_held(r);
    return rows - held_.C.transpose() * (inverse_gram * (held_.C * (weight.asDiagonal() * rows)));
}

// field += P C^T (C P C^T)^-1 values
void LocalSystem::lift(const Eigen::MatrixXd& values, SlotField& field) const {
    const Eigen::MatrixXd change = held_.preconditioner.asDiagonal() * held_.C.transpose() *
                                   (held_.inverse_gram_preconditioner * values);
    for (Eigen::Index j = 0; j < change.rows(); ++j) {
        for (Index c = 0; c < columns(); ++c)
            field[held_.slots[static_cast<std::size_t>(j)]][c] += change(j, c);
    }
}

void LocalSystem::impose() {
    if (held_.slots.empty()) return;
    const double scale = std::max(held_.value.cwiseAbs().maxCoeff(), at_held(x).cwiseAbs().maxCoeff());
    lift(held_.value - held_.C * at_held(x), x);
    const Eigen::MatrixXd lack = held_.value - held_.C * at_held(x);
    // Written so that NaN is refused. Points that are closer together than 1e-5 of a cell count as one.
    if (lack.cwiseAbs().maxCoeff() <= 2e-5 * scale) return;
    Eigen::Index worst = 0;
    (void)lack.rowwise().norm().maxCoeff(&worst);
    throw InputError(
        fmt::format("held point {} of {} lies in the place of others that are held at another value", worst,
                    held_.value.rows()),
        "keep contacts apart, or move them alike");
}

void LocalSystem::balance() {
    // p = x without the lift of the held values.
    p_.fill_zero(0, domain_.slot_count());
    if (!held_.slots.empty()) lift(-held_.value, p_);
    const std::ptrdiff_t active = static_cast<std::ptrdiff_t>(domain_.end(0)) * x.width();
    for (std::ptrdiff_t i = 0; i < active; ++i)
        p_.data()[i] += x.data()[i];
    operator_.apply(domain_, weights_, p_, q_, domain_.rings());
    const double square = dot(p_, q_);
    if (!(square > 0.0)) return;
    const double step = dot(p_, r) / square;
    for (std::ptrdiff_t i = 0; i < active; ++i)
        x.data()[i] += step * p_.data()[i];
    const std::ptrdiff_t all = static_cast<std::ptrdiff_t>(domain_.slot_count()) * x.width();
    for (std::ptrdiff_t i = x.width(); i < all; ++i)
        r.data()[i] -= step * q_.data()[i];
}

void LocalSystem::compute_residual() {
    operator_.apply(domain_, weights_, x, r, domain_.rings());
    const std::ptrdiff_t numbers = static_cast<std::ptrdiff_t>(domain_.slot_count()) * x.width();
    double* const rs = r.data();
    const double* const bs = b.data();
    for (std::ptrdiff_t i = x.width(); i < numbers; ++i)
        rs[i] = bs[i] - rs[i];
    bytes_ += static_cast<double>(numbers) * 3 * sizeof(double);
}

LocalSystem::Missing LocalSystem::missing() const {
    Missing missing;
    missing.inside = weighted_dot(inverse_mass_, r, r, 1, domain_.end(0));
    if (!held_.slots.empty()) {
        const Eigen::MatrixXd rest = projected(held_.inverse_mass, held_.inverse_gram_mass);
        missing.inside += (held_.inverse_mass.asDiagonal() * rest.cwiseAbs2()).sum();
    }
    missing.outside = weighted_dot(operator_.inverse_mass(), r, r, domain_.end(0), domain_.slot_count());
    return missing;
}

LocalSystem::Missing LocalSystem::missing_by_factor() {
    Missing missing;
    missing.inside = sigma() * std::max(0.0, precondition());
    z_.fill_zero(domain_.end(0), domain_.slot_count());
    operator_.apply(domain_, weights_, z_, q_, domain_.rings());
    const std::ptrdiff_t end = static_cast<std::ptrdiff_t>(domain_.slot_count()) * x.width();
    for (std::ptrdiff_t i = static_cast<std::ptrdiff_t>(domain_.end(0)) * x.width(); i < end; ++i)
        q_.data()[i] = r.data()[i] - q_.data()[i];
    missing.outside = weighted_dot(operator_.inverse_mass(), q_, q_, domain_.end(0), domain_.slot_count());
    return missing;
}

std::vector<Index> LocalSystem::growth(double budget) const {
    const double share = budget / std::max(1, domain_.slot_count() - domain_.end(0));
    std::vector<Index> grown;
    for (Index s = domain_.end(0); s < domain_.slot_count(); ++s) {
        if (weighted_dot(operator_.inverse_mass(), r, r, s, s + 1) > share)
            grown.push_back(domain_.vertex(s));
    }
    return grown;
}

LocalSystem::Iterations LocalSystem::iterate(double target, int most,
                                             std::optional<Clock::time_point> deadline, int least) {
    Iterations done;
    const Index end = domain_.end(0);
    const std::vector<double>& D = inverse_mass_;
    const std::vector<double>& P = preconditioner_;
    const bool held = !held_.slots.empty();

    Eigen::MatrixXd held_direction;  // P times the projected residual, at held slots
    // p = z + beta p with z the projection of the preconditioned residual.
    const auto direction = [&](double beta) {
        if (factor_) {
            const std::ptrdiff_t numbers = static_cast<std::ptrdiff_t>(end) * x.width();
            for (std::ptrdiff_t i = 0; i < numbers; ++i)
                p_.data()[i] = z_.data()[i] + beta * p_.data()[i];
            return;
        }
        with_width(x.width(), [&](auto fixed) {
            const Index width = fixed() > 0 ? fixed() : x.width();
            for (Index s = 1; s < end; ++s) {
                for (Index c = 0; c < width; ++c)
                    p_[s][c] = P[static_cast<std::size_t>(s)] * r[s][c] + beta * p_[s][c];
            }
        });
        for (Eigen::Index j = 0; j < held_direction.rows(); ++j) {
            for (Index c = 0; c < columns(); ++c)
                p_[held_.slots[static_cast<std::size_t>(j)]][c] += held_direction(j, c);
        }
    };
    struct Norms {
        double preconditioned;
        double mass;
    };
    // The squares of the projected residual in both norms, from those of the free slots.
    const auto with_held = [&](Norms free) -> Norms {
        if (factor_) free.preconditioned = precondition();
        if (!held) return free;
        const Eigen::MatrixXd rest_mass = projected(held_.inverse_mass, held_.inverse_gram_mass);
        free.mass += (held_.inverse_mass.asDiagonal() * rest_mass.cwiseAbs2()).sum();
        if (factor_) return free;
        const Eigen::MatrixXd rest = projected(held_.preconditioner, held_.inverse_gram_preconditioner);
        held_direction = held_.preconditioner.asDiagonal() * rest;
        free.preconditioned += rest.cwiseProduct(held_direction).sum();
        return free;
    };

    Norms now = with_held({weighted_dot(P, r, r, 1, end), weighted_dot(D, r, r, 1, end)});
    if (end == 1 || now.preconditioned == 0.0 || (now.mass <= target && least == 0)) return done;
    p_.fill_zero(0, domain_.slot_count());
    direction(0.0);
    while (done.count < most) {
        operator_.apply(domain_, weights_, p_, q_, 0);
        const double pq = dot(p_, q_);
        // Written so that NaN counts as indefinite.
        if (!(pq > 0.0)) {
            done.definite = now.preconditioned == 0.0;
            break;
        }
        const double alpha = now.preconditioned / pq;
        const Norms plain = with_width(x.width(), [&](auto fixed) -> Norms {
            const Index width = fixed() > 0 ? fixed() : x.width();
            Norms sums{0.0, 0.0};
            for (Index s = 1; s < end; ++s) {
                double square = 0.0;
                for (Index c = 0; c < width; ++c) {
                    x[s][c] += alpha * p_[s][c];
                    r[s][c] -= alpha * q_[s][c];
                    square += r[s][c] * r[s][c];
                }
                sums.preconditioned += P[static_cast<std::size_t>(s)] * square;
                sums.mass += D[static_cast<std::size_t>(s)] * square;
            }
            return sums;
        });
        const Norms next = with_held(plain);
        ++done.count;
        // p q once, x r p q, r p.
        bytes_ += static_cast<double>(end - 1) * static_cast<double>(x.width()) * 9 * sizeof(double);
        if (next.mass <= target && done.count >= least) break;
        if (deadline && Clock::now() >= *deadline) {
            done.in_time = false;
            break;
        }
        direction(now.preconditioned > 0.0 ? next.preconditioned / now.preconditioned : 0.0);
        now = next;
    }
    return done;
}

Block LocalSystem::forces() const {
    if (held_.slots.empty()) return Block(0, columns());
    return -(held_.inverse_gram_preconditioner *
             (held_.C * (held_.preconditioner.asDiagonal() * at_held(r))));
}

LocalSystem::Part LocalSystem::part(std::span<const Index> vertices, const SlotField& u) {
    p_.fill_zero(0, domain_.slot_count());
    for (const Index v : vertices) {
        const Index s = domain_.slot(v);
        std::copy_n(u[s], u.width(), p_[s]);
    }
    operator_.apply(domain_, {0.0, 1.0}, p_, q_, 0);
    return {dot(p_, q_), dot(u, q_)};
}

double LocalSystem::dot(const SlotField& a, const SlotField& c) const {
    const std::ptrdiff_t numbers = static_cast<std::ptrdiff_t>(domain_.end(0)) * a.width();
    const double* const as = a.data();
    const double* const cs = c.data();
    double sum = 0.0;
#pragma omp simd reduction(+ : sum)
    for (std::ptrdiff_t i = 0; i < numbers; ++i)
        sum += as[i] * cs[i];
    return sum;
}

std::size_t LocalSystem::memory_bytes() const {
    std::size_t bytes = domain_.memory_bytes() + operator_.memory_bytes() +
                        (preconditioner_.capacity() + inverse_mass_.capacity()) * sizeof(double) +
                        quiet_.capacity();
    for (const SlotField* field : {&x, &b, &r, &p_, &q_, &z_})
        bytes += field->memory_bytes();
    if (factor_) bytes += factor_->cholesky.memory_bytes();
    return bytes;
}

}  // namespace beltrami
