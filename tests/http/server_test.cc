// Tests the server from outside: routes, refusals, ports, pages.
#include "http/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "core/cell_name.h"
#include "core/error.h"
#include "http/plain_http.h"
#include "http/raw_socket.h"
#include "http/routes.h"
#include "http/server_fixture.h"
#include "http/service/localize_service.h"
#include "http/wire/base64.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Reply {
  int status = 0;
  std::string head;
  std::string body;
};

Reply Split(const std::string& text) {
  Reply reply;
  const size_t end = text.find("\r\n\r\n");
  if (end == std::string::npos || !text.starts_with("HTTP/1.1 ")) {
    return reply;
  }
  reply.status = std::stoi(text.substr(9, 3));
  reply.head = text.substr(0, end);
  reply.body = text.substr(end + 4);
  return reply;
}

class HttpServer : public testing::ServerFixture {
 protected:
  static Reply Send(const std::string& bytes) {
    testing::RawSocket socket(port());
    socket.Send(bytes);
    return Split(socket.ReadAll());
  }
  static Reply Get(const std::string& path, const std::string& headers = "") {
    return Send("GET " + path + " HTTP/1.1\r\nHost: h\r\nConnection: close\r\n" + headers + "\r\n");
  }
  static nlohmann::json GetJson(const std::string& path) {
    const Reply reply = Get(path);
    EXPECT_EQ(reply.status, 200) << path << ": " << reply.body;
    return nlohmann::json::parse(reply.body);
  }
  static std::string TileIdText() { return GetJson("/v1/tiles")["tiles"][0]["id"]; }
};

struct BadHttpRequest {
  const char* name;
  std::string bytes;
  int status;
  const char* code;
};

std::string PostOf(const std::string& headers, const std::string& body = "") {
  return "POST /v1/localize HTTP/1.1\r\nHost: h\r\nConnection: close\r\n" + headers + "\r\n" + body;
}

std::string PostJson(const std::string& json) {
  return PostOf(
      "Content-Type: application/json\r\nContent-Length: " + std::to_string(json.size()) + "\r\n",
      json);
}

std::string Line(const std::string& line) {
  return line + "\r\nHost: h\r\nConnection: close\r\n\r\n";
}

std::vector<BadHttpRequest> BadRequests() {
  std::string header_flood;
  for (int i = 0; i < 100'000; ++i) {
    header_flood += "X-Flood: yes\r\n";
  }
  return {
      {"chunked", PostOf("Transfer-Encoding: chunked\r\n", "5\r\nhello\r\n0\r\n\r\n"), 411,
       "length_required"},
      {"no length", PostOf(""), 411, "length_required"},
      {"too large", PostOf("Content-Length: 30000000\r\n"), 413, "payload_too_large"},
      {"absurdly large", PostOf("Content-Length: 123456789012345678901234567890\r\n"), 413,
       "payload_too_large"},
      {"gzip", PostOf("Content-Encoding: gzip\r\nContent-Length: 3\r\n", "abc"), 415,
       "unsupported_encoding"},
      {"content type", PostOf("Content-Type: text/plain\r\nContent-Length: 3\r\n", "abc"), 415,
       "unsupported_media_type"},
      {"form",
       PostOf("Content-Type: application/x-www-form-urlencoded\r\nContent-Length: 10000\r\n",
              std::string(10'000, 'a')),
       415, "unsupported_media_type"},
      {"two lengths", PostOf("Content-Length: 3\r\nContent-Length: 3\r\n", "abc"), 400,
       "bad_request"},
      {"smuggled", PostOf("Content-Length: 3\r\nTransfer-Encoding: chunked\r\n", "0\r\n\r\n"), 400,
       "bad_request"},
      {"header flood", PostOf(header_flood), 431, "headers_too_large"},
      {"long header", PostOf("X: " + std::string(20'000, 'x') + "\r\n"), 431, "headers_too_large"},
      {"long target", Line("GET /" + std::string(20'000, 'x') + " HTTP/1.1"), 414, "uri_too_long"},
      {"not HTTP", "hello there\r\n\r\n", 400, "bad_request"},
      {"TLS hello", std::string("\x16\x03\x01\x02\0\r\n\r\n", 9), 400, "bad_request"},
      {"version", Line("GET / HTTP/3.0"), 505, "version_not_supported"},
      {"method", Line("BREW / HTTP/1.1"), 501, "not_implemented"},
      {"escape", Line("GET /%zz HTTP/1.1"), 400, "bad_request"},
      {"wrong method", Line("DELETE /v1/localize HTTP/1.1"), 405, "method_not_allowed"},
      {"get", Line("GET /v1/localize HTTP/1.1"), 405, "method_not_allowed"},
      {"no route", Line("GET /v2/localize HTTP/1.1"), 404, "not_found"},
      {"path not UTF-8", Line("GET /%ff%fe HTTP/1.1"), 404, "not_found"},
      {"empty body", PostJson(""), 400, "invalid_json"},
      {"not UTF-8", PostJson("{\"\xff\":1}"), 400, "invalid_json"},
      {"deep", PostJson(std::string(100'000, '[')), 400, "invalid_json"},
      {"NaN", PostJson(R"({"gravity":[NaN,0,0]})"), 400, "invalid_json"},
      {"huge number", PostJson(R"({"gravity":[1e999,0,0]})"), 400, "invalid_json"},
      {"no camera", PostJson("{}"), 400, "invalid_field"},
      {"multipart", PostOf("Content-Type: multipart/form-data\r\nContent-Length: 2\r\n", "--"), 400,
       "invalid_multipart"},
      {"latitude", Line("GET /v1/availability?lat=91&lon=0 HTTP/1.1"), 400, "invalid_field"},
      {"latitude nan", Line("GET /v1/availability?lat=nan&lon=0 HTTP/1.1"), 400, "invalid_field"},
      {"no longitude", Line("GET /v1/availability?lat=0 HTTP/1.1"), 400, "invalid_field"},
      {"accuracy", Line("GET /v1/availability?lat=0&lon=0&accuracy=inf HTTP/1.1"), 400,
       "invalid_field"},
      {"bbox", Line("GET /v1/coverage?bbox=1,2,3 HTTP/1.1"), 400, "invalid_field"},
      {"bbox order", Line("GET /v1/coverage?bbox=1,2,3,1 HTTP/1.1"), 400, "invalid_field"},
      {"bbox five", Line("GET /v1/coverage?bbox=1,2,3,4,5 HTTP/1.1"), 400, "invalid_field"},
      {"limit", Line("GET /v1/tiles?limit=0 HTTP/1.1"), 400, "invalid_field"},
      {"limit text", Line("GET /v1/tiles?limit=ten HTTP/1.1"), 400, "invalid_field"},
      {"tile id", Line("GET /v1/tiles/32N HTTP/1.1"), 400, "bad_input"},
      {"no such tile", Line("GET /v1/tiles/32N-03104-30000 HTTP/1.1"), 404, "not_found"},
      {"expectation", PostOf("Expect: wonders\r\nContent-Length: 1\r\n"), 417,
       "expectation_failed"},
  };
}

TEST_F(HttpServer, RefusesBadRequestsWithStableCodes) {
  for (const BadHttpRequest& bad : BadRequests()) {
    const Reply reply = Send(bad.bytes);
    EXPECT_EQ(reply.status, bad.status) << bad.name << ": " << reply.body;
    EXPECT_THAT(reply.head, HasSubstr("Content-Type: application/problem+json")) << bad.name;
    EXPECT_THAT(reply.head, HasSubstr("X-Request-Id: ")) << bad.name;
    const auto problem = nlohmann::json::parse(reply.body, nullptr, false);
    ASSERT_TRUE(problem.is_object()) << bad.name;
    EXPECT_EQ(problem["code"], bad.code) << bad.name;
    EXPECT_EQ(problem["status"], bad.status) << bad.name;
    EXPECT_THAT(reply.head, HasSubstr("X-Request-Id: " + problem["requestId"].get<std::string>()));
    EXPECT_THAT(reply.body, ::testing::Not(HasSubstr(map_path()))) << bad.name;
  }
}

TEST_F(HttpServer, MethodNotAllowedNamesTheAllowedOnes) {
  EXPECT_THAT(Get("/v1/localize").head, HasSubstr("Allow: POST, OPTIONS"));
  EXPECT_THAT(Send(Line("PUT /geopose HTTP/1.1")).status, 411);
  EXPECT_THAT(Send(Line("DELETE /geopose HTTP/1.1")).head,
              HasSubstr("Allow: GET, HEAD, POST, OPTIONS"));
}

TEST_F(HttpServer, AnswersPreflightRequests) {
  const Reply reply = Send(Line("OPTIONS /v1/localize HTTP/1.1"));
  EXPECT_EQ(reply.status, 204);
  EXPECT_THAT(reply.head, HasSubstr("Access-Control-Allow-Methods: POST, OPTIONS"));
  EXPECT_THAT(reply.head, HasSubstr("Access-Control-Allow-Origin: *"));
}

TEST_F(HttpServer, HeadHasTheLengthButNoBody) {
  const Reply reply = Send(Line("HEAD /livez HTTP/1.1"));
  EXPECT_EQ(reply.status, 200);
  EXPECT_THAT(reply.head, HasSubstr("Content-Length: 15"));
  EXPECT_EQ(reply.body, "");
}

TEST_F(HttpServer, EchoesUsableRequestIdsOnly) {
  EXPECT_THAT(Get("/livez", "X-Request-Id: abc-123\r\n").head, HasSubstr("X-Request-Id: abc-123"));
  EXPECT_THAT(Get("/livez", "X-Request-Id: a b\r\n").head,
              ::testing::Not(HasSubstr("X-Request-Id: a b")));
}

TEST_F(HttpServer, KeepsAConnectionForManyRequests) {
  testing::RawSocket socket(port());
  for (int i = 0; i < 20; ++i) {
    socket.Send("GET /livez HTTP/1.1\r\nHost: h\r\n\r\n");
    EXPECT_EQ(Split(socket.ReadResponse()).status, 200);
  }
}

TEST_F(HttpServer, AnswersPipelinedRequestsInOrder) {
  testing::RawSocket socket(port());
  const std::string body = "{}";
  socket.Send(
      "GET /livez HTTP/1.1\r\nHost: h\r\n\r\nPOST /v1/localize HTTP/1.1\r\nHost: h\r\n"
      "Content-Type: application/json\r\nContent-Length: 2\r\n\r\n{}GET /nowhere "
      "HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(Split(socket.ReadResponse()).status, 200);
  EXPECT_EQ(Split(socket.ReadResponse()).status, 400);
  EXPECT_EQ(Split(socket.ReadResponse()).status, 404);
}

TEST_F(HttpServer, ARefusedBodyIsNotReadAsTheNextRequest) {
  testing::RawSocket socket(port());
  const std::string smuggled = "GET /livez HTTP/1.1\r\nHost: h\r\n\r\n";
  socket.Send(
      "POST /v1/localize HTTP/1.1\r\nHost: h\r\nContent-Encoding: gzip\r\n"
      "Content-Length: " +
      std::to_string(smuggled.size()) + "\r\n\r\n" + smuggled);
  const std::string all = socket.ReadAll();
  EXPECT_THAT(all, StartsWith("HTTP/1.1 415"));
  EXPECT_EQ(all.find("HTTP/1.1 200"), std::string::npos);
}

TEST_F(HttpServer, ContinuesWhenAskedTo) {
  testing::RawSocket socket(port());
  socket.Send(
      PostOf("Content-Type: application/json\r\nContent-Length: 2\r\n"
             "Expect: 100-continue\r\n"));
  EXPECT_THAT(socket.ReadResponse(), StartsWith("HTTP/1.1 100"));
  socket.Send("{}");
  EXPECT_EQ(Split(socket.ReadResponse()).status, 400);
}

TEST_F(HttpServer, ManyIdleConnectionsDoNotStarveANewOne) {
  std::vector<std::unique_ptr<testing::RawSocket>> idle;
  for (int i = 0; i < 40; ++i) {
    idle.push_back(std::make_unique<testing::RawSocket>(port()));
  }
  EXPECT_EQ(Get("/livez").status, 200);
}

TEST_F(HttpServer, ASecondServerOnTheSamePortIsRefused) {
  ServerOptions options = Options();
  options.port = port();
  Server second(options);
  try {
    second.Start();
    ADD_FAILURE() << "started";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kConflict);
    EXPECT_THAT(e.what(), HasSubstr(std::to_string(port())));
  }
}

TEST_F(HttpServer, AHostThatIsNotOursIsRefused) {
  ServerOptions options = Options();
  options.host = "192.0.2.1";  // TEST-NET-1, never an address of this machine.
  Server server(options);
  EXPECT_THROW(server.Start(), Error);
}

TEST_F(HttpServer, StopsWhileConnectionsAreOpenAndCanBeStoppedTwice) {
  Server server(Options());
  server.Start();
  const int port = server.port();
  testing::RawSocket idle(port);
  testing::RawSocket half_sent(port);
  half_sent.Send("GET /livez HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(Split(half_sent.ReadAll()).status, 200);
  server.Stop();
  server.Stop();
  EXPECT_EQ(idle.ReadAll(), "");
  EXPECT_THROW(testing::RawSocket{port}, std::runtime_error);
}

TEST_F(HttpServer, AnswersWhileItDrainsButIsNotReady) {
  Server server(Options());
  server.Start();
  server.Drain();
  LocalizeClient client({.url = "http://127.0.0.1:" + std::to_string(server.port())});
  EXPECT_TRUE(client.LocalizeFeatures(Query()).localized);
  testing::RawSocket socket(server.port());
  socket.Send("GET /readyz HTTP/1.1\r\nHost: h\r\n\r\n");
  const Reply reply = Split(socket.ReadAll());  // Ends, because the server closes the connection.
  EXPECT_EQ(reply.status, 503);
  EXPECT_EQ(nlohmann::json::parse(reply.body)["code"], "unavailable");
  EXPECT_THAT(reply.head, HasSubstr("Connection: close"));
}

TEST_F(HttpServer, NamesTheCellAndIgnoresThatOfTheRequest) {
  const std::string json = R"({"camera":{"size":[64,48]},"image":{"format":"GRAY8","data":")" +
                           EncodeBase64(std::vector<uint8_t>(64 * 48, 99)) +
                           R"("},"prior":{"position":{"lat":47.3769,"lon":8.5417}}})";
  const auto cell_of = [&](const std::string& stated_cell) {
    httplib::Client client("127.0.0.1", port());
    const httplib::Headers headers{{"X-Cairn-Cell", stated_cell}};
    const auto result = client.PostOf("/v1/localize", headers, json, "application/json");
    EXPECT_EQ(result->status, 200) << result->body;
    return result->get_header_value("X-Cairn-Cell");
  };
  const std::string cell = CellName(Geodetic::FromDegrees(47.3769, 8.5417, 0.0));
  EXPECT_EQ(cell_of(cell), cell);
  EXPECT_EQ(cell_of("01S-00000-00000"), cell);
  EXPECT_EQ(cell_of(std::string(8000, '%')), cell);
  EXPECT_EQ(GetJson("/v1/availability?lat=47.3769&lon=8.5417")["cell"], cell);
}

TEST_F(HttpServer, ServesHealthApartWithAnAdminListener) {
  ServerOptions options = Options();
  options.admin_port = 0;
  Server server(options);
  server.Start();
  ASSERT_NE(server.port(), server.admin_port());
  httplib::Client main("127.0.0.1", server.port());
  httplib::Client admin("127.0.0.1", server.admin_port());
  EXPECT_EQ(main.Get("/metrics")->status, 404);
  EXPECT_EQ(main.Get("/version")->status, 200);
  EXPECT_EQ(admin.Get("/version")->status, 404);
  for (const char* path : {"/healthz", "/livez", "/readyz", "/metrics"}) {
    EXPECT_EQ(admin.Get(path)->status, 200) << path;
  }
}

TEST_F(HttpServer, AMapThatIsNotThereIsNamed) {
  ServerOptions options = Options();
  options.map_path = dir_->File("missing.gpkg");
  try {
    Server server(options);
    ADD_FAILURE() << "opened";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kNotFound);
    EXPECT_THAT(e.what(), HasSubstr("missing.gpkg"));
  }
}

TEST_F(HttpServer, CoverageIsGeoJsonAroundTheStreet) {
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

TEST_F(HttpServer, VersionsAreNewestFirst) {
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

TEST_F(HttpServer, CoverageAndTilesCanBeRestrictedToABox) {
  EXPECT_EQ(GetJson("/v1/coverage?bbox=8.5,47.3,8.6,47.4")["features"].size(),
            GetJson("/v1/coverage")["features"].size());
  EXPECT_EQ(GetJson("/v1/tiles?bbox=9.5,47.3,9.6,47.4")["tiles"].size(), 0u);
  EXPECT_EQ(GetJson("/v1/tiles?bbox=170,-10,-170,10")["tiles"].size(), 0u);
  EXPECT_EQ(GetJson("/v1/tiles?limit=1")["tiles"].size(), 1u);
}

TEST_F(HttpServer, AvailabilitySaysWhetherAQueryWouldFindTiles) {
  const auto here = GetJson("/v1/availability?lat=47.3769&lon=8.5417&accuracy=20");
  EXPECT_EQ(here["available"], true);
  EXPECT_GE(here["tiles"].size(), 1u);
  EXPECT_THAT(here["codec"].get<std::string>(), StartsWith("sift-128-16"));
  EXPECT_EQ(GetJson("/v1/availability?lat=-47&lon=8")["available"], false);
}

TEST_F(HttpServer, ATileHasAnEtagThatSavesTheSecondTransfer) {
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

TEST_F(HttpServer, APayloadIsATile) {
  const std::string id = TileIdText();
  const std::string payload = Get("/v1/tiles/" + id + "/payload").body;
  const Tile tile = DecodeTile({reinterpret_cast<const uint8_t*>(payload.data()), payload.size()});
  EXPECT_EQ(tile.id.ToString(), id);
  EXPECT_EQ(GetJson("/v1/tiles/" + id)["landmarks"], tile.num_landmarks());
}

TEST_F(HttpServer, VersionDescribesMapCodecAndLimits) {
  const auto json = GetJson("/version");
  EXPECT_EQ(json["name"], "cairn");
  EXPECT_GE(json["map"]["tiles"].get<int>(), 1);
  EXPECT_EQ(json["map"]["descriptorType"], "sift");
  EXPECT_EQ(json["limits"]["features"], 5000);
}

TEST_F(HttpServer, GeoPoseStatusIsWhatTheProtocolWants) {
  EXPECT_EQ(Get("/geopose").body, R"({"status":"running"})");
}

TEST_F(HttpServer, MetricsCountRequestsOutcomesAndStages) {
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

TEST_F(HttpServer, ThePageLoadsNothingFromElsewhere) {
  for (const char* path : {"/ui", "/ui/app.js", "/ui/style.css"}) {
    const Reply reply = Get(path);
    EXPECT_EQ(reply.status, 200) << path;
    EXPECT_THAT(reply.head, HasSubstr("Content-Security-Policy: default-src 'self'"));
    EXPECT_EQ(reply.body.find("http://"), std::string::npos) << path;
    EXPECT_EQ(reply.body.find("https://"), std::string::npos) << path;
  }
}

TEST_F(HttpServer, OpenApiDescribesExactlyTheRoutesThereAre) {
  LocalizeService service(Options());
  std::set<std::string> served;
  const Router router = MainRoutes(&service, /*with_admin=*/true);
  for (const Route& route : router.routes()) {
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

TEST(ServerOptions, ValidateNamesTheField) {
  ServerOptions good;
  good.map_path = "map.gpkg";
  good.Validate();
  const std::pair<const char*, std::function<void(ServerOptions*)>> cases[] = {
      {"map_path", [](ServerOptions* o) { o->map_path.clear(); }},
      {"port", [](ServerOptions* o) { o->port = 70000; }},
      {"admin_port", [](ServerOptions* o) { o->admin_port = o->port; }},
      {"num_threads", [](ServerOptions* o) { o->num_threads = -1; }},
      {"cache_bytes", [](ServerOptions* o) { o->cache_bytes = 0; }},
      {"max_body_bytes", [](ServerOptions* o) { o->max_body_bytes = 10; }},
      {"max_image_pixels", [](ServerOptions* o) { o->max_image_pixels = 0; }},
      {"max_features", [](ServerOptions* o) { o->max_features = 0; }},
      {"default_timeout_ms", [](ServerOptions* o) { o->default_timeout_ms = 0; }},
  };
  for (const auto& [field, spoil] : cases) {
    ServerOptions options = good;
    spoil(&options);
    try {
      options.Validate();
      ADD_FAILURE() << field;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kInvalidArgument);
      EXPECT_THAT(e.what(), HasSubstr(field));
    }
  }
}

}  // namespace
}  // namespace cairn
