// The state machine of a connection. The first byte says how the peer behaves; the other bytes come
// in pieces, whose sizes the second byte determines.
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <string>

#include "core/wire/problem.h"
#include "fuzz/fuzz_target.h"
#include "http/net/connection.h"

namespace cairn {
namespace {

using Next = Connection::Next;

constexpr size_t kMaxBodyBytes = 4096;

// The server's end of a connection, driven as the event loop does.
class Served {
 public:
  Served(Socket socket, uint8_t behavior, const ConnectionLimits* limits)
      : connection_(std::move(socket), Peer{}, limits), behavior_(behavior) {}

  bool is_open() const { return is_open_; }
  Connection& connection() { return connection_; }

  // Does all that is possible without a further event.
  void Advance() {
    // Every pass reads, answers or sends something, so few passes are possible.
    for (int pass = 0; is_open_; ++pass) {
      CAIRN_CHECK(pass < 10'000, "a connection works for ever");
      const Next next = Step();
      if (next == Next::kClose) {
        is_open_ = false;
      } else if (next == Next::kRequest) {
        Answer();
      } else if (next == Next::kWait) {
        return;
      }
    }
  }

  // What happens when the deadline has passed.
  void Expire() {
    try {
      connection_.GiveUp();
      is_open_ = false;
    } catch (const HttpError&) {
      Refuse();
      Advance();
    }
  }

 private:
  Next Step() {
    try {
      return connection_.Proceed();
    } catch (const HttpError&) {
      Refuse();
      return Next::kMore;
    }
  }

  void Answer() {
    const ReceivedRequest request = connection_.TakeRequest();
    CAIRN_CHECK(request.body.size() == request.head.content_length, "a body of another length");
    CAIRN_CHECK(request.body.size() <= kMaxBodyBytes, "a body beyond the limit");
    const std::string body((behavior_ & 1) != 0 ? 300'000 : 3, 'x');
    connection_.Respond({"HTTP/1.1 200 OK\r\n\r\n", body},
                        request.head.keep_alive && (behavior_ & 2) == 0);
  }

  void Refuse() {
    CAIRN_CHECK(!has_refused_, "a connection goes on after a refusal");
    has_refused_ = true;
    connection_.Respond({"HTTP/1.1 400 Bad Request\r\n\r\n", ""}, /*keep_alive=*/false);
  }

  Connection connection_;
  uint8_t behavior_;
  bool is_open_ = true;
  bool has_refused_ = false;
};

// Reads what the server has sent. A peer that never reads leaves responses unsent.
void Drain(const Socket& peer) {
  std::array<char, 65536> buffer;
  while (recv(peer.fd(), buffer.data(), buffer.size(), 0) > 0) {
  }
}

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  if (size < 2) {
    return 0;
  }
  const uint8_t behavior = data[0];
  const size_t piece_bytes = size_t{1} << data[1] % 16;
  std::string_view rest = cairn::testing::AsText(data + 2, size - 2);
  int ends[2] = {-1, -1};
  CAIRN_CHECK(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends) == 0, "no sockets");
  const Socket peer(ends[0]);
  const ConnectionLimits limits = {.max_body_bytes = kMaxBodyBytes, .max_bytes_a_pass = 1000};
  Served served(Socket(ends[1]), behavior, &limits);
  while (!rest.empty() && served.is_open()) {
    const auto piece = rest.substr(0, piece_bytes);
    const ssize_t sent = send(peer.fd(), piece.data(), piece.size(), MSG_NOSIGNAL);
    rest.remove_prefix(std::max<ssize_t>(sent, 0));
    served.connection().NoteReadable();
    served.Advance();
    const size_t response_bytes = served.connection().is_sending() ? 300'100 : 0;
    CAIRN_CHECK(served.connection().buffered_bytes() <=
                    2 * (kMaxBodyBytes + kMaxHeadBytes) + response_bytes,
                "more in memory than the limits allow");
    if ((behavior & 4) == 0) {
      Drain(peer);
      served.Advance();
    } else if (sent <= 0) {
      break;  // The peer does not read, and the server takes nothing more.
    }
  }
  if (served.is_open() && (behavior & 8) != 0) {
    shutdown(peer.fd(), SHUT_WR);
    served.connection().NotePeerFinished();
    served.Advance();
  }
  if (served.is_open()) {
    served.Expire();
  }
  return 0;
}
