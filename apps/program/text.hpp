// Numbers in texts, as people write them.
#pragma once

#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "beltrami/framework/error.hpp"

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

/// Numbers parted by commas; empty where one of them is not a number.
inline std::vector<double> parse_numbers(std::string_view text) {
    std::vector<double> numbers;
    for (bool more = true; more;) {
        const auto comma = text.find(',');
        more = comma != std::string_view::npos;
        double number = 0.0;
        if (!parse(text.substr(0, comma), number)) return {};
        numbers.push_back(number);
        if (more) text.remove_prefix(comma + 1);
    }
    return numbers;
}

/// line(place, text) for each line of a CSV file that holds something: without blanks around it, comments (#) and a
/// byte-order mark; place is "FILE, line N,". Throws InputError, with the hint, for a file that cannot be read.
template <class Line>
void for_each_line(const std::filesystem::path& path, const std::string& hint, Line line) {
    std::ifstream file(path);
    if (!file || std::filesystem::is_directory(path))
        throw InputError(path.string() + " cannot be read", hint);
    std::string whole;
    for (int number = 1; std::getline(file, whole); ++number) {
        std::string_view text = whole;
        if (number == 1 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
        text = trimmed(text.substr(0, text.find('#')));
        if (!text.empty()) line(path.string() + ", line " + std::to_string(number) + ",", text);
    }
}

}  // namespace beltrami::program
