// The one door between the user's vertex order and the working order of operators and solvers.
//
//     Renumbering order = cuthill_mckee(graph);             // neighbours get close numbers: 3 to 4 times faster products
//     Block inside = order.to_working(field);               // rows permuted
//     Block outside = order.to_user(inside);
#pragma once

#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

class EdgeGraph;
class Constraints;

class Renumbering {
  public:
    /// Nothing moves.
    static Renumbering identity(Index vertex_count);

    /// working[v] is the working number of user vertex v; throws InputError unless it is a permutation.
    explicit Renumbering(std::vector<Index> working);

    [[nodiscard]] Index vertex_count() const { return static_cast<Index>(working_.size()); }
    [[nodiscard]] Index working(Index user_vertex) const {
        return working_[static_cast<std::size_t>(user_vertex)];
    }
    [[nodiscard]] Index user(Index working_vertex) const {
        return user_[static_cast<std::size_t>(working_vertex)];
    }

    /// Rows of an n x k block, permuted. Throws InputError for another number of rows.
    [[nodiscard]] Block to_working(const Block& user_values) const;
    [[nodiscard]] Block to_user(const Block& working_values) const;

    /// Points, cells and fields.
    [[nodiscard]] Mesh to_working(const Mesh& mesh) const;
    [[nodiscard]] Constraints to_working(const Constraints& constraints) const;

  private:
    std::vector<Index> working_;  // of user vertex
    std::vector<Index> user_;     // of working vertex
};

/// Reduces the bandwidth of a graph (Cuthill & McKee 1969, through Boost.Graph), component after component.
Renumbering cuthill_mckee(const EdgeGraph& graph);

}  // namespace beltrami
