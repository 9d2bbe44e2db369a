// Meshes made by formula, for tests, demos and measurements.
//
//     Mesh sphere = shapes::icosphere(5);
//     Mesh named = shapes::from_name("torus:1:0.4:200x80");     // what the program calls shape:torus:1:0.4:200x80
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

/// The icosahedron's or tetrahedron's faces cut in frequency^2 triangles along geodesic arcs: points on two edge arcs
/// by spherical interpolation, the rows between them likewise.
Mesh geodesic_icosahedron(int frequency, double radius = 1.0);
Mesh geodesic_tetrahedron(int frequency, double radius = 1.0);

/// The rectangle [0, width] x [0, height] in z = 0, nx x ny squares, each split by a diagonal (alternating
/// directions when `alternate`).
Mesh grid(int nx, int ny, double width = 1.0, double height = 1.0, bool alternate = false);

/// A flat disc of the unit circle with `rings` rings.
Mesh disk(int rings, double radius = 1.0);

/// The torus around z with the given radii, nu vertices along the large circle and nv along the tube.
Mesh torus(double major_radius, double minor_radius, int nu, int nv);

/// A closed surface of genus g: g square holes in a slab of cubes, `subdivisions` splits of each square.
Mesh genus(int holes, int subdivisions);

/// An open cylinder around z without caps.
Mesh cylinder(double radius, double height, int nu, int nv);

/// The unit cube as n^3 little cubes of six tetrahedra; a ball of tetrahedra (the cube grid mapped to the ball).
Mesh tetrahedral_cube(int n);
Mesh tetrahedral_ball(int n, double radius = 1.0);

/// A closed polygon of n segments on the circle.
Mesh circle(int n, double radius = 1.0);

/// `fins` (at least three) rectangles of n x n squares that meet along one straight non-manifold curve.
Mesh fins(int fins, int n);

/// Two spheres that share one vertex.
Mesh pinched_spheres(int levels);

/// A bumpy sphere of about `vertices` vertices at irregular places, with slivers: what NOTES.md calls irregular. Points
/// from a random process with varying density, triangulated by their convex hull on the sphere, then displaced.
Mesh bumpy_sphere(Index vertices, std::uint32_t seed = 1);

/// Vertices moved by a random vector of at most amount x (mean edge length), along the surface's bounding frame.
Mesh with_noise(const Mesh& mesh, double amount, std::uint32_t seed = 1);

/// Interior vertices of a flat mesh (z = 0) moved within the plane by at most amount x (mean edge length); boundary
/// vertices stay.
Mesh jittered(const Mesh& flat, double amount, std::uint32_t seed = 1);

/// Vertices and cells in random order; new_number[v] is where vertex v went.
struct Shuffled {
    Mesh mesh;
    std::vector<Index> new_number;
};
Shuffled shuffled(const Mesh& mesh, std::uint32_t seed = 1);

/// All meshes as one, in order, without joining anything.
Mesh together(const std::vector<Mesh>& meshes);

/// The mesh of a built-in shape's name: the function's name with dashes for underscores, then its arguments after
/// colons (`grid:200x100`, `icosphere:5`, `latlong:14`, `torus:1:0.4:200x80`). Throws InputError that lists the shapes.
Mesh from_name(std::string_view name);

/// One line a shape: how to call it and what it is.
std::string list();

}  // namespace beltrami::shapes
