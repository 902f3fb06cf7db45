#include "http/exchange/server_url.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace cairn {
namespace {

TEST(ServerUrl, HasSchemeHostAndPort) {
  const ServerUrl plain = ParseServerUrl("http://map.example:8080");
  EXPECT_FALSE(plain.is_secure);
  EXPECT_EQ(plain.host, "map.example");
  EXPECT_EQ(plain.port, 8080);
  const ServerUrl secure = ParseServerUrl("https://10.0.0.1");
  EXPECT_TRUE(secure.is_secure);
  EXPECT_EQ(secure.host, "10.0.0.1");
  EXPECT_EQ(secure.port, 443);
  EXPECT_EQ(ParseServerUrl("http://[::1]").port, 80);
  EXPECT_EQ(ParseServerUrl("http://[::1]:81").host, "::1");
}

TEST(ServerUrl, MayHaveASlashOrAPathBehindIt) {
  EXPECT_EQ(ParseServerUrl("http://h:8080").prefix, "");
  const ServerUrl slash = ParseServerUrl("HTTP://h:8080/");
  EXPECT_EQ(slash.host, "h");
  EXPECT_EQ(slash.port, 8080);
  EXPECT_EQ(slash.prefix, "");
  const ServerUrl under_path = ParseServerUrl("Https://[::1]/vps/eu/");
  EXPECT_TRUE(under_path.is_secure);
  EXPECT_EQ(under_path.port, 443);
  EXPECT_EQ(under_path.host, "::1");
  EXPECT_EQ(under_path.prefix, "/vps/eu");
}

TEST(ServerUrl, RefusesEverythingElse) {
  for (const char* url : {"",
                          "http://",
                          "https://",
                          "localhost:8080",
                          "ftp://h",
                          "http:///vps",
                          "http://h:",
                          "http://h:0",
                          "http://h:65536",
                          "http://h:80x",
                          "http://[::1",
                          "http://[]:80",
                          "http://:80",
                          "http://user@h",
                          "http://h?x",
                          "http://a b",
                          "http://h\r\nX: y",
                          "http://h/a b",
                          "http://h/a?b",
                          "http://h/\r\nX: y"}) {
    EXPECT_THROW(ParseServerUrl(url), Error) << url;
  }
}

}  // namespace
}  // namespace cairn
