#include "core/wire/problem.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "core/wire/json_error.h"

namespace cairn {
namespace {

TEST(Problem, EveryCodeHasItsOwnNameAndAnErrorStatus) {
  std::set<std::string> names;
  for (const ProblemInfo& info : AllProblems()) {
    EXPECT_EQ(&InfoOf(info.code), &info);
    EXPECT_GE(info.status, 400);
    EXPECT_LT(info.status, 600);
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
  }
}

TEST(Problem, JsonHasTheMembersOfRfc9457) {
  const HttpError error =
      HttpError(ProblemCode::kInvalidField, "/camera: is missing").At("/camera").Hint("send it");
  const auto json = nlohmann::json::parse(ProblemJson(error, "r1"));
  EXPECT_EQ(json["type"], "urn:cairn:problem:invalid_field");
  EXPECT_EQ(json["status"], 400);
  EXPECT_EQ(json["code"], "invalid_field");
  EXPECT_EQ(json["errors"][0]["pointer"], "/camera");
  EXPECT_EQ(json["hint"], "send it");
  EXPECT_EQ(json["requestId"], "r1");
}

TEST(Problem, TheJsonOfARequestIsAtFaultWhereItsReaderSays) {
  const HttpError field = PublicError(JsonError("/a/b: is missing", "/a/b", "send it"));
  EXPECT_EQ(field.problem(), ProblemCode::kInvalidField);
  EXPECT_STREQ(field.what(), "/a/b: is missing");
  EXPECT_EQ(field.pointer(), "/a/b");
  EXPECT_EQ(field.hint(), "send it");
  EXPECT_TRUE(PublicError(JsonError("the top level: must be an object", "", "")).has_pointer());
  const HttpError text = PublicError(JsonError("does not parse", std::nullopt, ""));
  EXPECT_EQ(text.problem(), ProblemCode::kInvalidJson);
  EXPECT_FALSE(text.has_pointer());
}

TEST(Problem, ARefusalStaysAsItIs) {
  const HttpError refusal = HttpError(ProblemCode::kWrongCodec, "another map").At("/features");
  const Error& error = refusal;
  EXPECT_EQ(PublicError(error).problem(), ProblemCode::kWrongCodec);
  EXPECT_EQ(PublicError(error).pointer(), "/features");
}

TEST(Problem, JsonSurvivesDetailsThatAreNotUtf8) {
  EXPECT_FALSE(nlohmann::json::parse(
                   ProblemJson(HttpError(ProblemCode::kNotFound, "\xff\xfe"), "r1"), nullptr, false)
                   .is_discarded());
}

TEST(Problem, ServerFaultsDoNotTellTheirMessages) {
  for (const ErrorCode code : {ErrorCode::kInternal, ErrorCode::kIo, ErrorCode::kMapDamaged,
                               ErrorCode::kNotFound, ErrorCode::kConflict}) {
    const HttpError shown = PublicError(Error(code, "/secret/path is damaged"));
    EXPECT_EQ(InfoOf(shown.problem()).status, code == ErrorCode::kConflict ? 503 : 500);
    EXPECT_EQ(std::string(shown.what()).find("secret"), std::string::npos);
  }
  EXPECT_STREQ(PublicError(Error(ErrorCode::kBadInput, "too short")).what(), "too short");
}

}  // namespace
}  // namespace cairn
