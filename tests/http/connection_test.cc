// Tests the deadlines and budgets of one connection, without a network.
#include "http/net/connection.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "core/wire/problem.h"
#include "http/raw_socket.h"

namespace cairn {
namespace {

using Next = Connection::Next;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr char kPost[] = "POST / HTTP/1.1\r\nHost: h\r\nContent-Length: 1000000\r\n\r\n";

// A connection whose peer is the test.
class ConnectionTest : public ::testing::Test {
 protected:
  ConnectionTest() {
    int ends[2] = {-1, -1};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends), 0);
    peer_ = Socket(ends[0]);
    connection_.emplace(Socket(ends[1]), Peer{}, &limits_);
  }

  // The peer sends; the connection reads. The bytes must fit into the buffer of the socket.
  Next Receive(std::string_view bytes) {
    EXPECT_EQ(send(peer_.fd(), bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    connection_->NoteReadable();
    return connection_->Proceed();
  }

  ConnectionLimits limits_;
  Socket peer_;
  std::optional<Connection> connection_;
};

TEST_F(ConnectionTest, ABodyThatComesFastEnoughHasAllItsTimeAgain) {
  limits_.body_timeout = seconds(15);
  limits_.min_body_bytes_per_s = 4096;
  ASSERT_EQ(Receive(kPost), Next::kWait);
  const auto before = connection_->deadline();
  const auto start = steady_clock::now();
  ASSERT_EQ(Receive(std::string(4096, 'x')), Next::kWait);
  EXPECT_GE(connection_->deadline(), start + seconds(15));
  EXPECT_GT(connection_->deadline(), before);
  // It gets no more than that, so a fast part pays for no slow one.
  ASSERT_EQ(Receive(std::string(60'000, 'x')), Next::kWait);
  EXPECT_LE(connection_->deadline(), steady_clock::now() + seconds(15));
}

TEST_F(ConnectionTest, ABodyThatTricklesUsesItsTimeUp) {
  limits_.min_body_bytes_per_s = 1'000'000;
  ASSERT_EQ(Receive(kPost), Next::kWait);
  const auto before = connection_->deadline();
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(Receive("x"), Next::kWait);
  }
  EXPECT_LE(connection_->deadline() - before, std::chrono::microseconds(100));
}

TEST_F(ConnectionTest, BytesThatComeOneByOneCountAsMuchAsOthers) {
  limits_.min_body_bytes_per_s = 1'000'000;
  limits_.body_timeout = seconds(15);
  ASSERT_EQ(Receive(kPost), Next::kWait);
  const auto before = connection_->deadline();
  ASSERT_EQ(Receive("x"), Next::kWait);
  EXPECT_GT(connection_->deadline(), before);
}

// Otherwise 64 clients that send a byte at a time take most of a core.
TEST(ConnectionOverTcp, ABodyWakesItsReaderOnceABatch) {
  const ConnectionLimits limits;
  const Socket listening = ListenOn("127.0.0.1", 0);
  testing::RawSocket client(LocalPort(listening));
  Peer peer;
  Connection connection(Accept(listening, seconds(10), &peer), peer, &limits);
  const auto wakes = [&](int timeout_ms) {
    pollfd waiting{.fd = connection.socket().fd(), .events = POLLIN, .revents = 0};
    return poll(&waiting, 1, timeout_ms) > 0;
  };
  const auto receive = [&] {
    EXPECT_TRUE(wakes(/*timeout_ms=*/20'000));
    connection.NoteReadable();
    return connection.Proceed();
  };
  client.Send("POST / HTTP/1.1\r\nHost: h\r\nContent-Length: 20000\r\n\r\n");
  ASSERT_EQ(receive(), Next::kWait);
  client.Send(std::string(1000, 'x'));
  EXPECT_FALSE(wakes(/*timeout_ms=*/0));
  client.Send(std::string(17'000, 'x'));
  ASSERT_EQ(receive(), Next::kWait);
  client.Send(std::string(1999, 'x'));
  EXPECT_FALSE(wakes(/*timeout_ms=*/0));
  client.Send("x");
  ASSERT_EQ(receive(), Next::kRequest);
  EXPECT_EQ(connection.TakeRequest().body, std::string(20'000, 'x'));
  connection.Respond({"HTTP/1.1 200 OK\r\n\r\n", ""}, /*keep_alive=*/true);
  client.Send("G");
  ASSERT_EQ(receive(), Next::kWait);
  client.Send("ET / HTTP/1.1\r\nHost: h\r\n\r\n");
  ASSERT_EQ(receive(), Next::kRequest);
  connection.TakeRequest();
  connection.Respond({"HTTP/1.1 200 OK\r\n\r\n", ""}, /*keep_alive=*/false);
  ASSERT_EQ(connection.Proceed(), Next::kWait);
  client.Send(std::string(1000, 'x'));
  EXPECT_FALSE(wakes(/*timeout_ms=*/0));
}

// The client's timeout must not run while the photo is on its way.
TEST_F(ConnectionTest, ARequestArrivesWithItsLastByte) {
  constexpr char kHead[] = "POST / HTTP/1.1\r\nHost: h\r\nContent-Length: 2\r\n\r\n1";
  ASSERT_EQ(Receive(kHead), Next::kWait);
  const auto before_the_last_byte = steady_clock::now();
  ASSERT_EQ(Receive("2"), Next::kRequest);
  EXPECT_GE(connection_->TakeRequest().arrival, before_the_last_byte);
}

TEST_F(ConnectionTest, OnePassReadsOnlyItsShare) {
  limits_.max_bytes_a_pass = 64 * 1024;
  ASSERT_EQ(Receive(kPost), Next::kWait);
  EXPECT_EQ(Receive(std::string(100'000, 'x')), Next::kMore);
  EXPECT_EQ(connection_->Proceed(), Next::kWait);  // The rest.
}

TEST_F(ConnectionTest, DiscardingReadsOnlyItsShareToo) {
  limits_.max_bytes_a_pass = 64 * 1024;
  connection_->Respond({.head = "HTTP/1.1 400 Bad Request\r\n\r\n", .body = ""},
                       /*keep_alive=*/false);
  EXPECT_EQ(Receive(std::string(100'000, 'x')), Next::kMore);
  EXPECT_EQ(connection_->Proceed(), Next::kWait);
}

// A client that looks for a response only after its upload would otherwise find a reset connection.
TEST_F(ConnectionTest, ARefusedUploadIsTakenToItsEnd) {
  constexpr size_t kUploadBytes = size_t{12} << 20;
  limits_.max_body_bytes = kUploadBytes;
  connection_->Respond({.head = "HTTP/1.1 401 Unauthorized\r\n\r\n", .body = ""},
                       /*keep_alive=*/false);
  const auto first_deadline = connection_->deadline();
  const std::string part(64 * 1024, 'x');
  for (size_t sent = 0; sent + part.size() < kUploadBytes; sent += part.size()) {
    ASSERT_EQ(Receive(part), Next::kWait) << "after " << sent << " bytes";
  }
  EXPECT_GT(connection_->deadline(), first_deadline);
  EXPECT_LE(connection_->deadline() - first_deadline, limits_.body_timeout);
  EXPECT_EQ(Receive(part), Next::kClose);
}

TEST_F(ConnectionTest, OneEmptyLineBeforeARequestIsSkipped) {
  EXPECT_EQ(Receive("\r\n"), Next::kWait);
  EXPECT_EQ(Receive("GET / HTTP/1.1\r\nHost: h\r\n\r\n"), Next::kRequest);
}

TEST_F(ConnectionTest, EmptyLinesAreCounted) {
  for (int i = 0; i < 8; ++i) {
    ASSERT_EQ(Receive("\r\n"), Next::kWait);
  }
  try {
    Receive("\r\n");
    ADD_FAILURE() << "not refused";
  } catch (const HttpError& error) {
    EXPECT_EQ(error.problem(), ProblemCode::kBadRequest);
  }
}

}  // namespace
}  // namespace cairn
