// Command lines for people to copy.
#pragma once

#include <string>
#include <vector>

namespace beltrami::view {

/// A word as a shell reads it back: in quotes where it needs them.
std::string shell_word(const std::string& word);
/// Words with blanks between.
std::string shell_line(const std::vector<std::string>& words);

}  // namespace beltrami::view
