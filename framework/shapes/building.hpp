// What the shapes are built with: checks of their arguments, a growing mesh, portable random numbers.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <random>
#include <string_view>
#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami::shapes {

/// Throw InputError unless value >= least; unless value is a positive finite number; unless a shape of that many
/// vertices is one that a machine can hold (50 million).
void require_at_least(std::string_view what, std::int64_t value, std::int64_t least);
void require_positive(std::string_view what, double value);
void require_size(double vertices);

/// A mesh that grows vertex by vertex and cell by cell.
class MeshBuilder {
  public:
    explicit MeshBuilder(CellKind kind = CellKind::triangle) : corners_(static_cast<int>(kind)) {}

    Index vertex(const Vector3& position);
    void cell(std::initializer_list<Index> vertices);
    /// Two triangles; `other` takes the diagonal b-d in place of a-c.
    void square(Index a, Index b, Index c, Index d, bool other = false);
    /// nu x nv squares between the vertices at(i, j), i = 0..nu and j = 0..nv, seen counterclockwise from the side
    /// where j turns left from i.
    template <class VertexAt>
    void sheet(int nu, int nv, VertexAt at, bool alternate = false) {
        for (int j = 0; j < nv; ++j) {
            for (int i = 0; i < nu; ++i) {
                square(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), alternate && (i + j) % 2 == 1);
            }
        }
    }
    [[nodiscard]] Mesh mesh() const;

  private:
    int corners_;
    std::vector<double> coordinates_;
    std::vector<Index> cells_;
};

/// std::mt19937 is the same everywhere; the distributions of the standard library are not, so these are our own.
class Random {
  public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}

    /// In [0, 1), with 53 random bits.
    double uniform();
    /// In [0, count).
    Index below(Index count);
    /// Evenly in the unit ball; in the unit disc of the plane z = 0.
    Vector3 in_ball() { return in_unit(3); }
    Vector3 in_disc() { return in_unit(2); }
    /// Evenly on the unit sphere.
    Vector3 direction();

  private:
    Vector3 in_unit(int dimensions);

    std::mt19937 engine_;
};

}  // namespace beltrami::shapes
