#include "beltrami/solvers/hierarchy.hpp"

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <limits>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

#include "beltrami/framework/cell_geometry.hpp"
#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

using testing::dense;
using testing::random_block;
using testing::random_vector;
using testing::relative_difference;
using Prolongation = Hierarchy::Prolongation;
using Sparse = Eigen::SparseMatrix<double>;

EdgeGraph graph_of(const Mesh& mesh) {
    return {mesh.vertex_count(), mesh.cells()};
}

Hierarchy hierarchy_of(const Mesh& mesh, Index coarsest = 20) {
    return {graph_of(mesh), mesh.points(), {.coarsest = coarsest}};
}

std::vector<Index> sizes(const Hierarchy& hierarchy) {
    std::vector<Index> all;
    all.reserve(static_cast<std::size_t>(hierarchy.level_count()));
    for (int level = 0; level < hierarchy.level_count(); ++level)
        all.push_back(hierarchy.size(level));
    return all;
}

// A point cloud as a solver gets it: points in a cube, each joined to its nearest ones.
struct Cloud {
    Points points;
    EdgeGraph graph;
};
Cloud cloud(Index n) {
    const Points points = random_block(n, 3);
    std::vector<std::pair<Index, Index>> edges;
    for (Index i = 0; i < n; ++i) {
        std::vector<std::pair<double, Index>> others;
        for (Index j = 0; j < n; ++j) {
            if (j != i) others.emplace_back((points.row(i) - points.row(j)).norm(), j);
        }
        std::partial_sort(others.begin(), others.begin() + 8, others.end());
        for (int k = 0; k < 8; ++k)
            edges.emplace_back(i, others[static_cast<std::size_t>(k)].second);
    }
    return {points, EdgeGraph(n, std::move(edges))};
}

// What the header promises of every hierarchy.
void expect_well_made(const Hierarchy& hierarchy, const EdgeGraph& graph) {
    const Components components = connected_components(graph);
    std::set<Index> with_edges;
    for (Index v = 0; v < graph.vertex_count(); ++v) {
        if (graph.degree(v) > 0) with_edges.insert(components.of_vertex[static_cast<std::size_t>(v)]);
    }
    const auto component = [&](int level, Index v) {
        const Index on_mesh = hierarchy.vertices(level)[static_cast<std::size_t>(v)];
        return components.of_vertex[static_cast<std::size_t>(on_mesh)];
    };
    EXPECT_EQ(hierarchy.size(0), graph.vertex_count());
    std::size_t bytes = 0;
    for (int level = 0; level + 1 < hierarchy.level_count(); ++level) {
        const Prolongation& P = hierarchy.prolongation(level);
        const std::vector<Index>& fine = hierarchy.vertices(level);
        const std::vector<Index>& coarse = hierarchy.vertices(level + 1);
        bytes += 12 * static_cast<std::size_t>(P.nonZeros());
        ASSERT_EQ(P.rows(), hierarchy.size(level));
        ASSERT_EQ(P.cols(), hierarchy.size(level + 1));
        EXPECT_LE(1.5 * hierarchy.size(level + 1), hierarchy.size(level));
        EXPECT_TRUE(std::is_sorted(coarse.begin(), coarse.end()));
        EXPECT_TRUE(std::includes(fine.begin(), fine.end(), coarse.begin(), coarse.end())) << "not nested";
        std::set<Index> found;
        for (Index c = 0; c < hierarchy.size(level + 1); ++c)
            found.insert(component(level + 1, c));
        EXPECT_EQ(found, with_edges) << "components of level " << level + 1;
        for (Index v = 0; v < P.rows(); ++v) {
            const Index on_mesh = fine[static_cast<std::size_t>(v)];
            int entries = 0;
            double sum = 0.0;
            Index before = -1;
            for (Prolongation::InnerIterator entry(P, v); entry; ++entry) {
                ++entries;
                sum += entry.value();
                EXPECT_GT(entry.value(), 0.0);
                EXPECT_LE(entry.value(), 1.0);
                EXPECT_GT(entry.col(), before) << "sorted";
                before = static_cast<Index>(entry.col());
                EXPECT_EQ(component(level + 1, before), component(level, v)) << "components meet";
            }
            if (graph.degree(on_mesh) == 0) {
                EXPECT_EQ(entries, 0) << "an isolated vertex";
                continue;
            }
            EXPECT_GE(entries, 1) << "vertex " << v << " of level " << level;
            EXPECT_LE(entries, 3);
            EXPECT_NEAR(sum, 1.0, 4e-16);
            if (std::binary_search(coarse.begin(), coarse.end(), on_mesh)) {
                EXPECT_EQ(entries, 1);
                EXPECT_EQ(coarse[static_cast<std::size_t>(before)], on_mesh);
            }
        }
    }
    EXPECT_GE(hierarchy.memory_bytes(), bytes + 4 * static_cast<std::size_t>(graph.vertex_count()));
}

void expect_same(const Hierarchy& a, const Hierarchy& b, double tolerance) {
    ASSERT_EQ(sizes(a), sizes(b));
    for (int level = 0; level + 1 < a.level_count(); ++level) {
        EXPECT_EQ(a.vertices(level + 1), b.vertices(level + 1));
        EXPECT_LE((a.prolongation(level) - b.prolongation(level)).norm(), tolerance) << "level " << level;
    }
}

TEST(Hierarchy, OfEveryKindOfMeshIsWellMade) {
    for (const Mesh& mesh :
         {shapes::icosphere(4), shapes::bumpy_sphere(4000), shapes::grid(50, 40), shapes::fins(4, 15),
          shapes::pinched_spheres(3), shapes::genus(2, 8), shapes::tetrahedral_ball(12), shapes::circle(500),
          shapes::shuffled(shapes::torus(1.0, 0.3, 60, 30)).mesh, shapes::latlong_sphere(40)}) {
        const Hierarchy hierarchy = hierarchy_of(mesh);
        EXPECT_GE(hierarchy.level_count(), 3) << mesh.vertex_count();
        EXPECT_LE(sizes(hierarchy).back(), 20) << mesh.vertex_count();
        expect_well_made(hierarchy, graph_of(mesh));
    }
    const Cloud points = cloud(1500);
    expect_well_made(Hierarchy(points.graph, points.points, {.coarsest = 20}), points.graph);
}

TEST(Hierarchy, LevelsOfASurfaceFallByAFactorOfThreeToEight) {
    for (const Mesh& mesh : {shapes::icosphere(6), shapes::bumpy_sphere(40000), shapes::grid(200, 200)}) {
        const std::vector<Index> n = sizes(hierarchy_of(mesh, 500));
        for (std::size_t level = 1; level < n.size(); ++level) {
            EXPECT_GT(n[level - 1], 3 * n[level]);
            EXPECT_LT(n[level - 1], 8 * n[level]);
        }
        EXPECT_LE(n.back(), 500);
        EXPECT_GT(n[n.size() - 2], 500) << "one level too many";
    }
}

TEST(Hierarchy, ALargerRadiusIsCoarser) {
    const Mesh mesh = shapes::bumpy_sphere(5000);
    Index before = mesh.vertex_count();
    for (const double radius : {1.5, 2.0, 2.3, 4.0}) {
        const Hierarchy hierarchy(graph_of(mesh), mesh.points(), {.radius = radius, .coarsest = 1000});
        EXPECT_LT(hierarchy.size(1), 0.9 * before) << radius;
        before = hierarchy.size(1);
    }
    // One that covers nothing gives no level, one that covers all leaves one vertex.
    EXPECT_EQ(Hierarchy(graph_of(mesh), mesh.points(), {.radius = 1e-9}).level_count(), 1);
    EXPECT_EQ(Hierarchy(graph_of(mesh), mesh.points(), {.radius = 1e9}).size(1), 1);
}

// By relaxing all edges until nothing changes, the length of the way to the next vertex of level 1.
TEST(Hierarchy, EveryVertexHasACoarseOneWithinItsOwnRadius) {
    const Mesh mesh = shapes::bumpy_sphere(3000);
    const EdgeGraph graph = graph_of(mesh);
    const Hierarchy hierarchy = hierarchy_of(mesh, 1000);
    const Vector lengths = edge_lengths(graph, mesh.points());
    Vector distance = Vector::Constant(graph.vertex_count(), 1e9);
    for (const Index v : hierarchy.vertices(1))
        distance[v] = 0.0;
    for (bool changed = true; changed;) {
        changed = false;
        for (Index v = 0; v < graph.vertex_count(); ++v) {
            for (const auto& [w, edge] : graph.neighbours(v)) {
                if (distance[v] + lengths[edge] >= distance[w]) continue;
                distance[w] = distance[v] + lengths[edge];
                changed = true;
            }
        }
    }
    for (Index v = 0; v < graph.vertex_count(); ++v) {
        double mean = 0.0;
        for (const auto& [w, edge] : graph.neighbours(v))
            mean += lengths[edge] / graph.degree(v);
        EXPECT_LE(distance[v], 2.0 * mean * (1.0 + 1e-6)) << v;
    }
}

TEST(Hierarchy, ConstantsStayConstant) {
    for (const Mesh& mesh : {shapes::bumpy_sphere(5000), shapes::tetrahedral_ball(10)}) {
        const Hierarchy hierarchy = hierarchy_of(mesh);
        Vector u = Vector::Ones(sizes(hierarchy).back());
        for (int level = hierarchy.level_count() - 2; level >= 0; --level)
            u = hierarchy.prolongation(level) * u;
        EXPECT_LT((u.array() - 1.0).abs().maxCoeff(), 2e-15);
    }
}

// The entries are barycentric coordinates: within the triangles of the coarse points linear functions are exact.
TEST(Hierarchy, LinearFunctionsOnAPlane) {
    const Mesh plane = shapes::jittered(shapes::grid(60, 60), 0.2);
    const Hierarchy hierarchy = hierarchy_of(plane, 1000);
    const Points coarse = plane.points()(hierarchy.vertices(1), Eigen::all);
    const Vector error = (hierarchy.prolongation(0) * coarse - plane.points()).rowwise().norm();
    Index inside = 0;
    Index exact = 0;
    for (Index v = 0; v < plane.vertex_count(); ++v) {
        const auto p = plane.points().row(v).head<2>().array();
        EXPECT_LT(error[v], 2.5 / 60.0) << "at most the radius";
        if (p.minCoeff() < 0.05 || p.maxCoeff() > 0.95) continue;
        ++inside;
        if (error[v] < 1e-14) ++exact;
        EXPECT_LT(error[v], 1.0 / 60.0) << v;
    }
    EXPECT_GT(exact, 0.97 * inside);
    EXPECT_GT(inside, 2000);
}

// On a curved mesh the combination of coarse points is the closest point of triangles: near, and no nearer when moved.
TEST(Hierarchy, CombinedCoarsePointsAreClose) {
    const Mesh sphere = shapes::icosphere(5);
    const Hierarchy hierarchy = hierarchy_of(sphere, 2000);
    const Points coarse = sphere.points()(hierarchy.vertices(1), Eigen::all);
    const Points combined = hierarchy.prolongation(0) * coarse;
    const double spacing = std::sqrt(4.0 * std::numbers::pi / hierarchy.size(1));
    EXPECT_LT((combined - sphere.points()).rowwise().norm().maxCoeff(), 0.5 * spacing);
    EXPECT_LT((combined - sphere.points()).rowwise().norm().mean(), 0.5 * spacing * spacing);
    EXPECT_LT((combined - sphere.points()).rowwise().norm().mean(), 0.1 * spacing);
    for (Index v = 0; v < sphere.vertex_count(); ++v) {
        const Vector3 residual = sphere.points().row(v) - combined.row(v);
        for (Prolongation::InnerIterator entry(hierarchy.prolongation(0), v); entry; ++entry) {
            const Vector3 towards = coarse.row(entry.col()) - combined.row(v);
            EXPECT_NEAR(residual.dot(towards), 0.0, 1e-14) << v;
        }
    }
}

TEST(Hierarchy, OfSegmentsInterpolatesAlongTheLine) {
    Points points(101, 3);
    Cells cells(100, 2);
    for (Index v = 0; v < 101; ++v) {
        points.row(v) << 0.1 * v, 0.0, 0.0;
        if (v < 100) cells.row(v) << v, v + 1;
    }
    const Hierarchy hierarchy = hierarchy_of(Mesh(points, cells));
    EXPECT_EQ(hierarchy.vertices(1)[1], 3) << "the radius is two edges";
    const Points coarse = points(hierarchy.vertices(1), Eigen::all);
    const Points combined = hierarchy.prolongation(0) * coarse;
    const Index last = hierarchy.vertices(1).back();
    EXPECT_LT((combined - points).topRows(last + 1).norm(), 1e-13);
    EXPECT_NEAR(hierarchy.prolongation(0).coeff(1, 0), 2.0 / 3.0, 1e-14);
    EXPECT_NEAR(hierarchy.prolongation(0).coeff(1, 1), 1.0 / 3.0, 1e-14);
}

// Rayleigh-Ritz: eigenvalues of a subspace are not below those of the mesh, and few percent above them.
TEST(Hierarchy, CoarseEigenvaluesOfTheSphere) {
    const Laplacian laplacian(shapes::icosphere(3), {.renumber = false});
    const Hierarchy hierarchy = hierarchy_of(shapes::icosphere(3), 200);
    ASSERT_EQ(hierarchy.level_count(), 2);
    const Prolongation& P = hierarchy.prolongation(0);
    const Sparse K = laplacian.stiffness().to_sparse();
    Sparse M(K.rows(), K.cols());
    M.setIdentity();
    M.diagonal() = laplacian.mass();
    const Eigen::MatrixXd K_c = dense(galerkin_product(K, P));
    const Eigen::MatrixXd M_c = dense(galerkin_product(M, P));
    EXPECT_LT((K_c * Vector::Ones(K_c.rows())).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_NEAR(M_c.sum(), laplacian.mass().sum(), 1e-12);
    const Vector fine =
        Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(dense(K), dense(M)).eigenvalues();
    const Vector coarse = Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(K_c, M_c).eigenvalues();
    EXPECT_NEAR(coarse[0], 0.0, 1e-12);
    for (Eigen::Index k = 1; k < 9; ++k)
        EXPECT_GE(coarse[k], fine[k] * (1.0 - 1e-12)) << k;
    for (Eigen::Index k = 1; k < 4; ++k) {
        EXPECT_GT(coarse[k], 1.95);
        EXPECT_LT(coarse[k], 1.15 * 2.0);
    }
    EXPECT_GT(coarse[4], 5.0) << "the multiplicity of 2 is three";
}

TEST(Hierarchy, GalerkinProduct) {
    const Mesh mesh = shapes::bumpy_sphere(400);
    const Hierarchy hierarchy = hierarchy_of(mesh, 100);
    const Prolongation& P = hierarchy.prolongation(0);
    const Sparse A = Laplacian(mesh, {.renumber = false}).stiffness().to_sparse();
    const Eigen::MatrixXd P_dense = P;
    const Eigen::MatrixXd expected = P_dense.transpose() * dense(A) * P_dense;
    EXPECT_LT(relative_difference(dense(galerkin_product(A, P)), expected), 1e-13);
}

// Each component is left with a vertex, down to levels on which that is all that is left of it.
TEST(Hierarchy, ComponentsStayApartAndNoneVanishes) {
    const Mesh mesh = shapes::shuffled(shapes::together({shapes::icosphere(4), shapes::grid(1, 1),
                                                         shapes::torus(1.0, 0.4, 40, 20),
                                                         shapes::grid(30, 30), shapes::icosphere(0)}))
                          .mesh;
    const Hierarchy hierarchy = hierarchy_of(mesh, 1);
    expect_well_made(hierarchy, graph_of(mesh));
    EXPECT_GE(hierarchy.level_count(), 4);
    EXPECT_LT(sizes(hierarchy).back(), 10) << "little but the five components is left";
    EXPECT_GE(sizes(hierarchy).back(), 5);
}

TEST(Hierarchy, IsolatedVerticesAreOnTheMeshOnly) {
    const Mesh sphere = shapes::icosphere(3);
    Points points(sphere.vertex_count() + 600, 3);
    points << random_block(300, 3), sphere.points(), random_block(300, 3);
    const Mesh mesh(points, sphere.cells().array() + 300);
    const Hierarchy hierarchy = hierarchy_of(mesh);
    expect_well_made(hierarchy, graph_of(mesh));
    const Hierarchy alone = hierarchy_of(sphere);
    ASSERT_EQ(hierarchy.level_count(), alone.level_count());
    for (int level = 1; level < alone.level_count(); ++level)
        EXPECT_EQ(hierarchy.size(level), alone.size(level));
    const Prolongation rows = hierarchy.prolongation(0).middleRows(300, sphere.vertex_count());
    EXPECT_EQ(rows.nonZeros(), hierarchy.prolongation(0).nonZeros());
    EXPECT_LT((rows - alone.prolongation(0)).norm(), 1e-13);
    // They do not count when a level is asked whether it is smaller.
    EXPECT_EQ(Hierarchy(graph_of(mesh), points, {.radius = 0.5, .coarsest = 1}).level_count(), 1);
    EXPECT_EQ(Hierarchy(EdgeGraph(50, Cells(0, 3)), random_block(50, 3), {.coarsest = 1}).level_count(), 1);
    EXPECT_EQ(Hierarchy(EdgeGraph(0, Cells(0, 3)), Points(0, 3)).level_count(), 1);
}

TEST(Hierarchy, CoincidentPointsAndSlivers) {
    // All in one place: nothing to tell vertices apart by, one is left of the component.
    const Mesh sphere = shapes::icosphere(3);
    for (const double x : {0.0, 3.0}) {
        const Mesh point = sphere.with_points(Points::Constant(sphere.vertex_count(), 3, x));
        const Hierarchy hierarchy = hierarchy_of(point);
        EXPECT_EQ(sizes(hierarchy), (std::vector<Index>{642, 1}));
        expect_well_made(hierarchy, graph_of(point));
    }
    // Rows of vertices in one place; all on a line; nearly so.
    for (const auto& [x, y, z] :
         {std::tuple{20.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {1e9, 1.0, 0.0}, {1.0, 1e-12, 0.0}}) {
        const Mesh flat = shapes::grid(40, 40);
        Points points = flat.points() * Eigen::Vector3d(x, y, z).asDiagonal();
        points.col(0) = points.col(0).array().ceil();
        const Hierarchy hierarchy = hierarchy_of(flat.with_points(points));
        EXPECT_GE(hierarchy.level_count(), 2);
        expect_well_made(hierarchy, graph_of(flat));
    }
    // A strip so thin that triangles are no more than their sides.
    const Mesh strip = shapes::grid(100, 1, 1.0, 1e-10);
    const Mesh moved = testing::rigidly_moved(strip);
    const Hierarchy thin = hierarchy_of(moved, 60);
    const Points corners = moved.points()(thin.vertices(1), Eigen::all);
    const Vector off = (thin.prolongation(0) * corners - moved.points()).rowwise().norm();
    const double end = strip.points()(thin.vertices(1), 0).maxCoeff();
    for (Index v = 0; v < strip.vertex_count(); ++v) {
        if (strip.points()(v, 0) < end) {
            EXPECT_LT(off[v], 1e-9) << v;
        }
    }
    // A closed line of three cells, two of whose centres, 0 and 6, lie in one place.
    Points loop(9, 3);
    loop << 0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 2, 0, 0, 1, 0, 0, 0, 0, 0, -0.6, 0.9, 0, 0.5, 0.9, 0;
    const Mesh closed = shapes::circle(9).with_points(loop);
    const Hierarchy three = hierarchy_of(closed, 3);
    ASSERT_EQ(three.size(three.level_count() - 1), 3);
    EXPECT_EQ(three.vertices(1), (std::vector<Index>{0, 3, 6}));
    expect_well_made(three, graph_of(closed));
    // Every vertex twice, with an edge of no length between the two.
    const Mesh once = shapes::icosphere(3);
    Points points(2 * once.vertex_count(), 3);
    points << once.points(), once.points();
    std::vector<std::pair<Index, Index>> edges;
    for (Index c = 0; c < once.cell_count(); ++c) {
        for (Index k = 0; k < 3; ++k)
            edges.emplace_back(once.cells()(c, k), once.cells()(c, (k + 1) % 3));
    }
    for (Index v = 0; v < once.vertex_count(); ++v)
        edges.emplace_back(v, v + once.vertex_count());
    const EdgeGraph graph(2 * once.vertex_count(), std::move(edges));
    const Hierarchy hierarchy(graph, points, {.coarsest = 20});
    expect_well_made(hierarchy, graph);
    const Prolongation& P = hierarchy.prolongation(0);
    for (const Index v : hierarchy.vertices(1)) {
        if (v >= once.vertex_count()) continue;
        const Index twin = v + once.vertex_count();
        EXPECT_EQ(P.row(v).dot(P.row(twin)), 1.0) << "in the place of a coarse vertex";
    }
}

// A vertex joined to all others, which come in the order of their distance: each is nearer than the next one.
TEST(Hierarchy, AStarTakesNoQuadraticTime) {
    const Index n = 200000;
    Points points = Points::Zero(n, 3);
    std::vector<std::pair<Index, Index>> edges;
    for (Index v = 0; v + 1 < n; ++v) {
        points(v, 0) = 1.0 + static_cast<double>(v) / n;
        edges.emplace_back(v, n - 1);
    }
    const EdgeGraph graph(n, std::move(edges));
    expect_well_made(Hierarchy(graph, points, {.radius = 1.5}), graph);
}

TEST(Hierarchy, IsTheSameEveryTimeAndWhereverTheMeshLies) {
    for (const Mesh& mesh : {shapes::grid(40, 40), shapes::icosphere(4), shapes::bumpy_sphere(3000),
                             shapes::tetrahedral_ball(10), shapes::fins(3, 20)}) {
        const Hierarchy hierarchy = hierarchy_of(mesh);
        expect_same(hierarchy_of(mesh), hierarchy, 0.0);
        expect_same(hierarchy_of(testing::rigidly_moved(mesh)), hierarchy, 1e-7);
        for (const double factor : {0.37, 1e-200, 1e200})
            expect_same(hierarchy_of(testing::scaled(mesh, factor)), hierarchy, 1e-7);
    }
}

// A V-cycle as multigrid will have it, with one sweep of Gauss-Seidel down and one up.
class VCycle {
  public:
    VCycle(const Sparse& A, const Hierarchy& hierarchy, Index held) {
        A_.emplace_back(A);
        for (int level = 0; level + 1 < hierarchy.level_count(); ++level) {
            P_.push_back(hierarchy.prolongation(level));
            if (level == 0)
                P_.back().prune([&](Eigen::Index row, Eigen::Index, double) { return row != held; });
            A_.emplace_back(galerkin_product(A_.back(), P_.back()));
        }
        coarsest_.compute(A_.back());
    }

    [[nodiscard]] Vector apply(const Vector& b, std::size_t level = 0) const {
        if (level == P_.size()) return coarsest_.solve(b);
        const auto& A = A_[level];
        Vector x = A.triangularView<Eigen::Lower>().solve(b);
        x += P_[level] * apply(P_[level].transpose() * (b - A * x), level + 1);
        x += A.triangularView<Eigen::Upper>().solve(b - A * x);
        return x;
    }

  private:
    std::vector<Eigen::SparseMatrix<double, Eigen::RowMajor>> A_;
    std::vector<Prolongation> P_;
    Eigen::SimplicialLDLT<Sparse> coarsest_;
};

int iterations(const Mesh& mesh, const Hierarchy& hierarchy) {
    const Index held = 17;
    Sparse K = Laplacian(mesh, {.renumber = false}).stiffness().to_sparse();
    K.prune([&](Eigen::Index i, Eigen::Index j, double) { return i == j || (i != held && j != held); });
    const VCycle cycle(K, hierarchy, held);
    Vector b = random_vector(mesh.vertex_count());
    b[held] = 0.0;
    Vector x = Vector::Zero(b.size());
    Vector r = b;
    Vector z = cycle.apply(r);
    Vector p = z;
    double rz = r.dot(z);
    const double wanted = 1e-16 * rz;
    int count = 0;
    for (; rz > wanted && count < 500; ++count) {
        const Vector Kp = K * p;
        const double step = rz / p.dot(Kp);
        x += step * p;
        r -= step * Kp;
        z = cycle.apply(r);
        const double before = std::exchange(rz, r.dot(z));
        p = z + (rz / before) * p;
    }
    EXPECT_LT((b - K * x).norm(), 1e-6 * b.norm());
    return count;
}

TEST(Hierarchy, AVCycleMakesConjugateGradientsFast) {
    const Mesh irregular = shapes::bumpy_sphere(20000);
    const int two_levels = iterations(irregular, hierarchy_of(irregular, 4000));
    const int v_cycle = iterations(irregular, hierarchy_of(irregular, 100));
    EXPECT_LT(two_levels, 40);
    EXPECT_LT(v_cycle, 40);
    RecordProperty("two levels", two_levels);
    RecordProperty("V-cycle", v_cycle);
    const Mesh regular = shapes::icosphere(5);
    EXPECT_LT(iterations(regular, hierarchy_of(regular, 100)), 15);
    const Mesh solid = shapes::tetrahedral_ball(16);
    EXPECT_LT(iterations(solid, hierarchy_of(solid, 20)), 20);
}

TEST(Hierarchy, TellsWhereItIsAndStops) {
    const Mesh mesh = shapes::icosphere(5);
    std::vector<double> fractions;
    const Progress watched([&](const ProgressReport& r) { fractions.push_back(r.fraction); });
    const Hierarchy hierarchy(graph_of(mesh), mesh.points(), {.coarsest = 20, .progress = &watched});
    EXPECT_GE(fractions.size(), static_cast<std::size_t>(hierarchy.level_count()));
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
    EXPECT_EQ(fractions.front(), 0.0);
    EXPECT_EQ(fractions.back(), 1.0);
    Progress stopped;
    stopped.cancel();
    EXPECT_THROW(Hierarchy(graph_of(mesh), mesh.points(), {.progress = &stopped}), Cancelled);
}

TEST(Hierarchy, RefusesWhatMakesNone) {
    const Mesh mesh = shapes::icosphere(2);
    const EdgeGraph graph = graph_of(mesh);
    EXPECT_THROW(Hierarchy(graph, mesh.points().topRows(100)), InputError);
    Points broken = mesh.points();
    broken(7, 1) = NAN;
    EXPECT_THROW(Hierarchy(graph, broken), InputError);
    for (const double radius : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
        EXPECT_THROW(Hierarchy(graph, mesh.points(), {.radius = radius}), InputError) << radius;
    EXPECT_THROW(Hierarchy(graph, mesh.points(), {.coarsest = 0}), InputError);
    const Hierarchy hierarchy(graph, mesh.points(), {.coarsest = 50});
    ASSERT_EQ(hierarchy.level_count(), 2);
    EXPECT_THROW((void)hierarchy.vertices(2), InputError);
    EXPECT_THROW((void)hierarchy.size(-1), InputError);
    EXPECT_THROW((void)hierarchy.prolongation(1), InputError);
    EXPECT_THROW((void)hierarchy.prolongation(-1), InputError);
}

}  // namespace
}  // namespace beltrami
