#include "http/net/request_head.h"

#include <gtest/gtest.h>

#include "core/wire/problem.h"

namespace cairn {
namespace {

constexpr size_t kMaxBodyBytes = size_t{2} << 20;

RequestHead ParseHead(const std::string& text) { return ParseRequestHead(text, kMaxBodyBytes); }

int StatusOf(const std::string& text) {
  try {
    ParseHead(text);
  } catch (const HttpError& e) {
    return InfoOf(e.problem()).status;
  }
  return 200;
}

std::string PostHead(const std::string& headers) {
  return "POST /v1/localize HTTP/1.1\r\nHost: h\r\n" + headers + "\r\n";
}

TEST(RequestHead, ReadsMethodTargetAndHeaders) {
  const RequestHead head = ParseHead(
      "POST /a?b=c HTTP/1.1\r\nHost: h\r\nContent-Length: 12\r\nX-Thing:  some value \r\n\r\n");
  EXPECT_EQ(head.method, "POST");
  EXPECT_EQ(head.target, "/a?b=c");
  EXPECT_EQ(head.content_length, 12u);
  EXPECT_EQ(head.Header("x-thing"), "some value");
  EXPECT_TRUE(head.keep_alive);
  EXPECT_FALSE(head.expects_continue);
}

TEST(RequestHead, KnowsWhenTheConnectionEnds) {
  EXPECT_FALSE(ParseHead("GET / HTTP/1.1\r\nHost: h\r\nConnection: Close\r\n\r\n").keep_alive);
  EXPECT_FALSE(ParseHead("GET / HTTP/1.0\r\n\r\n").keep_alive);
  EXPECT_TRUE(ParseHead("GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n").keep_alive);
}

TEST(RequestHead, TheConnectionHeaderIsAListOfTokens) {
  const auto keeps = [](const std::string& version, const std::string& headers) {
    return ParseHead("GET / HTTP/" + version + "\r\nHost: h\r\n" + headers + "\r\n").keep_alive;
  };
  EXPECT_FALSE(keeps("1.1", "Connection: TE, close\r\n"));
  EXPECT_FALSE(keeps("1.1", "Connection: TE\r\nConnection: , CLOSE ,\r\n"));
  EXPECT_FALSE(keeps("1.1", "Connection: keep-alive, close\r\n"));
  EXPECT_TRUE(keeps("1.1", "Connection: TE, closed\r\nX-Connection: close\r\n"));
  EXPECT_TRUE(keeps("1.0", "Connection: TE,Keep-Alive\r\n"));
}

TEST(RequestHead, ATargetMayNameSchemeAndHost) {
  const auto target = [](const std::string& text) {
    return ParseHead("GET " + text + " HTTP/1.1\r\nHost: h\r\n\r\n").target;
  };
  EXPECT_EQ(target("http://127.0.0.1:8080/version?a=b"), "/version?a=b");
  EXPECT_EQ(target("HTTPS://map.example"), "/");
  EXPECT_EQ(target("http://map.example?a=/b"), "/?a=/b");
  EXPECT_EQ(StatusOf("GET ftp://h/version HTTP/1.1\r\nHost: h\r\n\r\n"), 400);
}

TEST(RequestHead, RefusesAmbiguousFraming) {
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 1\r\nContent-Length: 1\r\n")), 400);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 1\r\nTransfer-Encoding: chunked\r\n")), 400);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 1, 1\r\n")), 400);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: +1\r\n")), 400);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: -1\r\n")), 400);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 0x10\r\n")), 400);
  EXPECT_EQ(StatusOf(PostHead("Content-Length:\r\n")), 400);
  EXPECT_EQ(StatusOf(PostHead("Content-Length : 1\r\n")), 400);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 1\r\n folded\r\n")), 400);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 1\nTransfer-Encoding: chunked\r\n")), 400);
}

TEST(RequestHead, RefusesBodiesItCannotBound) {
  EXPECT_EQ(StatusOf(PostHead("")), 411);
  EXPECT_EQ(StatusOf(PostHead("Transfer-Encoding: chunked\r\n")), 411);
  EXPECT_EQ(StatusOf("GET / HTTP/1.1\r\nHost: h\r\nTransfer-Encoding: chunked\r\n\r\n"), 411);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 2097153\r\n")), 413);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 99999999999999999999999\r\n")), 413);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 9\r\nContent-Encoding: gzip\r\n")), 415);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 9\r\nContent-Encoding: identity\r\n")), 200);
  EXPECT_EQ(StatusOf(PostHead("Content-Length: 2097152\r\n")), 200);
}

TEST(RequestHead, RefusesMalformedRequestLines) {
  EXPECT_EQ(StatusOf("GET\r\n\r\n"), 400);
  EXPECT_EQ(StatusOf("GET /\r\n\r\n"), 400);
  EXPECT_EQ(StatusOf("GET / b HTTP/1.1\r\nHost: h\r\n\r\n"), 400);
  EXPECT_EQ(StatusOf("GET /\xc3\xa4 HTTP/1.1\r\nHost: h\r\n\r\n"), 400);
  EXPECT_EQ(StatusOf("GET h/ HTTP/1.1\r\nHost: h\r\n\r\n"), 400);
  EXPECT_EQ(StatusOf("G(T / HTTP/1.1\r\nHost: h\r\n\r\n"), 400);
  EXPECT_EQ(StatusOf("BREW / HTTP/1.1\r\nHost: h\r\n\r\n"), 501);
  EXPECT_EQ(StatusOf("GET / HTTP/2.0\r\nHost: h\r\n\r\n"), 505);
  EXPECT_EQ(StatusOf("GET / SMTP/1.1\r\nHost: h\r\n\r\n"), 400);
  EXPECT_EQ(StatusOf("GET /" + std::string(5000, 'a') + " HTTP/1.1\r\nHost: h\r\n\r\n"), 414);
}

TEST(RequestHead, RefusesMalformedHeaders) {
  const auto get = [](const std::string& headers) {
    return "GET / HTTP/1.1\r\nHost: h\r\n" + headers + "\r\n";
  };
  EXPECT_EQ(StatusOf("GET / HTTP/1.1\r\n\r\n"), 400);  // No Host.
  EXPECT_EQ(StatusOf(get("Host: other\r\n")), 400);
  EXPECT_EQ(StatusOf(get("no colon\r\n")), 400);
  EXPECT_EQ(StatusOf(get(": nameless\r\n")), 400);
  EXPECT_EQ(StatusOf(get(std::string("X: a\0b\r\n", 8))), 400);
  EXPECT_EQ(StatusOf(get("X: a\rb\r\n")), 400);
  EXPECT_EQ(StatusOf(get("Expect: a miracle\r\n")), 417);
  std::string many;
  for (int i = 0; i < 70; ++i) {
    many += "X: y\r\n";
  }
  EXPECT_EQ(StatusOf(get(many)), 431);
}

TEST(RequestHead, RefusesEveryTruncationOfAGoodHead) {
  const std::string head = PostHead("Content-Length: 5\r\n");
  for (size_t size = 0; size < head.size(); ++size) {
    EXPECT_EQ(StatusOf(head.substr(0, size)), 400) << size;
  }
}

// A front that compares paths may take "/metrics#a" for another path than "/metrics".
TEST(RequestHead, RefusesFragments) {
  EXPECT_THROW(ParseRequestHead("GET /metrics#a HTTP/1.1\r\nHost: h\r\n\r\n", 100), HttpError);
}

}  // namespace
}  // namespace cairn
