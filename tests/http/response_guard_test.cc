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
  EXPECT_EQ(ViolationOf("HTTP/1.0 404\r\nA:\tb \r\n\r\nuntil the end of the connection"), "");
  EXPECT_EQ(ViolationOf("HTTP/1.1 204 \r\nContent-Length: 0\r\ncontent-length:0\r\n\r\n"), "");
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
  EXPECT_THAT(
      ViolationOf("HTTP/1.1 100 Continue\r\nA: b\r\n\r\nHTTP/1.1 200 " + std::string(50'000, 'b')),
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
  EXPECT_THAT(ViolationOf(start + std::string(100'000, '\r')), HasSubstr("8192 bytes"));
}

TEST(ResponseGuard, BoundsTheBody) {
  const std::string head = "HTTP/1.1 200 OK\r\n\r\n";
  EXPECT_EQ(ViolationOf(head + std::string(kMaxBody, ' ')), "");
  EXPECT_THAT(ViolationOf(head + std::string(kMaxBody + 1, ' ')), HasSubstr("1000 bytes"));
}

TEST(ResponseGuard, RefusesLengthsThatReadersUnderstandInDifferentWays) {
  const auto violation_of = [](const std::string& headers) {
    return ViolationOf("HTTP/1.1 200 OK\r\n" + headers + "\r\n\r\n{}");
  };
  EXPECT_EQ(violation_of("Content-Length: 2"), "");
  EXPECT_EQ(violation_of("Content-Length: 2\r\nA: b\r\nCONTENT-LENGTH: 02"), "");
  EXPECT_THAT(violation_of("Content-Length: 2\r\nContent-Length: 1"), HasSubstr("different"));
  EXPECT_THAT(violation_of("Content-Length: 1\r\nA: b\r\ncontent-length: 2"),
              HasSubstr("different"));
  for (const char* length : {"", "+2", "-2", "2,2", "2 2", "2;", "0x2", "2.0", "2e0", "two",
                             "18446744073709551618", "99999999999999999999999"}) {
    EXPECT_THAT(violation_of("Content-Length: " + std::string(length)), HasSubstr("not a number"))
        << length;
  }
}

TEST(ResponseGuard, RefusesTransferEncodingsThatTheLibraryDoesNotKnow) {
  const auto violation_of = [](const std::string& headers) {
    return ViolationOf("HTTP/1.1 200 OK\r\n" + headers + "\r\n\r\n0\r\n\r\n");
  };
  EXPECT_EQ(violation_of("Transfer-Encoding: chunked"), "");
  EXPECT_EQ(violation_of("transfer-encoding:\tChunked "), "");
  for (const char* encoding :
       {"", "gzip", "gzip, chunked", "chunked, chunked", "xchunked", "identity", "chunked;a=b"}) {
    EXPECT_THAT(violation_of("Transfer-Encoding: " + std::string(encoding)),
                HasSubstr("than 'chunked'"))
        << encoding;
  }
  const std::string chunked = "Transfer-Encoding: chunked";
  EXPECT_THAT(violation_of(chunked + "\r\n" + chunked), HasSubstr("than 'chunked'"));
  EXPECT_THAT(violation_of(chunked + "\r\nContent-Length: 5"), HasSubstr("both"));
  EXPECT_THAT(violation_of("Content-Length: 5\r\n" + chunked), HasSubstr("both"));
}

TEST(ResponseGuard, RefusesLinesThatTheLibrarySkips) {
  const auto violation_of = [](const std::string& lines) {
    return ViolationOf("HTTP/1.1 200 OK\r\nA: b\r\n" + lines + "\r\n\r\n");
  };
  for (const std::string line :
       {" folded: line", "\tfolded", "Content-Length : 2", "no colon", ": no name", "A b: c",
        "A: b\rContent-Length: 2", "A: \x01", "A: \x7f"}) {
    EXPECT_THAT(violation_of(line), HasSubstr("not 'Name: value'")) << line;
  }
  EXPECT_THAT(violation_of(std::string("A: \0b", 5)), HasSubstr("control character"));
  EXPECT_THAT(violation_of(std::string("A\0: b", 5)), HasSubstr("control character"));
  EXPECT_THAT(violation_of("A: b\nContent-Length: 2"), HasSubstr("carriage return"));
  EXPECT_EQ(violation_of("A: caf\xc3\xa9"), "");
  for (const std::string status : {"200\rA", "2000", "20", "20x OK", "", " 200", "200 \x01"}) {
    EXPECT_THAT(ViolationOf("HTTP/1.1 " + status + "\r\n\r\n"), HasSubstr("HTTP/1.0 or HTTP/1.1"))
        << status;
  }
  EXPECT_THAT(ViolationOf("HTTP/1.1 103 Early Hints\r\n\r\n"), HasSubstr("interim status 103"));
}

TEST(ResponseGuard, FollowsChunks) {
  const auto violation_of = [](const std::string& body) {
    return ViolationOf("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n" + body);
  };
  EXPECT_EQ(violation_of("2\r\n{}\r\n0A;a=\"b\"\r\n0123456789\r\n1 \r\n\n\r\n0\r\nA: b\r\n\r\n"),
            "");
  for (const char* size : {"", "-1", "+1", "0x1", " 1", "x", "1 2", "1,", "fffffffffffffffff"}) {
    EXPECT_THAT(violation_of(std::string(size) + "\r\n"), HasSubstr("no size")) << size;
  }
  EXPECT_THAT(violation_of("2\r\n{}}\r\n"), HasSubstr("longer than its size"));
  EXPECT_THAT(violation_of("2\n{}\n"), HasSubstr("carriage return"));
  EXPECT_THAT(violation_of("0\r\nno colon\r\n"), HasSubstr("behind the last chunk"));
  EXPECT_THAT(violation_of(std::string(100'000, '0')), HasSubstr("1000 bytes"));
}

TEST(ResponseGuard, RefusesBytesBehindTheEnd) {
  const std::string next = "HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n";
  for (const std::string response :
       {"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\n{}", "HTTP/1.1 204 \r\n\r\n",
        "HTTP/1.1 304 \r\nContent-Length: 5\r\n\r\n",
        "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"}) {
    EXPECT_EQ(ViolationOf(response), "");
    EXPECT_THAT(ViolationOf(response + next), HasSubstr("follow the end")) << response;
  }
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
