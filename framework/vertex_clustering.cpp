#include "beltrami/framework/vertex_clustering.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <tuple>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/sides.hpp"

namespace beltrami {

namespace {

std::size_t at(Index i) {
    return static_cast<std::size_t>(i);
}

std::vector<Index> used_vertices(const Mesh& mesh) {
    std::vector<Index> vertices;
    if (mesh.kind() == CellKind::point) {
        vertices.resize(at(mesh.vertex_count()));
        std::iota(vertices.begin(), vertices.end(), 0);
        return vertices;
    }
    std::vector<char> used(at(mesh.vertex_count()), 0);
    for (Eigen::Index i = 0; i < mesh.cells().size(); ++i)
        used[at(mesh.cells().data()[i])] = 1;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (used[at(v)] != 0) vertices.push_back(v);
    }
    return vertices;
}

// Boxes of a grid over some of the points, `divisions` along its longest side, each with a number of its own.
class Grid {
  public:
    static constexpr std::int64_t finest = std::int64_t{1} << 20U;  // three numbers of a box fit in 64 bits

    Grid(const Points& points, const std::vector<Index>& vertices) : points_(points), vertices_(vertices) {
        Vector3 upper = Vector3::Constant(-std::numeric_limits<double>::infinity());
        lower_ = -upper;
        for (const Index v : vertices) {
            lower_ = lower_.cwiseMin(points.row(v).transpose());
            upper = upper.cwiseMax(points.row(v).transpose());
        }
        size_ = (upper - lower_).maxCoeff();
    }

    [[nodiscard]] double box(std::int64_t divisions) const { return size_ / static_cast<double>(divisions); }

    /// The number of the box of each of the vertices.
    [[nodiscard]] std::vector<std::uint64_t> boxes(std::int64_t divisions) const {
        const double scale = size_ > 0.0 ? static_cast<double>(divisions) / size_ : 0.0;
        const double last = static_cast<double>(divisions - 1);
        std::vector<std::uint64_t> numbers(vertices_.size());
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            const Vector3 place = scale * (points_.row(vertices_[i]).transpose() - lower_);
            std::uint64_t number = 0;
            for (int axis = 0; axis < 3; ++axis) {
                number =
                    (number << 20U) | static_cast<std::uint64_t>(std::min(std::floor(place[axis]), last));
            }
            numbers[i] = number;
        }
        return numbers;
    }

    [[nodiscard]] Index occupied(std::int64_t divisions) const {
        std::vector<std::uint64_t> numbers = boxes(divisions);
        std::sort(numbers.begin(), numbers.end());
        return static_cast<Index>(std::unique(numbers.begin(), numbers.end()) - numbers.begin());
    }

  private:
    const Points& points_;
    const std::vector<Index>& vertices_;
    Vector3 lower_;
    double size_ = 0.0;
};

// Finer grids have more boxes that hold something, but for chance: bisection finds one that is as fine as matters.
std::int64_t finest_within(const Grid& grid, Index most) {
    const auto enough = static_cast<Index>(0.97 * most);
    std::int64_t good = 1;
    // A surface fills about as many boxes as a cube's face has.
    auto tried = std::clamp<std::int64_t>(std::llround(std::sqrt(most / 3.0)), 1, Grid::finest);
    std::int64_t bad = Grid::finest + 1;
    while (bad - good > 1) {
        const Index count = grid.occupied(tried);
        if (count <= most) {
            good = std::max(good, tried);
            if (count >= enough) break;
        } else {
            bad = tried;
        }
        tried = bad > Grid::finest ? std::min(2 * good, Grid::finest) : (good + bad) / 2;
        if (tried == good) break;
    }
    return good;
}

// The member of each run of `members` (positions in `vertices`, sorted by box) that is nearest the run's mean. Of equally
// near ones the first by place, so that the order of the vertices does not matter.
std::vector<Index> representatives(const Points& points, const std::vector<Index>& vertices,
                                   const std::vector<std::uint64_t>& boxes, const std::vector<Index>& members,
                                   std::vector<Index>& cluster_of) {
    std::vector<Index> chosen;
    for (std::size_t begin = 0; begin < members.size();) {
        std::size_t end = begin;
        Vector3 mean = Vector3::Zero();
        const std::uint64_t box = boxes[at(members[begin])];
        for (; end < members.size() && boxes[at(members[end])] == box; ++end)
            mean += points.row(vertices[at(members[end])]).transpose();
        mean /= static_cast<double>(end - begin);
        const auto key = [&](std::size_t i) {
            const Vector3 p = points.row(vertices[at(members[i])]).transpose();
            return std::tuple((p - mean).squaredNorm(), p.x(), p.y(), p.z());
        };
        std::size_t nearest = begin;
        for (std::size_t i = begin + 1; i < end; ++i) {
            if (key(i) < key(nearest)) nearest = i;
        }
        const Index representative = vertices[at(members[nearest])];
        for (std::size_t i = begin; i < end; ++i)
            cluster_of[at(vertices[at(members[i])])] = representative;
        chosen.push_back(representative);
        begin = end;
    }
    return chosen;
}

// The cells between the clusters: without those that collapsed, each once.
Cells cells_between(const Cells& cells, const std::vector<Index>& cluster_of, Index clusters) {
    Cells kept(cells.rows(), cells.cols());
    Cells sorted(cells.rows(), cells.cols());
    Eigen::Index count = 0;
    for (Eigen::Index c = 0; c < cells.rows(); ++c) {
        auto ascending = sorted.row(count);
        for (Eigen::Index k = 0; k < cells.cols(); ++k)
            kept(count, k) = ascending[k] = cluster_of[at(cells(c, k))];
        std::sort(ascending.begin(), ascending.end());
        if (std::adjacent_find(ascending.begin(), ascending.end()) == ascending.end()) ++count;
    }
    sorted.conservativeResize(count, Eigen::NoChange);
    const EqualRows groups(sorted, clusters);
    std::vector<Index> first;
    first.reserve(static_cast<std::size_t>(groups.group_count()));
    for (Index g = 0; g < groups.group_count(); ++g)
        first.push_back(groups.group(g).front());
    std::sort(first.begin(), first.end());
    return kept(first, Eigen::all);
}

}  // namespace

VertexClustering cluster_vertices(const Mesh& mesh, Index most) {
    if (most < 1) throw InputError(fmt::format("a mesh of at most {} vertices", most), "allow one or more");
    std::vector<Index> vertices = used_vertices(mesh);
    std::vector<Index> cluster_of(at(mesh.vertex_count()), -1);
    double box = 0.0;
    if (vertices.size() > at(most)) {
        const Grid grid(mesh.points(), vertices);
        const std::int64_t divisions = finest_within(grid, most);
        box = grid.box(divisions);
        const std::vector<std::uint64_t> boxes = grid.boxes(divisions);
        std::vector<Index> members(vertices.size());
        std::iota(members.begin(), members.end(), 0);
        std::sort(members.begin(), members.end(),
                  [&](Index a, Index b) { return std::pair(boxes[at(a)], a) < std::pair(boxes[at(b)], b); });
        vertices = representatives(mesh.points(), vertices, boxes, members, cluster_of);
        std::sort(vertices.begin(), vertices.end());
    } else {
        for (const Index v : vertices)
            cluster_of[at(v)] = v;
    }
    // From numbers in the original to numbers among those that are left.
    std::vector<Index> number(at(mesh.vertex_count()), -1);
    for (std::size_t i = 0; i < vertices.size(); ++i)
        number[at(vertices[i])] = static_cast<Index>(i);
    for (Index& cluster : cluster_of)
        cluster = cluster < 0 ? -1 : number[at(cluster)];

    const Points points = mesh.points()(vertices, Eigen::all);
    Fields fields;
    for (const Field& field : mesh.fields())
        fields.push_back({field.name, field.values(vertices, Eigen::all)});
    if (mesh.kind() == CellKind::point)
        return {Mesh(points, fields), std::move(vertices), std::move(cluster_of), box};
    const Cells cells = cells_between(mesh.cells(), cluster_of, static_cast<Index>(vertices.size()));
    const Cells whole = non_degenerate_cells(Mesh(points, cells));
    return {Mesh(points, whole, fields), std::move(vertices), std::move(cluster_of), box};
}

}  // namespace beltrami
