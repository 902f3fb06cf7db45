// A server that sends any bytes.
#ifndef CAIRN_TESTS_SUPPORT_HOSTILE_SERVER_H_
#define CAIRN_TESTS_SUPPORT_HOSTILE_SERVER_H_

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

namespace cairn::testing {

// The server's end of a connection whose request has begun to arrive.
class Connection {
 public:
  explicit Connection(int socket) : socket_(socket) {
    std::array<char, 65536> request;
    recv(socket_, request.data(), request.size(), 0);
  }

  // Returns false once the client reads no more.
  bool Send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) {
        return false;
      }
      bytes.remove_prefix(static_cast<size_t>(sent));
    }
    return true;
  }

  bool PeerClosesWithin(int timeout_ms) {
    pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
    std::array<char, 65536> more;
    while (poll(&waiting, 1, timeout_ms) > 0) {
      if (recv(socket_, more.data(), more.size(), 0) <= 0) {
        return true;
      }
    }
    return false;
  }

 private:
  int socket_;
};

// Answers each connection with `behavior`, one after the other, and then closes it.
class HostileServer {
 public:
  explicit HostileServer(std::function<void(Connection*)> behavior)
      : socket_(socket(AF_INET, SOCK_STREAM, 0)), behavior_(std::move(behavior)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof(address);
    if (bind(socket_, reinterpret_cast<sockaddr*>(&address), length) != 0 ||
        listen(socket_, 8) != 0 ||
        getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
      throw std::runtime_error("no port to listen on");
    }
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { Serve(); });
  }
  ~HostileServer() {
    shutdown(socket_, SHUT_RDWR);
    thread_.join();
    close(socket_);
  }
  HostileServer(const HostileServer&) = delete;
  HostileServer& operator=(const HostileServer&) = delete;

  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }

 private:
  void Serve() {
    while (true) {
      const int peer = accept(socket_, nullptr, nullptr);
      if (peer < 0) {
        return;
      }
      Connection connection(peer);
      behavior_(&connection);
      close(peer);
    }
  }

  int socket_;
  int port_ = 0;
  std::function<void(Connection*)> behavior_;
  std::thread thread_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_HOSTILE_SERVER_H_
