#include "beltrami/framework/read_mesh.hpp"

#include <fmt/format.h>

#include <array>
#include <new>
#include <string_view>
#include <system_error>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/formats/readers.hpp"
#include "beltrami/framework/formats/text_scanner.hpp"

namespace beltrami {

namespace {

struct Format {
    std::string_view ending;
    formats::Contents (*read)(const formats::Source&);
};

constexpr std::array<Format, 9> known_formats{{
    {".obj", formats::read_obj},
    {".off", formats::read_off},
    {".ply", formats::read_ply},
    {".stl", formats::read_stl},
    {".vtk", formats::read_vtk_legacy},
    {".vtu", formats::read_vtk_xml},
    {".vtp", formats::read_vtk_xml},
    {".mesh", formats::read_medit},
    {".xyz", formats::read_xyz},
}};

const Format& format_of(const std::filesystem::path& path) {
    const std::string ending = formats::lower(path.extension().string());
    std::string endings;
    for (const Format& format : known_formats) {
        if (format.ending == ending) return format;
        endings += fmt::format("{}{}", endings.empty() ? "" : ", ", format.ending);
    }
    throw InputError(
        ending.empty() ? fmt::format("{}: the name has no ending, so its format is not known", path.string())
                       : fmt::format("{}: files that end in {} are not read", path.string(), ending),
        fmt::format("give one of {}", endings));
}

}  // namespace

Mesh read_mesh(const std::filesystem::path& path) {
    try {
        // A missing file or a folder is said before an unknown ending.
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(path, ignored)) (void)formats::Source(path);
        const Format& format = format_of(path);
        const formats::Source source(path);
        return to_mesh(source, format.read(source));
    } catch (const std::bad_alloc&) {
        throw InputError(fmt::format("{}: the mesh does not fit into memory", path.string()),
                         "free some memory, or simplify the mesh first");
    }
}

}  // namespace beltrami
