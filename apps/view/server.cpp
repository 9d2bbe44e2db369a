// One thread runs the io_context and alone touches what is below; other threads only post to it.
//
// A connection begins as a Visit, which answers requests one after the other, and may become a Page, which is an open
// socket. Both are kept by the server's list and by the operations that are under way, and leave the list in end().
#include "server.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/span_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <limits>
#include <list>
#include <map>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

#include "beltrami/framework/error.hpp"

namespace beltrami::view {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using namespace std::chrono_literals;

namespace {

// The executor by its type: Asio's default erases it, at an allocation for every operation.
using Executor = asio::io_context::executor_type;
using Protocol = asio::ip::tcp;
using Socket = asio::basic_stream_socket<Protocol, Executor>;
using Acceptor = asio::basic_socket_acceptor<Protocol, Executor>;
using Clock = std::chrono::steady_clock;
using Timer = asio::basic_waitable_timer<Clock, asio::wait_traits<Clock>, Executor>;
using Stream = beast::basic_stream<Protocol, Executor>;
using WebSocket = websocket::stream<Stream, false>;  // false: no compression, so no bombs
using Request = http::request<http::empty_body>;
using Bytes = std::shared_ptr<const std::string>;

constexpr std::uint32_t largest_header = 8192;
// Between frames of a large message pings and a close find their way.
constexpr std::size_t largest_frame = std::size_t{1} << 20U;
// How long a page may take to answer a close, and all of them after stop().
constexpr auto close_time = 2s;
constexpr auto stop_time = 250ms;
// How long and how much a refused client may go on talking: an answer is lost where its connection is closed over
// bytes that nobody read.
constexpr auto linger_time = 2s;
constexpr std::size_t linger_bytes = std::size_t{1} << 18U;

Clock::duration duration(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

std::string_view view_of(beast::string_view text) {
    return {text.data(), text.size()};
}

Bytes sentence(std::string text) {
    return std::make_shared<const std::string>(std::move(text) + "\n");
}

std::string random_token() {
    std::array<unsigned char, 16> bytes{};
    if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
        throw InputError("this system gives no random numbers, and the server must not run without",
                         "look at getrandom(2)");
    }
    std::string token;
    for (const unsigned char byte : bytes)
        token += fmt::format("{:02x}", byte);
    return token;
}

/// In a time that does not tell how much of it is right.
bool same_secret(std::string_view left, std::string_view right) {
    if (left.size() != right.size()) return false;
    volatile unsigned char difference = 0;
    for (std::size_t i = 0; i < left.size(); ++i)
        difference = difference | static_cast<unsigned char>(left[i] ^ right[i]);
    return difference == 0;
}

bool is_file_name(std::string_view name) {
    const auto allowed = [](char letter) {
        return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
               (letter >= '0' && letter <= '9') || letter == '.' || letter == '_' || letter == '-';
    };
    return !name.empty() && name.size() <= 100 && name.front() != '.' &&
           std::all_of(name.begin(), name.end(), allowed);
}

std::string in_url(const asio::ip::address& address) {
    if (address.is_v4()) return address.to_string();
    asio::ip::address_v6 without_scope = address.to_v6();
    without_scope.scope_id(0);
    return "[" + without_scope.to_string() + "]";
}

asio::ip::address address_of(asio::io_context& context, const std::string& host) {
    beast::error_code error;
    asio::ip::address literal = asio::ip::make_address(host, error);
    if (!error) return literal;
    Protocol::resolver resolver(context);
    const auto found = resolver.resolve(host, "", error);
    if (host.empty() || error || found.empty()) {
        throw InputError("the host \"" + host + "\" has no address",
                         "give an address of this machine, such as 127.0.0.1");
    }
    // Browsers try a name's IPv4 address too, and older tools nothing else.
    for (const auto& entry : found) {
        if (entry.endpoint().address().is_v4()) return entry.endpoint().address();
    }
    return found.begin()->endpoint().address();
}

/// The Host headers of a server at an address, without the port; none for all addresses.
std::vector<std::string> host_names(const asio::ip::address& address) {
    if (address.is_unspecified()) return {};
    std::vector<std::string> names = {in_url(address)};
    if (address == asio::ip::address_v4::loopback() || address == asio::ip::address_v6::loopback())
        names.emplace_back("localhost");
    return names;
}

void keep_from_children(int descriptor) {
    fcntl(descriptor, F_SETFD, FD_CLOEXEC);
}

/// The most that a close frame holds, not cut within a character.
std::string_view close_text(std::string_view text) {
    std::size_t size = std::min<std::size_t>(text.size(), 123);
    while (size > 0 && size < text.size() && (static_cast<unsigned char>(text[size]) & 0xc0U) == 0x80U)
        --size;
    return text.substr(0, size);
}

// At most 20 lines a second, and how many more there would have been.
class Log {
  public:
    Log(asio::io_context& context, std::function<void(const std::string&)> sink)
        : sink_(std::move(sink)), timer_(context) {}

    void say(const std::string& line) {
        if (!sink_) return;
        if (Clock::now() >= second_ + 1s) next_second();
        if (said_ < 20) {
            ++said_;
            pass_on(line);
        } else if (++left_out_ == 1) {
            timer_.expires_at(second_ + 1s);
            timer_.async_wait([this](beast::error_code cancelled) {
                if (!cancelled) next_second();
            });
        }
    }

    void next_second() {
        second_ = Clock::now();
        said_ = left_out_ > 0 ? 1 : 0;
        if (left_out_ > 0) pass_on(fmt::format("{} more lines are left out", std::exchange(left_out_, 0)));
        timer_.cancel();
    }

  private:
    void pass_on(const std::string& line) const {
        try {
            sink_(line);
        } catch (...) {
            // There is nowhere to say that nothing can be said.
        }
    }

    std::function<void(const std::string&)> sink_;
    Timer timer_;
    Clock::time_point second_ = {};
    int said_ = 0;
    long left_out_ = 0;
};

// So many a second, and twice as many at once.
class Allowance {
  public:
    explicit Allowance(double per_second) : per_second_(per_second), left_(2.0 * per_second) {}

    bool take() {
        const Clock::time_point now = Clock::now();
        const double seconds = std::chrono::duration<double>(now - last_).count();
        last_ = now;
        left_ = std::min(2.0 * per_second_, left_ + per_second_ * seconds);
        if (left_ < 1.0) return false;
        left_ -= 1.0;
        return true;
    }

  private:
    double per_second_;
    double left_;
    Clock::time_point last_ = Clock::now();
};

// What waits, in the order in which it goes on. An item with a key replaces the one with the same key.
template <class Item>
class Queue {
  public:
    void push(Item item, const std::string& key, std::size_t bytes) {
        const std::uint64_t turn = ++turns_;
        if (key.empty()) {
            last_plain_ = turn;
        } else if (const auto known = by_key_.find(key); known != by_key_.end()) {
            const auto old = known->second;
            bytes_ -= old->bytes;
            if (old->turn > last_plain_) {
                // In its place: where keys are renewed faster than they go on, each still has its turn.
                bytes_ += bytes;
                old->item = std::move(item);
                old->bytes = bytes;
                return;
            }
            by_key_.erase(known);
            waiting_.erase(old);
        }
        bytes_ += bytes;
        waiting_.push_back({std::move(item), key, bytes, turn});
        if (!key.empty()) by_key_.emplace(key, std::prev(waiting_.end()));
    }

    Item pop() {
        Waiting first = std::move(waiting_.front());
        waiting_.pop_front();
        bytes_ -= first.bytes;
        if (!first.key.empty()) by_key_.erase(first.key);
        return std::move(first.item);
    }

    [[nodiscard]] bool empty() const { return waiting_.empty(); }
    [[nodiscard]] std::size_t bytes() const { return bytes_; }

  private:
    struct Waiting {
        Item item;
        std::string key;
        std::size_t bytes;
        std::uint64_t turn;
    };

    std::list<Waiting> waiting_;
    std::unordered_map<std::string, typename std::list<Waiting>::iterator> by_key_;
    std::size_t bytes_ = 0;
    std::uint64_t turns_ = 0;
    std::uint64_t last_plain_ = 0;
};

struct Answer {
    http::status status;
    Bytes body;
    std::string type = "text/plain; charset=utf-8";
    std::vector<std::pair<http::field, std::string>> headers = {};
};

}  // namespace

class Server::Implementation {
  public:
    Implementation(ServerOptions options, std::string page, ServerHandlers handlers);

    [[nodiscard]] std::string url() const;
    [[nodiscard]] const Protocol::endpoint& endpoint() const { return endpoint_; }

    void run();
    /// From any thread: the server's does it.
    template <class Task>
    void post(Task task) {
        if (!over_) asio::post(context_, std::move(task));
    }
    void send(std::optional<ClientId> to, Outgoing message);
    void close(ClientId client, const std::string& reason);
    void stop();

  private:
    struct Letter {
        std::optional<ClientId> to;  // nobody: all
        Outgoing message;
    };

    class Connection;
    class Visit;
    class Page;

    void accept();
    void admit(Socket socket);
    bool make_room();
    void deliver();
    void forget(ClientId client);
    void finish();
    std::vector<std::shared_ptr<Connection>> all_connections() const;

    [[nodiscard]] bool is_ours(std::string_view host) const;
    /// Why a request does not come from this server's page or its user; empty: it does.
    [[nodiscard]] std::string objection(const Request& request) const;
    /// What a client said, for the log: without the token, control characters or great length.
    [[nodiscard]] std::string shown(std::string_view from_client) const;

    // The context is destroyed last: the operations that it still holds keep connections.
    asio::io_context context_{1};
    ServerOptions options_;
    Bytes page_;
    ServerHandlers handlers_;
    std::string token_ = random_token();
    Log log_;
    Acceptor acceptor_;
    Protocol::endpoint endpoint_;
    std::vector<std::string> hosts_;
    Timer pause_;
    Timer grace_;
    std::map<ClientId, std::shared_ptr<Connection>> connections_;  // the oldest first
    std::map<ClientId, std::shared_ptr<Page>> pages_;
    ClientId last_client_ = 0;
    bool stopping_ = false;
    std::atomic<bool> over_ = false;
    // From other threads, which may send faster than this one takes: here too a message replaces an older one.
    std::mutex inbox_mutex_;
    Queue<Letter> inbox_;
};

// --- Connections ----------------------------------------------------------------------------------------------------

class Server::Implementation::Connection : public std::enable_shared_from_this<Connection> {
  public:
    Connection(Implementation& server, ClientId id, std::string peer)
        : server_(server), id_(id), peer_(std::move(peer)) {}
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;
    virtual ~Connection() = default;

    /// Closes the socket at once and leaves the server's list.
    virtual void end() = 0;
    /// Ends as politely as a moment allows.
    virtual void leave() = 0;
    /// Whether it has shown the token.
    [[nodiscard]] virtual bool trusted() const = 0;
    [[nodiscard]] const std::string& peer() const { return peer_; }

  protected:
    void log(const std::string& what) { server_.log_.say(peer_ + ": " + what); }

    /// What throws ends its connection and nothing else.
    template <class Step>
    void attempt(Step step) {
        try {
            step();
        } catch (const std::exception& error) {
            log("closed, after " + server_.shown(error.what()));
            end();
        } catch (...) {
            log("closed, after an exception");
            end();
        }
    }

    Implementation& server_;
    ClientId id_;
    std::string peer_;
    bool ended_ = false;
};

// Answers requests, one after the other.
class Server::Implementation::Visit final : public Connection {
  public:
    Visit(Implementation& server, ClientId id, std::string peer, Socket socket)
        : Connection(server, id, std::move(peer)), stream_(std::move(socket)) {}

    void read();
    void end() override;
    void leave() override { end(); }
    [[nodiscard]] bool trusted() const override { return trusted_; }

  private:
    void on_read(beast::error_code error);
    void route(const Request& request);
    void answer_file(const std::string& name);
    void open_page(const Request& request);
    void answer(Answer answer, bool close = false);
    void refuse(http::status status, const std::string& what, const std::string& for_log);
    void write();
    void on_written(beast::error_code error);
    void linger();
    std::shared_ptr<Visit> self() { return std::static_pointer_cast<Visit>(shared_from_this()); }

    Stream stream_;
    beast::flat_buffer buffer_{std::size_t{2} * largest_header};
    std::optional<http::request_parser<http::empty_body>> parser_;
    Bytes body_;
    std::optional<http::response<http::span_body<const char>>> response_;
    std::optional<http::response_serializer<http::span_body<const char>>> serializer_;
    std::array<char, 4096> unread_{};
    std::size_t unread_bytes_ = 0;
    bool trusted_ = false;
    bool lingers_ = false;
};

// An open socket.
class Server::Implementation::Page final : public Connection {
  public:
    Page(Implementation& server, ClientId id, std::string peer, Stream stream)
        : Connection(server, id, std::move(peer)),
          socket_(std::move(stream)),
          deadline_(server.context_),
          allowance_(server.options_.messages_per_second) {}

    void open(const Request& request);
    void send(const Outgoing& message);
    void close(websocket::close_code code, std::string_view reason);
    void end() override;
    void leave() override;
    [[nodiscard]] bool trusted() const override { return true; }

  private:
    void read();
    void on_read(beast::error_code error);
    void fail(beast::error_code error);
    template <class Handler>
    void call(Handler handler);
    void hand_over();
    void write();
    void on_written(beast::error_code error);
    void too_fast();
    std::shared_ptr<Page> self() { return std::static_pointer_cast<Page>(shared_from_this()); }

    WebSocket socket_;
    Timer deadline_;
    Allowance allowance_;
    beast::flat_buffer buffer_;
    Queue<Outgoing> queue_;
    std::optional<Outgoing> in_flight_;
    bool opened_ = false;
    bool closing_ = false;
};

// --- Visits ---------------------------------------------------------------------------------------------------------

void Server::Implementation::Visit::read() {
    parser_.emplace();
    parser_->header_limit(largest_header);
    // Bodies are refused by route(), which knows better what to say. (No limit at all is read as 0 here by Beast 1.74.)
    parser_->body_limit(std::numeric_limits<std::uint64_t>::max());
    // For all of the request: a client that sends a byte now and then does not move it.
    stream_.expires_after(duration(server_.options_.request_seconds));
    http::async_read_header(stream_, buffer_, *parser_,
                            [self = self()](beast::error_code error, std::size_t) {
                                self->attempt([&] { self->on_read(error); });
                            });
}

void Server::Implementation::Visit::on_read(beast::error_code error) {
    if (ended_) return;
    if (!error) {
        route(parser_->get());
    } else if (error == http::error::header_limit || error == http::error::buffer_overflow) {
        refuse(http::status::request_header_fields_too_large, "the request is too long",
               fmt::format("a request of more than {} bytes", largest_header));
    } else if (error == http::error::end_of_stream || error == http::error::partial_message) {
        end();
    } else if (error.category() == http::make_error_code(http::error::bad_method).category()) {
        refuse(http::status::bad_request, "this is not HTTP", "what is not HTTP: " + error.message());
    } else {
        // Silence between two requests is how connections end.
        if (error == beast::error::timeout && (parser_->got_some() || buffer_.size() > 0))
            log(fmt::format("closed, for a request that is not whole after {:.3g} s",
                            server_.options_.request_seconds));
        end();
    }
}

void Server::Implementation::Visit::route(const Request& request) {
    const std::string_view target = view_of(request.target());
    const std::string_view path = target.substr(0, target.find('?'));
    if (const std::string objection = server_.objection(request); !objection.empty())
        return refuse(http::status::forbidden, objection, objection);
    // Browsers ask for it without being told to.
    if (path == "/favicon.ico") return answer({http::status::no_content, nullptr}, true);

    const std::size_t slash = path.find('/', 1);
    const std::string_view token = path.substr(std::min<std::size_t>(1, path.size()), slash - 1);
    if (!path.starts_with('/') || !same_secret(token, server_.token_)) {
        return refuse(http::status::forbidden, "open the whole address that `beltrami view` printed",
                      token.empty() ? "a request without the token" : "a wrong token");
    }
    trusted_ = true;
    const bool whole = parser_->is_done();
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
        return answer({.status = http::status::method_not_allowed,
                       .body = sentence("only GET and HEAD are answered"),
                       .headers = {{http::field::allow, "GET, HEAD"}}},
                      !whole);
    }
    if (!whole)
        return answer({http::status::payload_too_large, sentence("requests have no body here")}, true);

    const std::string_view rest = slash == std::string_view::npos ? std::string_view{} : path.substr(slash);
    constexpr std::string_view files = "/files/";
    if (rest == "/") return answer({http::status::ok, server_.page_, "text/html; charset=utf-8"});
    if (rest == "/socket") return open_page(request);
    if (rest == "/icon") return answer({http::status::no_content, nullptr});
    if (rest.empty()) {
        return answer({.status = http::status::moved_permanently,
                       .body = sentence("the address ends in a slash"),
                       .headers = {{http::field::location, "/" + server_.token_ + "/"}}});
    }
    if (rest.starts_with(files) && is_file_name(rest.substr(files.size())))
        return answer_file(std::string(rest.substr(files.size())));
    answer({http::status::not_found, sentence("there is nothing of this name")});
}

void Server::Implementation::Visit::answer_file(const std::string& name) {
    std::optional<Download> file;
    try {
        if (server_.handlers_.file) file = server_.handlers_.file(name);
    } catch (const std::exception& error) {
        log(fmt::format("no file {}: {}", name, server_.shown(error.what())));
        return answer({http::status::internal_server_error, sentence("this file could not be made")}, true);
    }
    if (!file) return answer({http::status::not_found, sentence("there is no such file")});
    answer({.status = http::status::ok,
            .body = std::make_shared<const std::string>(std::move(file->body)),
            .type = file->type,
            .headers = {{http::field::content_disposition, "attachment; filename=\"" + name + "\""}}});
}

void Server::Implementation::Visit::open_page(const Request& request) {
    if (!websocket::is_upgrade(request)) {
        return answer({.status = http::status::upgrade_required,
                       .body = sentence("this is the address of a WebSocket"),
                       .headers = {{http::field::upgrade, "websocket"}}},
                      true);
    }
    if (request.count(http::field::origin) == 0) {
        return refuse(http::status::forbidden, "only this server's page opens the socket",
                      "a socket without an Origin");
    }
    // Beast would lose them, and no browser speaks before it is answered.
    if (buffer_.size() > 0)
        return refuse(http::status::bad_request, "wait for the answer", "frames before the socket was open");
    if (static_cast<int>(server_.pages_.size()) >= server_.options_.most_pages) {
        const std::string full =
            fmt::format("{} pages are open, and no more are served", server_.pages_.size());
        return refuse(http::status::service_unavailable, full, full);
    }
    stream_.expires_never();  // the page's socket has timeouts of its own
    const auto page = std::make_shared<Page>(server_, id_, peer_, std::move(stream_));
    ended_ = true;
    server_.pages_[id_] = page;
    server_.connections_[id_] = page;
    page->open(request);
}

void Server::Implementation::Visit::refuse(http::status status, const std::string& what,
                                           const std::string& for_log) {
    log("refused, for " + for_log);
    answer({status, sentence(what)}, true);
}

void Server::Implementation::Visit::answer(Answer answer, bool close) {
    const Request& request = parser_->get();
    body_ = answer.body ? std::move(answer.body) : std::make_shared<const std::string>();
    response_.emplace();
    response_->version(request.version() == 10 ? 10 : 11);
    response_->result(answer.status);
    response_->keep_alive(request.keep_alive() && !close);
    response_->set(http::field::cache_control, "no-store");
    response_->set("Referrer-Policy", "no-referrer");
    response_->set("X-Content-Type-Options", "nosniff");
    response_->set("X-Frame-Options", "DENY");
    response_->set("Cross-Origin-Opener-Policy", "same-origin");
    response_->set("Cross-Origin-Resource-Policy", "same-origin");
    for (const auto& [field, value] : answer.headers)
        response_->set(field, value);
    if (answer.status != http::status::no_content) response_->set(http::field::content_type, answer.type);
    response_->body() = {body_->data(), body_->size()};
    response_->prepare_payload();
    serializer_.emplace(*response_);
    serializer_->split(request.method() == http::verb::head);  // the header goes alone
    write();
}

void Server::Implementation::Visit::write() {
    // For each step: a large file takes as long as it takes, as long as somebody takes it.
    stream_.expires_after(duration(server_.options_.request_seconds));
    http::async_write_some(stream_, *serializer_, [self = self()](beast::error_code error, std::size_t) {
        self->attempt([&] { self->on_written(error); });
    });
}

void Server::Implementation::Visit::on_written(beast::error_code error) {
    if (ended_) return;
    if (error) return end();
    if (!(serializer_->split() ? serializer_->is_header_done() : serializer_->is_done())) return write();
    const bool more = response_->keep_alive();
    serializer_.reset();
    response_.reset();
    body_.reset();
    more ? read() : linger();
}

void Server::Implementation::Visit::linger() {
    if (!std::exchange(lingers_, true)) {
        beast::error_code ignored;
        stream_.socket().shutdown(Socket::shutdown_send, ignored);
        stream_.expires_after(linger_time);
    }
    stream_.async_read_some(asio::buffer(unread_),
                            [self = self()](beast::error_code error, std::size_t bytes) {
                                self->attempt([&] {
                                    if (self->ended_) return;
                                    self->unread_bytes_ += bytes;
                                    if (error || self->unread_bytes_ > linger_bytes) return self->end();
                                    self->linger();
                                });
                            });
}

void Server::Implementation::Visit::end() {
    if (std::exchange(ended_, true)) return;
    stream_.close();
    server_.forget(id_);
}

// --- Pages ----------------------------------------------------------------------------------------------------------

void Server::Implementation::Page::open(const Request& request) {
    const ServerOptions& options = server_.options_;
    socket_.set_option(websocket::stream_base::timeout{duration(options.request_seconds),
                                                       duration(options.silent_seconds), true});
    socket_.read_message_max(options.largest_message);
    socket_.auto_fragment(true);
    socket_.write_buffer_bytes(largest_frame);
    // Pings cost an answer each, so they count as messages. Beast calls this within a read, which must not be closed
    // from here.
    socket_.control_callback([this](websocket::frame_type kind, beast::string_view) {
        if (kind == websocket::frame_type::close || allowance_.take()) return;
        server_.post([self = self()] { self->attempt([&] { self->too_fast(); }); });
    });
    socket_.async_accept(request, [self = self()](beast::error_code error) {
        self->attempt([&] {
            if (self->ended_) return;
            if (error) {
                self->log("refused, for what is no WebSocket: " + error.message());
                return self->end();
            }
            if (self->closing_) return self->end();
            self->opened_ = true;
            if (self->server_.handlers_.opened)
                self->call([&] { self->server_.handlers_.opened(self->id_); });
            if (!self->closing_) self->read();
        });
    });
}

void Server::Implementation::Page::read() {
    socket_.async_read(buffer_, [self = self()](beast::error_code error, std::size_t) {
        self->attempt([&] { self->on_read(error); });
    });
}

void Server::Implementation::Page::on_read(beast::error_code error) {
    if (ended_) return;
    if (error) return fail(error);
    // Closing reads for itself.
    if (closing_) return;
    if (!allowance_.take()) return too_fast();
    hand_over();
    if (!ended_ && !closing_) read();
}

void Server::Implementation::Page::fail(beast::error_code error) {
    // Protocol errors: Beast has told the page, with the code that fits.
    const bool protocol = error.category() == websocket::make_error_code(websocket::error::closed).category();
    if (!closing_ && error == beast::error::timeout) {
        log(fmt::format("closed, for a page that was silent for {:.3g} s", server_.options_.silent_seconds));
    } else if (!closing_ && protocol && error != websocket::error::closed) {
        log("closed, for a message that is none: " + error.message());
    }
    end();
}

template <class Handler>
void Server::Implementation::Page::call(Handler handler) {
    std::string why;
    try {
        return handler();
    } catch (const std::exception& thrown) {
        why = ": " + server_.shown(thrown.what());
    } catch (...) {
    }
    log("closed, for a handler that failed" + why);
    close(websocket::close_code::internal_error, "the server failed at this");
}

void Server::Implementation::Page::hand_over() {
    const auto data = buffer_.data();
    const std::string_view message(static_cast<const char*>(data.data()), data.size());
    const ServerHandlers& handlers = server_.handlers_;
    const auto& handler = socket_.got_text() ? handlers.text : handlers.binary;
    if (handler) {
        call([&] { handler(id_, message); });
    } else {
        log("closed, for a message of a kind that is not taken");
        close(websocket::close_code::unknown_data, "messages of this kind are not taken");
    }
    buffer_.consume(buffer_.size());
}

void Server::Implementation::Page::too_fast() {
    if (ended_ || closing_) return;
    log(fmt::format("closed, for more than {:.4g} messages a second", server_.options_.messages_per_second));
    close(websocket::close_code::policy_error, "too many messages");
}

void Server::Implementation::Page::send(const Outgoing& message) {
    if (ended_ || closing_ || !opened_) return;
    attempt([&] {
        queue_.push(message, message.replaces, message.bytes->size());
        const std::size_t backlog = queue_.bytes() + (in_flight_ ? in_flight_->bytes->size() : 0);
        if (backlog > server_.options_.largest_backlog) {
            log(fmt::format("closed, for {} bytes that the page does not take", backlog));
            return close(websocket::close_code::try_again_later, "this page takes its messages too slowly");
        }
        write();
    });
}

void Server::Implementation::Page::write() {
    if (in_flight_ || queue_.empty() || closing_) return;
    in_flight_ = queue_.pop();
    socket_.binary(in_flight_->binary);
    const asio::const_buffer bytes = asio::buffer(*in_flight_->bytes);
    socket_.async_write(bytes, [self = self()](beast::error_code error, std::size_t) {
        self->attempt([&] { self->on_written(error); });
    });
}

void Server::Implementation::Page::on_written(beast::error_code error) {
    in_flight_.reset();
    if (ended_ || closing_) return;
    // The read found an error, and is telling the page.
    if (error == asio::error::operation_aborted) return;
    if (error) return fail(error);
    write();
}

void Server::Implementation::Page::close(websocket::close_code code, std::string_view reason) {
    if (ended_ || std::exchange(closing_, true)) return;
    queue_ = {};
    // The answer to the handshake is still on its way: the connection ends after it.
    if (!opened_) return;
    // A page that takes nothing cannot be told, and one that sends without end does not listen.
    deadline_.expires_after(close_time);
    deadline_.async_wait([self = self()](beast::error_code cancelled) {
        if (!cancelled) self->attempt([&] { self->end(); });
    });
    const std::string_view text = close_text(reason);
    socket_.async_close({code, {text.data(), text.size()}},
                        [self = self()](beast::error_code) { self->attempt([&] { self->end(); }); });
}

void Server::Implementation::Page::leave() {
    close(websocket::close_code::going_away, "the server has stopped");
}

void Server::Implementation::Page::end() {
    if (std::exchange(ended_, true)) return;
    deadline_.cancel();
    queue_ = {};
    beast::get_lowest_layer(socket_).close();
    server_.pages_.erase(id_);
    server_.forget(id_);
    if (!opened_ || !server_.handlers_.closed) return;
    try {
        server_.handlers_.closed(id_);
    } catch (const std::exception& error) {
        log("a page that closed: " + server_.shown(error.what()));
    } catch (...) {
        log("a page that closed: an exception");
    }
}

// --- The server -----------------------------------------------------------------------------------------------------

Server::Implementation::Implementation(ServerOptions options, std::string page, ServerHandlers handlers)
    : options_(std::move(options)),
      page_(std::make_shared<const std::string>(std::move(page))),
      handlers_(std::move(handlers)),
      log_(context_, options_.log),
      acceptor_(context_),
      pause_(context_),
      grace_(context_) {
    const asio::ip::address address = address_of(context_, options_.host);
    const Protocol::endpoint wanted(address, options_.port);
    beast::error_code error;
    acceptor_.open(wanted.protocol(), error);
    if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor_.bind(wanted, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (!error) endpoint_ = acceptor_.local_endpoint(error);
    if (error == asio::error::address_in_use) {
        throw InputError(fmt::format("port {} of {} is taken", options_.port, options_.host),
                         "choose another port, or none: then one is found that is free");
    }
    if (error == asio::error::access_denied) {
        throw InputError(fmt::format("port {} of {} is not open to this user", options_.port, options_.host),
                         "choose a port from 1024 upwards, or none: then one is found that is free");
    }
    if (error) {
        throw InputError(fmt::format("no server can listen at {}: {}", options_.host, error.message()),
                         "give an address of this machine, such as 127.0.0.1");
    }
    // A browser that the program starts must not inherit the port.
    keep_from_children(acceptor_.native_handle());
    hosts_ = host_names(address);
}

std::string Server::Implementation::url() const {
    asio::ip::address address = endpoint_.address();
    if (address.is_unspecified()) {
        if (address.is_v4()) {
            address = asio::ip::address_v4::loopback();
        } else {
            address = asio::ip::address_v6::loopback();
        }
    }
    return fmt::format("http://{}:{}/{}/", in_url(address), endpoint_.port(), token_);
}

void Server::Implementation::run() {
    if (over_) return;
    accept();
    for (;;) {
        try {
            context_.run();
            return;
        } catch (const std::exception& error) {
            log_.say("went on, after " + shown(error.what()));
        }
    }
}

void Server::Implementation::accept() {
    acceptor_.async_accept([this](beast::error_code error, Socket socket) {
        if (stopping_) return;
        if (!error) {
            try {
                admit(std::move(socket));
            } catch (const std::exception& thrown) {
                log_.say("refused a connection, after " + shown(thrown.what()));
            }
            return accept();
        }
        // Where descriptors have run out the connection goes on waiting: to ask again at once would be to spin.
        log_.say("no connection could be accepted: " + error.message());
        pause_.expires_after(100ms);
        pause_.async_wait([this](beast::error_code cancelled) {
            if (!cancelled && !stopping_) accept();
        });
    });
}

void Server::Implementation::admit(Socket socket) {
    beast::error_code error;
    const Protocol::endpoint peer = socket.remote_endpoint(error);
    if (error) return;  // gone already
    keep_from_children(socket.native_handle());
    socket.set_option(Protocol::no_delay(true), error);
    if (!make_room()) {
        log_.say(fmt::format("{}: refused, for {} connections are open", peer.address().to_string(),
                             connections_.size()));
        constexpr std::string_view full =
            "HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nContent-Length: 30\r\n\r\n"
            "too many connections are open\n";
        socket.non_blocking(true, error);
        socket.write_some(asio::buffer(full), error);
        return;
    }
    const ClientId id = ++last_client_;
    const auto visit = std::make_shared<Visit>(*this, id, peer.address().to_string(), std::move(socket));
    connections_[id] = visit;
    visit->read();
}

// Those who have not shown the token must not keep out those who have it.
bool Server::Implementation::make_room() {
    if (static_cast<int>(connections_.size()) < options_.most_connections) return true;
    const auto stranger = std::find_if(connections_.begin(), connections_.end(),
                                       [](const auto& entry) { return !entry.second->trusted(); });
    if (stranger == connections_.end()) return false;
    const std::shared_ptr<Connection> leaves = stranger->second;
    log_.say(leaves->peer() + ": closed, to make room for another connection");
    leaves->end();
    return true;
}

void Server::Implementation::forget(ClientId client) {
    connections_.erase(client);
    if (stopping_ && connections_.empty()) finish();
}

std::vector<std::shared_ptr<Server::Implementation::Connection>> Server::Implementation::all_connections()
    const {
    std::vector<std::shared_ptr<Connection>> all;
    for (const auto& [id, connection] : connections_)
        all.push_back(connection);
    return all;
}

void Server::Implementation::send(std::optional<ClientId> to, Outgoing message) {
    if (!message.bytes || over_) return;
    const std::size_t bytes = message.bytes->size();
    const std::string key =
        message.replaces.empty() ? "" : fmt::format("{} {}", to.value_or(0), message.replaces);
    const std::lock_guard lock(inbox_mutex_);
    if (inbox_.empty()) post([this] { deliver(); });
    inbox_.push({to, std::move(message)}, key, bytes);
}

void Server::Implementation::deliver() {
    Queue<Letter> letters;
    {
        const std::lock_guard lock(inbox_mutex_);
        std::swap(letters, inbox_);
    }
    while (!letters.empty()) {
        const Letter letter = letters.pop();
        if (letter.to) {
            if (const auto page = pages_.find(*letter.to); page != pages_.end())
                page->second->send(letter.message);
            continue;
        }
        // A copy of the list: a page may leave it.
        const auto pages = pages_;
        for (const auto& [id, page] : pages)
            page->send(letter.message);
    }
}

void Server::Implementation::close(ClientId client, const std::string& reason) {
    post([this, client, reason] {
        if (const auto page = pages_.find(client); page != pages_.end())
            page->second->close(websocket::close_code::normal, reason);
    });
}

void Server::Implementation::stop() {
    post([this] {
        if (std::exchange(stopping_, true)) return;
        beast::error_code ignored;
        acceptor_.close(ignored);
        pause_.cancel();
        for (const auto& connection : all_connections())
            connection->leave();
        if (connections_.empty()) return finish();
        grace_.expires_after(stop_time);
        grace_.async_wait([this](beast::error_code cancelled) {
            if (!cancelled) finish();
        });
    });
}

void Server::Implementation::finish() {
    if (over_.exchange(true)) return;
    for (const auto& connection : all_connections())
        connection->end();
    log_.next_second();
    context_.stop();
}

bool Server::Implementation::is_ours(std::string_view host) const {
    const std::string port = fmt::format(":{}", endpoint_.port());
    if (host.ends_with(port)) {
        host.remove_suffix(port.size());
    } else if (endpoint_.port() != 80) {  // which browsers leave out
        return false;
    }
    if (hosts_.empty()) {
        // All addresses of this machine, whatever they are, but no name: names can be made to point here.
        beast::error_code error;
        if (host.size() > 2 && host.starts_with('[') && host.ends_with(']')) {
            asio::ip::make_address_v6(std::string(host.substr(1, host.size() - 2)), error);
        } else {
            asio::ip::make_address_v4(std::string(host), error);
        }
        return !error;
    }
    return std::any_of(hosts_.begin(), hosts_.end(), [&](const std::string& name) {
        return beast::iequals({name.data(), name.size()}, {host.data(), host.size()});
    });
}

std::string Server::Implementation::objection(const Request& request) const {
    const std::string host(view_of(request[http::field::host]));
    if (request.count(http::field::host) != 1 || !is_ours(host))
        return fmt::format("a Host that is not this server's: \"{}\"", shown(host));
    const auto origins = request.count(http::field::origin);
    const std::string origin(view_of(request[http::field::origin]));
    if (origins > 1 || (origins == 1 && !beast::iequals(origin, "http://" + host)))
        return fmt::format("an Origin that is not this server's page: \"{}\"", shown(origin));
    // Following a link to the page is no request of the other site's: it knew the token and cannot read the answer.
    const bool followed = beast::iequals(request["Sec-Fetch-Mode"], "navigate") &&
                          beast::iequals(request["Sec-Fetch-Dest"], "document");
    if (beast::iequals(request["Sec-Fetch-Site"], "cross-site") && !followed)
        return "a request that another site made";
    return {};
}

std::string Server::Implementation::shown(std::string_view from_client) const {
    std::string text(from_client.substr(0, 4096));
    for (std::size_t at = text.find(token_); at != std::string::npos; at = text.find(token_, at))
        text.replace(at, token_.size(), "TOKEN");
    constexpr std::size_t most = 120;
    if (text.size() > most) text = text.substr(0, most) + "...";
    std::replace_if(
        text.begin(), text.end(), [](char letter) { return letter < ' ' || letter > '~'; }, '?');
    return text;
}

// --- The door -------------------------------------------------------------------------------------------------------

Server::Server(ServerOptions options, std::string page, ServerHandlers handlers)
    : implementation_(
          std::make_unique<Implementation>(std::move(options), std::move(page), std::move(handlers))) {}

Server::~Server() = default;

std::string Server::url() const {
    return implementation_->url();
}

std::uint16_t Server::port() const {
    return implementation_->endpoint().port();
}

bool Server::loopback() const {
    return implementation_->endpoint().address().is_loopback();
}

void Server::send(ClientId client, Outgoing message) {
    implementation_->send(client, std::move(message));
}

void Server::broadcast(Outgoing message) {
    implementation_->send(std::nullopt, std::move(message));
}

void Server::close(ClientId client, const std::string& reason) {
    implementation_->close(client, reason);
}

void Server::run() {
    implementation_->run();
}

void Server::stop() {
    implementation_->stop();
}

}  // namespace beltrami::view
