#include "support/cut_wire.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

namespace cairn::testing {
namespace {

constexpr int64_t kAll = std::numeric_limits<int64_t>::max();
constexpr int kPollMs = 5;  // How soon the thread sees what another thread asks of it.

std::string SocketIn(const std::string& folder) { return folder + "/.s.PGSQL.5432"; }

sockaddr_un AddressOf(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) {
    throw std::runtime_error(path + " is too long for a socket");
  }
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  return address;
}

bool SendAll(int socket, const char* bytes, size_t num_bytes) {
  while (num_bytes > 0) {
    const ssize_t sent = send(socket, bytes, num_bytes, MSG_NOSIGNAL);
    if (sent <= 0) {
      return false;
    }
    bytes += sent;
    num_bytes -= static_cast<size_t>(sent);
  }
  return true;
}

}  // namespace

// The two sockets of a connection.
struct CutWire::Pair {
  Pair(int client_socket, int server_socket) : client(client_socket), server(server_socket) {}
  ~Pair() {
    close(client);
    close(server);
  }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;

  int client;
  int server;
};

CutWire::CutWire(const std::string& server_folder)
    : server_socket_(SocketIn(server_folder)), num_bytes_left_(kAll) {
  const sockaddr_un address = AddressOf(SocketIn(folder()));
  listener_ = socket(AF_UNIX, SOCK_STREAM, 0);
  if (bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      listen(listener_, 16) != 0) {
    throw std::runtime_error("cannot listen on " + SocketIn(folder()));
  }
  thread_ = std::thread([this] { Run(); });
}

CutWire::~CutWire() {
  ends_ = true;
  thread_.join();
  close(listener_);
}

void CutWire::CutAfter(int64_t num_bytes, Kind kind) {
  kind_ = kind;
  num_bytes_left_ = num_bytes;
}

void CutWire::Mend() {
  num_bytes_left_ = kAll;
  ++num_mends_;
}

void CutWire::Run() {
  std::vector<std::unique_ptr<Pair>> pairs;
  int num_mends = 0;
  while (!ends_) {
    std::vector<pollfd> sockets = {{listener_, POLLIN, 0}};
    for (const auto& pair : pairs) {
      sockets.push_back({pair->client, POLLIN, 0});
      sockets.push_back({pair->server, POLLIN, 0});
    }
    poll(sockets.data(), sockets.size(), kPollMs);
    if (num_mends != num_mends_) {
      num_mends = num_mends_;
      pairs.clear();
      continue;
    }
    std::erase_if(pairs, [&](const auto& pair) { return !PassOn(pair.get()); });
    if ((sockets[0].revents & POLLIN) != 0) {
      const sockaddr_un address = AddressOf(server_socket_);
      const int server = socket(AF_UNIX, SOCK_STREAM, 0);
      connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
      pairs.push_back(std::make_unique<Pair>(accept(listener_, nullptr, nullptr), server));
    }
  }
}

bool CutWire::PassOn(Pair* pair) {
  char bytes[16384];
  const ssize_t from_client = recv(pair->client, bytes, sizeof(bytes), MSG_DONTWAIT);
  if (from_client == 0 ||
      (from_client > 0 && !SendAll(pair->server, bytes, static_cast<size_t>(from_client)))) {
    return false;
  }
  const int64_t left = num_bytes_left_;
  if (left == 0) {
    return kind_ == Kind::kSilent;
  }
  const auto most = static_cast<size_t>(std::min<int64_t>(left, sizeof(bytes)));
  const ssize_t from_server = recv(pair->server, bytes, most, MSG_DONTWAIT);
  if (from_server > 0 && left != kAll) {
    num_bytes_left_ -= from_server;
  }
  return from_server != 0 &&
         (from_server < 0 || SendAll(pair->client, bytes, static_cast<size_t>(from_server)));
}

}  // namespace cairn::testing
