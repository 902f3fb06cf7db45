// TCP sockets that are owned and never block.
#ifndef CAIRN_HTTP_NET_SOCKET_H_
#define CAIRN_HTTP_NET_SOCKET_H_

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

namespace cairn {

// A file descriptor with one owner, which closes it.
class Socket {
 public:
  Socket() = default;
  explicit Socket(int fd) : fd_(fd) {}
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket& operator=(Socket&& other) noexcept;
  ~Socket() { Close(); }

  int fd() const { return fd_; }  // Negative: there is none.
  void Close();
  // Closes and forgets what is unsent. After Close alone, the kernel keeps unsent bytes for as long
  // as the peer answers without reading.
  void Abort();

 private:
  int fd_ = -1;
};

// Who is at the other end.
struct Peer {
  std::string address = "unknown";  // Numeric.
  // The same for all connections of one client: its IPv4 address, or the first 64 bits of its IPv6
  // address, as whoever has one address of such a network has all of them.
  uint64_t network = 0;
};

// Binds and listens. `port` 0 picks a free one. Throws Error(kConflict) naming the port if it is
// taken, Error(kIo) if the system refuses otherwise (privileged port, foreign address).
Socket ListenOn(const std::string& host, int port);

int LocalPort(const Socket& listening);

// What the kernel holds for a connection of an answer that its peer does not read, beyond what is
// on its way.
inline constexpr int kMaxUnsentBytes = 128 * 1024;

// The next connection that waits. The kernel gives it up when its peer acknowledges nothing for
// `peer_timeout`, also after it was closed. Without one, or if the system refuses, the socket has
// no descriptor and errno says why.
Socket Accept(const Socket& listening, std::chrono::milliseconds peer_timeout, Peer* peer);

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_SOCKET_H_
