// Numbers for the page: a JSON header and float32 or uint32 arrays in one piece of bytes (page/src/protocol.ts).
//
//     Parcel parcel({{"kind", "frame"}, {"task", "heat"}});
//     parcel.add("values", values);                      // a Block: rows after each other, as float32
//     const std::string bytes = parcel.bytes();
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "beltrami/framework/types.hpp"

namespace beltrami::view {

class Parcel {
  public:
    explicit Parcel(nlohmann::json header) : header_(std::move(header)) {}

    /// As float32, row after row. Values past float's range become its largest.
    void add(const std::string& name, const Block& values);
    void add(const std::string& name, const Points& points);
    void add(const std::string& name, const Vector& values);
    void add(const std::string& name, std::span<const float> values);
    /// As uint32, row after row.
    void add(const std::string& name, const Cells& cells);
    void add(const std::string& name, std::span<const Index> numbers);

    /// Little-endian, as the page reads it.
    [[nodiscard]] std::string bytes() const;

  private:
    void place(const std::string& name, const char* type, std::size_t count);

    nlohmann::json header_;
    std::string arrays_;
};

/// The numbers of an array that was added as float32.
std::vector<float> floats_of(std::string_view parcel, const std::string& name);

}  // namespace beltrami::view
