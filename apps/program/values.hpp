// Values at vertices, as people write them: V=x, V=x,y,z and rows of a CSV file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "beltrami/framework/constraints.hpp"
#include "beltrami/framework/mesh.hpp"

namespace beltrami::program {

/// The constraints of options such as `--fix 12=0.5` and of CSV files with rows `vertex,x[,y,z]`, which may have a
/// header line and comments (#). `columns` 0 means as many as the first value has. Throws InputError that quotes what
/// cannot be understood, names a vertex out of range or given twice with different values, and unequal columns.
Constraints parse_values(const std::string& option, const std::vector<std::string>& arguments,
                         const std::filesystem::path& csv, Index columns, Index vertex_count);

/// The mesh's field of that name, or zeros of `columns` columns where `name` is empty.
Block field_or_zero(const Mesh& mesh, const std::string& name, Index columns);

}  // namespace beltrami::program
