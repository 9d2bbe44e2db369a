// Chladni figures: where a function of the spectrum is 0, or has another value.
//
//     const NodalLines nodal = nodal_lines(mesh, basis.function(12));
//     nodal.lines.length;  nodal.domains;
//     write_picture("chladni.png", draw_lines(mesh, &function, nodal.lines.segments));
#pragma once

#include "beltrami/framework/isolines.hpp"

namespace beltrami {

struct NodalLines {
    Isolines lines;
    /// Connected sets of vertices on one side of the level, over edges: nodal domains, at most k + 1 of function k
    /// (Courant 1923) where no weight of an edge is negative (Davies, Gladwell, Leydold & Stadler 2001) and the
    /// eigenvalue is simple.
    Index domains = 0;
};

/// Of a function on triangles, one value a vertex. Vertices that are on the level, up to 1e-9 of the largest distance from
/// it, take the side of their neighbours, and triangles of such vertices only, or with a side of them on the boundary,
/// are left out: so held vertices, where a function is 0 without changing its sign, are no line but where lines end, and
/// components that have no part in a function are empty. Vertices in no triangle, and those of triangles left out only,
/// count in no domain. Throws as isolines().
NodalLines nodal_lines(const Mesh& mesh, const Vector& values, double level = 0.0);

}  // namespace beltrami
