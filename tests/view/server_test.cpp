#include "view/server.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include "beltrami/framework/error.hpp"
#include "expect_text.hpp"
#include "view/raw_client.hpp"

namespace beltrami::view {
namespace {

using namespace beltrami::testing;

const std::string page_text = "<!doctype html><title>a page</title>";

Outgoing outgoing(std::string bytes, std::string replaces = {}) {
    return {std::make_shared<const std::string>(std::move(bytes)), true, std::move(replaces)};
}

// A server on a thread of its own, and what its handlers and its log were told. Its text handler sends "echo ..." back,
// takes "count" and throws for all else.
class Running {
  public:
    explicit Running(ServerOptions options = {}) {
        options.log = [this](const std::string& line) { note([&] { lines_.push_back(line); }); };
        ServerHandlers handlers;
        handlers.opened = [this](ClientId client) {
            note([&] { last_opened_ = client, ++opened_[client]; });
            if (throws_when_opened) throw std::runtime_error("no client today");
        };
        handlers.closed = [this](ClientId client) { note([&] { ++closed_[client]; }); };
        handlers.text = [this](ClientId client, std::string_view text) {
            note([&] { ++taken_; });
            if (text == "count") return;
            if (!text.starts_with("echo ")) throw std::runtime_error("no message: " + std::string(text));
            server_->send(client, {std::make_shared<const std::string>(text)});
        };
        handlers.file = [](std::string_view name) -> std::optional<Download> {
            if (name == "broken.csv") throw std::runtime_error("it cannot be made");
            if (name != "values.csv") return std::nullopt;
            return Download{"text/csv", "vertex,value\n0,1\n"};
        };
        server_ = std::make_unique<Server>(options, page_text, handlers);
        thread_ = std::thread([this] { server_->run(); });
    }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;
    ~Running() { stop(); }

    /// The seconds from stop() to the end of run().
    double stop() {
        const Clock::time_point start = Clock::now();
        server_->stop();
        if (thread_.joinable()) thread_.join();
        return std::chrono::duration<double>(Clock::now() - start).count();
    }

    Server& operator*() { return *server_; }
    Server* operator->() { return server_.get(); }
    [[nodiscard]] std::uint16_t port() const { return server_->port(); }
    [[nodiscard]] std::string token() const {
        const std::string url = server_->url();
        return url.substr(url.size() - 33, 32);
    }
    [[nodiscard]] std::string host() const { return fmt::format("127.0.0.1:{}", port()); }
    [[nodiscard]] std::string request(const std::string& path, const std::string& headers = {},
                                      const std::string& method = "GET") const {
        return fmt::format("{} {} HTTP/1.1\r\nHost: {}\r\n{}\r\n", method, path, host(), headers);
    }
    [[nodiscard]] std::string below(const std::string& path) const {
        return fmt::format("/{}{}", token(), path);
    }
    [[nodiscard]] HttpAnswer ask(const std::string& request, bool head = false) const {
        RawClient client(port());
        client.send(request);
        return client.answer(head);
    }
    [[nodiscard]] HttpAnswer get(const std::string& path, const std::string& headers = {}) const {
        return ask(request(path, headers));
    }
    [[nodiscard]] std::string handshake(const std::string& origin = "ours") const {
        const std::string line = origin == "ours"   ? "Origin: http://" + host() + "\r\n"
                                 : origin == "none" ? ""
                                                    : "Origin: " + origin + "\r\n";
        return request(below("/socket"),
                       line +
                           "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
    }
    /// A page that is open. The answer to the key is the example of RFC 6455, section 1.3.
    [[nodiscard]] RawClient open(int receive_buffer = 0) {
        RawClient client(port(), receive_buffer);
        client.send(handshake());
        const HttpAnswer answer = client.answer();
        if (answer.status != 101) throw std::runtime_error("not opened: " + answer.head + answer.body);
        EXPECT_EQ(answer.header("Sec-WebSocket-Accept"), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
        return client;
    }
    /// A page whose number is known.
    [[nodiscard]] RawClient open(ClientId& client) {
        RawClient page = open();
        expect_echo(page);
        client = locked(last_opened_);
        return page;
    }
    static void expect_echo(RawClient& page) {
        page.send(frame(text, "echo hello"));
        EXPECT_EQ(next_message(page).bytes, "echo hello");
    }
    void expect_well(RawClient& page) const {
        EXPECT_EQ(get(below("/")).body, page_text);
        expect_echo(page);
    }

    /// Waits for it, up to the deadline.
    template <class Condition>
    ::testing::AssertionResult becomes(Condition condition) {
        std::unique_lock lock(mutex_);
        if (changed_.wait_until(lock, in_seconds(RawClient::patience), [&] { return condition(*this); }))
            return ::testing::AssertionSuccess();
        return ::testing::AssertionFailure() << "in vain; the log says: " << fmt::format("{}", lines_);
    }
    [[nodiscard]] std::size_t opened() const { return locked(opened_).size(); }
    [[nodiscard]] std::size_t closed() const { return locked(closed_).size(); }
    [[nodiscard]] long taken() const { return locked(taken_); }
    [[nodiscard]] std::vector<std::string> lines() const { return locked(lines_); }
    [[nodiscard]] bool said(const std::string& part) const {
        const std::vector<std::string> now = lines();
        return std::any_of(now.begin(), now.end(),
                           [&](const std::string& line) { return line.find(part) != std::string::npos; });
    }
    [[nodiscard]] bool closed_each_once() const { return locked(opened_) == locked(closed_); }

    std::atomic<bool> throws_when_opened = false;

  private:
    template <class Value>
    Value locked(const Value& value) const {
        const std::lock_guard lock(mutex_);
        return value;
    }
    template <class Change>
    void note(Change change) {
        const std::lock_guard lock(mutex_);
        change();
        changed_.notify_all();
    }

    mutable std::recursive_mutex mutex_;  // conditions of becomes() take it again
    std::condition_variable_any changed_;
    std::map<ClientId, int> opened_;
    std::map<ClientId, int> closed_;
    ClientId last_opened_ = 0;
    long taken_ = 0;
    std::vector<std::string> lines_;
    std::unique_ptr<Server> server_;
    std::thread thread_;
};

// --- Requests -------------------------------------------------------------------------------------------------------

TEST(Server, AnswersThePageBelowItsToken) {
    Running server;
    EXPECT_EQ(server->url(), fmt::format("http://127.0.0.1:{}/{}/", server.port(), server.token()));
    EXPECT_EQ(server.token().find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_TRUE(server->loopback());
    EXPECT_NE(Running().token(), server.token());

    const HttpAnswer page = server.get(server.below("/"));
    EXPECT_EQ(page.status, 200);
    EXPECT_EQ(page.body, page_text);
    EXPECT_EQ(page.header("Content-Type"), "text/html; charset=utf-8");
    EXPECT_EQ(page.header("Cache-Control"), "no-store");
    EXPECT_EQ(page.header("Referrer-Policy"), "no-referrer");
    EXPECT_EQ(page.header("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(page.header("X-Frame-Options"), "DENY");
    EXPECT_EQ(page.header("Cross-Origin-Opener-Policy"), "same-origin");
    EXPECT_EQ(page.header("Cross-Origin-Resource-Policy"), "same-origin");

    EXPECT_EQ(server.get(server.below("/?task=heat")).body, page_text);
    EXPECT_EQ(server.get(server.below("/"), "Origin: http://" + server.host() + "\r\n").status, 200);
    EXPECT_EQ(server.get(server.below("/"), "Sec-Fetch-Site: none\r\n").status, 200);
    const HttpAnswer moved = server.get(server.below(""));
    EXPECT_EQ(moved.status, 301);
    EXPECT_EQ(moved.header("Location"), server.below("/"));
    EXPECT_EQ(server.get("/favicon.ico").status, 204);
    EXPECT_EQ(server.get(server.below("/icon")).status, 204);
}

TEST(Server, AnswersSeveralRequestsOfOneConnectionAndHeadWithoutABody) {
    Running server;
    RawClient client(server.port());
    const std::string head = server.request(server.below("/"), {}, "HEAD");
    client.send(head + head + server.request(server.below("/")) + server.request(server.below("/none")));
    for (int i = 0; i < 2; ++i) {
        const HttpAnswer answer = client.answer(true);
        EXPECT_EQ(answer.status, 200);
        EXPECT_EQ(answer.header("Content-Length"), std::to_string(page_text.size()));
    }
    EXPECT_EQ(client.answer().body, page_text);
    EXPECT_EQ(client.answer().status, 404);
    client.send(server.request(server.below("/"), "Connection: close\r\n"));
    EXPECT_EQ(client.answer().body, page_text);
    EXPECT_EQ(client.read_all(), "");
}

TEST(Server, RefusesAWrongTokenAndAMissingOne) {
    Running server;
    std::string almost = server.token();
    almost.back() = almost.back() == '0' ? '1' : '0';
    for (const std::string& path :
         {std::string("/"), std::string("/socket"), std::string("//"), "/" + almost + "/", "/" + almost,
          "/" + server.token() + "0/", "/" + server.token().substr(1) + "/", "//" + server.token() + "/",
          "/x/" + server.token() + "/", "/?" + server.token(), server.token() + "/", std::string("*")}) {
        const HttpAnswer answer = server.get(path);
        EXPECT_EQ(answer.status, 403) << path;
        EXPECT_EQ(answer.header("Connection"), "close") << path;
        EXPECT_EQ(answer.body.find(server.token()), std::string::npos) << path;
    }
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.said("without the token"); }));
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.said("a wrong token"); }));
}

TEST(Server, RefusesAForeignHost) {
    Running server;
    const auto status = [&](const std::string& hosts) {
        return server.ask("GET " + server.below("/") + " HTTP/1.1\r\n" + hosts + "\r\n").status;
    };
    const std::string port = std::to_string(server.port());
    EXPECT_EQ(status("Host: 127.0.0.1:" + port + "\r\n"), 200);
    EXPECT_EQ(status("Host: LocalHost:" + port + "\r\n"), 200);
    for (const std::string& host :
         {"evil.example:" + port, std::string("127.0.0.1"), std::string("localhost"), "127.0.0.1:1" + port,
          "127.0.0.1.evil.example:" + port, "[::1]:" + port, "127.0.0.2:" + port, ":" + port, std::string(),
          "evil@127.0.0.1:" + port}) {
        EXPECT_EQ(status("Host: " + host + "\r\n"), 403) << host;
    }
    EXPECT_EQ(status(""), 403);
    EXPECT_EQ(status("Host: 127.0.0.1:" + port + "\r\nHost: evil.example\r\n"), 403);
    EXPECT_EQ(server.ask("GET " + server.below("/") + " HTTP/1.0\r\n\r\n").status, 403);
    EXPECT_TRUE(server.becomes([&](const Running& now) {
        return now.said(R"(127.0.0.1: refused, for a Host that is not this server's: "evil.example:)" + port);
    }));
}

TEST(Server, AtAllAddressesTakesAnyAddressAsHostButNoName) {
    ServerOptions options;
    options.host = "0.0.0.0";
    Running server(options);
    EXPECT_FALSE(server->loopback());
    EXPECT_TRUE(server->url().starts_with("http://127.0.0.1:"));
    const auto status = [&](const std::string& host) {
        return server
            .ask(
                fmt::format("GET {} HTTP/1.1\r\nHost: {}:{}\r\n\r\n", server.below("/"), host, server.port()))
            .status;
    };
    EXPECT_EQ(status("127.0.0.1"), 200);
    EXPECT_EQ(status("192.0.2.7"), 200);
    EXPECT_EQ(status("[2001:db8::7]"), 200);
    EXPECT_EQ(status("rebound.example"), 403);
    EXPECT_EQ(status("192.0.2.7.rebound.example"), 403);
    EXPECT_EQ(status("[rebound.example]"), 403);
    EXPECT_EQ(status("[]"), 403);
}

TEST(Server, RefusesOtherSites) {
    Running server;
    for (const std::string& path : {std::string("/"), std::string("/files/values.csv")}) {
        const std::string whole = server.below(path);
        EXPECT_EQ(server.get(whole, "Origin: http://evil.example\r\n").status, 403);
        EXPECT_EQ(server.get(whole, "Origin: null\r\n").status, 403);
        EXPECT_EQ(server.get(whole, "Origin: https://" + server.host() + "\r\n").status, 403);
        EXPECT_EQ(server.get(whole, "Origin: http://127.0.0.1:1\r\n").status, 403);
        EXPECT_EQ(server.get(whole, "Sec-Fetch-Site: cross-site\r\n").status, 403);
        EXPECT_EQ(server.get(whole, "Origin: http://" + server.host() + "\r\nOrigin: http://evil.example\r\n")
                      .status,
                  403);
    }
    for (const std::string origin : {"http://evil.example", "null", "none"}) {
        EXPECT_EQ(server.ask(server.handshake(origin)).status, 403) << origin;
    }
    // Of the same server, but not the one that the request names.
    EXPECT_EQ(server.ask(server.handshake(fmt::format("http://localhost:{}", server.port()))).status, 403);
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.said("a socket without an Origin"); }));
    EXPECT_EQ(server.opened(), 0U);
    RawClient page = server.open();
    server.expect_well(page);
}

TEST(Server, AnswersOnlyGetAndHeadWithoutABody) {
    Running server;
    for (const std::string method : {"POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "BREW"}) {
        const HttpAnswer answer = server.ask(server.request(server.below("/"), {}, method));
        EXPECT_EQ(answer.status, 405) << method;
        EXPECT_EQ(answer.header("Allow"), "GET, HEAD") << method;
    }
    EXPECT_EQ(server.ask(server.request(server.below("/"), "Content-Length: 5\r\n", "POST") + "hello").status,
              405);
    EXPECT_EQ(server.ask(server.request(server.below("/"), "Content-Length: 5\r\n") + "hello").status, 413);
    EXPECT_EQ(server.ask(server.request(server.below("/"), "Transfer-Encoding: chunked\r\n")).status, 413);
    EXPECT_EQ(server.get(server.below("/none")).status, 404);
    EXPECT_EQ(server.get(server.below("/socket")).status, 426);
    EXPECT_EQ(server.get(server.below("/../")).status, 404);
}

TEST(Server, HandsOutFiles) {
    Running server;
    const HttpAnswer file = server.get(server.below("/files/values.csv"));
    EXPECT_EQ(file.status, 200);
    EXPECT_EQ(file.body, "vertex,value\n0,1\n");
    EXPECT_EQ(file.header("Content-Type"), "text/csv");
    EXPECT_EQ(file.header("Content-Disposition"), "attachment; filename=\"values.csv\"");
    EXPECT_EQ(file.header("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(server.get(server.below("/files/other.csv")).status, 404);
    for (const std::string& name :
         {std::string(), std::string("."), std::string(".."), std::string(".hidden"), std::string("a/b"),
          std::string("..%2fvalues.csv"), std::string("a\"b"), std::string("..\\values.csv"),
          std::string(101, 'a')}) {
        EXPECT_EQ(server.get(server.below("/files/" + name)).status, 404) << name;
    }
    EXPECT_EQ(server.get(server.below("/files/broken.csv")).status, 500);
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.said("broken.csv: it cannot be made"); }));
    EXPECT_EQ(server.get(server.below("/files/values.csv")).status, 200);
}

// --- Abuse ----------------------------------------------------------------------------------------------------------

// A client's misdeed and how the server answers: an HTTP status, the code of a close, or 0 for the end of the connection.
struct Misdeed {
    std::string name;
    bool page;  ///< after the socket has opened
    std::string bytes;
    int answer;
};

std::vector<Misdeed> misdeeds(const Running& server, const ServerOptions& options, std::mt19937& random) {
    const auto letters = [&](std::size_t count) {
        std::string bytes(count, ' ');
        std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<char>(random() % 256); });
        return bytes;
    };
    const std::string whole = server.request(server.below("/"));
    const std::string handshake = server.handshake();
    const std::string too_large(options.largest_message + 1, 'a');
    return {
        {"garbage", false, "\x01\x02" + letters(20 + random() % 400), 400},
        {"TLS", false, std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11) + letters(200), 400},
        {"no version", false, "GET " + server.below("/") + " HTTX/1.1\r\n\r\n", 400},
        {"header without a colon", false, "GET / HTTP/1.1\r\nHost 127.0.0.1\r\n\r\n", 400},
        {"two lengths", false, server.request("/", "Content-Length: 1\r\nContent-Length: 2\r\n"), 400},
        {"truncated request", false, whole.substr(0, 1 + random() % (whole.size() - 1)), 0},
        {"truncated handshake", false, handshake.substr(0, 1 + random() % (handshake.size() - 1)), 0},
        {"large header", false, server.request("/", "X-Large: " + std::string(9000, 'a') + "\r\n"), 431},
        {"many headers", false, "GET / HTTP/1.1\r\n" + std::string(60000, 'a'), 431},
        {"large target", false, "GET /" + std::string(20000, 'a') + " HTTP/1.1\r\n\r\n", 431},
        {"random target", false, "GET /" + std::to_string(random()) + " HTTP/1.1\r\nHost: x\r\n\r\n", 403},
        {"no handshake", false,
         server.request(server.below("/socket"), "Origin: http://" + server.host() +
                                                     "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"),
         400},
        {"old handshake", false,
         server.request(server.below("/socket"), "Origin: http://" + server.host() +
                                                     "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
                                                     "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                                                     "Sec-WebSocket-Version: 8\r\n"),
         426},
        {"frames before the answer", false, handshake + frame(text, "echo early"), 400},
        {"random frames", true, letters(1 + random() % 300), -1},
        {"unmasked", true, frame(text, "echo", {.masked = false}), 1002},
        {"reserved bits", true, frame(text, "echo", {.reserved = static_cast<unsigned>(1 + random() % 7)}),
         1002},
        {"compressed", true, frame(text, letters(100), {.reserved = 4}), 1002},
        {"reserved kind", true, frame(3 + random() % 5, "echo"), 1002},
        {"reserved control", true, frame(11 + random() % 5, "echo"), 1002},
        {"fragmented ping", true, frame(ping, "echo", {.last = false}), 1002},
        {"large ping", true, frame(ping, std::string(126, 'a')), 1002},
        {"nothing to continue", true, frame(continuation, "echo"), 1002},
        {"message within a message", true, frame(text, "echo", {.last = false}) + frame(text, "echo"), 1002},
        {"large text", true, frame(text, too_large), 1009},
        {"claims to be huge", true, frame(binary, "echo", {.claimed = std::uint64_t{1} << 62U}), 1009},
        {"negative length", true, frame(text, "echo", {.claimed = UINT64_MAX - 1}), -1},
        {"large in pieces", true,
         frame(text, too_large.substr(0, 1000), {.last = false}) + frame(continuation, too_large), 1009},
        {"no UTF-8", true, frame(text, "echo \xc3\x28 \xf0\x28\x8c\x28"), 1007},
        {"half a character", true, frame(text, "echo \xe2\x82"), 1007},
        {"surrogate", true, frame(text, "echo \xed\xa0\x80"), 1007},
        {"binary", true, frame(binary, letters(random() % 200)), 1003},
        {"text that means nothing", true,
         frame(text, "\r\n\x1b[2J" + server.token() + std::to_string(random())), 1011},
        {"empty text", true, frame(text, ""), 1011},
        {"truncated frame", true, frame(text, "echo", {.claimed = 1000}), 0},
        {"half a frame's head", true, frame(text, std::string(300, 'a')).substr(0, 3), 0},
        {"close with one byte", true, frame(closing, "a"), 1002},
        {"close with a wrong code", true, frame(closing, std::string("\x03\xec", 2)), 1002},
        {"close with bad text", true, frame(closing, std::string("\x03\xe8\xff\xff", 4)), 1002},
    };
}

TEST(Server, OutlivesTenThousandMalformedMessages) {
    ServerOptions options;
    options.largest_message = 2000;
    options.messages_per_second = 1e6;  // of the good page
    Running server(options);
    RawClient good = server.open();
    std::mt19937 random(1);
    std::map<std::string, int> counts;
    const Clock::time_point start = Clock::now();
    std::size_t done = 0;
    std::size_t pages = 1;
    while (done < 10000) {
        for (const Misdeed& misdeed : misdeeds(server, options, random)) {
            RawClient client = misdeed.page ? server.open() : RawClient(server.port());
            pages += misdeed.page ? 1 : 0;
            client.send(misdeed.bytes);
            client.end_sending();
            const int answer = misdeed.page ? close_code(client) : client.answer().status;
            if (misdeed.answer >= 0) {
                ASSERT_EQ(answer, misdeed.answer) << misdeed.name;
            }
            client.read_all();  // the server has ended the connection
            ++done;
            ++counts[misdeed.name];
        }
        server.expect_well(good);
    }
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    good.close();
    EXPECT_TRUE(server.becomes([&](const Running& now) { return now.closed() == pages; }));
    server.stop();
    EXPECT_TRUE(server.closed_each_once());
    EXPECT_GE(done, 10000U);
    RecordProperty("seconds", std::to_string(seconds));

    EXPECT_LE(static_cast<double>(server.lines().size()), 21.0 * (seconds + 2.0));
    EXPECT_TRUE(server.said("more lines are left out"));
    for (const std::string& line : server.lines()) {
        EXPECT_EQ(line.find(server.token()), std::string::npos) << line;
        EXPECT_TRUE(std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; }))
            << line;
    }
}

std::ptrdiff_t open_descriptors() {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

TEST(Server, OutlivesConnectionsThatAreDropped) {
    ServerOptions options;
    options.most_connections = 200;
    options.most_pages = 100;
    Running server(options);
    RawClient good = server.open();
    const std::ptrdiff_t before = open_descriptors();
    const std::string handshake = server.handshake();
    std::size_t pages = 1;
    {
        std::vector<RawClient> clients;
        for (int i = 0; i < 120; ++i) {
            RawClient client(server.port());
            switch (i % 6) {
                case 0:
                    break;
                case 1:
                    client.send(server.request(server.below("/")).substr(0, 30));
                    break;
                case 2:
                    client.send(handshake.substr(0, handshake.size() / 2));
                    break;
                case 3:
                    client.send(handshake);
                    break;  // gone before the answer
                default:
                    client.send(handshake);
                    EXPECT_EQ(client.answer().status, 101);
                    client.send(
                        frame(text, "echo", {.claimed = 500 + 70000 * static_cast<std::uint64_t>(i % 2)}));
                    ++pages;
            }
            clients.push_back(std::move(client));
        }
        for (std::size_t i = 0; i < clients.size(); ++i) {
            if (i % 12 < 6) clients[i].reset();
        }
    }
    server.expect_well(good);
    // All of them are gone: what they held is free again.
    const Clock::time_point deadline = in_seconds(RawClient::patience);
    while (open_descriptors() > before && Clock::now() < deadline)
        server.expect_well(good);
    EXPECT_LE(open_descriptors(), before);
    good.close();
    EXPECT_TRUE(server.becomes([&](const Running& now) { return now.closed() == now.opened(); }));
    server.stop();
    EXPECT_GE(server.opened(), pages);
    EXPECT_TRUE(server.closed_each_once());
}

TEST(Server, ClosesAPageThatFloodsAndServesTheOthers) {
    ServerOptions options;
    options.messages_per_second = 40.0;
    for (const std::string& message : {frame(text, "count"), frame(ping, "")}) {
        Running server(options);
        RawClient good = server.open();
        const Clock::time_point start = Clock::now();
        RawClient flood = server.open();
        for (int i = 0; i < 500; ++i)
            flood.send(message);
        for (int i = 0; i < 10; ++i)
            Running::expect_echo(good);
        EXPECT_EQ(close_code(flood), 1008);
        const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
        EXPECT_TRUE(
            server.becomes([](const Running& now) { return now.said("more than 40 messages a second"); }));
        flood.close();
        EXPECT_TRUE(server.becomes([](const Running& now) { return now.closed() == 1; }));
        server.expect_well(good);
        server.stop();
        EXPECT_LE(static_cast<double>(server.taken()), 80.0 + 40.0 * seconds + 1.0 + 11.0);
    }
}

TEST(Server, EndsARequestThatTrickles) {
    ServerOptions options;
    options.request_seconds = 0.5;
    Running server(options);
    RawClient idle(server.port());
    RawClient kept(server.port());
    kept.send(server.request(server.below("/")));
    EXPECT_EQ(kept.answer().status, 200);

    RawClient slow(server.port());
    const Clock::time_point start = Clock::now();
    const std::string request = server.request("/", "X-Long: " + std::string(4000, 'a') + "\r\n");
    std::size_t sent = 0;
    while (sent < request.size() && !slow.readable(0.02))
        slow.send(request.substr(sent++, 1));
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    EXPECT_LT(sent, request.size());
    EXPECT_EQ(slow.answer().status, 0);
    EXPECT_GT(seconds, 0.4);
    EXPECT_EQ(idle.read_all(), "");
    EXPECT_EQ(kept.read_all(), "");
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.said("not whole after 0.5 s"); }));
    EXPECT_EQ(server.get(server.below("/")).status, 200);
}

TEST(Server, ClosesAPageThatAnswersNoPing) {
    ServerOptions options;
    options.silent_seconds = 0.6;
    Running server(options);
    RawClient answers = server.open();
    RawClient silent = server.open();
    for (int pings = 0; pings < 4; ++pings) {
        ASSERT_EQ(next_message(answers).opcode, static_cast<unsigned>(ping));
        answers.send(frame(pong, ""));
    }
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.closed() == 1; }));
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.said("silent for 0.6 s"); }));
    EXPECT_EQ(close_code(silent), 0);
    answers.send(frame(text, "echo hello"));
    while (true) {
        const Message message = next_message(answers);
        if (message.opcode == ping) continue;
        EXPECT_EQ(message.bytes, "echo hello");
        break;
    }
}

TEST(Server, BoundsPages) {
    ServerOptions options;
    options.most_pages = 2;
    Running server(options);
    RawClient first = server.open();
    RawClient second = server.open();
    const HttpAnswer third = server.ask(server.handshake());
    EXPECT_EQ(third.status, 503);
    EXPECT_EQ(third.body, "2 pages are open, and no more are served\n");
    server.expect_well(first);
    second.close();
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.closed() == 1; }));
    second = server.open();
    server.expect_well(second);
}

TEST(Server, BoundsConnectionsAndLetsStrangersGiveWay) {
    ServerOptions options;
    options.most_connections = 4;
    Running server(options);
    std::vector<RawClient> strangers;
    strangers.reserve(4);
    for (int i = 0; i < 4; ++i)
        strangers.emplace_back(server.port());
    RawClient good = server.open();
    EXPECT_EQ(strangers.front().read_all(), "");  // the oldest
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.said("to make room"); }));

    std::vector<RawClient> pages;
    pages.reserve(3);
    for (int i = 0; i < 3; ++i)
        pages.push_back(server.open());
    EXPECT_EQ(server.ask(server.request(server.below("/"))).status, 503);
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.said("4 connections are open"); }));
    Running::expect_echo(good);
    pages.pop_back();
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.closed() == 1; }));
    server.expect_well(good);
}

TEST(Server, WaitsForDescriptorsInsteadOfSpinning) {
    Running server;
    RawClient good = server.open();
    std::vector<RawClient> clients(3);
    rlimit limit{};
    ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
    const int free = dup(STDIN_FILENO);
    ASSERT_GE(free, 0);
    close(free);
    rlimit less = limit;
    less.rlim_cur = static_cast<rlim_t>(free);
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &less), 0);
    for (RawClient& client : clients) {
        client.connect(server.port());
        client.send(server.request(server.below("/")));
    }
    const bool said =
        server.becomes([](const Running& now) { return now.said("no connection could be accepted"); });
    for (int i = 0; i < 20; ++i)
        Running::expect_echo(good);
    setrlimit(RLIMIT_NOFILE, &limit);
    EXPECT_TRUE(said);
    for (RawClient& client : clients)
        EXPECT_EQ(client.answer().body, page_text);
    server.stop();
    EXPECT_FALSE(server.said("left out"));
}

// --- What goes out --------------------------------------------------------------------------------------------------

TEST(Server, SendsLargeMessagesWithoutCopies) {
    Running server;
    ClientId client = 0;
    RawClient page = server.open(client);
    std::string bytes(std::size_t{48} << 20U, ' ');
    for (std::size_t i = 0; i < bytes.size(); i += 1000)
        bytes[i] = static_cast<char>('a' + i / 1000 % 26);
    const Outgoing message = outgoing(bytes);
    server->send(client, message);
    server->send(client, {std::make_shared<const std::string>("a text"), false});
    const Message got = next_message(page);
    EXPECT_EQ(got.opcode, static_cast<unsigned>(binary));
    EXPECT_TRUE(got.bytes == bytes);
    const Message then = next_message(page);
    EXPECT_EQ(then.opcode, static_cast<unsigned>(text));
    EXPECT_EQ(then.bytes, "a text");
    server.stop();
    EXPECT_EQ(message.bytes.use_count(), 1);
}

TEST(Server, KeepsTheOrderOfEachThread) {
    Running server;
    ClientId client = 0;
    RawClient page = server.open(client);
    std::vector<std::thread> threads;
    threads.reserve(4);
    constexpr int count = 300;
    for (int t = 0; t < 4; ++t) {
        threads.emplace_back([&, t] {
            for (int i = 0; i < count; ++i)
                i % 2 == 0 ? server->send(client, outgoing(fmt::format("{} {}", t, i)))
                           : server->broadcast(outgoing(fmt::format("{} {}", t, i)));
        });
    }
    std::array<int, 4> next{};
    for (int i = 0; i < 4 * count; ++i) {
        const std::string bytes = next_message(page).bytes;
        const auto t = static_cast<std::size_t>(bytes.at(0) - '0');
        EXPECT_EQ(bytes, fmt::format("{} {}", t, next.at(t)++));
    }
    for (std::thread& thread : threads)
        thread.join();
    server->send(client + 1000, outgoing("to nobody"));
    server->send(client, {});
    server.expect_well(page);
}

// More than the buffers of a connection hold whose client does not read.
const std::string filler(std::size_t{24} << 20U, 'f');

TEST(Server, ReplacesWhatASlowPageHasNotTaken) {
    Running server;
    RawClient slow = server.open(16384);
    RawClient quick = server.open();
    constexpr int count = 500;
    for (int i = 0; i < count; ++i)
        server->send(1, outgoing(fmt::format("{:06}", i) + std::string(std::size_t{1} << 18U, 'x'), "frame"));
    server.expect_well(quick);  // so all of them have been sent or replaced
    int got = 0;
    int last = -1;
    while (last != count - 1) {
        const int number = std::stoi(next_message(slow).bytes.substr(0, 6));
        EXPECT_GT(number, last);
        last = number;
        ++got;
    }
    EXPECT_LT(got, count / 4);
    server.expect_well(slow);
}

TEST(Server, LetsNoMessageOvertakeOneWithoutAKey) {
    Running server;
    RawClient slow = server.open(16384);
    RawClient quick = server.open();
    server->send(1, outgoing(filler));
    server->send(1, outgoing("a1", "a"));
    server->send(1, outgoing("plain"));
    server->send(1, outgoing("a2", "a"));
    server->send(1, outgoing("b1", "b"));
    server->send(1, outgoing("b2", "b"));
    server->send(1, outgoing("a3", "a"));
    server.expect_well(quick);
    EXPECT_EQ(next_message(slow).bytes.size(), filler.size());
    EXPECT_EQ(next_message(slow).bytes, "plain");
    EXPECT_EQ(next_message(slow).bytes, "a3");
    EXPECT_EQ(next_message(slow).bytes, "b2");
    server->send(1, outgoing("a4", "a"));
    EXPECT_EQ(next_message(slow).bytes, "a4");
    server.expect_well(slow);
}

TEST(Server, ClosesAPageWhoseBacklogGrowsTooLarge) {
    ServerOptions options;
    options.largest_backlog = filler.size() + (std::size_t{8} << 20U);
    Running server(options);
    RawClient slow = server.open(16384);
    RawClient quick = server.open();
    server->send(1, outgoing(filler));
    const Outgoing piece = outgoing(std::string(std::size_t{1} << 20U, 'x'));
    for (int i = 0; i < 8; ++i)
        server->send(1, piece);
    server.expect_well(quick);
    EXPECT_EQ(server.closed(), 0U);
    server->send(1, piece);
    server.expect_well(quick);
    EXPECT_TRUE(
        server.becomes([](const Running& now) { return now.said("bytes that the page does not take"); }));
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.closed() == 1; }));
    server.expect_well(quick);
    server.stop();
    EXPECT_EQ(piece.bytes.use_count(), 1);
}

TEST(Server, ClosesWithAReason) {
    Running server;
    ClientId client = 0;
    RawClient page = server.open(client);
    std::string reason = "x";
    for (int i = 0; i < 100; ++i)
        reason += "\xc3\xa9";
    server->close(client, reason);
    server->close(client, "again");
    server->send(client, outgoing("too late"));
    const Message message = next_message(page);
    EXPECT_EQ(message.code(), 1000);
    EXPECT_EQ(message.bytes.substr(2), reason.substr(0, 123));
    page.send(frame(closing, message.bytes.substr(0, 2)));
    EXPECT_EQ(page.read_all(), "");
    page.close();
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.closed() == 1; }));
    server->close(client, "gone");
    // One that does not answer.
    RawClient deaf = server.open(client);
    server->close(client, "an end");
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.closed() == 2; }));
    server.stop();
    EXPECT_TRUE(server.closed_each_once());
}

TEST(Server, ClosesWhereOpeningThrows) {
    Running server;
    server.throws_when_opened = true;
    RawClient page = server.open();
    EXPECT_EQ(close_code(page), 1011);
    page.close();
    EXPECT_TRUE(server.becomes([](const Running& now) { return now.closed() == 1; }));
    EXPECT_TRUE(server.said("no client today"));
    server.throws_when_opened = false;
    RawClient next = server.open();
    server.expect_well(next);
    server.stop();
    EXPECT_TRUE(server.closed_each_once());
}

// --- The end --------------------------------------------------------------------------------------------------------

TEST(Server, StopsPromptlyWhateverClientsDo) {
    Running server;
    RawClient idle(server.port());
    RawClient half(server.port());
    half.send(server.request(server.below("/")).substr(0, 30));
    RawClient deaf = server.open();
    RawClient within = server.open();
    within.send(frame(text, "echo", {.claimed = 1000}));
    RawClient slow = server.open(16384);
    server->broadcast(outgoing(filler));
    RawClient polite = server.open();
    server.expect_well(polite);
    std::atomic<bool> over = false;
    std::thread sender([&] {
        while (!over)
            server->broadcast(outgoing("more", "more"));
    });
    EXPECT_LT(server.stop(), 1.0);
    over = true;
    sender.join();
    EXPECT_EQ(server.opened(), 4U);
    EXPECT_TRUE(server.closed_each_once());
    EXPECT_EQ(close_code(polite), 1001);
    EXPECT_EQ(idle.read_all(), "");
    EXPECT_THROW(RawClient(server.port()), std::runtime_error);
    server->stop();
    server->run();
}

TEST(Server, ComesAndGoesWithoutRunning) {
    const ServerOptions options;
    { const Server unused(options, page_text, {}); }
    {
        Server connected(options, page_text, {});
        RawClient client(connected.port());
        connected.broadcast(outgoing("to nobody"));
    }
    Server stopped(options, page_text, {});
    stopped.stop();
    stopped.run();
    stopped.run();
}

TEST(Server, SaysWhereItCannotListen) {
    const auto message = [](const std::string& host, std::uint16_t port) {
        ServerOptions options;
        options.host = host;
        options.port = port;
        try {
            const Server server(options, page_text, {});
        } catch (const InputError& error) {
            EXPECT_NE(error.hint(), "");
            return std::string(error.what());
        }
        return std::string("it can");
    };
    Running server;
    EXPECT_EQ(message("127.0.0.1", server.port()),
              fmt::format("port {} of 127.0.0.1 is taken", server.port()));
    EXPECT_TRUE(contains(message("203.0.113.7", 0), {"no server can listen at 203.0.113.7: "}));
    EXPECT_TRUE(contains(message("", 0), {"has no address"}));
    EXPECT_EQ(message("localhost", 0), "it can");
}

}  // namespace
}  // namespace beltrami::view
