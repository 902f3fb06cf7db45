// Bytes to a port and back, for requests that no HTTP client would send.
#ifndef CAIRN_TESTS_HTTP_RAW_SOCKET_H_
#define CAIRN_TESTS_HTTP_RAW_SOCKET_H_

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>

namespace cairn::testing {

class RawSocket {
 public:
  explicit RawSocket(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) {
      ::close(socket_);
      throw std::runtime_error("connect failed");
    }
  }
  ~RawSocket() { ::close(socket_); }
  RawSocket(const RawSocket&) = delete;
  RawSocket& operator=(const RawSocket&) = delete;

  void Send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return;  // The server has seen enough.
      bytes.remove_prefix(static_cast<size_t>(sent));
    }
  }

  // Everything until the server closes.
  std::string ReadAll() {
    std::string text;
    while (ReadSome(&text)) {
    }
    return text;
  }

  // One response with a Content-Length; what follows stays unread.
  std::string ReadResponse() {
    std::string& text = received_;
    size_t head = 0;
    while ((head = text.find("\r\n\r\n")) == std::string::npos) {
      if (!ReadSome(&text)) return text;
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
    if (received <= 0) return false;
    text->append(chunk.data(), static_cast<size_t>(received));
    return true;
  }

  int socket_;
  std::string received_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_HTTP_RAW_SOCKET_H_
