// The page that Node bundled when the program was built: one HTML file without any other.
//
//     write_whole("report.html", [&](std::ostream& out) {
//         out << self_contained_page("bunny", {embedded({parcel, true}), embedded({text, false})});
//     });
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace beltrami::view {

/// False where the program was built without Node: there is no viewer and there are no reports.
bool has_page();
/// Throws InputError that says so where there is none; `wanted_by`: the option or command that wants it.
void require_page(std::string_view wanted_by);

/// For the viewer: gets its data through the socket.
std::string live_page();

/// A message of protocol.ts.
struct PageMessage {
    std::string bytes;  ///< a JSON text or a parcel
    bool is_parcel = false;
};

/// The message as an element of a page that holds its data: base64 of the zlib stream of 'T' and the text, or of 'P', three
/// NULs (so that the parcel's arrays start at a multiple of 4) and the parcel. May be called on several threads.
std::string embedded(const PageMessage& message);

/// A page that holds its data, each piece made by embedded(), and uses no network. `title` is plain text.
std::string self_contained_page(std::string_view title, const std::vector<std::string>& embedded_messages);

}  // namespace beltrami::view
