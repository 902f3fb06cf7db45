#include "http/dispatcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/error.h"
#include "http/router.h"
#include "http/service/metrics.h"

namespace cairn {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Key;
using ::testing::Not;
using ::testing::Pair;

// The response to a request whose handler throws Error(code).
HttpResponse ResponseToError(ErrorCode code) {
  Router router;
  router.Add({.method = "GET",
              .pattern = "/v1/tiles/{id}",
              .handler = [code](const HttpRequest&, const std::string&) -> HttpResponse {
                throw Error(code, "/maps/lund.gpkg: version 7 was pruned");
              }});
  Metrics metrics;
  Dispatcher dispatcher(std::move(router), &metrics);
  HttpRequest request;
  request.method = "GET";
  request.path = "/v1/tiles/32N-03104-30000";
  request.request_id = "request-1";
  return dispatcher.Handle(request);
}

TEST(Dispatcher, WhatIsUnavailableMayBeAskedForAgain) {
  const HttpResponse response = ResponseToError(ErrorCode::kUnavailable);
  EXPECT_EQ(response.status, 503);
  EXPECT_THAT(response.headers, Contains(Pair("Retry-After", "1")));
  EXPECT_EQ(nlohmann::json::parse(response.body)["code"], "unavailable");
  EXPECT_THAT(response.body, Not(HasSubstr("lund.gpkg")));
}

// A retry would not help, and a file that is missing here is no missing route.
TEST(Dispatcher, OtherFaultsOfTheServerAre500WithoutRetry) {
  for (const ErrorCode code : {ErrorCode::kMapDamaged, ErrorCode::kNotFound, ErrorCode::kIo}) {
    const HttpResponse response = ResponseToError(code);
    EXPECT_EQ(response.status, 500) << response.body;
    EXPECT_THAT(response.headers, Not(Contains(Key("Retry-After"))));
  }
}

}  // namespace
}  // namespace cairn
