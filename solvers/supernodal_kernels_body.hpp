// Included once for each instruction set by supernodal_kernels.cpp, which defines
//     BELTRAMI_KERNELS            a namespace
//     BELTRAMI_KERNELS_NAME       what to call it
//     BELTRAMI_KERNELS_TARGET     an attribute, on every function here: vectors are lowered before functions are inlined
//     BELTRAMI_KERNELS_LANES      numbers of a register
//     BELTRAMI_KERNELS_NARROW_LANES  the same or less, a divisor of four
//     BELTRAMI_KERNELS_REGISTERS  of a row of a tile, so that four rows, a row of factors and a number fit

namespace beltrami::supernodal {
namespace BELTRAMI_KERNELS {

struct Wide {
    typedef double Lane __attribute__((vector_size(BELTRAMI_KERNELS_LANES * sizeof(double)),
                                       aligned(sizeof(double)), may_alias));
    static constexpr int lanes = BELTRAMI_KERNELS_LANES;
};
struct Narrow {
    typedef double Lane __attribute__((vector_size(BELTRAMI_KERNELS_NARROW_LANES * sizeof(double)),
                                       aligned(sizeof(double)), may_alias));
    static constexpr int lanes = BELTRAMI_KERNELS_NARROW_LANES;
};
// Numbers of the factor that are fetched ahead: most panels are too short for what a processor does by itself.
static constexpr int ahead = 1024;
static constexpr int most = BELTRAMI_KERNELS_REGISTERS;

// c_r -= or, where fresh, = - sum over k of L(r, k) b_k for four rows; L is [k][row].
enum class Tile { fresh, update, sweep };
template <class T, int registers, Tile kind>
BELTRAMI_KERNELS_TARGET static inline void tile(const double* L, int depth, const double* b,
                                                std::ptrdiff_t stride, double* const* c) {
    using Lane = typename T::Lane;
    Lane sum[4][registers];
    for (int r = 0; r < 4; ++r) {
        for (int v = 0; v < registers; ++v)
            sum[r][v] = kind == Tile::fresh ? Lane{} : *reinterpret_cast<const Lane*>(c[r] + v * T::lanes);
    }
    for (int k = 0; k < depth; ++k, L += 4, b += stride) {
        if (kind == Tile::sweep) __builtin_prefetch(L + ahead);
        Lane row[registers];
        for (int v = 0; v < registers; ++v)
            row[v] = *reinterpret_cast<const Lane*>(b + v * T::lanes);
        for (int r = 0; r < 4; ++r) {
            for (int v = 0; v < registers; ++v)
                sum[r][v] -= L[r] * row[v];
        }
    }
    for (int r = 0; r < 4; ++r) {
        for (int v = 0; v < registers; ++v)
            *reinterpret_cast<Lane*>(c[r] + v * T::lanes) = sum[r][v];
    }
}

// Rows `depth` ... `depth` + count of x <- L^-1 x, given the rows before them. L: a block of the triangle.
template <class T, int registers, int count>
BELTRAMI_KERNELS_TARGET static inline void triangle(const double* L, int depth, double* x,
                                                    std::ptrdiff_t stride) {
    using Lane = typename T::Lane;
    Lane sum[count][registers];
    double* own = x + depth * stride;
    for (int r = 0; r < count; ++r) {
        for (int v = 0; v < registers; ++v)
            sum[r][v] = *reinterpret_cast<const Lane*>(own + r * stride + v * T::lanes);
    }
    const double* b = x;
    for (int k = 0; k < depth; ++k, L += 4, b += stride) {
        Lane row[registers];
        for (int v = 0; v < registers; ++v)
            row[v] = *reinterpret_cast<const Lane*>(b + v * T::lanes);
        for (int r = 0; r < count; ++r) {
            for (int v = 0; v < registers; ++v)
                sum[r][v] -= L[r] * row[v];
        }
    }
    for (int k = 0; k + 1 < count; ++k) {
        for (int r = k + 1; r < count; ++r) {
            for (int v = 0; v < registers; ++v)
                sum[r][v] -= L[4 * k + r] * sum[k][v];
        }
    }
    for (int r = 0; r < count; ++r) {
        for (int v = 0; v < registers; ++v)
            *reinterpret_cast<Lane*>(own + r * stride + v * T::lanes) = sum[r][v];
    }
}

template <class T, int registers>
BELTRAMI_KERNELS_TARGET static inline void triangle_of(int count, const double* L, int depth, double* x,
                                                       std::ptrdiff_t stride) {
    switch (count) {
        case 1:
            return triangle<T, registers, 1>(L, depth, x, stride);
        case 2:
            return triangle<T, registers, 2>(L, depth, x, stride);
        case 3:
            return triangle<T, registers, 3>(L, depth, x, stride);
        default:
            return triangle<T, registers, 4>(L, depth, x, stride);
    }
}

template <class T, int registers>
BELTRAMI_KERNELS_TARGET static inline void forward_panel(const Panel& panel, const double* L,
                                                         const Index* rows, double* x,
                                                         std::ptrdiff_t stride) {
    double* own = x + panel.first * stride;
    for (int at = 0; at < panel.columns; at += 4) {
        triangle_of<T, registers>(panel.columns - at, L, at, own, stride);
        L += 4 * at + 16;
    }
    for (int at = 0; at < panel.below; at += 4) {
        double* const c[4] = {x + rows[at] * stride, x + rows[at + 1] * stride, x + rows[at + 2] * stride,
                              x + rows[at + 3] * stride};
        tile<T, registers, Tile::sweep>(L, panel.columns, own, stride, static_cast<double* const*>(c));
        L += 4 * static_cast<std::ptrdiff_t>(panel.columns);
    }
}

// Columns at ... at + count of a panel, at a multiple of four, less what blocks of four rows below begin ... end have of
// them; `scale`: first times D^-1; `finish`: then less the columns behind, which are done, and each other.
// Everything goes backwards through memory, as sweeps do from panel to panel.
template <class T, int registers, int count>
BELTRAMI_KERNELS_TARGET static inline void backward_columns(const Panel& panel, const double* L,
                                                            const Index* rows, double* x,
                                                            std::ptrdiff_t stride, int at, int begin, int end,
                                                            bool scale, bool finish) {
    using Lane = typename T::Lane;
    double* own = x + panel.first * stride;
    // Of column r with row s of the block of rows that begins at row `behind`.
    const auto entry = [=](int behind, int r, int s)
                           BELTRAMI_KERNELS_TARGET { return L[triangle_size(behind) + 4 * (at + r) + s]; };
    Lane sum[count][registers];
    for (int r = 0; r < count; ++r) {
        const double factor = scale ? entry(at + r / 4 * 4, r, r % 4) : 1.0;
        for (int v = 0; v < registers; ++v)
            sum[r][v] = factor * *reinterpret_cast<const Lane*>(own + (at + r) * stride + v * T::lanes);
    }
    const std::ptrdiff_t block = 4 * static_cast<std::ptrdiff_t>(panel.columns);
    const double* l = L + triangle_size(panel.columns) + end * block + 4 * at;
    for (int i = 4 * end; i > 4 * begin; i -= 4) {
        l -= block;
        for (int r = 0; r < count; r += 2)
            __builtin_prefetch(l - ahead + 4 * r);
        for (int s = 3; s >= 0; --s) {
            const double* from = x + rows[i - 4 + s] * stride;
            Lane row[registers];
            for (int v = 0; v < registers; ++v)
                row[v] = *reinterpret_cast<const Lane*>(from + v * T::lanes);
            for (int r = 0; r < count; ++r) {
                for (int v = 0; v < registers; ++v)
                    sum[r][v] -= l[4 * r + s] * row[v];
            }
        }
    }
    if (finish) {
        for (int i = panel.columns - 1; i >= at + count; --i) {
            const double* t = L + triangle_size(i / 4 * 4) + 4 * at + i % 4;
            Lane row[registers];
            for (int v = 0; v < registers; ++v)
                row[v] = *reinterpret_cast<const Lane*>(own + i * stride + v * T::lanes);
            for (int r = 0; r < count; ++r) {
                for (int v = 0; v < registers; ++v)
                    sum[r][v] -= t[4 * r] * row[v];
            }
        }
        for (int s = count - 1; s > 0; --s) {
            for (int r = 0; r < s; ++r) {
                for (int v = 0; v < registers; ++v)
                    sum[r][v] -= entry(at + s / 4 * 4, r, s % 4) * sum[s][v];
            }
        }
    }
    for (int r = 0; r < count; ++r) {
        for (int v = 0; v < registers; ++v)
            *reinterpret_cast<Lane*>(own + (at + r) * stride + v * T::lanes) = sum[r][v];
    }
}

template <class T, int registers>
BELTRAMI_KERNELS_TARGET static inline void backward_panel(const Panel& panel, const double* L,
                                                          const Index* rows, double* x,
                                                          std::ptrdiff_t stride) {
    // Columns at a time, so that their sums stay in registers.
    constexpr int group = registers <= BELTRAMI_KERNELS_REGISTERS / 2 ? 8 : 4;
    const int blocks = (panel.below + 3) / 4;
    const auto columns = [=, &panel](int at, int count, int begin, int end, bool scale, bool finish)
                             BELTRAMI_KERNELS_TARGET {
                                 switch (count) {
                                     case 1:
                                         return backward_columns<T, registers, 1>(
                                             panel, L, rows, x, stride, at, begin, end, scale, finish);
                                     case 2:
                                         return backward_columns<T, registers, 2>(
                                             panel, L, rows, x, stride, at, begin, end, scale, finish);
                                     case 3:
                                         return backward_columns<T, registers, 3>(
                                             panel, L, rows, x, stride, at, begin, end, scale, finish);
                                     case 4:
                                         return backward_columns<T, registers, 4>(
                                             panel, L, rows, x, stride, at, begin, end, scale, finish);
                                     default:
                                         break;
                                 }
                                 if constexpr (group == 8) {
                                     switch (count) {
                                         case 5:
                                             return backward_columns<T, registers, 5>(
                                                 panel, L, rows, x, stride, at, begin, end, scale, finish);
                                         case 6:
                                             return backward_columns<T, registers, 6>(
                                                 panel, L, rows, x, stride, at, begin, end, scale, finish);
                                         case 7:
                                             return backward_columns<T, registers, 7>(
                                                 panel, L, rows, x, stride, at, begin, end, scale, finish);
                                         default:
                                             return backward_columns<T, registers, 8>(
                                                 panel, L, rows, x, stride, at, begin, end, scale, finish);
                                     }
                                 }
                             };
    const int last = (panel.columns - 1) / group * group;
    if (last == 0) return columns(0, panel.columns, 0, blocks, true, true);
    // Rows below by what fits in a cache.
    constexpr int some = 16;
    for (int end = blocks; end > 0; end -= some) {
        for (int at = last; at >= 0; at -= group) {
            columns(at, panel.columns - at < group ? panel.columns - at : group, end > some ? end - some : 0,
                    end, end == blocks, false);
        }
    }
    for (int at = last; at >= 0; at -= group)
        columns(at, panel.columns - at < group ? panel.columns - at : group, 0, 0, blocks == 0, true);
}

template <class T, int registers>
BELTRAMI_KERNELS_TARGET static void forward_all(const Panel* panels, std::size_t count, const double* values,
                                                const Index* rows, double* x, std::ptrdiff_t stride,
                                                int parts) {
    for (std::size_t p = 0; p < count; ++p) {
        for (int part = 0; part < parts; ++part) {
            forward_panel<T, registers>(panels[p], values + panels[p].values, rows + panels[p].rows,
                                        x + part * registers * T::lanes, stride);
        }
    }
}
template <class T, int registers>
BELTRAMI_KERNELS_TARGET static void backward_all(const Panel* panels, std::size_t count, const double* values,
                                                 const Index* rows, double* x, std::ptrdiff_t stride,
                                                 int parts) {
    for (std::size_t p = count; p-- > 0;) {
        for (int part = 0; part < parts; ++part) {
            backward_panel<T, registers>(panels[p], values + panels[p].values, rows + panels[p].rows,
                                         x + part * registers * T::lanes, stride);
        }
    }
}

// So many registers of a row at a time that the parts of a row are equal.
BELTRAMI_KERNELS_TARGET static inline int registers_of(int total) {
    int registers = total < most ? total : most;
    while (total % registers != 0)
        --registers;
    return registers;
}

BELTRAMI_KERNELS_TARGET static void forward(const Panel* panels, std::size_t count, const double* values,
                                            const Index* rows, double* x, std::ptrdiff_t stride, int width) {
    if (width < Wide::lanes) return forward_all<Narrow, 1>(panels, count, values, rows, x, stride, 1);
    const int total = width / Wide::lanes;
    const int registers = registers_of(total);
    const int parts = total / registers;
    switch (registers) {
        case 1:
            return forward_all<Wide, 1>(panels, count, values, rows, x, stride, parts);
        case 2:
            return forward_all<Wide, 2>(panels, count, values, rows, x, stride, parts);
        case 3:
            return forward_all<Wide, 3>(panels, count, values, rows, x, stride, parts);
        default:
            return forward_all<Wide, most>(panels, count, values, rows, x, stride, parts);
    }
}
BELTRAMI_KERNELS_TARGET static void backward(const Panel* panels, std::size_t count, const double* values,
                                             const Index* rows, double* x, std::ptrdiff_t stride, int width) {
    if (width < Wide::lanes) return backward_all<Narrow, 1>(panels, count, values, rows, x, stride, 1);
    const int total = width / Wide::lanes;
    const int registers = registers_of(total);
    const int parts = total / registers;
    switch (registers) {
        case 1:
            return backward_all<Wide, 1>(panels, count, values, rows, x, stride, parts);
        case 2:
            return backward_all<Wide, 2>(panels, count, values, rows, x, stride, parts);
        case 3:
            return backward_all<Wide, 3>(panels, count, values, rows, x, stride, parts);
        default:
            return backward_all<Wide, most>(panels, count, values, rows, x, stride, parts);
    }
}

BELTRAMI_KERNELS_TARGET static inline void solve_block(const Front& front, int first, int at, int count,
                                                       const double* L, int begin, int end) {
    double* x = front.panel + first * front.stride;
    for (int j = begin; j < end;) {
        const int left = (end - j) / Wide::lanes;
        switch (left < most ? left : most) {
            case 1:
                triangle_of<Wide, 1>(count, L, at, x + j, front.stride);
                break;
            case 2:
                triangle_of<Wide, 2>(count, L, at, x + j, front.stride);
                break;
            case 3:
                triangle_of<Wide, 3>(count, L, at, x + j, front.stride);
                break;
            default:
                triangle_of<Wide, most>(count, L, at, x + j, front.stride);
                break;
        }
        j += Wide::lanes * (left < most ? left : most);
    }
}

BELTRAMI_KERNELS_TARGET static int eliminate(const Front& front, int first, int columns, double* L) {
    int negative = 0;
    const int end = first + round_up(columns, 8);
    for (int at = 0; at < columns; at += 4) {
        const int count = columns - at < 4 ? columns - at : 4;
        double* block = L + triangle_size(at);
        const double* row = front.panel + first * front.stride + first + at;
        double t[4][4] = {};
        for (int r = 0; r < count; ++r) {
            for (int c = r; c < count; ++c)
                t[r][c] = row[(at + r) * front.stride + c];
        }
        for (int k = 0; k < at; ++k, row += front.stride, block += 4) {
            const double inverse = L[triangle_size(k / 4 * 4) + 4 * k + k % 4];
            for (int r = 0; r < 4; ++r)
                block[r] = r < count ? row[r] * inverse : 0.0;
            for (int r = 0; r < count; ++r) {
                for (int c = r; c < count; ++c)
                    t[r][c] -= block[r] * row[c];
            }
        }
        for (int i = 0; i < 16; ++i)
            block[i] = 0.0;
        for (int k = 0; k < count; ++k) {
            const double pivot = t[k][k];
            const double inverse = 1.0 / pivot;
            // Also where the inverse of a tiny pivot overflows.
            if (!(inverse - inverse == 0.0) || !(pivot - pivot == 0.0)) return -1;
            if (pivot < 0.0) ++negative;
            block[5 * k] = inverse;
            for (int r = k + 1; r < count; ++r) {
                const double l = t[k][r] * inverse;
                block[4 * k + r] = l;
                for (int c = r; c < count; ++c)
                    t[r][c] -= l * t[k][c];
            }
        }
        solve_block(front, first, at, count, L + triangle_size(at), first + at / 8 * 8, end);
    }
    return negative;
}

BELTRAMI_KERNELS_TARGET static void solve(const Front& front, int first, int columns, const double* L,
                                          int begin, int end) {
    for (int j = begin; j < end; j += chunk_columns) {
        const int stop = end - j < chunk_columns ? end : j + chunk_columns;
        for (int at = 0; at < columns; at += 4) {
            solve_block(front, first, at, columns - at < 4 ? columns - at : 4, L + triangle_size(at), j,
                        stop);
        }
    }
}

BELTRAMI_KERNELS_TARGET static void fill(const Front& front, int first, int columns, double* L, int begin,
                                         int end) {
    using Lane = Narrow::Lane;
    double* to = L + triangle_size(columns) + 4 * static_cast<std::ptrdiff_t>(columns) * begin;
    for (int block = begin; block < end; ++block) {
        const double* from = front.panel + first * front.stride + first + columns + 4 * block;
        const double* corner = L;
        for (int k = 0; k < columns; ++k, from += front.stride, to += 4) {
            // The diagonal of [column][row] blocks of which each has a column more.
            const double inverse = corner[4 * k + k % 4];
            if (k % 4 == 3) corner += 4 * (k - 3) + 16;
            for (int r = 0; r < 4; r += Narrow::lanes) {
                *reinterpret_cast<Lane*>(to + r) = inverse * *reinterpret_cast<const Lane*>(from + r);
            }
        }
    }
}

template <Tile kind>
BELTRAMI_KERNELS_TARGET static inline void tile_row(const double* L, int depth, const double* b,
                                                    std::ptrdiff_t stride, double** c, int width) {
    for (int left = width / Wide::lanes; left > 0;) {
        const int now = left < most ? left : most;
        switch (now) {
            case 1:
                tile<Wide, 1, kind>(L, depth, b, stride, c);
                break;
            case 2:
                tile<Wide, 2, kind>(L, depth, b, stride, c);
                break;
            case 3:
                tile<Wide, 3, kind>(L, depth, b, stride, c);
                break;
            default:
                tile<Wide, most, kind>(L, depth, b, stride, c);
                break;
        }
        left -= now;
        b += now * Wide::lanes;
        for (int r = 0; r < 4; ++r)
            c[r] += now * Wide::lanes;
    }
}

BELTRAMI_KERNELS_TARGET static void update(const Front& front, int first, int columns, const double* L,
                                           int begin, int end, bool fresh) {
    double nowhere[chunk_columns];
    for (double& number : nowhere)
        number = 0.0;
    const int behind = first + columns;
    const double* b = front.panel + first * front.stride;
    for (int j = begin; j < end; j += chunk_columns) {
        const int stop = end - j < chunk_columns ? end : j + chunk_columns;
        const double* l = L + triangle_size(columns);
        for (int i = behind; i < front.rows && i < stop;
             i += 4, l += 4 * static_cast<std::ptrdiff_t>(columns)) {
            const int from = i / 8 * 8 > j ? i / 8 * 8 : j;
            double* c[4];
            for (int r = 0; r < 4; ++r)
                c[r] = i + r < front.rows ? front.at(i + r, from) : static_cast<double*>(nowhere);
            if (fresh && i >= front.columns) {
                tile_row<Tile::fresh>(l, columns, b + from, front.stride, static_cast<double**>(c),
                                      stop - from);
            } else {
                tile_row<Tile::update>(l, columns, b + from, front.stride, static_cast<double**>(c),
                                       stop - from);
            }
        }
    }
}

BELTRAMI_KERNELS_TARGET static void add(const Front& child, const Index* place, const Front& parent,
                                        int begin, int end) {
    const int size = child.rows - child.columns;
    for (int r = begin; r < end; ++r) {
        const double* from = child.update + child.update_at(child.columns + r, child.columns + r) - r;
        const int i = place[r];
        double* to = parent.at(i, i) - i;
        if (place[size - 1] - i == size - 1 - r) {
            to += i - r;
            for (int c = r; c < size; ++c)
                to[c] += from[c];
        } else {
            for (int c = r; c < size; ++c)
                to[place[c]] += from[c];
        }
    }
}

static constexpr Kernels all{BELTRAMI_KERNELS_NAME, forward, backward, eliminate, solve, fill, update, add};

}  // namespace BELTRAMI_KERNELS
}  // namespace beltrami::supernodal
