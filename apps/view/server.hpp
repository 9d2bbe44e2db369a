// The web server of `beltrami view`: one page, one socket, files made on request; for this machine's user alone.
//
//     Server server(options, page, handlers);         // listens; throws InputError where it cannot
//     fmt::print("{}\n", server.url());                // http://127.0.0.1:40123/1f0c.../
//     server.run();                                    // until stop()
//
// Below the address lie the page itself, `socket` (a WebSocket) and `files/NAME`.
//
// Everything lives below a random token in the address. The page is answered, and the socket opened, only with that
// token, a Host that is this server's, and (for the socket) an Origin that is this server's page: another site in the
// same browser, another user of the machine and a name that is rebound to this address are refused with 403 and a
// line in the log. What comes in is bounded in size, rate, number and time; what goes out is bounded by replacing
// messages that a slow page has not yet taken. A handler that throws closes its connection, never the server.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace beltrami::view {

using ClientId = std::uint64_t;

/// To a page. Bytes are shared among pages, and never copied.
struct Outgoing {
    std::shared_ptr<const std::string> bytes;
    /// Where it is false the bytes must be UTF-8, or browsers close the socket.
    bool binary = false;
    /// A message with the same (not empty) key that is still waiting is replaced by this one, in its place; but no
    /// message overtakes one without a key.
    std::string replaces = {};
};

struct ServerOptions {
    /// An address, or a name of one. 0.0.0.0 and :: are all addresses of this machine.
    std::string host = "127.0.0.1";
    std::uint16_t port = 0;                               ///< 0: any that is free
    std::size_t largest_message = std::size_t{1} << 20U;  ///< bytes, from a page
    std::size_t largest_backlog = std::size_t{1} << 30U;  ///< bytes on the way to one page; more closes it
    /// With the pages. Where there are more, the oldest that has not shown the token gives way.
    int most_connections = 64;
    int most_pages = 8;                  ///< open sockets
    double messages_per_second = 400.0;  ///< of one page, sustained; twice as many at once
    /// For a request to arrive whole, for a connection to ask again, and for each step of taking an answer.
    double request_seconds = 10.0;
    double silent_seconds = 60.0;  ///< a page that answers no ping for so long is closed
    std::function<void(const std::string&)> log =
        {};  ///< a line for each refusal; at most 20 a second are said
};

struct Download {
    std::string type;  ///< "text/csv"
    std::string body;
};

/// Called on the server's thread, which does nothing else meanwhile: they should be quick. Any may be empty.
struct ServerHandlers {
    std::function<void(ClientId)> opened;
    std::function<void(ClientId, std::string_view text)> text;
    /// Where it is empty, binary messages are refused.
    std::function<void(ClientId, std::string_view bytes)> binary = {};
    /// Once for each that was opened, and before run() returns.
    std::function<void(ClientId)> closed;
    /// GET files/NAME; nothing: 404. Names are 1 to 100 of [A-Za-z0-9._-], the first of them no dot.
    std::function<std::optional<Download>(std::string_view name)> file;
};

class Server {
  public:
    /// Throws InputError for a host that is not an address of this machine and for a port that is taken.
    Server(ServerOptions options, std::string page, ServerHandlers handlers);
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;
    /// run() must have returned, or never been called.
    ~Server();

    /// With the token. Where the server listens at all addresses: by the loopback one.
    [[nodiscard]] std::string url() const;
    [[nodiscard]] std::uint16_t port() const;
    /// Whether only this machine can connect.
    [[nodiscard]] bool loopback() const;

    /// From any thread. A client that is gone takes nothing.
    void send(ClientId client, Outgoing message);
    void broadcast(Outgoing message);
    /// Closes one connection with a reason: UTF-8, cut after 123 bytes. What waits for it is dropped.
    void close(ClientId client, const std::string& reason);

    /// Serves until stop(), which may come from any thread (a handler's too) but not from within a signal handler.
    /// Returns within half a second of stop(), whatever the clients do. Runs once.
    void run();
    void stop();

  private:
    class Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace beltrami::view
