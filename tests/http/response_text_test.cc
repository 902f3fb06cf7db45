#include "http/net/response_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/wire/problem.h"

namespace cairn {
namespace {

using ::testing::MatchesRegex;

std::string StatusLine(int status) {
  const std::string head = SerializeResponse({.status = status}, false, std::nullopt).head;
  return head.substr(0, head.find("\r\n"));
}

TEST(ResponseText, TheStatusLineHasTheStandardPhrase) {
  EXPECT_EQ(StatusLine(200), "HTTP/1.1 200 OK");
  EXPECT_EQ(StatusLine(400), "HTTP/1.1 400 Bad Request");
  EXPECT_EQ(StatusLine(503), "HTTP/1.1 503 Service Unavailable");
}

TEST(ResponseText, EveryProblemHasAPhrase) {
  for (const ProblemInfo& problem : AllProblems()) {
    EXPECT_THAT(StatusLine(problem.status), MatchesRegex("HTTP/1.1 [45][0-9]{2} [A-Z][A-Za-z ]+"));
  }
}

}  // namespace
}  // namespace cairn
