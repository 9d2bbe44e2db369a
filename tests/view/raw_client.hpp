// A client that can misbehave: bytes to and from a port of 127.0.0.1, HTTP answers, and frames by RFC 6455 made by hand,
// so that a mistake of the server's library is not hidden by the same one in its client. Whatever waits has a deadline
// and then throws.
#pragma once

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace beltrami::testing {

using Clock = std::chrono::steady_clock;

inline Clock::time_point in_seconds(double seconds) {
    return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

struct HttpAnswer {
    int status = 0;    ///< 0: the connection ended without an answer
    std::string head;  ///< with the status line
    std::string body;

    [[nodiscard]] std::string header(const std::string& name) const {
        const std::size_t at = head.find("\r\n" + name + ": ");
        if (at == std::string::npos) return {};
        const std::size_t start = at + 4 + name.size();
        return head.substr(start, head.find("\r\n", start) - start);
    }
};

class RawClient {
  public:
    static constexpr double patience = 30.0;  // seconds; reached by failures only

    /// Not connected.
    RawClient() : descriptor_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        if (descriptor_ < 0) throw std::runtime_error("no descriptor");
    }
    explicit RawClient(std::uint16_t port, int receive_buffer = 0) : RawClient() {
        if (receive_buffer > 0)
            setsockopt(descriptor_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
        connect(port);
    }
    RawClient(const RawClient&) = delete;
    RawClient& operator=(const RawClient&) = delete;
    RawClient(RawClient&& other) noexcept
        : descriptor_(std::exchange(other.descriptor_, -1)), buffer_(std::move(other.buffer_)) {}
    RawClient& operator=(RawClient&& other) noexcept {
        std::swap(descriptor_, other.descriptor_);
        std::swap(buffer_, other.buffer_);
        return *this;
    }
    ~RawClient() { close(); }

    void connect(std::uint16_t port) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        if (::connect(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
            throw std::runtime_error("no connection");
        const int one = 1;
        setsockopt(descriptor_, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    }
    void close() {
        if (descriptor_ >= 0) ::close(descriptor_);
        descriptor_ = -1;
    }
    /// With a reset instead of an end.
    void reset() {
        const linger none{1, 0};
        setsockopt(descriptor_, SOL_SOCKET, SO_LINGER, &none, sizeof none);
        close();
    }
    void end_sending() const { shutdown(descriptor_, SHUT_WR); }

    /// As much of it as the server takes; false where it has closed the connection.
    bool send(std::string_view bytes) const {
        const Clock::time_point deadline = in_seconds(patience);
        while (!bytes.empty()) {
            wait(POLLOUT, deadline);
            const ssize_t sent = ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
            if (sent < 0 && (errno == EAGAIN || errno == EINTR)) continue;
            if (sent < 0) return false;
            bytes.remove_prefix(static_cast<std::size_t>(sent));
        }
        return true;
    }

    /// Whether there is something to read, or an end, within the time.
    [[nodiscard]] bool readable(double seconds) const {
        pollfd entry{descriptor_, POLLIN, 0};
        return !buffer_.empty() || poll(&entry, 1, static_cast<int>(1000.0 * seconds)) > 0;
    }

    /// Up to `most` bytes into the buffer; false at the end of the connection.
    bool read_more(std::size_t most = std::size_t{1} << 18U) {
        wait(POLLIN, in_seconds(patience));
        const std::size_t size = buffer_.size();
        buffer_.resize(size + most);
        const ssize_t got = recv(descriptor_, buffer_.data() + size, most, 0);
        buffer_.resize(size + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
        return got > 0;
    }

    /// Exactly so many; throws at an earlier end.
    std::string read(std::size_t count) {
        while (buffer_.size() < count) {
            if (!read_more(std::max<std::size_t>(count - buffer_.size(), 4096)))
                throw std::runtime_error("the connection ended");
        }
        std::string bytes = buffer_.substr(0, count);
        buffer_.erase(0, count);
        return bytes;
    }
    /// All until the server ends the connection.
    std::string read_all() {
        while (read_more()) {
        }
        return std::exchange(buffer_, {});
    }

    HttpAnswer answer(bool to_head = false) {
        HttpAnswer answer;
        std::size_t end = 0;
        while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
            if (!read_more()) return answer;
        }
        answer.head = read(end + 4);
        answer.status = std::atoi(answer.head.substr(9, 3).c_str());
        if (!to_head) answer.body = read(std::strtoul(answer.header("Content-Length").c_str(), nullptr, 10));
        return answer;
    }

  private:
    void wait(short event, Clock::time_point deadline) const {
        pollfd entry{descriptor_, event, 0};
        while (true) {
            const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
            if (left.count() <= 0) throw std::runtime_error("the server kept a client waiting");
            if (poll(&entry, 1, static_cast<int>(left.count())) > 0) return;
        }
    }

    int descriptor_;
    std::string buffer_;
};

enum Opcode : unsigned { continuation = 0, text = 1, binary = 2, closing = 8, ping = 9, pong = 10 };

struct FrameShape {
    bool last = true;
    bool masked = true;
    unsigned reserved = 0;               ///< three bits
    std::uint64_t claimed = UINT64_MAX;  ///< a length other than the payload's
};

inline std::string frame(unsigned opcode, std::string_view payload, FrameShape shape = {}) {
    const std::uint64_t length = shape.claimed == UINT64_MAX ? payload.size() : shape.claimed;
    std::string bytes;
    const auto put = [&](std::uint64_t value) { bytes.push_back(static_cast<char>(value & 0xffU)); };
    put((shape.last ? 0x80U : 0U) | (shape.reserved << 4U) | opcode);
    const unsigned mask_bit = shape.masked ? 0x80U : 0U;
    const int length_bytes = length < 126 ? 0 : length < 65536 ? 2 : 8;
    put(mask_bit | (length_bytes == 0 ? length : length_bytes == 2 ? 126U : 127U));
    for (int i = length_bytes - 1; i >= 0; --i)
        put(length >> (8U * static_cast<unsigned>(i)));
    constexpr std::string_view key = "\x12\x34\x56\x78";
    if (shape.masked) bytes += key;
    for (std::size_t i = 0; i < payload.size(); ++i)
        bytes.push_back(static_cast<char>(payload[i] ^ (shape.masked ? key[i % 4] : 0)));
    return bytes;
}

struct Message {
    unsigned opcode = 0;
    std::string bytes;

    /// Of a close; 0 where there is none.
    [[nodiscard]] int code() const {
        if (opcode != closing || bytes.size() < 2) return 0;
        return 256 * static_cast<unsigned char>(bytes[0]) + static_cast<unsigned char>(bytes[1]);
    }
};

/// The next frame, whole messages put together; throws at the end of the connection. Pings are handed out.
inline Message next_message(RawClient& client) {
    Message message;
    while (true) {
        const std::string start = client.read(2);
        const unsigned opcode = static_cast<unsigned char>(start[0]) & 0x0fU;
        const bool last = (static_cast<unsigned char>(start[0]) & 0x80U) != 0;
        std::uint64_t length = static_cast<unsigned char>(start[1]);
        if (length > 127) throw std::runtime_error("a masked frame from a server");
        if (length >= 126) {
            const std::string more = client.read(length == 126 ? 2 : 8);
            length = 0;
            for (const char byte : more)
                length = 256 * length + static_cast<unsigned char>(byte);
        }
        const std::string payload = client.read(length);
        if (opcode >= closing) return {opcode, payload};
        if (opcode != continuation) message.opcode = opcode;
        message.bytes += payload;
        if (last) return message;
    }
}

/// The code of the close that comes, whatever comes before it; 0: the connection ended without.
inline int close_code(RawClient& client) {
    try {
        while (true) {
            const Message message = next_message(client);
            if (message.opcode == closing) return message.code();
        }
    } catch (const std::runtime_error& error) {
        if (std::string_view(error.what()) != "the connection ended") throw;
        return 0;
    }
}

}  // namespace beltrami::testing
