// A region of the mesh, as people name it: a file of vertex numbers, a field that is not zero, a box, everything.
#pragma once

#include "run.hpp"

namespace beltrami::program {

struct RegionOptions {
    std::string file = {};
    std::string field = {};
    std::vector<double> box = {};
    bool all = false;             ///< every vertex
    bool off_boundary = false;    ///< all but those of the boundary
    std::string fourth_way = {};  ///< the option of the command that sets one of these two, for messages
};

/// Declares --region-file, --region-field and --box.
void add_region_options(CLI::App& command, RegionOptions& options);

/// The vertices of the region, in the user's order. The file holds vertex numbers parted by commas, blanks or line
/// ends, and may have a header line and comments (#). Throws InputError unless exactly one way to name it is used, for
/// what is no vertex number, a field that is not there, a box that is none, and a region without vertices.
std::vector<Index> region(const Mesh& mesh, const RegionOptions& options);

}  // namespace beltrami::program
