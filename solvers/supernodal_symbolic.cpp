#include "beltrami/solvers/supernodal_factor.hpp"

#include <cholmod.h>

#include <algorithm>
#include <new>
#include <numeric>
#include <queue>
#include <utility>

namespace beltrami::supernodal {

// CHOLMOD's ordering and supernodes.
struct Supernodes {
    std::vector<Index> order;              // row of the matrix by column of L
    std::vector<Index> begin;              // first column of each supernode, and n
    std::vector<std::vector<Index>> rows;  // of each, its columns first
};

namespace {

// Sets of subtrees that threads share. Not their number, on which results would depend then.
constexpr std::size_t group_count = 8;
// Entries of a factor from which threads gain.
constexpr double worth_groups = 2e5;
// Unknowns whose values fit in a core's cache while a sweep passes through them.
constexpr Index piece_rows = 2048;

template <class T>
std::size_t bytes_of(const std::vector<T>& v) {
    return v.size() * sizeof(T);
}

std::size_t at(Index i) {
    return static_cast<std::size_t>(i);
}

struct CholmodCommon {
    cholmod_common common{};
    CholmodCommon() {
        cholmod_l_start(&common);
        common.print = 0;
        common.try_catch = 1;
    }
    CholmodCommon(const CholmodCommon&) = delete;
    CholmodCommon& operator=(const CholmodCommon&) = delete;
    ~CholmodCommon() { cholmod_l_finish(&common); }
};

Supernodes analyse(const UpperPattern& upper, bool quick) {
    CholmodCommon start;
    cholmod_common& common = start.common;
    std::vector<SuiteSparse_long> starts(upper.starts.begin(), upper.starts.end());
    std::vector<SuiteSparse_long> indices(upper.rows.begin(), upper.rows.end());
    cholmod_sparse pattern{};
    pattern.nrow = pattern.ncol = at(upper.size());
    pattern.nzmax = indices.size();
    pattern.p = starts.data();
    pattern.i = indices.data();
    pattern.stype = 1;
    pattern.itype = CHOLMOD_LONG;
    pattern.xtype = CHOLMOD_PATTERN;
    pattern.dtype = CHOLMOD_DOUBLE;
    pattern.sorted = 1;
    pattern.packed = 1;
    common.nmethods = 1;
    common.method[0].ordering = quick ? CHOLMOD_AMD : CHOLMOD_METIS;
    common.postorder = 1;
    common.supernodal = CHOLMOD_SUPERNODAL;
    // Sweeps read the zeros that merged supernodes hold: fewer of them than CHOLMOD takes by itself.
    common.nrelax[0] = 4;
    common.nrelax[1] = 8;
    common.nrelax[2] = 32;
    common.zrelax[0] = 0.5;
    common.zrelax[1] = 0.2;
    common.zrelax[2] = 0.05;
    cholmod_factor* L = cholmod_l_analyze(&pattern, &common);
    if (L == nullptr) throw std::bad_alloc();
    Supernodes nodes;
    const auto* order = static_cast<const SuiteSparse_long*>(L->Perm);
    const auto* super = static_cast<const SuiteSparse_long*>(L->super);
    const auto* list = static_cast<const SuiteSparse_long*>(L->pi);
    const auto* rows = static_cast<const SuiteSparse_long*>(L->s);
    nodes.order.assign(order, order + upper.size());
    nodes.begin.assign(super, super + L->nsuper + 1);
    nodes.rows.resize(L->nsuper);
    for (std::size_t f = 0; f < L->nsuper; ++f)
        nodes.rows[f].assign(rows + list[f], rows + list[f + 1]);
    cholmod_l_free_factor(&L, &common);
    return nodes;
}

}  // namespace

void Symbolic::set_order(const Supernodes& supernodes, std::vector<std::vector<Index>>& rows) {
    const std::size_t count = supernodes.rows.size();
    std::vector<Index> node_of(at(n));
    for (std::size_t f = 0; f < count; ++f)
        std::fill(node_of.begin() + supernodes.begin[f], node_of.begin() + supernodes.begin[f + 1],
                  static_cast<Index>(f));
    std::vector<Index> parent(count, -1);
    std::vector<std::vector<Index>> children(count);
    std::vector<double> cost(count);
    std::vector<double> entries(count);
    for (std::size_t f = 0; f < count; ++f) {
        const double columns = supernodes.begin[f + 1] - supernodes.begin[f];
        const auto size = static_cast<double>(supernodes.rows[f].size());
        entries[f] = columns * size - columns * (columns - 1) / 2;
        for (Index c = supernodes.begin[f]; c < supernodes.begin[f + 1]; ++c) {
            const double length = size - (c - supernodes.begin[f]);
            cost[f] += length * length;
        }
        nonzeros += entries[f];
        flops += cost[f];
        if (size > columns) {
            parent[f] = node_of[at(supernodes.rows[f][static_cast<std::size_t>(columns)])];
            children[at(parent[f])].push_back(static_cast<Index>(f));
        }
    }
    // Half by entries, for the sweeps, and half by operations, for the factorization.
    std::vector<double> weight(count);
    for (std::size_t f = 0; f < count; ++f) {
        weight[f] += entries[f] / nonzeros + cost[f] / flops;
        if (parent[f] >= 0) weight[at(parent[f])] += weight[f];
    }

    // Subtrees, the heaviest cut until none holds more than its share.
    using Heavy = std::pair<double, Index>;
    std::priority_queue<Heavy> heap;
    std::vector<char> is_top(count, 0);
    std::vector<Heavy> subtrees;
    double sum = 0.0;
    const std::size_t bins = nonzeros < worth_groups ? 1 : group_count;
    for (std::size_t f = 0; f < count; ++f) {
        if (parent[f] >= 0) continue;
        heap.emplace(weight[f], static_cast<Index>(f));
        sum += weight[f];
    }
    while (!heap.empty()) {
        const auto [heavy, f] = heap.top();
        heap.pop();
        if (bins == 1 || heavy < 1.2 * sum / static_cast<double>(bins) || children[at(f)].empty()) {
            subtrees.emplace_back(heavy, f);
            continue;
        }
        is_top[at(f)] = 1;
        sum -= heavy;
        for (const Index c : children[at(f)]) {
            heap.emplace(weight[at(c)], c);
            sum += weight[at(c)];
        }
    }
    std::sort(subtrees.begin(), subtrees.end(), [](const Heavy& a, const Heavy& b) {
        return a.first > b.first || (a.first == b.first && a.second < b.second);
    });
    std::vector<double> load(bins, 0.0);
    std::vector<std::vector<Index>> roots(bins);
    for (const auto& [heavy, f] : subtrees) {
        const auto bin = static_cast<std::size_t>(std::min_element(load.begin(), load.end()) - load.begin());
        load[bin] += heavy;
        roots[bin].push_back(f);
    }

    // Descendants first, children beside each other.
    std::vector<Index> sequence;
    sequence.reserve(count);
    std::vector<std::pair<Index, std::size_t>> path;
    for (std::size_t g = 0; g <= bins; ++g) {
        Group group;
        group.begin = sequence.size();
        if (g == bins) {
            for (std::size_t f = 0; f < count; ++f) {
                if (is_top[f] != 0) sequence.push_back(static_cast<Index>(f));
            }
        } else {
            std::sort(roots[g].begin(), roots[g].end());
            for (const Index root : roots[g]) {
                path.emplace_back(root, 0);
                while (!path.empty()) {
                    auto& [f, next] = path.back();
                    if (next < children[at(f)].size()) {
                        const Index child = children[at(f)][next++];
                        path.emplace_back(child, 0);
                    } else {
                        sequence.push_back(f);
                        path.pop_back();
                    }
                }
            }
        }
        group.end = sequence.size();
        groups.push_back(std::move(group));
    }

    std::vector<Index> node_at(count);
    std::vector<Index> new_column(at(n));
    nodes.resize(count);
    rows.resize(count);
    Index columns_done = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t f = at(sequence[i]);
        node_at[f] = static_cast<Index>(i);
        Node& node = nodes[i];
        node.first = columns_done;
        node.columns = supernodes.begin[f + 1] - supernodes.begin[f];
        node.rows = static_cast<Index>(supernodes.rows[f].size());
        for (Index c = supernodes.begin[f]; c < supernodes.begin[f + 1]; ++c) {
            new_column[at(c)] = columns_done++;
            column.push_back(supernodes.order[at(c)]);
        }
    }
    // The rows of a front are columns of its ancestors: their order among each other is as it was.
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t f = at(sequence[i]);
        if (parent[f] >= 0) nodes[i].parent = node_at[at(parent[f])];
        rows[i].reserve(supernodes.rows[f].size());
        for (const Index row : supernodes.rows[f])
            rows[i].push_back(new_column[at(row)]);
    }
    for (std::size_t i = count; i-- > 0;) {
        Node& node = nodes[i];
        if (node.parent < 0) continue;
        Node& above = nodes[at(node.parent)];
        node.depth = above.depth + 1;
        node.sibling = above.child;
        above.child = static_cast<Index>(i);
    }
}

// Pieces and what moves in and out of them: the row of each column in its group's array.
std::vector<Index> Symbolic::set_pieces() {
    std::vector<Index> size(nodes.size());  // columns of a subtree
    for (std::size_t f = 0; f < nodes.size(); ++f) {
        size[f] += nodes[f].columns;
        if (nodes[f].parent >= 0) size[at(nodes[f].parent)] += size[f];
    }
    std::vector<Index> row_of(at(n));
    for (Group& group : groups) {
        group.first_piece = pieces.size();
        const bool is_top = &group == &groups.back();
        const auto whole = [&](std::size_t f) { return !is_top && size[f] <= piece_rows; };
        Index room = 0;
        for (std::size_t f = group.begin; f < group.end;) {
            Piece piece;
            piece.whole = whole(f);
            piece.begin = f;
            Index columns = 0;
            while (f < group.end && whole(f) == piece.whole) {
                std::size_t end = f + 1;
                if (piece.whole) {
                    // Descendants come first: f is a leaf, and its last ancestor that is whole ends the subtree.
                    while (nodes[end - 1].parent >= 0 && at(nodes[end - 1].parent) < group.end &&
                           whole(at(nodes[end - 1].parent)))
                        end = at(nodes[end - 1].parent) + 1;
                    if (columns > 0 && columns + size[end - 1] > piece_rows) break;
                }
                for (; f < end; ++f)
                    columns += nodes[f].columns;
            }
            piece.end = f;
            if (piece.whole) room = std::max(room, columns);
            pieces.push_back(piece);
        }
        group.last_piece = pieces.size();
        group.columns = room;
        for (std::size_t p = group.first_piece; p < group.last_piece; ++p) {
            Piece& piece = pieces[p];
            Index in_room = 0;
            Index& row = piece.whole ? in_room : group.columns;
            piece.first_move = moves.size();
            for (std::size_t f = piece.begin; f < piece.end; ++f) {
                for (Index c = nodes[f].first; c < nodes[f].first + nodes[f].columns; ++c) {
                    row_of[at(c)] = row;
                    moves.push_back({column[at(c)], row++});
                }
            }
            piece.last_move = moves.size();
            std::sort(moves.begin() + static_cast<std::ptrdiff_t>(piece.first_move), moves.end(),
                      [](const Move& a, const Move& b) { return a.unknown < b.unknown; });
        }
    }
    return row_of;
}

// Panels and lists of rows. row_of: of each column in its group's array.
void Symbolic::set_groups(const std::vector<Index>& row_of, const std::vector<std::vector<Index>>& rows) {
    const Group& top = groups.back();
    const Index top_begin = top.begin < nodes.size() ? nodes[top.begin].first : n;
    std::vector<Index> touched_row(at(n - top_begin));
    std::vector<Index> position(at(n));
    for (Group& group : groups) {
        const bool is_top = &group == &groups.back();
        if (!is_top) {
            std::fill(touched_row.begin(), touched_row.end(), -1);
            for (std::size_t f = group.begin; f < group.end; ++f) {
                for (const Index row : rows[f]) {
                    if (row < top_begin || touched_row[at(row - top_begin)] >= 0) continue;
                    touched_row[at(row - top_begin)] = 0;
                    group.touched.push_back(row - top_begin);
                }
            }
            std::sort(group.touched.begin(), group.touched.end());
            for (std::size_t t = 0; t < group.touched.size(); ++t)
                touched_row[at(group.touched[t])] = group.columns + static_cast<Index>(t);
        }
        const Index zeros = group.columns + static_cast<Index>(group.touched.size());
        group.base = array_rows;
        array_rows += at(zeros) + 1;

        std::array<std::size_t, 2> used{};
        for (std::size_t f = group.begin; f < group.end; ++f) {
            Node& node = nodes[f];
            node.list = lists.size();
            node.place = places.size();
            node.panels = panels.size();
            for (const Index row : rows[f])
                lists.push_back(row < top_begin || is_top ? row_of[at(row)]
                                                          : touched_row[at(row - top_begin)]);
            for (int fill = 0; fill < 3; ++fill)
                lists.push_back(zeros);
            for (Index from = 0; from < node.columns; from += panel_columns) {
                Panel panel{};
                panel.columns = std::min<Index>(panel_columns, node.columns - from);
                panel.first = row_of[at(node.first + from)];
                panel.below = node.rows - from - panel.columns;
                panel.values = values_size;
                panel.rows = node.list + at(from + panel.columns);
                values_size += static_cast<std::size_t>(panel_size(panel.columns, panel.below));
                panels.push_back(panel);
            }
            if (node.parent >= 0) {
                const std::vector<Index>& above = rows[at(node.parent)];
                for (std::size_t i = 0; i < above.size(); ++i)
                    position[at(above[i])] = static_cast<Index>(i);
                for (std::size_t i = at(node.columns); i < rows[f].size(); ++i)
                    places.push_back(position[at(rows[f][i])]);
            }
            group.panel = std::max(group.panel,
                                   at(node.columns) * static_cast<std::size_t>(Front::stride_of(node.rows)));
            node.stacked = !is_top && node.parent >= 0 && at(node.parent) < group.end;
            if (node.stacked) {
                const auto parity = static_cast<std::size_t>(node.depth & 1);
                used[parity] += node.update_size();
                group.stack[parity] = std::max(group.stack[parity], used[parity]);
            }
            for (Index c = node.child; c >= 0; c = nodes[at(c)].sibling) {
                if (nodes[at(c)].stacked)
                    used[static_cast<std::size_t>(nodes[at(c)].depth & 1)] -= nodes[at(c)].update_size();
            }
        }
        working += (group.stack[0] + group.stack[1] + group.panel) * sizeof(double);
    }
    for (Piece& piece : pieces) {
        piece.first_panel = nodes[piece.begin].panels;
        piece.last_panel = piece.end < nodes.size() ? nodes[piece.end].panels : panels.size();
    }
}

void Symbolic::set_entries(const UpperPattern& pattern, const std::vector<std::vector<Index>>& rows) {
    column_of.resize(at(n));
    for (Index j = 0; j < n; ++j)
        column_of[at(column[at(j)])] = j;
    // An entry belongs to the column that is eliminated first.
    starts.assign(at(n) + 1, 0);
    const auto for_each = [&](const auto& visit) {
        for (Index c = 0; c < n; ++c) {
            for (std::size_t e = pattern.starts[at(c)]; e < pattern.starts[at(c) + 1]; ++e) {
                const Index r = pattern.rows[e];
                const bool c_first = column_of[at(c)] < column_of[at(r)];
                visit(column_of[at(c_first ? c : r)], c_first ? r : c);
            }
        }
    };
    for_each([&](Index j, Index) { ++starts[at(j) + 1]; });
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    unknowns.resize(pattern.rows.size());
    std::vector<std::size_t> next(starts.begin(), starts.end() - 1);
    for_each([&](Index j, Index unknown) { unknowns[next[at(j)]++] = unknown; });
    positions.resize(unknowns.size());
    std::vector<Index> position(at(n));
    for (std::size_t f = 0; f < nodes.size(); ++f) {
        for (std::size_t i = 0; i < rows[f].size(); ++i)
            position[at(rows[f][i])] = static_cast<Index>(i);
        for (Index j = nodes[f].first; j < nodes[f].first + nodes[f].columns; ++j) {
            std::sort(unknowns.begin() + static_cast<std::ptrdiff_t>(starts[at(j)]),
                      unknowns.begin() + static_cast<std::ptrdiff_t>(starts[at(j) + 1]));
            for (std::size_t e = starts[at(j)]; e < starts[at(j) + 1]; ++e)
                positions[e] = position[at(column_of[at(unknowns[e])])];
        }
    }
}

Symbolic::Symbolic(const UpperPattern& pattern, bool quick) : n(pattern.size()) {
    std::vector<std::vector<Index>> rows;
    set_order(analyse(pattern, quick), rows);
    set_groups(set_pieces(), rows);
    set_entries(pattern, rows);
}

std::size_t Symbolic::entry(Index row, Index col) const {
    const bool col_first = column_of[at(col)] < column_of[at(row)];
    const std::size_t j = at(column_of[at(col_first ? col : row)]);
    const Index unknown = col_first ? row : col;
    const Index* begin = unknowns.data() + starts[j];
    const Index* end = unknowns.data() + starts[j + 1];
    const Index* found = std::lower_bound(begin, end, unknown);
    return found == end || *found != unknown ? none : static_cast<std::size_t>(found - unknowns.data());
}

std::size_t Symbolic::memory_bytes() const {
    std::size_t touched = 0;
    for (const Group& group : groups)
        touched += bytes_of(group.touched);
    return touched + bytes_of(nodes) + bytes_of(panels) + bytes_of(lists) + bytes_of(places) +
           bytes_of(pieces) + bytes_of(moves) + bytes_of(starts) + bytes_of(positions) + bytes_of(unknowns) +
           bytes_of(column) + bytes_of(column_of);
}

}  // namespace beltrami::supernodal
