// Owning, non-blocking TCP sockets.
#ifndef CAIRN_HTTP_NET_SOCKET_H_
#define CAIRN_HTTP_NET_SOCKET_H_

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

namespace cairn {

// A file descriptor with one owner. The owner closes the descriptor.
class Socket {
 public:
  Socket() = default;
  explicit Socket(int fd) : fd_(fd) {}
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket& operator=(Socket&& other) noexcept;
  ~Socket() { Close(); }

  int fd() const { return fd_; }  // Negative if there is no descriptor.
  void Close();
  // Closes and discards unsent bytes. After Close alone, the kernel keeps unsent bytes as long as
  // the peer acknowledges packets without reading.
  void Abort();

 private:
  int fd_ = -1;
};

// The other end of a connection.
struct Peer {
  std::string address = "unknown";  // Numeric.
  // Identifies a client: equal for all of its connections (see client_network.h).
  uint64_t network = 0;
};

// Binds and listens. Port 0 picks a free port. Throws Error(kConflict), which names the port, if
// the port is taken. Throws Error(kIo) if the system refuses for another reason (privileged port,
// foreign address).
Socket ListenOn(const std::string& host, int port);

int LocalPort(const Socket& listening);

// Unsent bytes that the kernel buffers for a response that the peer does not read, beyond the bytes
// in flight.
inline constexpr int kMaxUnsentBytes = 128 * 1024;

// Accepts the next waiting connection. The kernel drops the connection, even after it was closed,
// if the peer acknowledges nothing for `peer_timeout`. If no connection waits or the system
// refuses, the returned socket has no descriptor and errno has the reason.
Socket Accept(const Socket& listening, std::chrono::milliseconds peer_timeout, Peer* peer);

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_SOCKET_H_
