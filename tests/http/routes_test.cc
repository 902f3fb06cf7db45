// Tests what the routes beside localization answer.
#include "http/routes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "http/net/gzip.h"
#include "http/plain_http.h"
#include "http/raw_http.h"
#include "http/service/localize_service.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using testing::Reply;
using ::testing::StartsWith;

class HttpRoutes : public testing::RawHttpTest {};

TEST_F(HttpRoutes, CoverageIsGeoJsonAroundTheStreet) {
  const auto json = GetJson("/v1/coverage");
  EXPECT_EQ(json["type"], "FeatureCollection");
  EXPECT_EQ(json["truncated"], false);
  ASSERT_GE(json["features"].size(), 1u);
  const auto& ring = json["features"][0]["geometry"]["coordinates"][0];
  ASSERT_EQ(ring.size(), 5u);
  EXPECT_EQ(ring[0], ring[4]);
  EXPECT_NEAR(ring[0][0].get<double>(), world_->options().origin.lon_deg(), 0.01);
  EXPECT_NEAR(ring[0][1].get<double>(), world_->options().origin.lat_deg(), 0.01);
  // Counter-clockwise, as RFC 7946 wants the outer ring.
  double doubled_area = 0.0;
  for (int i = 0; i < 4; ++i) {
    doubled_area += ring[i][0].get<double>() * ring[i + 1][1].get<double>() -
                    ring[i + 1][0].get<double>() * ring[i][1].get<double>();
  }
  EXPECT_GT(doubled_area, 0.0);
}

TEST_F(HttpRoutes, VersionsAreNewestFirst) {
  const auto all = GetJson("/v1/versions");
  ASSERT_GE(all["versions"].size(), 2u);
  EXPECT_EQ(all["truncated"], false);
  EXPECT_EQ(all["versions"][0]["version"], all["map"]["version"]);
  EXPECT_EQ(all["versions"][0]["kind"], "ingest");
  EXPECT_EQ(all["versions"][0]["tiles"], GetJson("/version")["map"]["tiles"]);
  EXPECT_EQ(all["versions"].back()["kind"], "create");
  const auto one = GetJson("/v1/versions?limit=1");
  EXPECT_EQ(one["versions"].size(), 1u);
  EXPECT_EQ(one["truncated"], true);
}

TEST_F(HttpRoutes, CoverageAndTilesCanBeRestrictedToABox) {
  EXPECT_EQ(GetJson("/v1/coverage?bbox=8.5,47.3,8.6,47.4")["features"].size(),
            GetJson("/v1/coverage")["features"].size());
  EXPECT_EQ(GetJson("/v1/tiles?bbox=9.5,47.3,9.6,47.4")["tiles"].size(), 0u);
  EXPECT_EQ(GetJson("/v1/tiles?bbox=170,-10,-170,10")["tiles"].size(), 0u);
  EXPECT_EQ(GetJson("/v1/tiles?limit=1")["tiles"].size(), 1u);
}

TEST_F(HttpRoutes, RefuseParametersThatAreUnknownOrThereTwice) {
  const testing::Reply misspelt = Get("/v1/tiles?limt=1");
  EXPECT_EQ(misspelt.status, 400);
  EXPECT_THAT(misspelt.body, HasSubstr("'limt'"));
  EXPECT_THAT(misspelt.body, HasSubstr("known: bbox, limit, after"));
  EXPECT_THAT(Get("/v1/tiles?limit=1&limit=2").body, HasSubstr("'limit' is there twice"));
  EXPECT_EQ(Get("/version?a=b").status, 400);
  EXPECT_EQ(Send("POST /v1/localize?a=b HTTP/1.1\r\nHost: h\r\nConnection: close\r\n"
                 "Content-Length: 0\r\n\r\n")
                .status,
            400);
  EXPECT_EQ(Get("/livez?from=probe").status, 200);
  EXPECT_EQ(Get("/ui?from=search").status, 200);
}

TEST_F(HttpRoutes, PagesOfTilesLeadFromOneToTheNext) {
  const auto all = GetJson("/v1/tiles");
  ASSERT_EQ(all["truncated"], false);
  ASSERT_FALSE(all.contains("next"));
  for (const std::string box : {"", "&bbox=8.5,47.3,8.6,47.4"}) {
    auto page = GetJson("/v1/tiles?limit=1" + box);
    nlohmann::json tiles = page["tiles"];
    while (page.contains("next")) {
      EXPECT_EQ(page["truncated"], true);
      page = GetJson("/v1/tiles?limit=1" + box + "&after=" + page["next"].get<std::string>());
      tiles.insert(tiles.end(), page["tiles"].begin(), page["tiles"].end());
    }
    EXPECT_EQ(tiles, all["tiles"]);
  }
  EXPECT_EQ(Get("/v1/coverage?after=here").status, 400);
}

TEST_F(HttpRoutes, ListsHaveATagThatSavesTheSecondTransfer) {
  for (const std::string path : {"/v1/tiles", "/v1/coverage", "/v1/versions", "/openapi.json"}) {
    const Reply first = Get(path);
    const size_t begin = first.head.find("ETag: ") + 6;
    const std::string tag = first.head.substr(begin, first.head.find("\r\n", begin) - begin);
    EXPECT_THAT(tag, StartsWith("W/\"")) << path;
    const Reply second = Get(path, "If-None-Match: " + tag + "\r\n");
    EXPECT_EQ(second.status, 304) << path;
    EXPECT_EQ(second.body, "") << path;
    EXPECT_EQ(Get(path, "If-None-Match: W/\"other\"\r\n").status, 200) << path;
  }
}

TEST_F(HttpRoutes, LargeListsAreCompressedForClientsThatWantIt) {
  const Reply plain = Get("/openapi.json");
  httplib::Client client("127.0.0.1", port());
  client.set_read_timeout(60);  // The machine may be busy.
  client.set_decompress(false);
  const auto zipped = client.Get("/openapi.json", {{"Accept-Encoding", "br, gzip"}});
  EXPECT_EQ(zipped->get_header_value("Content-Encoding"), "gzip");
  EXPECT_EQ(zipped->get_header_value("Vary"), "Accept-Encoding");
  EXPECT_LT(zipped->body.size(), plain.body.size() / 3);
  EXPECT_LT(zipped->body.size(), Gzip(plain.body).size()) << "more than for a single response";
  client.set_decompress(true);
  EXPECT_EQ(client.Get("/openapi.json", {{"Accept-Encoding", "gzip"}})->body, plain.body);
  for (const char* encoding : {"br", "gzip;q=0", "identity"}) {
    const auto other = client.Get("/openapi.json", {{"Accept-Encoding", encoding}});
    EXPECT_FALSE(other->has_header("Content-Encoding")) << encoding;
  }
}

TEST_F(HttpRoutes, AvailabilitySaysWhetherAQueryWouldFindTiles) {
  const auto here = GetJson("/v1/availability?lat=47.3769&lon=8.5417&accuracy=20");
  EXPECT_EQ(here["available"], true);
  EXPECT_GE(here["tiles"].size(), 1u);
  EXPECT_THAT(here["codec"].get<std::string>(), StartsWith("sift-128-16"));
  EXPECT_EQ(GetJson("/v1/availability?lat=-47&lon=8")["available"], false);
}

TEST_F(HttpRoutes, ATileHasAnEtagThatSavesTheSecondTransfer) {
  const std::string id = TileIdText();
  for (const char* suffix : {"", "/payload"}) {
    const std::string path = "/v1/tiles/" + id + suffix;
    const Reply first = Get(path);
    ASSERT_EQ(first.status, 200);
    const size_t begin = first.head.find("ETag: ") + 6;
    const std::string tag = first.head.substr(begin, first.head.find("\r\n", begin) - begin);
    EXPECT_THAT(tag, ::testing::MatchesRegex("\"[0-9A-Za-z]+-[0-9]+\""));
    const Reply second = Get(path, "If-None-Match: " + tag + "\r\n");
    EXPECT_EQ(second.status, 304);
    EXPECT_EQ(second.body, "");
    EXPECT_EQ(Get(path, "If-None-Match: \"other\"\r\n").status, 200);
  }
}

TEST_F(HttpRoutes, APayloadIsATile) {
  const std::string id = TileIdText();
  const std::string payload = Get("/v1/tiles/" + id + "/payload").body;
  const Tile tile = DecodeTile({reinterpret_cast<const uint8_t*>(payload.data()), payload.size()});
  EXPECT_EQ(tile.id.ToString(), id);
  EXPECT_EQ(GetJson("/v1/tiles/" + id)["landmarks"], tile.num_landmarks());
}

TEST_F(HttpRoutes, VersionDescribesMapCodecAndLimits) {
  const auto json = GetJson("/version");
  EXPECT_EQ(json["name"], "cairn");
  EXPECT_GE(json["map"]["tiles"].get<int>(), 1);
  EXPECT_EQ(json["map"]["descriptorType"], "sift");
  EXPECT_EQ(json["limits"]["features"], 5000);
}

TEST_F(HttpRoutes, GeoPoseStatusIsWhatTheProtocolWants) {
  EXPECT_EQ(Get("/geopose").body, R"({"status":"running"})");
}

TEST_F(HttpRoutes, MetricsCountRequestsOutcomesAndStages) {
  Client().LocalizeFeatures(Query());
  Get("/nowhere");
  const std::string text = Get("/metrics").body;
  EXPECT_THAT(text, HasSubstr("cairn_http_requests_total{route=\"/v1/localize\",status=\"200\"}"));
  EXPECT_THAT(text, HasSubstr("cairn_http_requests_total{route=\"\",status=\"404\"}"));
  EXPECT_THAT(text, HasSubstr("cairn_localize_total{outcome=\"LOCALIZED\"}"));
  EXPECT_THAT(text, HasSubstr("cairn_stage_seconds_bucket{stage=\"matching\",le=\"+Inf\"}"));
  EXPECT_THAT(text, HasSubstr("cairn_tile_cache_misses_total"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("nowhere")));
}

TEST_F(HttpRoutes, ThePageLoadsNothingFromElsewhere) {
  for (const char* path : {"/ui", "/ui/app.js", "/ui/style.css"}) {
    const Reply reply = Get(path);
    EXPECT_EQ(reply.status, 200) << path;
    EXPECT_THAT(reply.head, HasSubstr("Content-Security-Policy: default-src 'self'"));
    EXPECT_EQ(reply.body.find("http://"), std::string::npos) << path;
    EXPECT_EQ(reply.body.find("https://"), std::string::npos) << path;
  }
}

// A front may serve the API as /vps/..., so the page must not ask for paths of the root.
TEST_F(HttpRoutes, ThePageAsksForRelativeAddressesOnly) {
  for (const char* path : {"/ui", "/ui/app.js"}) {
    const std::string body = Get(path).body;
    for (const char* absolute : {"href=\"/", "src=\"/", "(\"/", "('/", "(`/"}) {
      EXPECT_EQ(body.find(absolute), std::string::npos) << path << ": " << absolute;
    }
  }
  EXPECT_EQ(GetJson("/openapi.json")["servers"][0]["url"], ".");
}

TEST_F(HttpRoutes, TheRootLeadsToThePage) {
  EXPECT_EQ(Get("/").status, 302);
  EXPECT_THAT(Get("/").head, HasSubstr("Location: ui\r\n"));
  EXPECT_THAT(Get("/ui/").head, HasSubstr("Location: ../ui\r\n"));
}

TEST_F(HttpRoutes, OpenApiDescribesExactlyTheRoutesThereAre) {
  LocalizeService service(Options());
  std::set<std::string> served;
  const Router router = MainRoutes(&service, /*with_admin=*/true);
  for (const Route& route : router.routes()) {
    if (route.pattern.size() > 1 && route.pattern.ends_with('/')) {
      continue;  // Leads to the path without the slash.
    }
    std::string method = route.method;
    for (char& c : method) {
      c = static_cast<char>(std::tolower(c));
    }
    served.insert(method + " " + route.pattern);
  }
  std::set<std::string> described;
  const auto openapi = GetJson("/openapi.json");
  for (const auto& [path, methods] : openapi["paths"].items()) {
    for (const auto& [method, operation] : methods.items()) {
      described.insert(method + " " + path);
    }
  }
  EXPECT_EQ(served, described);
  EXPECT_EQ(openapi["info"]["version"], GetJson("/version")["version"]);
}

}  // namespace
}  // namespace cairn
