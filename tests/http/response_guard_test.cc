#include "http/exchange/response_guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace cairn {
namespace {

using ::testing::HasSubstr;

constexpr size_t kMaxBody = 1000;

std::string ViolationOf(const std::string& response) {
  ResponseGuard guard(kMaxBody);
  guard.Take(response);
  return guard.violation();
}

TEST(ResponseGuard, LetsOrdinaryResponsesPass) {
  EXPECT_EQ(ViolationOf("HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\n{}"), "");
  EXPECT_EQ(ViolationOf("HTTP/1.0 404 \nA: b\n\nbare line feeds"), "");
  EXPECT_EQ(ViolationOf("HTTP/1.1 100 Continue\r\n\r\nHTTP/1.1 200 OK\r\n\r\n"), "");
}

TEST(ResponseGuard, GivesTheSameVerdictForOneByteAtATime) {
  const std::string response = "HTTP/1.1 200 " + std::string(1000, 'b') + "\r\n\r\nbody";
  ResponseGuard guard(kMaxBody);
  EXPECT_TRUE(guard.Take(response));
  ResponseGuard by_bytes(kMaxBody);
  for (const char byte : response) {
    EXPECT_TRUE(by_bytes.Take({&byte, 1}));
  }
}

TEST(ResponseGuard, BoundsTheStatusLine) {
  EXPECT_THAT(ViolationOf("HTTP/1.1 200 " + std::string(50'000, 'b')), HasSubstr("1024 bytes"));
}

TEST(ResponseGuard, BoundsTheStatusLineBehindAnInterimResponse) {
  EXPECT_THAT(ViolationOf("HTTP/1.1 103 Early Hints\r\nA: b\r\n\r\nHTTP/1.1 200 " +
                          std::string(50'000, 'b')),
              HasSubstr("1024 bytes"));
}

TEST(ResponseGuard, BoundsLinesAndHeads) {
  const std::string start = "HTTP/1.1 200 OK\r\n";
  EXPECT_THAT(ViolationOf(start + "A: " + std::string(9000, 'b')), HasSubstr("8192 bytes"));
  std::string many = start;
  for (int i = 0; i < 10'000; ++i) {
    many += "A: b\r\n";
  }
  EXPECT_THAT(ViolationOf(many), HasSubstr("32768 bytes"));
  std::string interim;
  for (int i = 0; i < 10'000; ++i) {
    interim += "HTTP/1.1 100 Continue\r\n\r\n";
  }
  EXPECT_THAT(ViolationOf(interim), HasSubstr("32768 bytes"));
  EXPECT_THAT(ViolationOf(start + std::string(100'000, '\r')), HasSubstr("32768 bytes"));
}

TEST(ResponseGuard, BoundsTheBody) {
  const std::string head = "HTTP/1.1 200 OK\r\n\r\n";
  EXPECT_EQ(ViolationOf(head + std::string(kMaxBody, ' ')), "");
  EXPECT_THAT(ViolationOf(head + std::string(kMaxBody + 1, ' ')), HasSubstr("1000 bytes"));
}

TEST(ResponseGuard, KnowsWhatIsNotHttp) {
  for (const char* bytes : {"SSH-2.0-OpenSSH_9.2\r\n", "HTTP/2 200\r\n", "\r\n", "HTTP\r\n",
                            "\x15\x03\x01\x00\x02\x02\x50"}) {
    EXPECT_THAT(ViolationOf(bytes), HasSubstr("not HTTP")) << bytes;
  }
}

TEST(ResponseGuard, StaysAtItsVerdict) {
  ResponseGuard guard(kMaxBody);
  EXPECT_FALSE(guard.Take("no"));
  EXPECT_FALSE(guard.Take("HTTP/1.1 200 OK\r\n\r\n"));
}

}  // namespace
}  // namespace cairn
