// Meshes made by formula, for tests, demos and measurements.
//
// Closed surfaces are oriented outward, flat ones towards +z; tetrahedra have positive volume. What is random
// depends on its seed alone, on every machine. Counts that are too small or give more than 50 million
// vertices, and lengths that are not positive, throw InputError.
//
//     Mesh sphere = shapes::icosphere(5);
//     Mesh named = shapes::from_name("torus:1:0.4:200x80");     // what the program calls
//     shape:torus:1:0.4:200x80
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami::shapes {

/// The icosahedron, each face split in four `levels` times, points pushed to the unit sphere: 10 4^levels + 2 vertices.
Mesh icosphere(int levels, double radius = 1.0);

/// The sphere as two poles and `rings` circles of latitude at equal steps, each of 2 (rings + 1) vertices: the spheres
/// of 6, 14, 26, 42 and 422 vertices of Table 1 of Kim & Rossignac are rings = 1, 2, 3, 4 and 14.
Mesh latlong_sphere(int rings, double radius = 1.0);

/// The icosahedron's or tetrahedron's faces cut in frequency^2 triangles along geodesic arcs: points on two
/// edge arcs by spherical interpolation (Shoemake 1985), the rows between them, seen from the face's first
/// corner, likewise. Table 1 of Kim & Rossignac has the frequencies 1, 3, 5 and 1, 2, 4, 10, 20.
Mesh geodesic_icosahedron(int frequency, double radius = 1.0);
Mesh geodesic_tetrahedron(int frequency, double radius = 1.0);

/// The rectangle [0, width] x [0, height] in z = 0, nx x ny squares, each split by a diagonal (alternating
/// directions when `alternate`).
Mesh grid(int nx, int ny, double width = 1.0, double height = 1.0, bool alternate = false);

/// A flat disc in z = 0: a middle and `rings` circles of 6, 12, 18, ... vertices, 1 + 3 rings (rings + 1) in
/// all.
Mesh disk(int rings, double radius = 1.0);

/// The torus around z with the given radii (minor < major), nu vertices along the large circle and nv along
/// the tube.
Mesh torus(double major_radius, double minor_radius, int nu, int nv);

/// A closed surface of genus `holes`: a slab of (2 holes + 1) x 3 x 1 unit cubes around the origin without
/// every second cube of its middle row, each outer square cut in subdivisions x subdivisions.
Mesh genus(int holes, int subdivisions);

/// An open cylinder around z from z = 0 to height, without caps: nu squares around, nv along.
Mesh cylinder(double radius, double height, int nu, int nv);

/// The unit cube as n^3 little cubes of six tetrahedra (Kuhn 1960); that cube made round, a ball around the
/// origin with no tetrahedron whose corners all lie on the surface (n > 1).
Mesh tetrahedral_cube(int n);
Mesh tetrahedral_ball(int n, double radius = 1.0);

/// A closed polygon of n segments on the circle.
Mesh circle(int n, double radius = 1.0);

/// `fins` (at least three) unit squares of n x n little ones that meet along one straight non-manifold line,
/// x = y = 0.
Mesh fins(int fins, int n);

/// Two icospheres that share one vertex, number 0.
Mesh pinched_spheres(int levels);

/// A sphere of radius about 1 with hills and dents, closed, of exactly that many vertices (at least 100):
/// random places, in some parts ten times as dense as in others, one in 500 so close to another that the
/// triangles there are slivers; triangulated by their convex hull on the sphere, then moved along the radius.
/// Numbered along a Hilbert curve; see shuffled(). It stands for irregular scans: what solvers are measured
/// on.
Mesh bumpy_sphere(Index vertices, std::uint32_t seed = 1);

/// Vertices moved in any direction by at most amount x (mean edge length), evenly in that ball. Throws
/// InputError for a mesh without edges.
Mesh with_noise(const Mesh& mesh, double amount, std::uint32_t seed = 1);

/// Interior vertices of a flat mesh of triangles (z = 0) moved within the plane by at most amount x (mean
/// edge length); boundary vertices stay. Less than a quarter turns no triangle of a grid over.
Mesh jittered(const Mesh& flat, double amount, std::uint32_t seed = 1);

/// Vertices and cells in random order; new_number[v] is where vertex v went.
struct Shuffled {
    Mesh mesh;
    std::vector<Index> new_number;
};
Shuffled shuffled(const Mesh& mesh, std::uint32_t seed = 1);

/// All meshes as one, in order, without joining anything and without their fields. Throws InputError for
/// none, or for cells of different kinds.
Mesh together(const std::vector<Mesh>& meshes);

/// The mesh of a built-in shape's name: the function's name with dashes for underscores (`latlong` for
/// latlong_sphere), then its arguments after colons (`grid:200x100`, `icosphere:5`, `latlong:14`,
/// `torus:1:0.4:200x80`), as list() shows them; those in brackets may be left out. Throws InputError that
/// lists the shapes, or shows the form of that shape.
Mesh from_name(std::string_view name);

/// One line a shape: how to name it and what it is.
std::string list();

}  // namespace beltrami::shapes
