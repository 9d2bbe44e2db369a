// Points as text: x y z, or x y z nx ny nz, a line each.
#include <fmt/format.h>

#include <array>

#include "beltrami/framework/formats/readers.hpp"
#include "beltrami/framework/formats/text_scanner.hpp"

namespace beltrami::formats {

Contents read_xyz(const Source& source) {
    source.require_text("an XYZ file");
    TextScanner scanner(source);
    Contents contents;
    std::vector<double> normals;
    std::size_t columns = 0;
    while (scanner.next_line()) {
        const std::int64_t number = contents.vertex_count();
        const Item item{"point", number, number + 1};
        std::array<double, 6> values{};
        std::size_t count = 0;
        for (auto word = scanner.word_on_line(); !word.empty(); word = scanner.word_on_line()) {
            if (count < values.size()) {
                values[count] =
                    count < 3 ? scanner.to_finite_number(word, item) : scanner.to_number(word, item);
            }
            ++count;
        }
        if (columns == 0) columns = count;
        if (count != columns || (count != 3 && count != 6)) {
            scanner.fail(fmt::format("there are {} numbers where {} are due", count,
                                     columns == 3   ? "3"
                                     : columns == 6 ? "6"
                                                    : "3 or 6"),
                         "every line holds x y z, or every line x y z nx ny nz");
        }
        contents.positions.insert(contents.positions.end(), values.begin(), values.begin() + 3);
        if (count == 6) normals.insert(normals.end(), values.begin() + 3, values.end());
    }
    if (!normals.empty()) add_field(contents, "normal", 3, normals);
    return contents;
}

}  // namespace beltrami::formats
