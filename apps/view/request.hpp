// What a page asks for: a JSON text that is trusted in nothing (page/src/protocol.ts, type Request).
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "beltrami/framework/types.hpp"

namespace beltrami::view {

class Request {
  public:
    /// Throws InputError for what is not a JSON object with a text `do`.
    explicit Request(std::string_view text);

    /// "heat.source".
    [[nodiscard]] const std::string& name() const { return name_; }
    /// The page's own number of it, 0 where it gave none.
    [[nodiscard]] long id() const { return id_; }

    // Each throws InputError that names the key for what is missing, of another type or out of range.
    [[nodiscard]] bool has(const char* key) const { return json_.contains(key); }
    [[nodiscard]] Index integer(const char* key, Index low, Index high) const;
    [[nodiscard]] double number(const char* key, double low, double high) const;
    [[nodiscard]] bool flag(const char* key) const;
    [[nodiscard]] std::string text(const char* key) const;
    /// The number of the word in `words`.
    [[nodiscard]] std::size_t word(const char* key, const std::vector<std::string>& words) const;
    [[nodiscard]] std::vector<Index> vertices(const char* key, Index vertex_count) const;
    /// Finite, between -1e12 and 1e12; `size`: how many there must be.
    [[nodiscard]] std::vector<double> numbers(const char* key, std::size_t size) const;
    /// Nothing for null.
    [[nodiscard]] bool is_null(const char* key) const;
    /// A list of pairs, none for null.
    [[nodiscard]] std::optional<std::vector<std::pair<double, double>>> pairs(const char* key,
                                                                              std::size_t most) const;

  private:
    [[nodiscard]] const nlohmann::json& at(const char* key) const;

    nlohmann::json json_;
    std::string name_;
    long id_ = 0;
};

}  // namespace beltrami::view
