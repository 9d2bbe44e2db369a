// What one run of the viewer holds: the mesh, its operator, the tasks and their results. Pages come and go; the session
// stays, so that a page that is loaded again finds everything. Without an operator the mesh can only be looked at.
//
//     Session session(mesh, report, laplacian, {.argument = "bunny.obj"});
//     Server server(options, live_page(), session.handlers());
//     session.speak_through({[&](ClientId c, Outgoing m) { server.send(c, m); }, [&](Outgoing m) { server.broadcast(m); }});
//     server.run();
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "beltrami/framework/mesh_report.hpp"
#include "beltrami/operators/laplacian.hpp"
#include "server.hpp"

namespace beltrami::view {

struct SessionOptions {
    std::string argument;           ///< MESH, as the user wrote it
    std::filesystem::path scratch;  ///< an existing folder for what is written on the way
    /// Why there is no operator, a sentence.
    std::string why_no_laplacian = "the mesh has no Laplacian";
    /// A message that each page gets after the mesh, such as `shoot`; none where it is empty.
    std::string greeting = {};
    /// For a page's binary message; none are taken where it is empty.
    std::function<void(std::string_view)> binary = {};
    /// Moments of a simulation that are kept; past this every other one is given up.
    std::size_t most_bytes_of_moments = std::size_t{256} << 20U;
};

/// What a server does for a session.
struct Voice {
    std::function<void(ClientId, Outgoing)> send;
    std::function<void(Outgoing)> broadcast;
};

class Session {
  public:
    Session(const Mesh& mesh, const MeshReport& report, const std::optional<Laplacian>& laplacian,
            SessionOptions options);
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;
    /// Ends the solver thread, which may speak until then.
    ~Session();

    [[nodiscard]] ServerHandlers handlers();
    /// Where messages go; before the first page opens. Both are called from several threads.
    void speak_through(Voice voice);

  private:
    class Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace beltrami::view
