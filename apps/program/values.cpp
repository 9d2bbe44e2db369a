#include "values.hpp"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "beltrami/framework/error.hpp"
#include "text.hpp"

namespace beltrami::program {

namespace {

class Collector {
  public:
    Collector(Index columns, Index vertex_count) : columns_(columns), vertex_count_(vertex_count) {
        if (columns_ > 0) held_ = Constraints(columns_);
    }

    void add(const std::string& place, Index vertex, const std::vector<double>& value) {
        if (columns_ == 0) {
            columns_ = static_cast<Index>(value.size());
            held_ = Constraints(columns_);
        }
        if (value.size() != static_cast<std::size_t>(columns_)) {
            throw InputError(
                fmt::format("{} gives {} number{}, but {} {} expected", place, value.size(),
                            value.size() == 1 ? "" : "s", columns_, columns_ == 1 ? "is" : "are"),
                "all values, and the field if there is one, must have the same number of columns");
        }
        if (vertex < 0 || vertex >= vertex_count_) {
            throw InputError(fmt::format("{} names vertex {}, but the vertices are 0 to {}", place, vertex,
                                         vertex_count_ - 1),
                             "vertex numbers are those of the file, from 0");
        }
        held_.add(vertex, value);
    }

    Constraints take() { return std::move(held_); }

  private:
    Index columns_;
    Index vertex_count_;
    Constraints held_;
};

void read_csv(const std::filesystem::path& path, Collector& collector) {
    bool any = false;
    bool header = false;  // one line of names may come first
    for_each_line(path, "give a CSV file with rows vertex,x[,y,z]",
                  [&](const std::string& place, std::string_view text) {
                      const auto comma = text.find(',');
                      Index vertex = 0;
                      const bool has_vertex = parse(text.substr(0, comma), vertex);
                      if (!has_vertex && !any && !header) {
                          header = true;
                          return;
                      }
                      const std::vector<double> value = has_vertex && comma != std::string_view::npos
                                                            ? parse_numbers(text.substr(comma + 1))
                                                            : std::vector<double>{};
                      if (value.empty()) {
                          throw InputError(fmt::format("{} is not vertex,x[,y,z]: '{}'", place, text),
                                           "write a vertex number and its values, parted by commas");
                      }
                      collector.add(place, vertex, value);
                      any = true;
                  });
    if (!any) throw InputError(fmt::format("{} holds no values", path.string()), "write rows vertex,x[,y,z]");
}

}  // namespace

Constraints parse_values(const std::string& option, const std::vector<std::string>& arguments,
                         const std::filesystem::path& csv, Index columns, Index vertex_count) {
    Collector collector(columns, vertex_count);
    for (const std::string& argument : arguments) {
        const std::string place = fmt::format("{} {}", option, argument);
        const auto equals = argument.find('=');
        Index vertex = 0;
        const std::vector<double> value = equals != std::string::npos
                                              ? parse_numbers(std::string_view(argument).substr(equals + 1))
                                              : std::vector<double>{};
        if (value.empty() || !parse(std::string_view(argument).substr(0, equals), vertex)) {
            throw InputError(fmt::format("{} cannot be understood", place),
                             fmt::format("write {} VERTEX=NUMBER, such as {} 120=1.5", option, option));
        }
        collector.add(place, vertex, value);
    }
    if (!csv.empty()) read_csv(csv, collector);
    return collector.take();
}

Block field_or_zero(const Mesh& mesh, const std::string& name, Index columns) {
    if (!name.empty()) return mesh.field(name).values;
    return Block::Zero(mesh.vertex_count(), columns);
}

}  // namespace beltrami::program
