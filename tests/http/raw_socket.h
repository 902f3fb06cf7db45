// Sends and receives raw bytes on a port, for requests that no HTTP client would send.
#ifndef CAIRN_TESTS_HTTP_RAW_SOCKET_H_
#define CAIRN_TESTS_HTTP_RAW_SOCKET_H_

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <stdexcept>
#include <string>
#include <string_view>

namespace cairn::testing {

struct RawSocketOptions {
  const char* source = "127.0.0.1";  // All of 127.0.0.0/8 is this machine.
  int receive_bytes = 0;             // Size of the kernel's buffer; 0: the default.
};

class RawSocket {
 public:
  explicit RawSocket(int port, const RawSocketOptions& options = {}) : RawSocket(options) {
    Connect(port);
  }
  // The socket is not yet connected.
  explicit RawSocket(const RawSocketOptions& options) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (options.receive_bytes > 0) {
      setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &options.receive_bytes, sizeof(int));
    }
    sockaddr_in source{};
    source.sin_family = AF_INET;
    if (inet_pton(AF_INET, options.source, &source.sin_addr) != 1 ||
        bind(socket_, reinterpret_cast<sockaddr*>(&source), sizeof(source)) != 0) {
      ::close(socket_);
      throw std::runtime_error("bind failed");
    }
  }
  ~RawSocket() { ::close(socket_); }
  RawSocket(const RawSocket&) = delete;
  RawSocket& operator=(const RawSocket&) = delete;

  void Connect(int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) {
      throw std::runtime_error("connect failed");
    }
  }

  void Send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) {
        return;  // The server reads no more.
      }
      bytes.remove_prefix(static_cast<size_t>(sent));
    }
  }

  // Announces the end of the request. Answers can still be read.
  void FinishSending() { shutdown(socket_, SHUT_WR); }

  // Returns true if the server has neither closed nor reset the connection nor sent anything.
  bool IsWaiting() const {
    char c;
    return recv(socket_, &c, 1, MSG_PEEK | MSG_DONTWAIT) < 0 && errno == EAGAIN;
  }

  // Waits until the server resets the connection, whether or not it has sent something before.
  // Returns false if that does not happen for a long time.
  bool WaitForReset() const {
    constexpr int kLongMs = 120'000;
    pollfd poll_fd{.fd = socket_, .events = 0, .revents = 0};
    return poll(&poll_fd, 1, kLongMs) == 1;
  }

  // Reads until the server closes the connection.
  std::string ReadAll() {
    std::string text;
    while (ReadSome(&text)) {
    }
    return text;
  }

  // Reads one response with a Content-Length. The bytes after it stay unread.
  std::string ReadResponse() {
    std::string& text = received_;
    size_t head = 0;
    while ((head = text.find("\r\n\r\n")) == std::string::npos) {
      if (!ReadSome(&text)) {
        return text;
      }
    }
    const size_t length_at = text.find("Content-Length: ");
    const size_t length = length_at < head ? std::stoul(text.substr(length_at + 16)) : 0;
    while (text.size() < head + 4 + length && ReadSome(&text)) {
    }
    const std::string response = text.substr(0, head + 4 + length);
    text.erase(0, response.size());
    return response;
  }

 private:
  bool ReadSome(std::string* text) {
    std::array<char, 4096> chunk;
    const ssize_t received = recv(socket_, chunk.data(), chunk.size(), 0);
    if (received <= 0) {
      return false;
    }
    text->append(chunk.data(), static_cast<size_t>(received));
    return true;
  }

  int socket_;
  std::string received_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_HTTP_RAW_SOCKET_H_
