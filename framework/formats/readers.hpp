// One reader a format; read_mesh() chooses by the file's ending. Each throws InputError by source.fail().
#pragma once

#include "beltrami/framework/formats/contents.hpp"
#include "beltrami/framework/formats/source.hpp"

namespace beltrami::formats {

Contents read_obj(const Source& source);
Contents read_off(const Source& source);
Contents read_ply(const Source& source);
Contents read_stl(const Source& source);
Contents read_vtk_legacy(const Source& source);
Contents read_vtk_xml(const Source& source);
Contents read_medit(const Source& source);
Contents read_xyz(const Source& source);

}  // namespace beltrami::formats
