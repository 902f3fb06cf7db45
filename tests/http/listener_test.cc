// Tests clients that keep connections occupied, and the limits on them.
#include "http/net/listener.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "http/no_more_files.h"
#include "http/raw_socket.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using testing::kSanitizerNeedsFiles;
using testing::NoMoreFiles;
using testing::RawSocket;
using testing::RawSocketOptions;
using ::testing::StartsWith;

using Clients = std::vector<std::unique_ptr<RawSocket>>;

constexpr char kGet[] = "GET / HTTP/1.1\r\nHost: h\r\n\r\n";
constexpr char kHalfHead[] = "GET / HTTP/1.1\r\nHost: h\r\nX: ";
constexpr char kOtherClient[] = "127.0.0.2";
// More than the kernel buffers for a connection.
constexpr size_t kLargeBytes = size_t{4} << 20;

std::string Post(size_t num_bytes) {
  return "POST / HTTP/1.1\r\nHost: h\r\nContent-Length: " + std::to_string(num_bytes) + "\r\n\r\n";
}

// Answers "/" at once, "/large" with kLargeBytes, and "/hold" when Release is called.
class Handler : public RequestHandler {
 public:
  HttpResponse Handle(HttpRequest request) override {
    ++num_handled;
    HttpResponse response{.status = 200, .content_type = "text/plain", .body = "fine"};
    if (request.path == "/large") {
      response.body.assign(kLargeBytes, 'x');
    }
    if (request.path == "/who") {
      response.body = request.remote_address + " " + std::to_string(request.client);
    }
    if (request.path == "/hold") {
      std::unique_lock lock(mutex_);
      released_.wait(lock, [this] { return is_released_; });
    }
    return response;
  }
  void CheckHead(const RequestHead& head) override {
    if (head.target == "/forbidden") {
      throw HttpError(ProblemCode::kForbidden, "not here");
    }
  }
  HttpResponse Refuse(const HttpError& error, const RefusedRequest& request) override {
    return {.status = InfoOf(error.problem()).status,
            .content_type = "text/plain",
            .body = std::string(error.what()) + " no: " + request.method + " " + request.target +
                    " from " + request.remote_address};
  }

  void Release() {
    const std::lock_guard lock(mutex_);
    is_released_ = true;
    released_.notify_all();
  }
  // False if they do not come for a long time.
  bool WaitForRequests(int count) const {
    const auto end = std::chrono::steady_clock::now() + seconds(120);
    while (num_handled < count && std::chrono::steady_clock::now() < end) {
      std::this_thread::yield();
    }
    return num_handled >= count;
  }

  std::atomic<int> num_handled{0};

 private:
  std::mutex mutex_;
  std::condition_variable released_;
  bool is_released_ = false;
};

class ListenerUnderAttack : public ::testing::Test {
 protected:
  static constexpr int kNumAttackers = 64;

  ListenerUnderAttack() {
    options_.num_threads = 2;
    // No client is late in these tests unless one says so.
    options_.connection.idle_timeout = seconds(120);
    options_.connection.head_timeout = seconds(120);
    options_.connection.body_timeout = seconds(120);
    options_.connection.send_timeout = seconds(120);
  }
  ~ListenerUnderAttack() override { handler_.Release(); }

  void Start() {
    listener_ = std::make_unique<Listener>(options_, &handler_);
    listener_->Start();
  }
  std::unique_ptr<RawSocket> Connect(const std::string& bytes,
                                     const RawSocketOptions& options = {}) const {
    auto client = std::make_unique<RawSocket>(listener_->port(), options);
    client->Send(bytes);
    return client;
  }
  Clients ConnectMany(int count, const std::string& bytes,
                      const RawSocketOptions& options = {}) const {
    Clients clients;
    for (int i = 0; i < count; ++i) {
      clients.push_back(Connect(bytes, options));
    }
    return clients;
  }
  void ExpectServed() const {
    EXPECT_THAT(Connect(kGet)->ReadResponse(), StartsWith("HTTP/1.1 200"));
  }
  // All attackers still hold their connections, and get their answers when they go on.
  static void ExpectAllServedAfter(const std::string& rest, const Clients& clients) {
    for (const auto& client : clients) {
      EXPECT_TRUE(client->IsWaiting());
    }
    for (const auto& client : clients) {
      client->Send(rest);
      EXPECT_THAT(client->ReadResponse(), StartsWith("HTTP/1.1 200"));
    }
  }
  static int NumWaiting(const Clients& clients) {
    return static_cast<int>(std::count_if(clients.begin(), clients.end(),
                                          [](const auto& client) { return client->IsWaiting(); }));
  }

  Handler handler_;
  ListenerOptions options_;
  std::unique_ptr<Listener> listener_;
};

TEST_F(ListenerUnderAttack, SlowHeadsHoldNoWorker) {
  Start();
  const Clients attackers = ConnectMany(kNumAttackers, kHalfHead);
  ExpectServed();
  ExpectAllServedAfter("y\r\n\r\n", attackers);
}

TEST_F(ListenerUnderAttack, SlowBodiesHoldNoWorker) {
  Start();
  const Clients attackers = ConnectMany(kNumAttackers, Post(1000) + "half");
  ExpectServed();
  ExpectAllServedAfter(std::string(996, 'x'), attackers);
}

TEST_F(ListenerUnderAttack, IdleConnectionsHoldNoWorker) {
  Start();
  const Clients attackers = ConnectMany(kNumAttackers, "");
  ExpectServed();
  ExpectAllServedAfter(kGet, attackers);
}

TEST_F(ListenerUnderAttack, ClientsThatDoNotReadHoldNoWorker) {
  constexpr int kNumSilent = 12;
  Start();
  const Clients attackers =
      ConnectMany(kNumSilent, "GET /large HTTP/1.1\r\nHost: h\r\n\r\n", {.receive_bytes = 65536});
  ASSERT_TRUE(handler_.WaitForRequests(kNumSilent));
  ExpectServed();
  // None had its answer by then, and all get the whole of it.
  for (const auto& attacker : attackers) {
    const std::string response = attacker->ReadResponse();
    EXPECT_THAT(response.substr(0, 64), StartsWith("HTTP/1.1 200"));
    EXPECT_GT(response.size(), kLargeBytes);
  }
}

TEST_F(ListenerUnderAttack, AnAnswerThatIsNotReadInTimeEndsTheConnection) {
  options_.connection.send_timeout = milliseconds(50);
  options_.connection.min_send_bytes_per_s = int64_t{1} << 40;
  Start();
  const auto attacker = Connect("GET /large HTTP/1.1\r\nHost: h\r\n\r\n", {.receive_bytes = 65536});
  EXPECT_TRUE(attacker->WaitForReset());
  ExpectServed();
}

TEST_F(ListenerUnderAttack, RequestsThatDoNotArriveInTimeAreToldSo) {
  options_.connection.head_timeout = milliseconds(50);
  options_.connection.body_timeout = milliseconds(50);
  options_.connection.idle_timeout = milliseconds(50);
  Start();
  EXPECT_THAT(Connect(kHalfHead)->ReadAll(), StartsWith("HTTP/1.1 408"));
  EXPECT_THAT(Connect(Post(10))->ReadAll(), StartsWith("HTTP/1.1 408"));
  EXPECT_EQ(Connect("")->ReadAll(), "");
}

TEST_F(ListenerUnderAttack, BytesTooFewToWakeTheLoopCountAtTheDeadline) {
  options_.connection.body_timeout = milliseconds(3000);
  Start();
  const auto client = Connect(
      "POST / HTTP/1.1\r\nHost: h\r\nExpect: 100-continue\r\nContent-Length: 1000000\r\n\r\n");
  ASSERT_THAT(client->ReadResponse(), StartsWith("HTTP/1.1 100"));
  client->Send("five.");
  EXPECT_THAT(client->ReadAll(), HasSubstr("5 of 1000000 body bytes arrived in time"));
}

TEST_F(ListenerUnderAttack, FloodsOfEmptyLinesAreEnded) {
  Start();
  const Clients attackers = ConnectMany(4, std::string(size_t{16} << 20, '\n'));
  ExpectServed();
  for (const auto& attacker : attackers) {
    EXPECT_FALSE(attacker->IsWaiting());
  }
}

TEST_F(ListenerUnderAttack, LargeBodiesArriveWholeInManyPasses) {
  options_.connection.max_body_bytes = kLargeBytes;
  options_.connection.max_bytes_a_pass = 1;
  Start();
  const Clients clients = ConnectMany(3, Post(kLargeBytes) + std::string(kLargeBytes, 'x'));
  for (const auto& client : clients) {
    EXPECT_THAT(client->ReadResponse(), StartsWith("HTTP/1.1 200"));
  }
}

TEST_F(ListenerUnderAttack, TheConnectionThatWaitedLongestGivesWayToANewOne) {
  options_.loop.max_connections = 8;
  Start();
  const Clients attackers = ConnectMany(8, kHalfHead);
  ExpectServed();
  EXPECT_TRUE(attackers.front()->WaitForReset());
  EXPECT_EQ(NumWaiting(attackers), 7);
}

TEST_F(ListenerUnderAttack, TheClientWithMostConnectionsGivesWay) {
  options_.loop.max_connections = 8;
  Start();
  const auto good = Connect(kHalfHead);  // Has waited longest.
  const Clients attackers = ConnectMany(20, kHalfHead, {.source = kOtherClient});
  ExpectServed();
  EXPECT_TRUE(good->IsWaiting());
  EXPECT_LE(NumWaiting(attackers), 7);
  good->Send("y\r\n\r\n");
  EXPECT_THAT(good->ReadResponse(), StartsWith("HTTP/1.1 200"));
}

TEST_F(ListenerUnderAttack, WithAllConnectionsBeingAnsweredANewOneIsTurnedAway) {
  options_.loop.max_connections = 2;
  Start();
  const Clients busy = ConnectMany(2, "GET /hold HTTP/1.1\r\nHost: h\r\n\r\n");
  ASSERT_TRUE(handler_.WaitForRequests(2));
  EXPECT_THAT(Connect(kGet)->ReadAll(), StartsWith("HTTP/1.1 503"));
  handler_.Release();
  for (const auto& client : busy) {
    EXPECT_THAT(client->ReadResponse(), StartsWith("HTTP/1.1 200"));
  }
  ExpectServed();
}

TEST_F(ListenerUnderAttack, BytesInMemoryAreBounded) {
  constexpr size_t kBodyBytes = size_t{1} << 20;
  options_.loop.max_buffered_bytes = 4 * kBodyBytes;
  Start();
  const auto good = Connect(Post(4) + "12");  // Holds its bytes for longest.
  const Clients attackers = ConnectMany(16, Post(kBodyBytes) + std::string(kBodyBytes - 1, 'x'),
                                        {.source = kOtherClient});
  // Three bodies fit beside each other, and not four, with what strings have in reserve.
  const auto end = std::chrono::steady_clock::now() + seconds(120);
  while (NumWaiting(attackers) > 3 && std::chrono::steady_clock::now() < end) {
    std::this_thread::yield();
  }
  EXPECT_LE(NumWaiting(attackers), 3);
  ExpectServed();
  good->Send("34");
  EXPECT_THAT(good->ReadResponse(), StartsWith("HTTP/1.1 200"));
}

// Requests that are being answered cannot give way.
TEST_F(ListenerUnderAttack, AClientWhoseRequestsFillTheMemoryKeepsNobodyOut) {
  constexpr size_t kHeldBytes = size_t{128} << 10, kGoodBytes = size_t{300} << 10;
  constexpr int kMaxHeld = 32;
  options_.loop.max_buffered_bytes = kMaxHeld * kHeldBytes;
  options_.num_threads = kMaxHeld + 1;
  Start();
  const std::string held =
      "POST /hold HTTP/1.1\r\nHost: h\r\nContent-Length: " + std::to_string(kHeldBytes) +
      "\r\n\r\n" + std::string(kHeldBytes, 'x');
  const Clients attackers = ConnectMany(2 * kMaxHeld, held, {.source = kOtherClient});
  const auto end = std::chrono::steady_clock::now() + seconds(120);
  while (NumWaiting(attackers) > handler_.num_handled && std::chrono::steady_clock::now() < end) {
    std::this_thread::yield();
  }
  ASSERT_LT(NumWaiting(attackers), 2 * kMaxHeld) << "the memory is not full";
  Clients idle;  // With them, an equal share of the memory is smaller than the request.
  for (int i = 3; i < 60; ++i) {
    const std::string source = "127.0.0." + std::to_string(i);
    idle.push_back(Connect(kHalfHead, {.source = source.c_str()}));
  }
  const auto good = Connect(Post(kGoodBytes) + std::string(kGoodBytes, 'x'));
  EXPECT_THAT(good->ReadResponse(), StartsWith("HTTP/1.1 200"));
}

TEST_F(ListenerUnderAttack, WithoutFreeDescriptorsAnIdleConnectionGivesWay) {
  if (kSanitizerNeedsFiles) {
    GTEST_SKIP() << "the sanitizers need descriptors themselves";
  }
  Start();
  const Clients attackers = ConnectMany(4, kHalfHead);
  ExpectServed();  // By now they have been accepted.
  RawSocket good{RawSocketOptions{}};
  const NoMoreFiles no_more_files;
  good.Connect(listener_->port());
  good.Send(kGet);
  EXPECT_THAT(good.ReadResponse(), StartsWith("HTTP/1.1 200"));
  EXPECT_TRUE(attackers.front()->WaitForReset());
}

TEST_F(ListenerUnderAttack, AcceptingGoesOnWhenThereAreDescriptorsAgain) {
  if (kSanitizerNeedsFiles) {
    GTEST_SKIP() << "the sanitizers need descriptors themselves";
  }
  Start();
  const Clients busy = ConnectMany(2, "GET /hold HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n");
  ASSERT_TRUE(handler_.WaitForRequests(2));
  RawSocket good{RawSocketOptions{}};
  const NoMoreFiles no_more_files;
  good.Connect(listener_->port());
  good.Send(kGet);
  EXPECT_TRUE(good.IsWaiting());
  handler_.Release();  // Their connections end and leave room.
  EXPECT_THAT(good.ReadResponse(), StartsWith("HTTP/1.1 200"));
}

TEST_F(ListenerUnderAttack, AClientThatHasFinishedSendingGetsItsAnswers) {
  Start();
  const auto client = Connect(std::string(kGet) + kGet);
  client->FinishSending();
  const std::string all = client->ReadAll();
  EXPECT_THAT(all, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(all.substr(1), HasSubstr("HTTP/1.1 200"));
}

TEST_F(ListenerUnderAttack, AClientThatLeavesWhileItsRequestIsAnsweredIsForgotten) {
  Start();
  Connect("GET /hold HTTP/1.1\r\nHost: h\r\n\r\n");
  ASSERT_TRUE(handler_.WaitForRequests(1));
  handler_.Release();
  ExpectServed();
}

TEST_F(ListenerUnderAttack, StopLetsRunningRequestsFinishAndWaitsForNobodyElse) {
  options_.loop.stop_timeout = milliseconds(100);
  Start();
  const auto running = Connect("GET /hold HTTP/1.1\r\nHost: h\r\n\r\n");
  ASSERT_TRUE(handler_.WaitForRequests(1));
  const Clients attackers = ConnectMany(8, kHalfHead);
  const auto upload = Connect(Post(1000) + "the first part");
  const Clients silent =
      ConnectMany(2, "GET /large HTTP/1.1\r\nHost: h\r\n\r\n", {.receive_bytes = 65536});
  ASSERT_TRUE(handler_.WaitForRequests(3));
  std::thread stop([this] { listener_->Stop(); });
  for (const auto& attacker : attackers) {
    const std::string response = attacker->ReadAll();
    EXPECT_THAT(response, StartsWith("HTTP/1.1 503"));
    EXPECT_THAT(response, HasSubstr("the server is stopping"));
  }
  EXPECT_THAT(upload->ReadAll(), StartsWith("HTTP/1.1 503"));
  for (const auto& client : silent) {
    EXPECT_TRUE(client->WaitForReset());
  }
  EXPECT_TRUE(running->IsWaiting());
  EXPECT_THROW(RawSocket{listener_->port()}, std::runtime_error);
  handler_.Release();
  const std::string response = running->ReadAll();
  EXPECT_THAT(response, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(response, HasSubstr("Connection: close"));
  EXPECT_THAT(response, EndsWith("fine"));
  stop.join();
}

TEST_F(ListenerUnderAttack, ATrustedFrontNamesItsClients) {
  options_.trusted_fronts = ParseTrustedFronts("127.0.0.1");
  Start();
  const auto who = [this](const char* source) {
    const auto client = Connect(
        "GET /who HTTP/1.1\r\nHost: h\r\nConnection: close\r\n"
        "X-Forwarded-For: 203.0.113.5\r\nX-Forwarded-For: 192.0.2.7\r\n\r\n",
        {.source = source});
    return client->ReadAll();
  };
  const auto end_with = [](const char* address) {
    return EndsWith(std::string(address) + " " + std::to_string(*NetworkOfAddress(address)));
  };
  EXPECT_THAT(who("127.0.0.1"), end_with("192.0.2.7"));
  EXPECT_THAT(who(kOtherClient), end_with(kOtherClient));
}

TEST_F(ListenerUnderAttack, ABodyIsNotReadIfTheHeadIsRefused) {
  Start();
  const auto client = Connect(
      "POST /forbidden HTTP/1.1\r\nHost: h\r\nContent-Length: 1000000\r\n\r\nthe first part");
  const std::string response = client->ReadAll();
  EXPECT_THAT(response, StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(response, EndsWith("no: POST /forbidden from 127.0.0.1"));
  EXPECT_EQ(handler_.num_handled, 0);
}

TEST_F(ListenerUnderAttack, AMalformedTargetIsRefusedWithItsMethodAndPath) {
  options_.trusted_fronts = ParseTrustedFronts("127.0.0.1");
  Start();
  const auto client =
      Connect("GET /a%zz HTTP/1.1\r\nHost: h\r\nX-Forwarded-For: 192.0.2.7\r\n\r\n");
  const std::string response = client->ReadAll();
  EXPECT_THAT(response, StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(response, EndsWith("no: GET /a%zz from 192.0.2.7"));
  EXPECT_EQ(handler_.num_handled, 0);
}

TEST_F(ListenerUnderAttack, ARequestThatArrivesInPiecesIsOneRequest) {
  Start();
  const auto client = Connect("");
  const std::string request = Post(20'000) + std::string(20'000, 'x') + kGet;
  for (size_t i = 0; i < request.size(); i += 17) {
    client->Send(request.substr(i, 17));
  }
  EXPECT_THAT(client->ReadResponse(), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(client->ReadResponse(), StartsWith("HTTP/1.1 200"));
  EXPECT_EQ(handler_.num_handled, 2);
}

}  // namespace
}  // namespace cairn
