#include "http/net/url.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cairn {
namespace {

using ::testing::Pair;
using ::testing::UnorderedElementsAre;

TEST(Url, SplitsAndDecodesTheQuery) {
  const auto target = ParseTarget("/v1/a%2Fb?lat=1.5&name=a+b%20c&&flag&empty=");
  ASSERT_TRUE(target.has_value());
  EXPECT_EQ(target->path, "/v1/a/b");
  EXPECT_THAT(target->query, UnorderedElementsAre(Pair("lat", "1.5"), Pair("name", "a b c"),
                                                  Pair("flag", ""), Pair("empty", "")));
}

TEST(Url, AQueryMayContainMoreQuestionMarks) {
  EXPECT_THAT(ParseTarget("/?q=what?")->query, UnorderedElementsAre(Pair("q", "what?")));
}

TEST(Url, RefusesMalformedEscapesAndNul) {
  for (const char* target : {"/%", "/%4", "/%zz", "/%4 ", "/%00", "/?a=%", "/?%=1", "/%+1"}) {
    EXPECT_FALSE(ParseTarget(target).has_value()) << target;
  }
}

}  // namespace
}  // namespace cairn
