// Tests the server from outside: refusals, connections, ports.
#include "http/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "core/cell_name.h"
#include "core/error.h"
#include "core/wire/base64.h"
#include "http/plain_http.h"
#include "http/raw_http.h"
#include "http/raw_socket.h"
#include "http/server_fixture.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using testing::Reply;
using testing::Split;
using ::testing::StartsWith;

class HttpServer : public testing::RawHttpTest {};

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
      {"too large", PostOf("Content-Length: 40000000\r\n"), 413, "payload_too_large"},
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

// Proxies want Authorization, tunnels want headers of their own.
TEST_F(HttpServer, APageMaySendAnyHeader) {
  const auto allowed = [](const std::string& wanted) {
    return Send(
               "OPTIONS /v1/localize HTTP/1.1\r\nHost: h\r\nConnection: close\r\n"
               "Access-Control-Request-Headers: " +
               wanted + "\r\n\r\n")
        .head;
  };
  for (const char* wanted : {"authorization", "content-type,ngrok-skip-browser-warning"}) {
    EXPECT_THAT(allowed(wanted), HasSubstr(std::string("Access-Control-Allow-Headers: ") + wanted));
  }
  EXPECT_THAT(allowed("a: b\""), HasSubstr("Access-Control-Allow-Headers: Accept, "));
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
    const Reply reply = Split(socket.ReadResponse());
    EXPECT_EQ(reply.status, 200);
    EXPECT_THAT(reply.head, HasSubstr("Keep-Alive: timeout=75"));
  }
  EXPECT_THAT(Get("/livez").head, ::testing::Not(HasSubstr("Keep-Alive")));
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
    client.set_read_timeout(60);  // The machine may be busy.
    const httplib::Headers headers{{"X-Cairn-Cell", stated_cell}};
    const auto result = client.Post("/v1/localize", headers, json, "application/json");
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
  for (httplib::Client* client : {&main, &admin}) {
    client->set_read_timeout(60);
  }
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

TEST(ServerOptions, ValidateNamesTheField) {
  ServerOptions good;
  good.map_path = "map.gpkg";
  good.Validate();
  const std::pair<const char*, std::function<void(ServerOptions*)>> cases[] = {
      {"map_path", [](ServerOptions* o) { o->map_path.clear(); }},
      {"port", [](ServerOptions* o) { o->port = 70000; }},
      {"admin_port", [](ServerOptions* o) { o->admin_port = o->port; }},
      {"num_threads", [](ServerOptions* o) { o->num_threads = -1; }},
      {"keep_alive_s", [](ServerOptions* o) { o->keep_alive_s = 0; }},
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
