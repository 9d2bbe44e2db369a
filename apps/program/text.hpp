// Numbers in texts, as people write them.
#pragma once

#include <charconv>
#include <string_view>
#include <system_error>

namespace beltrami::program {

/// Without the blanks at both ends.
inline std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Whether the whole text is a number, but for blanks around it and a sign.
template <class Number>
bool parse(std::string_view text, Number& number) {
    text = trimmed(text);
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

}  // namespace beltrami::program
