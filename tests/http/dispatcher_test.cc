#include "http/dispatcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/error.h"
#include "http/keys/key_ring.h"
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
              .needs = KeyRights(),
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

// The number by which the gate tells the clients of two requests apart.
std::pair<std::string, std::string> ClientsOfTwoAddresses(const std::string& key_of_second) {
  Router router;
  router.Add({.method = "GET",
              .pattern = "/who",
              .needs = KeyRight::kLocalize,
              .handler = [](const HttpRequest& request, const std::string&) {
                return HttpResponse{.body = std::to_string(request.client)};
              }});
  Metrics metrics;
  KeyRing keys({{.label = "a", .hash = HashOfSecret("key of a"), .may = KeyRight::kLocalize},
                {.label = "b", .hash = HashOfSecret("key of b"), .may = KeyRight::kLocalize}});
  Dispatcher dispatcher(std::move(router), &metrics, &keys);
  const auto ask = [&](uint64_t network, const std::string& key) {
    HttpRequest request;
    request.method = "GET";
    request.path = "/who";
    request.headers = {{"x-api-key", key}};
    request.client = network;
    return dispatcher.Handle(std::move(request)).body;
  };
  return {ask(1, "key of a"), ask(2, key_of_second)};
}

TEST(Dispatcher, AKeyIsOneClientFromAllItsAddresses) {
  const auto [first, same] = ClientsOfTwoAddresses("key of a");
  EXPECT_EQ(first, same);
  EXPECT_NE(first, "1");
  EXPECT_NE(first, ClientsOfTwoAddresses("key of b").second);
}

}  // namespace
}  // namespace cairn
