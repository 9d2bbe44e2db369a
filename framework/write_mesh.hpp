// Meshes and fields to files; vertices in the user's order and count.
//
//     write_mesh("out.ply", mesh, {{"value", value}});
//
// | ending | what is written                                                                             |
// | .ply   | binary little-endian; every field as double properties (NAME; NAME_x NAME_y NAME_z of three |
// |        | columns; NAME_0 NAME_1 ... of others), `normal` as nx ny nz, a `color` within [0, 1] as     |
// |        | uchar red green blue; segments as element `edge`, tetrahedra as element `tetrahedron`,      |
// |        | which read_mesh reads and other programs skip or refuse                                     |
// | .vtu   | XML, appended raw binary; every field as a point-data array; opens in ParaView              |
// | .obj   | positions, cells but tetrahedra; a field `color` as `v x y z r g b`; no other fields        |
// | .off   | positions and triangles; no fields                                                          |
//
// Numbers come back from every format as they were, to the last bit; colours in PLY to 1/255. PLY names
// cannot hold blanks, which become _; a name that PLY uses itself (x, red) gets a _ at its end.
//
// A file is written beside its name and renamed when whole: nothing half-written is left under a final name.
// Where the name is a link its target is replaced; a pipe or a device is written to as it is.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string_view>
#include <utility>
#include <vector>

#include "beltrami/framework/mesh.hpp"

namespace beltrami {

/// Writes the mesh, the fields it carries and `fields` (which win where names are equal). Throws InputError
/// for an ending that is not in the table, a folder that does not exist or cannot be written, a full disk, a
/// field that the format cannot hold (only for fields given here; carried ones are left out), cells that it
/// cannot hold, and a value that is not finite.
void write_mesh(const std::filesystem::path& path, const Mesh& mesh, const Fields& fields = {});

/// Throws what write_mesh(path, ...) would throw for the name alone; for programs that check before long work.
void check_writable_mesh(const std::filesystem::path& path);

/// Gives `write` a stream to a file beside `path` and renames it to `path` when `write` returned and everything
/// was written; removes it when `write` throws. Throws InputError where that cannot be done.
void write_whole(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

/// Throws InputError if the folder of `path` does not exist, or `path` is a folder or cannot be written.
void check_writable(const std::filesystem::path& path);

/// A ParaView time series: NAME.pvd and NAME_0000.vtu, NAME_0001.vtu, ... beside it. After every add() the .pvd lists
/// every step written so far, so that a run that is stopped leaves a readable series.
class SeriesWriter {
  public:
    /// Throws InputError unless `path` ends in .pvd and can be written.
    explicit SeriesWriter(std::filesystem::path path);

    void add(double time, const Mesh& mesh, const Fields& fields);

    /// What was written, the .pvd first.
    [[nodiscard]] std::vector<std::filesystem::path> files() const;

  private:
    std::filesystem::path path_;
    std::vector<std::pair<double, std::filesystem::path>> steps_;
};

}  // namespace beltrami
