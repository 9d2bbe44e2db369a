// A file's bytes, and the one way in which every reader words its complaints about them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "beltrami/framework/types.hpp"

namespace beltrami::formats {

/// What a reader is at: {"vertex", 56, 100} is "vertex 57 of 100" (index from 0, messages from 1).
struct Item {
    std::string_view kind;
    std::int64_t index;
    std::int64_t total;
};
std::string describe(const Item& item);

inline constexpr std::string_view damaged_hint =
    "the file is damaged or was cut short: export or download it again";

class Source {
  public:
    /// Reads the whole file. Throws InputError where it is missing, a folder, unreadable or empty.
    explicit Source(const std::filesystem::path& path);

    [[nodiscard]] const std::string& name() const { return name_; }
    /// Without a UTF-8 byte order mark.
    [[nodiscard]] std::string_view bytes() const { return view_; }

    /// Throws InputError "NAME, PLACE: REASON"; place may be empty.
    [[noreturn]] void fail(std::string_view place, std::string_view reason,
                           std::string_view hint = damaged_hint) const;

    /// Fails where the file has a zero byte near its start.
    void require_text(std::string_view format) const;

    /// Fails where `count` is negative, exceeds 2^31 - 1, or `count` times `bytes_each` exceeds `bytes_left`:
    /// a header is believed only as far as the file is long, so that a damaged one cannot ask for all memory.
    void require_room(std::string_view place, std::string_view kind, std::int64_t count,
                      std::size_t bytes_each, std::size_t bytes_left) const;

    /// `first` is the number of the first vertex in the format's counting.
    [[noreturn]] void fail_vertex(std::string_view place, const Item& item, std::int64_t vertex,
                                  std::int64_t first, std::int64_t vertex_count) const;

  private:
    std::string name_;
    std::string bytes_;
    std::string_view view_;
};

}  // namespace beltrami::formats
