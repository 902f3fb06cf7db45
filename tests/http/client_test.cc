// Tests the client against servers that are not Cairn's.
#include "http/client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/error.h"
#include "support/canned_server.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

std::string MessageFor(const std::string& body) {
  const testing::CannedServer server([&](const httplib::Request&, httplib::Response& response) {
    response.status = 400;
    response.set_content(body, "application/problem+json");
  });
  LocalizeClient client({.url = server.url()});
  try {
    client.Get("/healthz");
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kBadInput);
    return e.what();
  }
  return "";
}

TEST(LocalizeClient, SaysWhatARefusalSays) {
  EXPECT_THAT(MessageFor(R"({"title":"t","detail":"no camera","hint":"send one"})"),
              HasSubstr("400: no camera (send one)"));
  EXPECT_THAT(MessageFor(R"({"title":"only this"})"), HasSubstr("400: only this"));
}

TEST(LocalizeClient, ARefusalOfAnotherShapeIsStillARefusal) {
  for (const char* body :
       {R"({"detail":5,"title":["x"],"hint":{}})", R"({"detail":null})", "[1]", "not JSON", ""}) {
    EXPECT_THAT(MessageFor(body), HasSubstr("the server answered 400")) << body;
  }
}

}  // namespace
}  // namespace cairn
