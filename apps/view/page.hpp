// The page that Node bundled when the program was built: one HTML file without any other.
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

/// A page that holds its data (parcels and JSON texts, see protocol.ts) and uses no network.
std::string self_contained_page(const std::string& title, const std::vector<std::string>& messages);

}  // namespace beltrami::view
