#include "beltrami/solvers/supernodal_factor.hpp"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <new>
#include <numeric>
#include <utility>

namespace beltrami::supernodal {

namespace {

// Operations of a panel's update from which threads gain.
constexpr double worth_sharing = 1e6;
// Columns of a sweep.
constexpr Index most_columns = 64;

std::size_t at(Index i) {
    return static_cast<std::size_t>(i);
}

// work(0) ... work(count - 1) by the threads that are free; returns when all are done. Tasks rather than loops with
// barriers: a thread that the system has taken away holds up nobody.
template <class Work>
void share_out(int count, const Work& work) {
    const int tasks = std::min(count, 4 * omp_get_num_threads());
    if (tasks < 1) return;
#pragma omp taskloop num_tasks(tasks) default(shared)
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
        work(static_cast<int>(i));
}

Front front_of(const Node& node, double* panel, double* update) {
    return {panel, update, Front::stride_of(node.rows), node.columns, node.rows};
}

}  // namespace

Factor::Factor(std::shared_ptr<const Symbolic> symbolic, const Kernels& kernels)
    : symbolic_(std::move(symbolic)), kernels_(&kernels), values_(symbolic_->values_size) {}

// All panels of a front whose own rows are assembled. The number of negative pivots, or -1.
int Factor::eliminate(const Node& node, const Front& front, bool share) {
    const Symbolic& s = *symbolic_;
    int negative_here = 0;
    const int padded = round_up(front.rows, 8);
    // Rows of the update that share a block of four with own rows are not fresh.
    if (front.columns > panel_columns && front.rows > front.columns) {
        for (int i = front.columns; i < std::min(round_up(front.columns, 4), front.rows); ++i)
            std::fill(front.at(i, i), front.at(i, i) + (padded - i), 0.0);
    }
    for (int first = 0; first < front.columns; first += panel_columns) {
        const Panel& panel = s.panels[node.panels + static_cast<std::size_t>(first / panel_columns)];
        double* L = values_.data() + panel.values;
        const int columns = panel.columns;
        const int pivots = kernels_->eliminate(front, first, columns, L);
        if (pivots < 0) return -1;
        negative_here += pivots;
        if (panel.below == 0) continue;
        const int solve_from = first + round_up(columns, 8);
        const int update_from = (first + columns) / 8 * 8;
        const int blocks = (panel.below + 3) / 4;
        const bool fresh = first == 0;
        const double work = static_cast<double>(columns) * panel.below * panel.below;
        if (!share || work < worth_sharing) {
            kernels_->solve(front, first, columns, L, solve_from, padded);
            kernels_->fill(front, first, columns, L, 0, blocks);
            kernels_->update(front, first, columns, L, update_from, padded, fresh);
            continue;
        }
        constexpr int chunk = chunk_columns;
        share_out((padded - solve_from + chunk - 1) / chunk, [&](int i) {
            const int j = solve_from + i * chunk;
            kernels_->solve(front, first, columns, L, j, std::min(j + chunk, padded));
        });
        constexpr int some = 8;
        share_out((blocks + some - 1) / some, [&](int i) {
            kernels_->fill(front, first, columns, L, i * some, std::min((i + 1) * some, blocks));
        });
        // Chunks further back have more rows: from both ends by turns, so that tasks are alike.
        const int chunks = (padded - update_from + chunk - 1) / chunk;
        share_out(chunks, [&](int i) {
            const int j = update_from + (i % 2 == 0 ? i / 2 : chunks - 1 - i / 2) * chunk;
            kernels_->update(front, first, columns, L, j, std::min(j + chunk, padded), fresh);
        });
    }
    return negative_here;
}

int Factor::process(std::size_t f, const Entries& entries, Room& room, std::vector<double*>& updates,
                    std::vector<LargeArray>& kept, bool share) {
    const Symbolic& s = *symbolic_;
    const Node& node = s.nodes[f];
    const auto parity = static_cast<std::size_t>(node.depth & 1);
    double* update = nullptr;
    if (node.stacked) {
        update = room.stacks[parity].data() + room.used[parity];
        room.used[parity] += node.update_size();
    } else if (node.below() > 0) {
        kept[f] = LargeArray(node.update_size());
        update = kept[f].data();
    }
    updates[f] = update;
    const Front front = front_of(node, room.panel.data(), update);
    std::fill(front.panel, front.panel + front.columns * front.stride, 0.0);
    for (Index c = 0; c < node.columns; ++c) {
        double* row = front.panel + c * front.stride;
        const std::size_t end = s.starts[at(node.first + c) + 1];
        for (std::size_t e = s.starts[at(node.first + c)]; e < end; ++e)
            row[s.positions[e]] = entries[e];
    }
    const auto add_children = [&](bool own) {
        for (Index c = node.child; c >= 0; c = s.nodes[at(c)].sibling) {
            const Node& child = s.nodes[at(c)];
            const Index* place = s.places.data() + child.place;
            const auto split =
                static_cast<int>(std::lower_bound(place, place + child.below(), node.columns) - place);
            const int begin = own ? 0 : split;
            const int end = own ? split : child.below();
            const Front from = front_of(child, nullptr, updates[at(c)]);
            if (share && static_cast<double>(end - begin) * child.below() > worth_sharing / 16) {
                constexpr int some = 8;
                share_out((end - begin + some - 1) / some, [&](int i) {
                    kernels_->add(from, place, front, begin + i * some,
                                  std::min(begin + (i + 1) * some, end));
                });
            } else {
                kernels_->add(from, place, front, begin, end);
            }
        }
    };
    add_children(true);
    const int pivots = eliminate(node, front, share);
    add_children(false);
    for (Index c = node.child; c >= 0; c = s.nodes[at(c)].sibling) {
        const Node& child = s.nodes[at(c)];
        if (child.stacked) {
            room.used[static_cast<std::size_t>(child.depth & 1)] -= child.update_size();
        } else {
            kept[at(c)] = LargeArray();
        }
    }
    return pivots;
}

int Factor::factor(const Entries& entries) {
    const Symbolic& s = *symbolic_;
    std::vector<double*> updates(s.nodes.size(), nullptr);
    std::vector<LargeArray> kept(s.nodes.size());
    std::vector<int> pivots(s.groups.size(), 0);
    std::atomic<bool> no_memory = false;
    const auto run = [&](std::size_t g) {
        const bool is_top = g + 1 == s.groups.size();
        const Group& group = s.groups[g];
        Room room;
        room.panel = LargeArray(group.panel);
        for (std::size_t parity = 0; parity < 2; ++parity)
            room.stacks[parity] = LargeArray(group.stack[parity]);
        for (std::size_t f = group.begin; f < group.end && pivots[g] >= 0; ++f) {
            const int more = process(f, entries, room, updates, kept, is_top);
            pivots[g] = more < 0 ? -1 : pivots[g] + more;
        }
    };
    const auto run_if_room = [&](std::size_t g) {
        try {
            run(g);
        } catch (const std::bad_alloc&) {
            no_memory = true;
        }
    };
    const std::size_t subtrees = s.groups.size() - 1;
    bool sound = true;
#pragma omp parallel if (subtrees > 1)
#pragma omp single
    {
        share_out(static_cast<int>(subtrees), [&](int g) { run_if_room(static_cast<std::size_t>(g)); });
        sound = !no_memory && *std::min_element(pivots.begin(), pivots.end()) >= 0;
        if (sound) run_if_room(subtrees);
        sound = sound && pivots.back() >= 0;
    }
    if (no_memory) throw std::bad_alloc();
    return sound ? std::accumulate(pivots.begin(), pivots.end(), 0) : -1;
}

// At most most_columns.
void Factor::sweep(const RightHandSides& b) const {
    const Symbolic& s = *symbolic_;
    const Index count = b.count;
    const int width = count <= 4 ? 4 : round_up(count, 8);
    const auto needed = s.array_rows * static_cast<std::size_t>(width);
    if (work_.size() < needed) {
        work_ = LargeArray();
        work_ = LargeArray(needed);
    }
    double* x = work_.data();
    const auto array = [&](const Group& group) { return x + group.base * static_cast<std::size_t>(width); };
    const auto subtrees = static_cast<int>(s.groups.size()) - 1;
    const Group& top = s.groups.back();
    const bool by_rows = b.column_stride == 1;
    const auto row_of = [&](auto* data, std::size_t m) { return data + s.moves[m].unknown * b.row_stride; };
    // Rows or columns lie far apart: their lines are fetched some rows ahead, once each.
    const auto fetch = [&](const double* data, std::size_t m, const Piece& piece, int begin, int end) {
        constexpr std::size_t ahead = 16;
        if (m + ahead >= piece.last_move) return;
        if (by_rows) {
            for (int c = begin; c < end; c += 8)
                __builtin_prefetch(row_of(data, m + ahead) + c);
            return;
        }
        if (s.moves[m + ahead].unknown / 8 == s.moves[m + ahead - 1].unknown / 8) return;
        for (int c = begin; c < end; ++c)
            __builtin_prefetch(row_of(data, m + ahead) + c * b.column_stride);
    };
    const auto move_in = [&](const double* data, double* rows, const Piece& piece, int begin, int end) {
        const int filled = std::min(end, count);
        for (std::size_t m = piece.first_move; m < piece.last_move; ++m) {
            fetch(data, m, piece, begin, filled);
            const double* from = row_of(data, m);
            double* to = rows + static_cast<std::ptrdiff_t>(s.moves[m].row) * width;
            if (by_rows) {
                std::copy(from + begin, from + filled, to + begin);
            } else {
#pragma GCC unroll 8
                for (int c = begin; c < filled; ++c)
                    to[c] = from[c * b.column_stride];
            }
            for (int c = std::max(begin, filled); c < end; ++c)
                to[c] = 0.0;
        }
    };
    const auto move_out = [&](const double* rows, const Piece& piece, int begin, int end) {
        end = std::min(end, count);
        for (std::size_t m = piece.first_move; m < piece.last_move; ++m) {
            fetch(b.to, m, piece, begin, end);
            double* to = row_of(b.to, m);
            const double* from = rows + static_cast<std::ptrdiff_t>(s.moves[m].row) * width;
            if (by_rows) {
                std::copy(from + begin, from + end, to + begin);
            } else {
#pragma GCC unroll 8
                for (int c = begin; c < end; ++c)
                    to[c * b.column_stride] = from[c];
            }
        }
    };
    const auto forward = [&](double* rows, const Piece& piece, int begin, int end) {
        kernels_->forward(s.panels.data() + piece.first_panel, piece.last_panel - piece.first_panel,
                          values_.data(), s.lists.data(), rows + begin, width, end - begin);
    };
    const auto backward = [&](double* rows, const Piece& piece, int begin, int end) {
        kernels_->backward(s.panels.data() + piece.first_panel, piece.last_panel - piece.first_panel,
                           values_.data(), s.lists.data(), rows + begin, width, end - begin);
    };

#pragma omp parallel if (subtrees > 1)
#pragma omp single
    {
        share_out(subtrees, [&](int g) {
            const Group& group = s.groups[static_cast<std::size_t>(g)];
            double* rows = array(group);
            double* above = rows + static_cast<std::ptrdiff_t>(group.columns) * width;
            std::fill(above, above + (group.touched.size() + 1) * static_cast<std::size_t>(width), 0.0);
            // What is in no piece gets updates before its turn comes.
            for (std::size_t p = group.first_piece; p < group.last_piece; ++p) {
                if (!s.pieces[p].whole) move_in(b.from, rows, s.pieces[p], 0, width);
            }
            for (std::size_t p = group.first_piece; p < group.last_piece; ++p) {
                if (s.pieces[p].whole) move_in(b.from, rows, s.pieces[p], 0, width);
                forward(rows, s.pieces[p], 0, width);
                if (s.pieces[p].whole) move_out(rows, s.pieces[p], 0, width);
            }
        });
        // Columns of the top by threads, each the whole way up and down.
        const int parts = std::max(1, std::min(omp_get_num_threads(), width / 8));
        share_out(parts, [&](int part) {
            const int begin = width == 4 ? 0 : width / 8 * part / parts * 8;
            const int end = width == 4 ? 4 : width / 8 * (part + 1) / parts * 8;
            double* rows = array(top);
            double* zeros = rows + static_cast<std::ptrdiff_t>(top.columns) * width;
            std::fill(zeros + begin, zeros + end, 0.0);
            for (std::size_t p = top.first_piece; p < top.last_piece; ++p)
                move_in(b.from, rows, s.pieces[p], begin, end);
            for (int g = 0; g < subtrees; ++g) {
                const Group& group = s.groups[static_cast<std::size_t>(g)];
                const double* from = array(group) + static_cast<std::ptrdiff_t>(group.columns) * width;
                for (const Index t : group.touched) {
                    double* to = rows + static_cast<std::ptrdiff_t>(t) * width;
                    for (int c = begin; c < end; ++c)
                        to[c] += from[c];
                    from += width;
                }
            }
            for (std::size_t p = top.first_piece; p < top.last_piece; ++p)
                forward(rows, s.pieces[p], begin, end);
            for (std::size_t p = top.last_piece; p-- > top.first_piece;) {
                backward(rows, s.pieces[p], begin, end);
                move_out(rows, s.pieces[p], begin, end);
            }
        });
        share_out(subtrees, [&](int g) {
            const Group& group = s.groups[static_cast<std::size_t>(g)];
            double* rows = array(group);
            double* above = rows + static_cast<std::ptrdiff_t>(group.columns) * width;
            for (const Index t : group.touched) {
                const double* from = array(top) + static_cast<std::ptrdiff_t>(t) * width;
                above = std::copy(from, from + width, above);
            }
            for (std::size_t p = group.last_piece; p-- > group.first_piece;) {
                if (s.pieces[p].whole) move_in(b.to, rows, s.pieces[p], 0, width);
                backward(rows, s.pieces[p], 0, width);
                move_out(rows, s.pieces[p], 0, width);
            }
        });
    }
}

void Factor::solve(const RightHandSides& b) const {
    // Parts of the same width, but for the last.
    for (Index first = 0; first < b.count; first += most_columns) {
        sweep({b.from + first * b.column_stride, b.to + first * b.column_stride, b.row_stride,
               b.column_stride, std::min(most_columns, b.count - first)});
    }
}

}  // namespace beltrami::supernodal
