#include "beltrami/framework/write_mesh.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <locale>
#include <ostream>
#include <pugixml.hpp>
#include <string>
#include <system_error>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/formats/text_scanner.hpp"
#include "beltrami/framework/formats/writers.hpp"

namespace beltrami {

namespace fs = std::filesystem;

namespace {

struct Format {
    std::string_view ending;
    void (*write)(std::ostream&, const Mesh&, const Fields&);
    bool (*holds_cells)(CellKind);
    bool (*holds_field)(const Field&);
    std::string_view fields;  ///< which it holds, for messages
};

constexpr auto any_cells = [](CellKind) { return true; };
constexpr auto any_field = [](const Field&) { return true; };

constexpr std::array<Format, 4> known_formats{{
    {".ply", formats::write_ply, any_cells, any_field, "any field"},
    {".vtu", formats::write_vtu, any_cells, any_field, "any field"},
    {".obj", formats::write_obj, [](CellKind kind) { return kind != CellKind::tetrahedron; },
     formats::is_color, "no field but a 'color' of three columns"},
    {".off", formats::write_off,
     [](CellKind kind) { return kind == CellKind::triangle || kind == CellKind::point; },
     [](const Field&) { return false; }, "no fields"},
}};

const Format& format_of(const fs::path& path) {
    const std::string ending = formats::lower(path.extension().string());
    for (const Format& format : known_formats) {
        if (format.ending == ending) return format;
    }
    throw InputError(
        ending.empty()
            ? fmt::format("{}: the name has no ending, so its format is not known", path.string())
            : fmt::format("{}: meshes are not written to files that end in {}", path.string(), ending),
        "give one of .ply, .vtu, .obj, .off");
}

void check_field(const fs::path& path, const Mesh& mesh, const Field& field) {
    const auto fail = [&](const std::string& reason, const std::string& hint) {
        throw InputError(fmt::format("{}: {}", path.string(), reason), hint);
    };
    if (field.name.empty()) fail("a field has no name", "name it");
    if (field.values.rows() != mesh.vertex_count()) {
        fail(fmt::format("field '{}' has {} values for {} vertices", field.name, field.values.rows(),
                         mesh.vertex_count()),
             "give one row a vertex");
    }
    if (field.values.cols() == 0)
        fail(fmt::format("field '{}' has no columns", field.name), "give at least one");
    for (Eigen::Index v = 0; v < field.values.rows(); ++v) {
        if (field.values.row(v).allFinite()) continue;
        fail(fmt::format("field '{}' has a value at vertex {} that is not a finite number", field.name, v),
             "the computation that made it went wrong, or it has no value there");
    }
}

// The carried fields with the given ones in their places or after them.
Fields merged(const fs::path& path, const Format& format, const Mesh& mesh, const Fields& given) {
    Fields all = mesh.fields();
    const std::size_t carried = all.size();
    std::vector<bool> replaced(carried, false);
    for (const Field& field : given) {
        if (!format.holds_field(field)) {
            throw InputError(fmt::format("{}: field '{}' cannot be written, {} files hold {}", path.string(),
                                         field.name, format.ending, format.fields),
                             "write .ply or .vtu");
        }
        std::size_t at = 0;
        while (at < all.size() && all[at].name != field.name)
            ++at;
        if (at < all.size() && (at >= carried || replaced[at])) {
            throw InputError(fmt::format("{}: two fields are named '{}'", path.string(), field.name),
                             "rename one of them");
        }
        if (at == all.size()) {
            all.push_back(field);
        } else {
            all[at] = field;
            replaced[at] = true;
        }
    }
    for (const Field& field : all)
        check_field(path, mesh, field);
    return all;
}

/// What a name that is a link stands for: the link stays and its target is replaced.
fs::path target_of(const fs::path& path) {
    std::error_code error;
    if (!fs::is_symlink(path, error)) return path;
    const fs::path target = fs::weakly_canonical(path, error);
    return error ? path : target;
}

fs::path folder_of(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// Pipes and devices (/dev/stdout) are written to, not replaced.
bool is_device(const fs::path& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

void write_stream(const fs::path& shown, const fs::path& file,
                  const std::function<void(std::ostream&)>& write) {
    const auto fail = [&](std::string_view what) {
        const std::string why = errno != 0 ? fmt::format(" ({})", std::strerror(errno)) : std::string();
        throw InputError(fmt::format("{}: {}{}", shown.string(), what, why),
                         "check the folder's permissions and the space left on the disk");
    };
    errno = 0;
    std::ofstream stream;
    stream.imbue(std::locale::classic());
    stream.open(file, std::ios::binary | std::ios::trunc);
    if (!stream) fail("the file cannot be opened for writing");
    write(stream);
    stream.close();
    if (!stream) fail("the file could not be written to its end");
}

/// A file that is removed unless it was renamed.
class TemporaryFile {
  public:
    explicit TemporaryFile(const fs::path& target) {
        static std::atomic<unsigned> count{0};
        path_ = folder_of(target) /
                fmt::format(".{}.{}-{}.part", target.filename().string(), ::getpid(), count++);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile() {
        std::error_code ignored;
        if (!path_.empty()) fs::remove(path_, ignored);
    }

    [[nodiscard]] const fs::path& path() const { return path_; }

    /// Replaces the target and takes over its permissions.
    void rename_to(const fs::path& shown, const fs::path& target) {
        std::error_code error;
        const fs::file_status old = fs::status(target, error);
        if (fs::exists(old)) fs::permissions(path_, old.permissions(), error);
        fs::rename(path_, target, error);
        if (error) {
            throw InputError(
                fmt::format("{}: the file cannot be put in place ({})", shown.string(), error.message()),
                "check the permissions of its folder");
        }
        path_.clear();
    }

  private:
    fs::path path_;
};

}  // namespace

void check_writable(const fs::path& path) {
    const auto fail = [&](std::string_view reason, std::string_view hint) {
        throw InputError(fmt::format("{}: {}", path.string(), reason), std::string(hint));
    };
    if (path.filename().empty()) fail("this is not the name of a file", "give a file name");
    const fs::path target = target_of(path);
    std::error_code error;
    const fs::path folder = folder_of(target);
    if (fs::is_directory(target, error)) fail("this is a folder", "give a file name in it");
    if (!fs::exists(folder, error))
        fail(fmt::format("there is no folder {}", folder.string()), "create it first");
    if (!fs::is_directory(folder, error))
        fail(fmt::format("{} is not a folder", folder.string()), "give another name");
    if (fs::exists(target, error) && ::access(target.c_str(), W_OK) != 0) {
        fail("the file is there and may not be overwritten", "change its permissions or give another name");
    }
    if (!is_device(target) && ::access(folder.c_str(), W_OK | X_OK) != 0) {
        fail(fmt::format("the folder {} may not be written to", folder.string()),
             "change its permissions or give another folder");
    }
}

void write_whole(const fs::path& path, const std::function<void(std::ostream&)>& write) {
    check_writable(path);
    const fs::path target = target_of(path);
    if (is_device(target)) return write_stream(path, target, write);
    TemporaryFile temporary(target);
    write_stream(path, temporary.path(), write);
    temporary.rename_to(path, target);
}

void check_writable_mesh(const fs::path& path) {
    (void)format_of(path);
    check_writable(path);
}

void write_mesh(const fs::path& path, const Mesh& mesh, const Fields& fields) {
    const Format& format = format_of(path);
    if (!format.holds_cells(mesh.kind())) {
        throw InputError(
            fmt::format("{}: {} files cannot hold {}", path.string(), format.ending, plural(mesh.kind())),
            "write .vtu or .ply");
    }
    const Fields all = merged(path, format, mesh, fields);
    write_whole(path, [&](std::ostream& stream) { format.write(stream, mesh, all); });
}

SeriesWriter::SeriesWriter(fs::path path) : path_(std::move(path)) {
    if (formats::lower(path_.extension().string()) != ".pvd") {
        throw InputError(fmt::format("{}: a time series' name must end in .pvd", path_.string()),
                         "give a name like out.pvd");
    }
    check_writable(path_);
}

void SeriesWriter::add(double time, const Mesh& mesh, const Fields& fields) {
    if (!std::isfinite(time))
        throw InputError(fmt::format("{}: a step's time is {}", path_.string(), time), "give a finite time");
    fs::path file = path_;
    file.replace_filename(fmt::format("{}_{:04}.vtu", path_.stem().string(), steps_.size()));
    write_mesh(file, mesh, fields);
    steps_.emplace_back(time, std::move(file));

    pugi::xml_document document;
    pugi::xml_node root = document.append_child("VTKFile");
    root.append_attribute("type") = "Collection";
    root.append_attribute("version") = "1.0";
    pugi::xml_node collection = root.append_child("Collection");
    for (const auto& [step_time, step_file] : steps_) {
        pugi::xml_node step = collection.append_child("DataSet");
        step.append_attribute("timestep") = fmt::format("{}", step_time).c_str();
        step.append_attribute("file") = step_file.filename().c_str();
    }
    write_whole(path_, [&](std::ostream& stream) { document.save(stream, " "); });
}

std::vector<fs::path> SeriesWriter::files() const {
    std::vector<fs::path> files{path_};
    for (const auto& [time, file] : steps_)
        files.push_back(file);
    return files;
}

}  // namespace beltrami
