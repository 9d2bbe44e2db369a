#include "request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "beltrami/framework/error.hpp"

namespace beltrami::view {

namespace {

constexpr double farthest = 1e12;
constexpr const char* hint = "this is not a request that the page makes; reload it";

InputError not_understood(const std::string& what) {
    return {what, hint};
}

double finite(const nlohmann::json& json, const char* key, double low, double high) {
    if (!json.is_number()) throw not_understood(fmt::format("'{}' is not a number", key));
    const auto value = json.get<double>();
    if (!std::isfinite(value) || value < low || value > high) {
        throw InputError(fmt::format("'{}' is {:g}, which is not within {:g} to {:g}", key, value, low, high),
                         "give a number within the range");
    }
    return value;
}

Index whole(const nlohmann::json& json, const char* key, Index low, Index high) {
    const double value = finite(json, key, low, high);
    if (value != std::floor(value))
        throw not_understood(fmt::format("'{}' is {:g}, not a whole number", key, value));
    return static_cast<Index>(value);
}

}  // namespace

Request::Request(std::string_view text) : json_(nlohmann::json::parse(text, nullptr, false)) {
    if (!json_.is_object()) throw not_understood("a message is not a JSON object");
    const auto name = json_.find("do");
    if (name == json_.end() || !name->is_string()) throw not_understood("a message does not say what to do");
    name_ = name->get<std::string>();
    if (has("id")) id_ = static_cast<long>(finite(at("id"), "id", 0.0, 1e15));
}

const nlohmann::json& Request::at(const char* key) const {
    const auto found = json_.find(key);
    if (found == json_.end()) throw not_understood(fmt::format("'{}' is missing", key));
    return *found;
}

Index Request::integer(const char* key, Index low, Index high) const {
    return whole(at(key), key, low, high);
}

double Request::number(const char* key, double low, double high) const {
    return finite(at(key), key, low, high);
}

bool Request::flag(const char* key) const {
    if (!at(key).is_boolean()) throw not_understood(fmt::format("'{}' is neither true nor false", key));
    return at(key).get<bool>();
}

std::string Request::text(const char* key) const {
    if (!at(key).is_string()) throw not_understood(fmt::format("'{}' is not a text", key));
    return at(key).get<std::string>();
}

std::size_t Request::word(const char* key, const std::vector<std::string>& words) const {
    const auto found = std::find(words.begin(), words.end(), text(key));
    if (found == words.end()) throw not_understood(fmt::format("'{}' is none of the words it can be", key));
    return static_cast<std::size_t>(found - words.begin());
}

std::vector<Index> Request::vertices(const char* key, Index vertex_count) const {
    if (!at(key).is_array()) throw not_understood(fmt::format("'{}' is not a list", key));
    std::vector<Index> list;
    for (const nlohmann::json& item : at(key))
        list.push_back(whole(item, key, 0, vertex_count - 1));
    return list;
}

std::vector<double> Request::numbers(const char* key, std::size_t size) const {
    const nlohmann::json& json = at(key);
    if (!json.is_array() || json.size() != size) {
        throw not_understood(
            fmt::format("'{}' is not a list of {} number{}", key, size, size == 1 ? "" : "s"));
    }
    std::vector<double> list;
    for (const nlohmann::json& item : json)
        list.push_back(finite(item, key, -farthest, farthest));
    return list;
}

bool Request::is_null(const char* key) const {
    return at(key).is_null();
}

std::optional<std::vector<std::pair<double, double>>> Request::pairs(const char* key,
                                                                     std::size_t most) const {
    if (is_null(key)) return std::nullopt;
    const nlohmann::json& json = at(key);
    if (!json.is_array() || json.size() > most)
        throw not_understood(fmt::format("'{}' is not a list of at most {} pairs", key, most));
    std::vector<std::pair<double, double>> list;
    for (const nlohmann::json& item : json) {
        if (!item.is_array() || item.size() != 2)
            throw not_understood(fmt::format("'{}' holds what is no pair", key));
        list.emplace_back(finite(item[0], key, -farthest, farthest),
                          finite(item[1], key, -farthest, farthest));
    }
    return list;
}

}  // namespace beltrami::view
