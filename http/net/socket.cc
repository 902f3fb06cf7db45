#include "http/net/socket.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "core/error.h"
#include "http/net/client_network.h"

namespace cairn {
namespace {

using AddressList = std::unique_ptr<addrinfo, void (*)(addrinfo*)>;

void SetOption(int fd, int level, int option, int value) {
  setsockopt(fd, level, option, &value, sizeof(value));
}

AddressList Resolve(const std::string& host, int port) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* list = nullptr;
  const int result = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list);
  if (result != 0) {
    throw Error(ErrorCode::kIo,
                fmt::format("cannot listen on {}:{}: {}", host, port, gai_strerror(result)));
  }
  return {list, freeaddrinfo};
}

// If the address cannot be listened on, the socket has no descriptor and errno has the reason.
Socket TryToListen(const addrinfo& address) {
  Socket socket(::socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (socket.fd() < 0) {
    return socket;
  }
  // SO_REUSEPORT would let a second server silently share the port.
  SetOption(socket.fd(), SOL_SOCKET, SO_REUSEADDR, 1);
  if (address.ai_family == AF_INET6) {
    SetOption(socket.fd(), IPPROTO_IPV6, IPV6_V6ONLY, 0);
  }
  if (bind(socket.fd(), address.ai_addr, address.ai_addrlen) != 0 ||
      listen(socket.fd(), SOMAXCONN) != 0) {
    const int error = errno;
    socket.Close();
    errno = error;
  }
  return socket;
}

}  // namespace

Socket& Socket::operator=(Socket&& other) noexcept {
  if (this != &other) {
    Close();
    fd_ = std::exchange(other.fd_, -1);
  }
  return *this;
}

void Socket::Close() {
  if (fd_ >= 0) {
    ::close(std::exchange(fd_, -1));
  }
}

void Socket::Abort() {
  const linger reset{.l_onoff = 1, .l_linger = 0};
  setsockopt(fd_, SOL_SOCKET, SO_LINGER, &reset, sizeof(reset));
  Close();
}

Socket ListenOn(const std::string& host, int port) {
  const AddressList list = Resolve(host, port);
  int error = 0;
  for (const addrinfo* address = list.get(); address != nullptr; address = address->ai_next) {
    Socket socket = TryToListen(*address);
    if (socket.fd() >= 0) {
      return socket;
    }
    error = errno;
  }
  if (error == EADDRINUSE) {
    throw Error(
        ErrorCode::kConflict,
        fmt::format("port {} on {} is taken by another program; choose another port", port, host));
  }
  throw Error(ErrorCode::kIo,
              fmt::format("cannot listen on {}:{}: {}", host, port, std::strerror(error)));
}

int LocalPort(const Socket& listening) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (getsockname(listening.fd(), reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    return 0;
  }
  return ntohs(address.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(address).sin6_port
                                             : reinterpret_cast<sockaddr_in&>(address).sin_port);
}

Socket Accept(const Socket& listening, std::chrono::milliseconds peer_timeout, Peer* peer) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  Socket socket(accept4(listening.fd(), reinterpret_cast<sockaddr*>(&address), &size,
                        SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (socket.fd() < 0) {
    return socket;
  }
  SetOption(socket.fd(), IPPROTO_TCP, TCP_NODELAY, 1);
  SetOption(socket.fd(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, kMaxUnsentBytes);
  SetOption(socket.fd(), IPPROTO_TCP, TCP_USER_TIMEOUT, static_cast<int>(peer_timeout.count()));
  char host[NI_MAXHOST];
  if (getnameinfo(reinterpret_cast<sockaddr*>(&address), size, host, sizeof(host), nullptr, 0,
                  NI_NUMERICHOST) == 0) {
    peer->address = host;
    peer->network = NetworkOfAddress(host).value_or(0);
  }
  return socket;
}

}  // namespace cairn
