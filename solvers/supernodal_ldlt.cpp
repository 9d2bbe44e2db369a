#include "beltrami/solvers/supernodal_ldlt.hpp"

#include <cholmod.h>
#include <fmt/format.h>
#include <omp.h>
#ifdef __linux__
#endif

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <new>
#include <numeric>
#include <queue>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "beltrami/solvers/large_array.hpp"
#include "beltrami/solvers/supernodal_kernels.hpp"

namespace beltrami {

namespace {

using supernodal::Front;
using supernodal::Panel;

// Sets of subtrees that threads share. Not their number, on which results would depend then.
constexpr std::size_t group_count = 8;
// Entries of a factor from which threads gain.
constexpr double worth_groups = 2e5;
// Operations of a panel's update from which threads gain.
constexpr double worth_sharing = 1e6;
// Columns of a sweep.
constexpr Index most_columns = 32;
// Unknowns whose values fit in a core's cache while a sweep passes through them.
constexpr Index piece_rows = 2048;

template <class T>
std::size_t bytes_of(const std::vector<T>& v) {
    return v.size() * sizeof(T);
}

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

[[noreturn]] void no_room(Index n) {
    throw SolveError(fmt::format("the factor L D L^T of {} unknowns does not fit in memory", n),
                     "keep the factor on disk with --memory LIMIT");
}

// CHOLMOD's ordering and supernodes.
struct Supernodes {
    std::vector<Index> order;              // row of K by column of L
    std::vector<Index> begin;              // first column of each supernode, and n
    std::vector<std::vector<Index>> rows;  // of each, its columns first
};

Supernodes analyse(const Eigen::SparseMatrix<double, Eigen::RowMajor>& K, bool few_solves) {
    CholmodCommon start;
    cholmod_common& common = start.common;
    const auto n = static_cast<Index>(K.rows());
    std::vector<SuiteSparse_long> starts{0};
    std::vector<SuiteSparse_long> indices;
    starts.reserve(at(n) + 1);
    indices.reserve(static_cast<std::size_t>(K.nonZeros()) / 2 + at(n));
    // Rows are columns, as K is symmetric: up to the diagonal, the upper triangle.
    for (Eigen::Index row = 0; row < n; ++row) {
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(K, row); entry; ++entry) {
            if (entry.col() <= row) indices.push_back(entry.col());
        }
        starts.push_back(static_cast<SuiteSparse_long>(indices.size()));
    }
    cholmod_sparse pattern{};
    pattern.nrow = pattern.ncol = at(n);
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
    common.method[0].ordering = few_solves ? CHOLMOD_AMD : CHOLMOD_METIS;
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
    if (L == nullptr) no_room(n);
    Supernodes nodes;
    const auto* order = static_cast<const SuiteSparse_long*>(L->Perm);
    const auto* super = static_cast<const SuiteSparse_long*>(L->super);
    const auto* list = static_cast<const SuiteSparse_long*>(L->pi);
    const auto* rows = static_cast<const SuiteSparse_long*>(L->s);
    nodes.order.assign(order, order + n);
    nodes.begin.assign(super, super + L->nsuper + 1);
    nodes.rows.resize(L->nsuper);
    for (std::size_t f = 0; f < L->nsuper; ++f)
        nodes.rows[f].assign(rows + list[f], rows + list[f + 1]);
    cholmod_l_free_factor(&L, &common);
    return nodes;
}

}  // namespace

// Fronts are in the order of elimination: group by group, whole subtrees, and last the top, which joins them. Each group
// sweeps in an array of rows of its own: room for one piece, which is a few small subtrees; the columns of the group
// that are in no piece; those of the top that it touches; a row of zeros, which fills up blocks. The values of a piece
// come from the caller's columns when its turn comes and go back there, so that they stay in a core's cache meanwhile.
struct SupernodalLdlt::Factor {
    struct Node {
        Index first = 0;  // column
        Index columns = 0;
        Index rows = 0;
        Index parent = -1;
        Index child = -1;        // the first
        Index sibling = -1;      // the next
        std::size_t place = 0;   // of its rows below, in `places`
        std::size_t list = 0;    // of all its rows, in `lists`
        std::size_t panels = 0;  // the first
        bool stacked = false;    // its update lies on a stack
        Index depth = 0;
        [[nodiscard]] Index below() const { return rows - columns; }
        [[nodiscard]] std::size_t update_size() const {
            return static_cast<std::size_t>(Front::update_size(columns, rows));
        }
    };
    // Successive nodes of a group and the unknowns that are their columns. A whole one is made of subtrees.
    struct Piece {
        std::size_t begin = 0;  // of the nodes
        std::size_t end = 0;
        std::size_t first_panel = 0;
        std::size_t last_panel = 0;
        std::size_t first_move = 0;
        std::size_t last_move = 0;
        bool whole = false;
    };
    struct Move {
        Index unknown;
        Index row;  // in the group's array
    };
    struct Group {
        std::size_t begin = 0;  // of the nodes
        std::size_t end = 0;
        std::size_t first_piece = 0;
        std::size_t last_piece = 0;
        std::size_t base = 0;                // of its array in that of all groups
        Index columns = 0;                   // rows of its array before those of the top
        std::vector<Index> touched;          // columns of the top, counted from there
        std::array<std::size_t, 2> stack{};  // numbers of updates at once, by parity of the depth
        std::size_t panel = 0;               // numbers of the largest front's own rows
    };

    Index n = 0;
    std::vector<Node> nodes;
    std::vector<Group> groups;  // the last is the top
    std::vector<Panel> panels;
    std::vector<Index> lists;   // rows in the group's array
    std::vector<Index> places;  // of a row below in the parent's front
    std::vector<Piece> pieces;
    std::vector<Move> moves;  // by unknown in each piece
    std::size_t array_rows = 0;

    // Entries at and below the diagonal by column of L.
    std::vector<std::size_t> starts;
    std::vector<Index> positions;  // in the front
    std::vector<Index> unknowns;   // row of K
    std::vector<Index> column;     // row of K that is the column
    std::vector<double> stiffness;
    std::vector<double> mass;

    const supernodal::Kernels* kernels = nullptr;
    LargeArray values;
    double nonzeros = 0.0;
    double flops = 0.0;
    std::size_t working = 0;

    bool factored = false;
    double shift = 0.0;
    Index negative = 0;
    double backward_error = 0.0;
    int factorizations = 0;
    mutable long solved = 0;
    mutable LargeArray work;

    struct Room {
        LargeArray panel;
        std::array<LargeArray, 2> stacks;
        std::array<std::size_t, 2> used{};
    };

    void build(const Eigenproblem& problem, bool few_solves);
    void set_order(const Supernodes& supernodes, std::vector<Index>& new_of_old,
                   std::vector<std::vector<Index>>& rows);
    void set_groups(const std::vector<Index>& row_of, const std::vector<std::vector<Index>>& rows);
    std::vector<Index> set_pieces(const std::vector<Index>& order);
    void set_entries(const Eigenproblem& problem, const std::vector<Index>& order,
                     const std::vector<std::vector<Index>>& rows);
    [[nodiscard]] Front front_of(const Node& node, double* panel, double* update) const;
    int eliminate(const Node& node, const Front& front, bool share);
    int process(std::size_t f, Room& room, std::vector<double*>& updates, std::vector<LargeArray>& kept,
                bool share);
    void factor(double new_shift);
    void measure();
    // Entry (i, c) lies at data[i row_stride + c column_stride].
    struct RightHandSides {
        double* data;
        std::ptrdiff_t row_stride;
        std::ptrdiff_t column_stride;
        Index count;
    };
    void sweep(const RightHandSides& b) const;
    void solve(const RightHandSides& b, Eigen::Index size) const;
};

void SupernodalLdlt::Factor::set_order(const Supernodes& supernodes, std::vector<Index>& order,
                                       std::vector<std::vector<Index>>& rows) {
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
    order.clear();
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
            order.push_back(supernodes.order[at(c)]);
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
std::vector<Index> SupernodalLdlt::Factor::set_pieces(const std::vector<Index>& order) {
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
                    moves.push_back({order[at(c)], row++});
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
void SupernodalLdlt::Factor::set_groups(const std::vector<Index>& row_of,
                                        const std::vector<std::vector<Index>>& rows) {
    const Group& top = groups.back();
    const Index top_begin = top.begin < nodes.size() ? nodes[top.begin].first : n;
    std::size_t values_size = 0;
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
            for (Index from = 0; from < node.columns; from += supernodal::panel_columns) {
                Panel panel{};
                panel.columns = std::min<Index>(supernodal::panel_columns, node.columns - from);
                panel.first = row_of[at(node.first + from)];
                panel.below = node.rows - from - panel.columns;
                panel.values = values_size;
                panel.rows = node.list + at(from + panel.columns);
                values_size += static_cast<std::size_t>(supernodal::panel_size(panel.columns, panel.below));
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
    values = LargeArray(values_size);
}

void SupernodalLdlt::Factor::set_entries(const Eigenproblem& problem, const std::vector<Index>& order,
                                         const std::vector<std::vector<Index>>& rows) {
    column = order;
    std::vector<Index> new_of(at(n));
    for (Index j = 0; j < n; ++j)
        new_of[at(order[at(j)])] = j;

    const auto& K = problem.stiffness();
    const Eigen::SparseMatrix<double, Eigen::RowMajor> M = problem.mass_matrix();
    using Entry = Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator;
    starts.assign(at(n) + 1, 0);
    std::vector<Index> position(at(n));
    for (std::size_t f = 0; f < nodes.size(); ++f) {
        for (std::size_t i = 0; i < rows[f].size(); ++i)
            position[at(rows[f][i])] = static_cast<Index>(i);
        for (Index c = 0; c < nodes[f].columns; ++c) {
            const Index j = nodes[f].first + c;
            const Index row = order[at(j)];
            Entry of_mass(M, row);
            for (Entry entry(K, row); entry; ++entry) {
                // M's pattern lies in K's.
                while (of_mass && of_mass.col() < entry.col())
                    ++of_mass;
                const auto other = static_cast<Index>(entry.col());
                if (new_of[at(other)] < j) continue;
                positions.push_back(position[at(new_of[at(other)])]);
                unknowns.push_back(other);
                stiffness.push_back(entry.value());
                mass.push_back(of_mass && of_mass.col() == entry.col() ? of_mass.value() : 0.0);
            }
            starts[at(j) + 1] = positions.size();
        }
    }
}

void SupernodalLdlt::Factor::build(const Eigenproblem& problem, bool few_solves) {
    n = problem.rows();
    std::vector<Index> order;
    std::vector<std::vector<Index>> rows;
    set_order(analyse(problem.stiffness(), few_solves), order, rows);
    set_groups(set_pieces(order), rows);
    set_entries(problem, order, rows);
}

Front SupernodalLdlt::Factor::front_of(const Node& node, double* panel, double* update) const {
    return {panel, update, Front::stride_of(node.rows), node.columns, node.rows};
}

// All panels of a front whose own rows are assembled. The number of negative pivots, or -1.
int SupernodalLdlt::Factor::eliminate(const Node& node, const Front& front, bool share) {
    int negative_here = 0;
    const int padded = supernodal::round_up(front.rows, 8);
    // Rows of the update that share a block of four with own rows are not fresh.
    if (front.columns > supernodal::panel_columns && front.rows > front.columns) {
        for (int i = front.columns; i < std::min(supernodal::round_up(front.columns, 4), front.rows); ++i)
            std::fill(front.at(i, i), front.at(i, i) + (padded - i), 0.0);
    }
    for (int first = 0; first < front.columns; first += supernodal::panel_columns) {
        const Panel& panel =
            panels[node.panels + static_cast<std::size_t>(first / supernodal::panel_columns)];
        double* L = values.data() + panel.values;
        const int columns = panel.columns;
        const int pivots = kernels->eliminate(front, first, columns, L);
        if (pivots < 0) return -1;
        negative_here += pivots;
        if (panel.below == 0) continue;
        const int solve_from = first + supernodal::round_up(columns, 8);
        const int update_from = (first + columns) / 8 * 8;
        const int blocks = (panel.below + 3) / 4;
        const bool fresh = first == 0;
        const double work = static_cast<double>(columns) * panel.below * panel.below;
        if (!share || work < worth_sharing) {
            kernels->solve(front, first, columns, L, solve_from, padded);
            kernels->fill(front, first, columns, L, 0, blocks);
            kernels->update(front, first, columns, L, update_from, padded, fresh);
            continue;
        }
        constexpr int chunk = supernodal::chunk_columns;
        share_out((padded - solve_from + chunk - 1) / chunk, [&](int i) {
            const int j = solve_from + i * chunk;
            kernels->solve(front, first, columns, L, j, std::min(j + chunk, padded));
        });
        constexpr int some = 8;
        share_out((blocks + some - 1) / some, [&](int i) {
            kernels->fill(front, first, columns, L, i * some, std::min((i + 1) * some, blocks));
        });
        // Chunks further back have more rows: from both ends by turns, so that tasks are alike.
        const int chunks = (padded - update_from + chunk - 1) / chunk;
        share_out(chunks, [&](int i) {
            const int j = update_from + (i % 2 == 0 ? i / 2 : chunks - 1 - i / 2) * chunk;
            kernels->update(front, first, columns, L, j, std::min(j + chunk, padded), fresh);
        });
    }
    return negative_here;
}

int SupernodalLdlt::Factor::process(std::size_t f, Room& room, std::vector<double*>& updates,
                                    std::vector<LargeArray>& kept, bool share) {
    const Node& node = nodes[f];
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
        const std::size_t end = starts[at(node.first + c) + 1];
        for (std::size_t e = starts[at(node.first + c)]; e < end; ++e)
            row[positions[e]] = stiffness[e] - shift * mass[e];
    }
    const auto add_children = [&](bool own) {
        for (Index c = node.child; c >= 0; c = nodes[at(c)].sibling) {
            const Node& child = nodes[at(c)];
            const Index* place = places.data() + child.place;
            const auto split =
                static_cast<int>(std::lower_bound(place, place + child.below(), node.columns) - place);
            const int begin = own ? 0 : split;
            const int end = own ? split : child.below();
            const Front from = front_of(child, nullptr, updates[at(c)]);
            if (share && static_cast<double>(end - begin) * child.below() > worth_sharing / 16) {
                constexpr int some = 8;
                share_out((end - begin + some - 1) / some, [&](int i) {
                    kernels->add(from, place, front, begin + i * some, std::min(begin + (i + 1) * some, end));
                });
            } else {
                kernels->add(from, place, front, begin, end);
            }
        }
    };
    add_children(true);
    const int pivots = eliminate(node, front, share);
    add_children(false);
    for (Index c = node.child; c >= 0; c = nodes[at(c)].sibling) {
        const Node& child = nodes[at(c)];
        if (child.stacked) {
            room.used[static_cast<std::size_t>(child.depth & 1)] -= child.update_size();
        } else {
            kept[at(c)] = LargeArray();
        }
    }
    return pivots;
}

void SupernodalLdlt::Factor::factor(double new_shift) {
    factored = false;
    shift = new_shift;
    negative = 0;
    std::vector<double*> updates(nodes.size(), nullptr);
    std::vector<LargeArray> kept(nodes.size());
    std::vector<int> pivots(groups.size(), 0);
    std::atomic<bool> no_memory = false;
    const auto run = [&](std::size_t g) {
        const bool is_top = g + 1 == groups.size();
        const Group& group = groups[g];
        Room room;
        room.panel = LargeArray(group.panel);
        for (std::size_t parity = 0; parity < 2; ++parity)
            room.stacks[parity] = LargeArray(group.stack[parity]);
        for (std::size_t f = group.begin; f < group.end && pivots[g] >= 0; ++f) {
            const int more = process(f, room, updates, kept, is_top);
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
    const std::size_t subtrees = groups.size() - 1;
    bool sound = true;
#pragma omp parallel if (subtrees > 1)
#pragma omp single
    {
        share_out(static_cast<int>(subtrees), [&](int g) { run_if_room(static_cast<std::size_t>(g)); });
        sound = !no_memory && *std::min_element(pivots.begin(), pivots.end()) >= 0;
        if (sound) run_if_room(subtrees);
        sound = sound && pivots.back() >= 0;
    }
    if (no_memory) no_room(n);
    if (sound) {
        negative = std::accumulate(pivots.begin(), pivots.end(), Index{0});
        factored = true;
        ++factorizations;
        measure();
        sound = backward_error <= 1e-8;
    }
    if (!sound) {
        const bool unstable = factored;
        factored = false;
        throw SolveError(
            unstable
                ? fmt::format("pivots of K - {:.17g} M are too small: solves have the backward error {:.1e}",
                              shift, backward_error)
                : fmt::format(
                      "K - {:.17g} M has a pivot that is zero or not finite: the shift is an eigenvalue of "
                      "it or of a part of it",
                      shift),
            "take another shift");
    }
}

void SupernodalLdlt::Factor::measure() {
    // The same numbers in [-1, 1] on every machine (Knuth's multiplicative hash).
    Columns b(n, 1);
    for (Index i = 0; i < n; ++i)
        b(i, 0) = static_cast<double>(static_cast<std::uint32_t>(i + 1) * 2654435761U) / 2147483648.0 - 1.0;
    Columns x = b;
    sweep({x.data(), 1, n, 1});
    Vector product = Vector::Zero(n);
    Vector sums = Vector::Zero(n);
    for (Index j = 0; j < n; ++j) {
        const Index c = column[at(j)];
        for (std::size_t e = starts[at(j)]; e < starts[at(j) + 1]; ++e) {
            const Index r = unknowns[e];
            const double a = stiffness[e] - shift * mass[e];
            product[r] += a * x(c, 0);
            sums[r] += std::abs(a);
            if (r == c) continue;
            product[c] += a * x(r, 0);
            sums[c] += std::abs(a);
        }
    }
    const double residual = (product - b.col(0)).cwiseAbs().maxCoeff();
    const double scale = sums.maxCoeff() * x.cwiseAbs().maxCoeff() + b.cwiseAbs().maxCoeff();
    // Not finite where x is not: maxCoeff may pass over what is not a number.
    backward_error = x.allFinite() && product.allFinite() ? residual / scale : INFINITY;
}

// At most most_columns.
void SupernodalLdlt::Factor::sweep(const RightHandSides& b) const {
    const Index count = b.count;
    const int width = count <= 4 ? 4 : supernodal::round_up(count, 8);
    const auto needed = array_rows * static_cast<std::size_t>(width);
    if (work.size() < needed) {
        work = LargeArray();
        work = LargeArray(needed);
    }
    double* x = work.data();
    const auto array = [&](const Group& group) { return x + group.base * static_cast<std::size_t>(width); };
    const auto subtrees = static_cast<int>(groups.size()) - 1;
    const Group& top = groups.back();
    const bool by_rows = b.column_stride == 1;
    const auto row_of = [&](std::size_t m) { return b.data + moves[m].unknown * b.row_stride; };
    // Rows or columns lie far apart: their lines are fetched some rows ahead, once each.
    const auto fetch = [&](std::size_t m, const Piece& piece, int begin, int end) {
        constexpr std::size_t ahead = 16;
        if (m + ahead >= piece.last_move) return;
        if (by_rows) {
            for (int c = begin; c < end; c += 8)
                __builtin_prefetch(row_of(m + ahead) + c);
            return;
        }
        if (moves[m + ahead].unknown / 8 == moves[m + ahead - 1].unknown / 8) return;
        for (int c = begin; c < end; ++c)
            __builtin_prefetch(row_of(m + ahead) + c * b.column_stride);
    };
    const auto move_in = [&](double* rows, const Piece& piece, int begin, int end) {
        const int filled = std::min(end, count);
        for (std::size_t m = piece.first_move; m < piece.last_move; ++m) {
            fetch(m, piece, begin, filled);
            const double* from = row_of(m);
            double* to = rows + static_cast<std::ptrdiff_t>(moves[m].row) * width;
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
            fetch(m, piece, begin, end);
            double* to = row_of(m);
            const double* from = rows + static_cast<std::ptrdiff_t>(moves[m].row) * width;
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
        kernels->forward(panels.data() + piece.first_panel, piece.last_panel - piece.first_panel,
                         values.data(), lists.data(), rows + begin, width, end - begin);
    };
    const auto backward = [&](double* rows, const Piece& piece, int begin, int end) {
        kernels->backward(panels.data() + piece.first_panel, piece.last_panel - piece.first_panel,
                          values.data(), lists.data(), rows + begin, width, end - begin);
    };

#pragma omp parallel if (subtrees > 1)
#pragma omp single
    {
        share_out(subtrees, [&](int g) {
            const Group& group = groups[static_cast<std::size_t>(g)];
            double* rows = array(group);
            double* above = rows + static_cast<std::ptrdiff_t>(group.columns) * width;
            std::fill(above, above + (group.touched.size() + 1) * static_cast<std::size_t>(width), 0.0);
            // What is in no piece gets updates before its turn comes.
            for (std::size_t p = group.first_piece; p < group.last_piece; ++p) {
                if (!pieces[p].whole) move_in(rows, pieces[p], 0, width);
            }
            for (std::size_t p = group.first_piece; p < group.last_piece; ++p) {
                if (pieces[p].whole) move_in(rows, pieces[p], 0, width);
                forward(rows, pieces[p], 0, width);
                if (pieces[p].whole) move_out(rows, pieces[p], 0, width);
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
                move_in(rows, pieces[p], begin, end);
            for (int g = 0; g < subtrees; ++g) {
                const Group& group = groups[static_cast<std::size_t>(g)];
                const double* from = array(group) + static_cast<std::ptrdiff_t>(group.columns) * width;
                for (const Index t : group.touched) {
                    double* to = rows + static_cast<std::ptrdiff_t>(t) * width;
                    for (int c = begin; c < end; ++c)
                        to[c] += from[c];
                    from += width;
                }
            }
            for (std::size_t p = top.first_piece; p < top.last_piece; ++p)
                forward(rows, pieces[p], begin, end);
            for (std::size_t p = top.last_piece; p-- > top.first_piece;) {
                backward(rows, pieces[p], begin, end);
                move_out(rows, pieces[p], begin, end);
            }
        });
        share_out(subtrees, [&](int g) {
            const Group& group = groups[static_cast<std::size_t>(g)];
            double* rows = array(group);
            double* above = rows + static_cast<std::ptrdiff_t>(group.columns) * width;
            for (const Index t : group.touched) {
                const double* from = array(top) + static_cast<std::ptrdiff_t>(t) * width;
                above = std::copy(from, from + width, above);
            }
            for (std::size_t p = group.last_piece; p-- > group.first_piece;) {
                if (pieces[p].whole) move_in(rows, pieces[p], 0, width);
                backward(rows, pieces[p], 0, width);
                move_out(rows, pieces[p], 0, width);
            }
        });
    }
}

void SupernodalLdlt::Factor::solve(const RightHandSides& b, Eigen::Index size) const {
    if (!factored || size != n) {
        throw InputError(
            fmt::format("a factor of {} rows got a right-hand side of {} rows", factored ? n : 0, size),
            "factor first, and give one row an unknown");
    }
    // Parts of the same width, but for the last.
    for (Index first = 0; first < b.count; first += most_columns) {
        sweep({b.data + first * b.column_stride, b.row_stride, b.column_stride,
               std::min(most_columns, b.count - first)});
    }
    solved += b.count;
}

SupernodalLdlt::SupernodalLdlt(const Eigenproblem& problem, const SupernodalLdltOptions& options)
    : factor_(std::make_unique<Factor>()) {
    for (const supernodal::Kernels* kernels : supernodal::available_kernels()) {
        if (factor_->kernels == nullptr &&
            (options.instructions.empty() || options.instructions == kernels->name)) {
            factor_->kernels = kernels;
        }
    }
    if (factor_->kernels == nullptr) {
        throw InputError(fmt::format("this machine has no instructions \"{}\"", options.instructions),
                         "use avx512, avx2 or any, or leave it empty");
    }
    try {
        factor_->build(problem, options.few_solves);
    } catch (const std::bad_alloc&) {
        no_room(problem.rows());
    }
}
SupernodalLdlt::SupernodalLdlt(SupernodalLdlt&&) noexcept = default;
SupernodalLdlt& SupernodalLdlt::operator=(SupernodalLdlt&&) noexcept = default;
SupernodalLdlt::~SupernodalLdlt() = default;

void SupernodalLdlt::factor(double shift) {
    factor_->factor(shift);
}
Index SupernodalLdlt::rows() const {
    return factor_->n;
}
double SupernodalLdlt::shift() const {
    return factor_->shift;
}
Index SupernodalLdlt::negative_pivots() const {
    return factor_->negative;
}
double SupernodalLdlt::backward_error() const {
    return factor_->backward_error;
}
void SupernodalLdlt::solve(Columns& columns) const {
    factor_->solve({columns.data(), 1, columns.rows(), static_cast<Index>(columns.cols())}, columns.rows());
}
void SupernodalLdlt::solve(Eigen::Ref<Block> block) const {
    factor_->solve({block.data(), block.outerStride(), 1, static_cast<Index>(block.cols())}, block.rows());
}
double SupernodalLdlt::nonzeros() const {
    return factor_->nonzeros;
}
double SupernodalLdlt::flops() const {
    return factor_->flops;
}
std::size_t SupernodalLdlt::memory_bytes() const {
    const Factor& f = *factor_;
    std::size_t touched = 0;
    for (const Factor::Group& group : f.groups)
        touched += bytes_of(group.touched);
    return f.values.bytes() + f.work.bytes() + touched + bytes_of(f.nodes) + bytes_of(f.panels) +
           bytes_of(f.lists) + bytes_of(f.places) + bytes_of(f.pieces) + bytes_of(f.moves) +
           bytes_of(f.starts) + bytes_of(f.positions) + bytes_of(f.unknowns) + bytes_of(f.column) +
           bytes_of(f.stiffness) + bytes_of(f.mass);
}
std::size_t SupernodalLdlt::working_bytes() const {
    return factor_->working;
}
int SupernodalLdlt::factorizations() const {
    return factor_->factorizations;
}
std::string SupernodalLdlt::instructions() const {
    return factor_->kernels->name;
}
long SupernodalLdlt::solved_columns() const {
    return factor_->solved;
}

}  // namespace beltrami
