// Words and numbers of a text, with line numbers for messages.
//
// Our own in place of streams: streams obey the user's locale, lose the line number and take ten times as
// long.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "beltrami/framework/formats/source.hpp"

namespace beltrami::formats {

/// nullopt unless all of `word` is a number. "nan" and "inf" are numbers; too small ones are 0, too large
/// ones inf.
std::optional<double> parse_number(std::string_view word);
std::optional<std::int64_t> parse_integer(std::string_view word);

/// Lower case of ASCII letters.
std::string lower(std::string_view word);

/// Cheap to copy: read ahead with a copy. Lines end with LF, CR LF or CR; `comment` (0: none) starts a
/// comment where a word could start; a backslash at a line's end joins the next line.
class TextScanner {
  public:
    explicit TextScanner(const Source& source, char comment = '#')
        : TextScanner(source, source.bytes(), comment) {}
    /// `text` in place of the source's bytes; its first line has number `first_line`.
    TextScanner(const Source& source, std::string_view text, char comment, std::int64_t first_line = 1);

    /// Moves to the start of the next line that holds a word; false at the end.
    bool next_line();
    /// The next word of this line; empty at its end.
    std::string_view word_on_line();
    /// The next word on this line or a later one; empty at the end of the text.
    std::string_view word();
    /// What is left of this line without its end; moves past it.
    std::string_view rest_of_line();
    /// Moves past the end of this line and takes `size` bytes as they are. Places are bytes from then on.
    std::string_view bytes_after_line(std::size_t size, const Item& item);
    std::string_view bytes(std::size_t size, const Item& item);

    /// Fail where the text ends or the word is not a number.
    double number(const Item& item) { return to_number(required(word(), item), item); }
    double finite_number(const Item& item) { return to_finite_number(required(word(), item), item); }
    std::int64_t integer(const Item& item) { return to_integer(required(word(), item), item); }

    [[nodiscard]] double to_number(std::string_view word, const Item& item) const;
    [[nodiscard]] double to_finite_number(std::string_view word, const Item& item) const;
    [[nodiscard]] std::int64_t to_integer(std::string_view word, const Item& item) const;

    /// Fails where the count does not fit the rest of the text: each item has at least `words` words.
    void require_room(std::string_view kind, std::int64_t count, std::size_t words) const;

    /// `vertex` less `first` as an index below `vertex_count`, or an error.
    [[nodiscard]] Index to_vertex(std::int64_t vertex, std::int64_t first, std::int64_t vertex_count,
                                  const Item& item) const {
        if (vertex < first || vertex - first >= vertex_count) {
            source_->fail_vertex(place(), item, vertex, first, vertex_count);
        }
        return static_cast<Index>(vertex - first);
    }

    [[nodiscard]] const Source& source() const { return *source_; }
    [[nodiscard]] std::int64_t line() const { return line_; }
    [[nodiscard]] std::size_t position() const { return cursor_; }
    [[nodiscard]] std::size_t bytes_left() const { return text_.size() - cursor_; }
    [[nodiscard]] std::string place() const;
    [[noreturn]] void fail(std::string_view reason, std::string_view hint = damaged_hint) const {
        source_->fail(place(), reason, hint);
    }
    [[noreturn]] void fail_end(const Item& item) const;

  private:
    /// Past blanks, comments and joined lines, to a word, the end of the line or the end of the text.
    void skip_blanks();
    void skip_to_line_end();
    void pass_line_end();
    [[nodiscard]] bool at_end() const { return cursor_ == text_.size(); }
    std::string_view take_word();
    [[nodiscard]] std::string_view required(std::string_view word, const Item& item) const {
        if (word.empty()) fail_end(item);
        return word;
    }

    const Source* source_;
    std::string_view text_;
    std::size_t cursor_ = 0;
    std::int64_t line_;
    char comment_;
    char line_end_;
    bool started_ = false;
    bool binary_ = false;
};

}  // namespace beltrami::formats
