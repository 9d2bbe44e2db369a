#include "beltrami/framework/formats/text_scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <system_error>

namespace beltrami::formats {

namespace {

// std::from_chars takes no plus sign.
std::string_view without_plus(std::string_view word) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    return word;
}

// Quotes a word for a message: short, and with nothing a terminal could take amiss.
std::string quoted(std::string_view word) {
    std::string text = "'";
    for (const char c : word.substr(0, 20))
        text += c >= ' ' && c <= '~' ? c : '?';
    return text + (word.size() > 20 ? "...'" : "'");
}

bool is_blank(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

}  // namespace

std::optional<double> parse_number(std::string_view word) {
    word = without_plus(word);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size()) return std::nullopt;
    if (error == std::errc()) return value;
    if (error != std::errc::result_out_of_range) return std::nullopt;
    const auto exponent = word.find_first_of("eE");
    if (exponent != std::string_view::npos && word.substr(exponent + 1).starts_with('-')) return 0.0;
    return std::numeric_limits<double>::infinity();
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
    word = without_plus(word);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size() || error != std::errc()) return std::nullopt;
    return value;
}

std::string lower(std::string_view word) {
    std::string text(word);
    for (char& c : text) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return text;
}

TextScanner::TextScanner(const Source& source, std::string_view text, char comment, std::int64_t first_line)
    : source_(&source), text_(text), line_(first_line), comment_(comment) {
    // The first line end tells the file's kind: a lone CR means that CR ends every line.
    const std::size_t first = text.find_first_of("\r\n");
    const bool lone_cr =
        first != std::string_view::npos && text[first] == '\r' && !text.substr(first).starts_with("\r\n");
    line_end_ = lone_cr ? '\r' : '\n';
}

void TextScanner::skip_to_line_end() {
    cursor_ = std::min(text_.find(line_end_, cursor_), text_.size());
}

void TextScanner::pass_line_end() {
    skip_to_line_end();
    if (at_end()) return;
    ++cursor_;
    ++line_;
}

void TextScanner::skip_blanks() {
    while (!at_end() && text_[cursor_] != line_end_) {
        const char c = text_[cursor_];
        if (is_blank(c)) {
            ++cursor_;
        } else if (comment_ != '\0' && c == comment_) {
            skip_to_line_end();
        } else if (c == '\\') {
            const std::string_view after = text_.substr(cursor_ + 1, 2);
            if (!after.starts_with(line_end_) && after != "\r\n") return;
            pass_line_end();
        } else {
            return;
        }
    }
}

bool TextScanner::next_line() {
    if (started_) pass_line_end();
    started_ = true;
    for (skip_blanks(); !at_end() && text_[cursor_] == line_end_; skip_blanks())
        pass_line_end();
    return !at_end();
}

std::string_view TextScanner::take_word() {
    const std::size_t start = cursor_;
    while (!at_end() && !is_blank(text_[cursor_]))
        ++cursor_;
    return text_.substr(start, cursor_ - start);
}

std::string_view TextScanner::word_on_line() {
    started_ = true;
    skip_blanks();
    return take_word();
}

std::string_view TextScanner::word() {
    started_ = true;
    for (skip_blanks(); !at_end() && text_[cursor_] == line_end_; skip_blanks())
        pass_line_end();
    return take_word();
}

std::string_view TextScanner::rest_of_line() {
    const std::size_t start = cursor_;
    skip_to_line_end();
    std::string_view rest = text_.substr(start, cursor_ - start);
    pass_line_end();
    started_ = false;
    while (!rest.empty() && is_blank(rest.back()))
        rest.remove_suffix(1);
    while (!rest.empty() && is_blank(rest.front()))
        rest.remove_prefix(1);
    return rest;
}

std::string_view TextScanner::bytes_after_line(std::size_t size, const Item& item) {
    pass_line_end();
    return bytes(size, item);
}

std::string_view TextScanner::bytes(std::size_t size, const Item& item) {
    binary_ = true;
    if (size > bytes_left()) fail_end(item);
    const std::string_view taken = text_.substr(cursor_, size);
    cursor_ += size;
    return taken;
}

double TextScanner::to_number(std::string_view word, const Item& item) const {
    const auto value = parse_number(word);
    if (!value) fail(fmt::format("{} has {} where a number is due", describe(item), quoted(word)));
    return *value;
}

double TextScanner::to_finite_number(std::string_view word, const Item& item) const {
    const double value = to_number(word, item);
    if (!std::isfinite(value)) {
        fail(fmt::format("{} has {}, which is not a finite number", describe(item), quoted(word)),
             "remove it or mend its position in the file");
    }
    return value;
}

std::int64_t TextScanner::to_integer(std::string_view word, const Item& item) const {
    const auto value = parse_integer(word);
    if (!value) fail(fmt::format("{} has {} where a whole number is due", describe(item), quoted(word)));
    return *value;
}

void TextScanner::require_room(std::string_view kind, std::int64_t count, std::size_t words) const {
    // A word takes two bytes, but for the last, which no blank need follow.
    source_->require_room(place(), kind, count, 2 * words, bytes_left() + 1);
}

std::string TextScanner::place() const {
    return binary_ ? fmt::format("byte {}", cursor_) : fmt::format("line {}", line_);
}

void TextScanner::fail_end(const Item& item) const {
    fail(fmt::format("the file ends before {} is complete", describe(item)));
}

}  // namespace beltrami::formats
