#include "http/exchange/bounded_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <latch>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "core/error.h"
#include "http/plain_http.h"
#include "support/canned_server.h"
#include "support/hostile_server.h"
#include "support/temp_dir.h"
#include "support/tls_certificate.h"

namespace cairn {
namespace {

using testing::CannedServer;
using testing::Connection;
using ::testing::HasSubstr;
using testing::HostileServer;
using ::testing::Not;
using testing::TlsCertificate;

ClientResponse Ask(const std::string& url, int timeout_ms = 20'000,
                   size_t max_body_bytes = 100'000) {
  return BoundedClient({.url = url, .timeout_ms = timeout_ms, .max_body_bytes = max_body_bytes})
      .Send({.path = "/"});
}

// What a client says of a server that answers with these bytes, then closes.
ClientResponse AnswerTo(const std::string& bytes) {
  const HostileServer server([&](Connection* connection) { connection->Send(bytes); });
  return Ask(server.url());
}

TEST(BoundedClient, SendsARequestAndReturnsTheResponse) {
  const CannedServer server([](const httplib::Request& request, httplib::Response& response) {
    response.status = 201;
    response.set_header("X-Cell", request.get_header_value("X-Cell") + "!");
    response.set_content(request.method + request.path + request.body, "text/plain");
  });
  BoundedClient client({.url = server.url()});
  for (int i = 0; i < 2; ++i) {  // On one connection.
    const ClientResponse response = client.Send(
        {.method = "POST", .path = "/v1", .headers = {{"X-Cell", "a"}}, .body = "body"});
    EXPECT_EQ(response.status, 201);
    EXPECT_EQ(response.Header("x-cell"), "a!");
    EXPECT_EQ(response.body, "POST/v1body");
    EXPECT_EQ(response.failure, "");
  }
}

TEST(BoundedClient, ALongStatusLineIsRefusedBeforeTheLibrarySeesIt) {
  for (const size_t length : {50'000, 10'000'000}) {
    const ClientResponse response =
        AnswerTo("HTTP/1.1 200 " + std::string(length, 'b') + "\r\n\r\n");
    EXPECT_EQ(response.status, 0);
    EXPECT_TRUE(response.is_garbled);
    EXPECT_THAT(response.failure, HasSubstr("1024 bytes"));
  }
}

TEST(BoundedClient, EndlessHeadsAndBodiesAreBrokenOff) {
  const auto failure_of = [](const std::string& start, const std::string& again) {
    const HostileServer server([&](Connection* connection) {
      connection->Send(start);
      while (connection->Send(again)) {
      }
    });
    return Ask(server.url()).failure;
  };
  EXPECT_THAT(failure_of("HTTP/1.1 200 OK\r\n", "A: b\r\n"), HasSubstr("32768 bytes"));
  EXPECT_THAT(failure_of("HTTP/1.1 200 OK\r\n\r\n", std::string(1000, ' ')),
              HasSubstr("100000 bytes"));
  EXPECT_THAT(failure_of("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n", "1\r\n \r\n"),
              HasSubstr("100000 bytes"));
  EXPECT_THAT(failure_of("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n", "0"),
              HasSubstr("8192 bytes"));
  EXPECT_THAT(failure_of("", "HTTP/1.1 100 Continue\r\n\r\n"), HasSubstr("32768 bytes"));
}

TEST(BoundedClient, AServerThatTricklesMeetsTheDeadlineOfTheExchange) {
  for (const char* start : {"HTTP/1.1 200 ", "HTTP/1.1 200 OK\r\nContent-Length: 99999\r\n\r\n"}) {
    const HostileServer server([&](Connection* connection) {
      connection->Send(start);
      while (connection->Send(" ") && !connection->PeerClosesWithin(/*timeout_ms=*/5)) {
      }
    });
    const ClientResponse response = Ask(server.url(), /*timeout_ms=*/200);
    EXPECT_EQ(response.status, 0);
    EXPECT_THAT(response.failure, HasSubstr("200 ms"));
  }
}

TEST(BoundedClient, ASilentServerMeetsTheDeadline) {
  const HostileServer server(
      [](Connection* connection) { connection->PeerClosesWithin(/*timeout_ms=*/60'000); });
  EXPECT_THAT(Ask(server.url(), /*timeout_ms=*/50).failure, HasSubstr("50 ms"));
}

TEST(BoundedClient, ACompressedBodyCountsAsItIsAfterwards) {
  const CannedServer server([](const httplib::Request&, httplib::Response& response) {
    response.set_content(std::string(10'000'000, ' '), "application/json");
  });
  BoundedClient client({.url = server.url(), .max_body_bytes = 1'000'000});
  const ClientResponse response =
      client.Send({.path = "/", .headers = {{"Accept-Encoding", "gzip"}}});
  EXPECT_EQ(response.status, 0);
  EXPECT_TRUE(response.is_garbled);
  EXPECT_THAT(response.failure, HasSubstr("1000000 bytes"));
}

TEST(BoundedClient, WhatIsNotHttpIsSaid) {
  EXPECT_THAT(AnswerTo("SSH-2.0-OpenSSH_9.2\r\n").failure, HasSubstr("not HTTP"));
  EXPECT_EQ(AnswerTo("").status, 0);
  EXPECT_EQ(AnswerTo("HTTP/1.1 200 OK\r\nContent-Length: 10\r\n\r\nfive.").status, 0);
}

TEST(BoundedClient, ResponsesWithTwoLengthsAreRefused) {
  const ClientResponse response =
      AnswerTo("HTTP/1.1 200 OK\r\nContent-Length: 2\r\nContent-Length: 5\r\n\r\n{}   ");
  EXPECT_EQ(response.status, 0);
  EXPECT_TRUE(response.is_garbled);
  EXPECT_THAT(response.failure, HasSubstr("two different Content-Lengths"));
}

TEST(BoundedClient, AResponseThatNobodyAskedForAnswersNoRequest) {
  std::latch answered(1), planted(1);
  int num_connections = 0;
  const HostileServer server([&](Connection* connection) {
    if (++num_connections == 2) {
      connection->Send("HTTP/1.1 200 OK\r\nContent-Length: 6\r\n\r\nsecond");
      return;
    }
    connection->Send("HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\nfirst");
    answered.wait();
    connection->Send("HTTP/1.1 200 OK\r\nContent-Length: 7\r\n\r\nplanted");
    planted.count_down();
    connection->PeerClosesWithin(/*timeout_ms=*/20'000);
  });
  BoundedClient client({.url = server.url()});
  EXPECT_EQ(client.Send({.path = "/"}).body, "first");
  answered.count_down();
  planted.wait();
  EXPECT_EQ(client.Send({.path = "/"}).body, "second");
}

TEST(BoundedClient, StopEndsTheExchange) {
  std::latch asked(1);
  const HostileServer server([&](Connection* connection) {
    asked.count_down();
    connection->PeerClosesWithin(/*timeout_ms=*/60'000);
  });
  BoundedClient client({.url = server.url(), .timeout_ms = 60'000});
  std::thread stopper([&] {
    asked.wait();
    client.Stop();
  });
  EXPECT_EQ(client.Send({.path = "/"}).status, 0);
  stopper.join();
}

// A server with this certificate, and a client that trusts those in `ca_file`.
ClientResponse AskSecurely(const TlsCertificate& certificate, const std::string& ca_file,
                           const std::string& host = "localhost") {
  httplib::SSLServer server(certificate.certificate(), certificate.key());
  server.Get("/", [](const httplib::Request&, httplib::Response& response) {
    response.set_content(std::string(100'000, 'x'), "text/plain");
  });
  const int port = server.bind_to_any_port("127.0.0.1");
  std::thread thread([&] { server.listen_after_bind(); });
  BoundedClient client({.url = "https://" + host + ":" + std::to_string(port), .ca_file = ca_file});
  ClientResponse response = client.Send({.path = "/"});
  if (response.status != 0) {
    response = client.Send({.path = "/"});  // On the same connection.
  }
  server.stop();
  thread.join();
  return response;
}

TEST(BoundedClient, SpeaksTlsWithAServerThatItTrusts) {
  const testing::TempDir dir;
  const TlsCertificate certificate({.host = "localhost"});
  certificate.WriteTo(dir.File("ca.pem"));
  const ClientResponse response = AskSecurely(certificate, dir.File("ca.pem"));
  EXPECT_EQ(response.status, 200) << response.failure;
  EXPECT_EQ(response.body.size(), 100'000u);
}

TEST(BoundedClient, RefusesCertificatesOfOthersOfOtherHostsAndOld) {
  const testing::TempDir dir;
  const TlsCertificate certificate({.host = "localhost"}), other({.host = "localhost"}),
      elsewhere({.host = "elsewhere.example"}), old({.host = "localhost", .days_left = -1});
  other.WriteTo(dir.File("other.pem"));
  elsewhere.WriteTo(dir.File("elsewhere.pem"));
  old.WriteTo(dir.File("old.pem"));
  EXPECT_THAT(AskSecurely(certificate, dir.File("other.pem")).failure, HasSubstr("not accepted"));
  EXPECT_THAT(AskSecurely(certificate, "").failure, HasSubstr("not accepted"));
  EXPECT_THAT(AskSecurely(elsewhere, dir.File("elsewhere.pem")).failure, HasSubstr("hostname"));
  EXPECT_THAT(AskSecurely(old, dir.File("old.pem")).failure, HasSubstr("expired"));
}

TEST(BoundedClient, AHandshakeThatDoesNotEndMeetsTheDeadline) {
  constexpr std::string_view kHalfHello("\x16\x03\x03\x3f\xff\x02\x00\x3f\xfb\x03\x03", 11);
  constexpr std::string_view kHelloRequest("\x16\x03\x03\x00\x04\x00\x00\x00\x00", 9);
  for (const std::string_view step : {std::string_view(), kHalfHello, kHelloRequest}) {
    const HostileServer server([&](Connection* connection) {
      do {
        connection->Send(step);
      } while (!connection->PeerClosesWithin(/*timeout_ms=*/5));
    });
    const ClientResponse response = Ask("https" + server.url().substr(4), /*timeout_ms=*/200);
    EXPECT_EQ(response.status, 0);
    EXPECT_THAT(response.failure, HasSubstr("200 ms")) << step.size();
  }
}

TEST(BoundedClient, APlainServerIsNotTakenForASecureOne) {
  const HostileServer server(
      [](Connection* connection) { connection->Send("HTTP/1.1 200 OK\r\n\r\n"); });
  const ClientResponse response = Ask("https" + server.url().substr(4));
  EXPECT_EQ(response.status, 0);
  EXPECT_THAT(response.failure, HasSubstr("TLS"));
}

TEST(BoundedClient, RefusesOptionsThatMakeNoSense) {
  EXPECT_THROW(BoundedClient({.url = "http://h", .timeout_ms = 0}), Error);
  EXPECT_THROW(BoundedClient({.url = "http://h", .max_body_bytes = 0}), Error);
  EXPECT_THROW(BoundedClient({.url = "http://h", .ca_file = "ca.pem"}), Error);
  EXPECT_THROW(BoundedClient({.url = "https://h", .ca_file = "/no/such/file"}), Error);
}

// What a client with this key and URL is refused with; empty if it is not.
std::string RefusalOfKey(const std::string& url, const std::string& key, bool allow_plain = false) {
  try {
    BoundedClientOptions{.url = url, .api_key = key, .allow_plain_key = allow_plain}.Validate();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "";
}

TEST(BoundedClient, SendsItsKeyWithEachRequest) {
  const CannedServer server([](const httplib::Request& request, httplib::Response& response) {
    response.set_content(request.get_header_value("Authorization"), "text/plain");
  });
  BoundedClient client({.url = server.url(), .api_key = "cairn_abc-_9"});
  EXPECT_EQ(client.Send({.path = "/"}).body, "Bearer cairn_abc-_9");
  EXPECT_EQ(client.Send({.path = "/"}).body, "Bearer cairn_abc-_9");
}

TEST(BoundedClient, TakesItsKeyNowhereElse) {
  std::string heard = "nothing";
  const CannedServer thief([&](const httplib::Request& request, httplib::Response&) {
    heard = request.get_header_value("Authorization");
  });
  for (const int status : {301, 302, 307, 308}) {
    const CannedServer server([&](const httplib::Request&, httplib::Response& response) {
      response.set_redirect(thief.url() + "/v1/localize", status);
    });
    BoundedClient client({.url = server.url(), .api_key = "cairn_abc"});
    EXPECT_EQ(client.Send({.path = "/"}).status, status);
  }
  EXPECT_EQ(heard, "nothing");
}

TEST(BoundedClient, SendsNoKeyThatOthersCanRead) {
  EXPECT_EQ(RefusalOfKey("https://map.example", "cairn_abc"), "");
  for (const char* here : {"http://127.0.0.1:80", "http://localhost:80", "http://[::1]:80"}) {
    EXPECT_EQ(RefusalOfKey(here, "cairn_abc"), "") << here;
  }
  for (const char* there : {"http://map.example", "http://10.0.0.1:80", "http://[2001:db8::1]",
                            "http://127.0.0.1.example", "http://localhost.example"}) {
    const std::string refusal = RefusalOfKey(there, "cairn_abc");
    EXPECT_THAT(refusal, HasSubstr("use https://")) << there;
    EXPECT_THAT(refusal, Not(HasSubstr("cairn_abc")));
    EXPECT_EQ(RefusalOfKey(there, "cairn_abc", /*allow_plain=*/true), "");
    EXPECT_EQ(RefusalOfKey(there, ""), "") << "no key, no harm";
  }
}

TEST(BoundedClient, RefusesKeysThatBreakAHeader) {
  for (const char* key : {"two words", "a\r\nX: y", "a\n", "caf\xc3\xa9", "\x7f"}) {
    const std::string refusal = RefusalOfKey("https://map.example", key);
    EXPECT_THAT(refusal, HasSubstr("client.api_key"));
    EXPECT_THAT(refusal, Not(HasSubstr(key)));
  }
}

TEST(ClientResponse, SaysWhenToReturn) {
  const auto pause = [](int status, const std::string& text) {
    ClientResponse response;
    response.status = status;
    response.headers = {{"retry-after", text}};
    return response.RetryAfter();
  };
  EXPECT_EQ(pause(429, "17"), std::chrono::seconds(17));
  EXPECT_EQ(pause(429, "0"), std::chrono::seconds(1));
  for (const char* text : {"", "-1", "soon", "1.5", "99999999999", "Thu, 26 Nov 2026 09:00 GMT"}) {
    EXPECT_EQ(pause(429, text), std::nullopt) << text;
  }
  EXPECT_EQ(pause(200, "17"), std::nullopt);
}

TEST(ClientResponse, ADateToReturnCountsFromThatOfTheResponse) {
  ClientResponse response;
  response.status = 429;
  response.headers = {{"Date", "Thu, 26 Nov 2026 23:59:50 GMT"},
                      {"Retry-After", "Fri, 27 Nov 2026 00:00:20 GMT"}};
  EXPECT_EQ(response.RetryAfter(), std::chrono::seconds(30));
  response.headers[1].second = "Thu, 26 Nov 2026 00:00:00 GMT";
  EXPECT_EQ(response.RetryAfter(), std::chrono::seconds(1));
}

}  // namespace
}  // namespace cairn
