#include "core/wire/json_document.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>
#include <string>

#include "core/file_bytes.h"
#include "core/wire/json_error.h"
#include "core/wire/json_reader.h"
#include "support/test_data.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

// What ParseJson says of a text that it refuses; empty if it accepts it.
std::string Refusal(const std::string& text, const JsonLimits& limits = {}) {
  try {
    ParseJson(text, limits);
    return "";
  } catch (const JsonError& e) {
    EXPECT_EQ(e.code(), ErrorCode::kBadInput);
    EXPECT_FALSE(e.pointer());
    EXPECT_LT(std::string(e.what()).size(), 200u);
    return e.what();
  }
}

// `item` `count` times with commas between.
std::string Repeated(const std::string& item, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += (i == 0 ? "" : ",") + item;
  }
  return text;
}

std::string Members(int count) {
  std::string text = "{";
  for (int i = 0; i < count; ++i) {
    text += fmt::format("{}\"m{}\":0", i == 0 ? "" : ",", i);
  }
  return text + "}";
}

TEST(JsonDocument, HoldsWhatTheTextSays) {
  const JsonDocument document =
      ParseJson(R"({"a":[1,-2,0.5,1e3],"b":{"c":"x\u00e9\n","d":true},"e":{},"f":[],"g":null})");
  const JsonReader json(document);
  EXPECT_EQ(json.At("a").Numbers(4, 4), (std::vector<double>{1, -2, 0.5, 1000}));
  EXPECT_EQ(json.At("b").At("c").String(), "x\xc3\xa9\n");
  EXPECT_TRUE(json.At("b").At("d").Bool());
  json.At("e").RequireOnly({});
  EXPECT_TRUE(json.At("f").Elements(0, 0).empty());
  EXPECT_FALSE(json.Has("g"));  // Null counts as absent.
  EXPECT_EQ(json.At("b").At("d").pointer(), "/b/d");
  EXPECT_EQ(json.At("a").Elements(4, 4)[2].pointer(), "/a/2");
}

TEST(JsonDocument, OneValueMayBeAll) {
  EXPECT_EQ(JsonReader(ParseJson("7")).Integer(0, 9), 7);
  EXPECT_EQ(JsonReader(ParseJson(" \"s\" ")).String(), "s");
}

TEST(JsonDocument, RefusesWhatIsNoJson) {
  for (const char* text : {"", "{", "[1,]", "{\"a\" 1}", "nul", "[1] 2", "\"\xff\"", "NaN", "1e999",
                           "{\"a\":1,}", "'a'", "[1}", "\"\\u12\"", "\"\n\"", "01", "[", "}"}) {
    EXPECT_NE(Refusal(text), "") << text;
  }
  EXPECT_THAT(Refusal("[1,?]"), HasSubstr("byte 4 of 5"));
}

TEST(JsonDocument, BoundsAreInclusive) {
  const JsonLimits limits{
      .max_values = 12, .max_elements = 10, .max_members = 5, .max_depth = 3, .max_name_bytes = 4};
  EXPECT_EQ(Refusal("[" + Repeated("1", 10) + "]", limits), "");
  EXPECT_THAT(Refusal("[" + Repeated("1", 11) + "]", limits), HasSubstr("more than 10 elements"));
  EXPECT_EQ(Refusal(Members(5), limits), "");
  EXPECT_THAT(Refusal(Members(6), limits), HasSubstr("more than 5 members"));
  EXPECT_EQ(Refusal("[[[]]]", limits), "");
  EXPECT_THAT(Refusal("[[[[]]]]", limits), HasSubstr("deeper than 3"));
  EXPECT_EQ(Refusal("[" + Repeated("[1]", 5) + ",1]", limits), "");
  EXPECT_THAT(Refusal("[" + Repeated("[1]", 6) + "]", limits), HasSubstr("more than 12 values"));
  EXPECT_EQ(Refusal(R"({"abcd":1})", limits), "");
  EXPECT_THAT(Refusal(R"({"abcde":1})", limits), HasSubstr("longer than 4 bytes"));
}

TEST(JsonDocument, RefusesTwoMembersOfOneName) {
  EXPECT_THAT(Refusal(R"({"a":1,"b":2,"a":3})"), HasSubstr("two members 'a'"));
  EXPECT_THAT(Refusal(R"({"a":{},"\u0061":3})"), HasSubstr("two members 'a'"));
  EXPECT_THAT(Refusal(R"({"":1,"":3})"), HasSubstr("two members ''"));
  EXPECT_EQ(Refusal(R"([{"a":1},{"a":{"a":3}}])"), "");
}

TEST(JsonDocument, RefusesManySiblingsByTheirNumber) {
  CAIRN_SKIP_WITHOUT_DATA("hostile/json_array_of_133000_empty_objects.json");
  const std::vector<uint8_t> bytes = ReadFileBytes(
      (testing::TestDataDir() / "hostile" / "json_array_of_133000_empty_objects.json").string(),
      1 << 20);
  EXPECT_THAT(Refusal(std::string(bytes.begin(), bytes.end())), HasSubstr("more than"));
}

// Processor seconds of a call; the least of some runs, as others want the processor, too.
template <typename Call>
double SecondsOf(const Call& call) {
  double least = 1e9;
  for (int run = 0; run < 3; ++run) {
    const std::clock_t start = std::clock();
    call();
    least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return least;
}

// The library's own document takes linear time, and new memory as ParseJson does. Comparing every
// sibling with all before it would take some hundred times as long.
TEST(JsonDocument, TimeIsLinearInTheNumberOfSiblings) {
  const JsonLimits many{.max_values = 4'000'000, .max_elements = 4'000'000};
  for (const char* item : {"{}", "[]", "1", "\"\"", "{\"a\":[{}]}"}) {
    const std::string text = "[" + Repeated(item, 300'000) + "]";
    const double ours = SecondsOf([&] { EXPECT_FALSE(ParseJson(text, many).empty()); });
    const double library =
        SecondsOf([&] { EXPECT_EQ(nlohmann::json::parse(text).size(), 300'000); });
    EXPECT_LT(ours, 30.0 * library) << item;
  }
}

}  // namespace
}  // namespace cairn
