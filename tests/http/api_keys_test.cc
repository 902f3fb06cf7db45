// Tests a server with API keys from outside.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "http/client.h"
#include "http/keys/key_file.h"
#include "http/raw_http.h"
#include "http/raw_socket.h"
#include "http/routes.h"
#include "http/server.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::Reply;
using ::testing::StartsWith;

constexpr char kBearer[] = "Authorization: Bearer ";

class ApiKeys : public testing::RawHttpTest {
 protected:
  void SetUp() override {
    Write({Named("app", KeyRight::kLocalize), Named("viewer", KeyRight::kLook),
           Named("mirror", KeyRight::kCopy | KeyRight::kLook)});
    guarded_ = std::make_unique<Server>(GuardedOptions());
    guarded_->Start();
  }
  void TearDown() override { guarded_.reset(); }

  virtual ServerOptions GuardedOptions() const {
    ServerOptions options = Options();
    options.api_keys_path = path_;
    return options;
  }
  static ApiKey Named(const std::string& label, KeyRights may) {
    return {.label = label, .hash = HashOfSecret(label + "-secret"), .may = may};
  }
  void Write(const std::vector<ApiKey>& keys) const {
    ChangeKeyFile(path_, [&](std::vector<ApiKey>* all) { *all = keys; });
  }

  Reply Exchange(const std::string& bytes) const {
    testing::RawSocket socket(guarded_->port());
    socket.Send(bytes);
    return testing::Split(socket.ReadAll());
  }
  // `header` is a line without its end, or empty.
  Reply Request(const std::string& method, const std::string& path,
                const std::string& header = "") const {
    return Exchange(method + " " + path + " HTTP/1.1\r\nHost: h\r\nConnection: close\r\n" +
                    (method == "POST" ? "Content-Length: 0\r\n" : "") +
                    (header.empty() ? "" : header + "\r\n") + "\r\n");
  }
  int StatusOf(const std::string& path, const std::string& label) const {
    return Request("GET", path, kBearer + label + "-secret").status;
  }

  const testing::TempDir folder_;  // Of this test; the suite shares its map only.
  const std::string path_ = folder_.File("keys.json");
  std::unique_ptr<Server> guarded_;
};

TEST_F(ApiKeys, AreAskedForInWords) {
  const Reply reply = Request("GET", "/v1/tiles");
  EXPECT_EQ(reply.status, 401);
  EXPECT_THAT(reply.head, HasSubstr("HTTP/1.1 401 Unauthorized"));
  EXPECT_THAT(reply.head, HasSubstr("WWW-Authenticate: Bearer realm=\"cairn\""));
  const auto problem = nlohmann::json::parse(reply.body);
  EXPECT_EQ(problem["code"], "unauthorized");
  EXPECT_THAT(problem["hint"].get<std::string>(), HasSubstr("X-API-Key"));
}

TEST_F(ApiKeys, AreSentInEitherHeader) {
  EXPECT_EQ(Request("GET", "/v1/tiles", "Authorization: Bearer viewer-secret").status, 200);
  EXPECT_EQ(Request("GET", "/v1/tiles", "authorization: bearer viewer-secret").status, 200);
  EXPECT_EQ(Request("GET", "/v1/tiles", "X-API-Key: viewer-secret").status, 200);
  const Reply unknown = Request("GET", "/v1/tiles", "X-API-Key: guessed-secret");
  EXPECT_EQ(unknown.status, 401);
  EXPECT_THAT(unknown.body, Not(HasSubstr("guessed-secret")));
  EXPECT_EQ(Request("GET", "/v1/tiles?key=viewer-secret").status, 401) << "URLs are logged";
}

TEST_F(ApiKeys, AreNotNeededForWhatEverybodyMaySee) {
  for (const char* path :
       {"/livez", "/readyz", "/openapi.json", "/ui", "/ui/app.js", "/ui/style.css"}) {
    EXPECT_EQ(Request("GET", path).status, 200) << path;
  }
  EXPECT_EQ(Request("GET", "/").status, 302);
  EXPECT_EQ(Request("GET", "/nowhere").status, 404);
  const Reply preflight =
      Request("OPTIONS", "/v1/localize", "Access-Control-Request-Headers: authorization");
  EXPECT_EQ(preflight.status, 204) << "browsers send no key with a preflight";
  EXPECT_THAT(preflight.head, HasSubstr("Access-Control-Allow-Headers: authorization"));
}

// A route that somebody adds is closed unless it is named here.
TEST_F(ApiKeys, AreNeededForAllOtherRoutes) {
  const std::set<std::string> open = {"/",   "/livez", "/openapi.json", "/readyz",
                                      "/ui", "/ui/",   "/ui/app.js",    "/ui/style.css"};
  const Router router = MainRoutes(nullptr, /*with_admin=*/true);
  for (const Route& route : router.routes()) {
    EXPECT_EQ(route.needs.empty(), open.contains(route.pattern)) << route.pattern;
  }
  const auto openapi = GetJson("/openapi.json");
  for (const auto& [path, methods] : openapi["paths"].items()) {
    for (const auto& [method, operation] : methods.items()) {
      EXPECT_EQ(operation.contains("security"), open.contains(path)) << path;
      EXPECT_EQ(operation["responses"].contains("429"), !open.contains(path)) << path;
    }
  }
}

TEST_F(ApiKeys, GiveTheRightsOfTheirKey) {
  const std::string payload = "/v1/tiles/" + TileIdText() + "/payload";
  EXPECT_EQ(StatusOf(payload, "mirror"), 200);
  EXPECT_EQ(StatusOf(payload, "viewer"), 403);
  EXPECT_EQ(StatusOf("/v1/coverage", "viewer"), 200);
  EXPECT_EQ(StatusOf("/metrics", "viewer"), 200);
  EXPECT_EQ(StatusOf("/healthz", "app"), 403);
  EXPECT_EQ(StatusOf("/version", "app"), 200);
  EXPECT_EQ(Request("POST", "/v1/localize", "X-API-Key: app-secret").status, 415) << "no body";
  const Reply refused = Request("POST", "/v1/localize", "X-API-Key: viewer-secret");
  EXPECT_EQ(refused.status, 403);
  EXPECT_THAT(refused.head, HasSubstr("error=\"insufficient_scope\", scope=\"localize\""));
}

TEST_F(ApiKeys, LimitTheRate) {
  ApiKey slow = Named("slow", KeyRight::kLook);
  slow.rate_per_s = 0.001;
  slow.burst = 2;
  Write({slow});
  guarded_->ReloadKeys();
  EXPECT_EQ(StatusOf("/v1/tiles", "slow"), 200);
  EXPECT_EQ(StatusOf("/v1/tiles", "slow"), 200);
  const Reply refused = Request("GET", "/v1/tiles", "X-API-Key: slow-secret");
  EXPECT_EQ(refused.status, 429);
  EXPECT_THAT(refused.head, HasSubstr("Retry-After: "));
  EXPECT_EQ(nlohmann::json::parse(refused.body)["code"], "too_many_requests");
}

// Otherwise anybody could fill the memory for requests.
TEST_F(ApiKeys, AreLookedAtBeforeABodyIsRead) {
  const std::string head =
      "POST /v1/localize HTTP/1.1\r\nHost: h\r\nContent-Length: 20000000\r\n"
      "Expect: 100-continue\r\n";
  EXPECT_EQ(Exchange(head + "\r\n").status, 401);
  EXPECT_EQ(Exchange(head + "X-API-Key: viewer-secret\r\n\r\n").status, 403);
  const auto status_of = [&](const std::string& request_line) {
    return Exchange(request_line + " HTTP/1.1\r\nHost: h\r\nContent-Length: 20000000\r\n\r\n")
        .status;
  };
  EXPECT_EQ(status_of("POST /v1/localize?x=%zz"), 400);
  EXPECT_EQ(status_of("POST /nowhere"), 404);
  EXPECT_EQ(status_of("POST /livez"), 405);
  EXPECT_EQ(status_of("GET /livez"), 413);
  EXPECT_EQ(status_of("OPTIONS /v1/localize"), 413);
  testing::RawSocket invited(guarded_->port());
  invited.Send(head + "X-API-Key: app-secret\r\n\r\n");
  EXPECT_THAT(invited.ReadResponse(), StartsWith("HTTP/1.1 100 Continue"));
}

TEST_F(ApiKeys, AreRefusedBeforeABodyIsReadIfTheyAreUsedUp) {
  ApiKey slow = Named("slow", KeyRight::kLocalize);
  slow.rate_per_s = 0.001;
  slow.burst = 1;
  ApiKey daily = Named("daily", KeyRight::kLocalize);
  daily.quota_per_day = 1;
  Write({slow, daily});
  guarded_->ReloadKeys();
  for (const std::string label : {"slow", "daily"}) {
    const std::string header = "X-API-Key: " + label + "-secret";
    const std::string upload =
        "POST /v1/localize HTTP/1.1\r\nHost: h\r\nContent-Length: 20000000\r\n"
        "Expect: 100-continue\r\n" +
        header + "\r\n\r\n";
    testing::RawSocket invited(guarded_->port());
    invited.Send(upload);
    EXPECT_THAT(invited.ReadResponse(), StartsWith("HTTP/1.1 100 Continue")) << label;
    EXPECT_EQ(Request("POST", "/v1/localize", header).status, 415) << "a head alone does not count";
    const Reply refused = Exchange(upload);
    EXPECT_EQ(refused.status, 429) << label;
    EXPECT_THAT(refused.head, HasSubstr("Retry-After: "));
  }
}

TEST_F(ApiKeys, AreReadAgain) {
  Write({Named("new", KeyRight::kLook)});
  EXPECT_EQ(StatusOf("/v1/tiles", "viewer"), 200) << "not before the server is told";
  guarded_->ReloadKeys();
  EXPECT_EQ(StatusOf("/v1/tiles", "new"), 200);
  EXPECT_EQ(StatusOf("/v1/tiles", "viewer"), 401);
  const std::string metrics = Request("GET", "/metrics", "X-API-Key: new-secret").body;
  EXPECT_THAT(metrics, HasSubstr("label=\"new\""));
  EXPECT_THAT(metrics, Not(HasSubstr("label=\"viewer\"")));
}

TEST_F(ApiKeys, StayIfTheNewFileIsBroken) {
  std::ofstream(path_) << "{\"format\":";
  ::testing::internal::CaptureStderr();
  guarded_->ReloadKeys();
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr(path_));
  EXPECT_THAT(log, HasSubstr("the API keys of before stay valid"));
  EXPECT_EQ(StatusOf("/v1/tiles", "viewer"), 200);
  EXPECT_EQ(Request("GET", "/v1/tiles").status, 401);
}

TEST_F(ApiKeys, AreNeededFromTheBeginning) {
  ServerOptions options = Options();
  options.api_keys_path = folder_.File("missing.json");
  EXPECT_THROW(Server{options}, Error);
}

TEST_F(ApiKeys, AreNotTurnedOffByAnEmptyPath) {
  ServerOptions options = Options();
  options.api_keys_path = "";
  try {
    Server server(options);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_THAT(error.what(), HasSubstr("server.api_keys_path is empty"));
  }
}

// On loopback, a front may make the server open to others.
TEST_F(ApiKeys, AreMissedIfAFrontPassesRequestsOn) {
  const auto log_of = [](const ServerOptions& options) {
    ::testing::internal::CaptureStderr();
    Server(options).Start();
    return ::testing::internal::GetCapturedStderr();
  };
  ServerOptions options = Options();
  EXPECT_THAT(log_of(options), Not(HasSubstr("without --api-keys")));
  options.trusted_fronts = "127.0.0.1";
  EXPECT_THAT(log_of(options), HasSubstr("without --api-keys"));
  options.api_keys_path = path_;
  EXPECT_THAT(log_of(options), Not(HasSubstr("without --api-keys")));
}

TEST_F(ApiKeys, AreCountedByTheirLabels) {
  StatusOf("/v1/tiles", "viewer");
  StatusOf("/v1/tiles", "app");
  const std::string metrics = Request("GET", "/metrics", "X-API-Key: viewer-secret").body;
  EXPECT_THAT(metrics, HasSubstr("cairn_client_requests_total{label=\"viewer\",status=\"200\"} 1"));
  EXPECT_THAT(metrics, HasSubstr("cairn_client_requests_total{label=\"app\",status=\"403\"} 1"));
  EXPECT_THAT(metrics, Not(HasSubstr("secret")));
}

TEST_F(ApiKeys, AreCountedByTheirLabelsIfTheHeadIsRefused) {
  const Reply refused = Exchange(
      "POST /v1/localize HTTP/1.1\r\nHost: h\r\nContent-Length: 20000000\r\n"
      "X-API-Key: viewer-secret\r\n\r\n");
  EXPECT_EQ(refused.status, 403);
  EXPECT_THAT(Request("GET", "/metrics", "X-API-Key: viewer-secret").body,
              HasSubstr("cairn_client_requests_total{label=\"viewer\",status=\"403\"} 1"));
}

// The lines of a server's access log.
class AccessLines : public ApiKeys {
 protected:
  ServerOptions GuardedOptions() const override {
    ServerOptions options = ApiKeys::GuardedOptions();
    options.access_log_path = log_path_;
    options.trusted_fronts = "127.0.0.1";
    return options;
  }
  // Stops the server.
  std::vector<nlohmann::json> Lines() {
    guarded_.reset();
    std::ifstream file(log_path_);
    std::vector<nlohmann::json> lines;
    for (std::string line; std::getline(file, line);) {
      lines.push_back(nlohmann::json::parse(line));
    }
    return lines;
  }

  const std::string log_path_ = folder_.File("access.log");
};

TEST_F(AccessLines, TellWhoAskedForWhat) {
  Request("GET", "/v1/tiles?limit=777", "X-API-Key: viewer-secret");
  Request("GET", "/v1/tiles", "X-Forwarded-For: 203.0.113.5");
  Request("GET", "/metrics", "X-API-Key: app-secret");
  Exchange("POST /v1/localize?secret=abc HTTP/1.1\r\nHost: h\r\nContent-Length: 20000000\r\n\r\n");
  Exchange("no HTTP\r\n\r\n");
  Exchange(
      "POST /v1/localize HTTP/1.1\r\nHost: h\r\nContent-Length: 20000000\r\n"
      "X-API-Key: viewer-secret\r\n\r\n");
  const std::vector<nlohmann::json> lines = Lines();
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[0]["label"], "viewer");
  EXPECT_EQ(lines[0]["path"], "/v1/tiles");
  EXPECT_EQ(lines[0]["status"], 200);
  EXPECT_GT(lines[0]["bytes"].get<int>(), 0);
  EXPECT_TRUE(lines[0]["reason"].is_null());
  EXPECT_EQ(lines[1]["client"], "203.0.113.5");
  EXPECT_EQ(lines[1]["reason"], "unauthorized");
  EXPECT_TRUE(lines[1]["label"].is_null());
  EXPECT_EQ(lines[2]["label"], "app");
  EXPECT_EQ(lines[2]["reason"], "forbidden");
  EXPECT_EQ(lines[3]["method"], "POST");
  EXPECT_EQ(lines[3]["path"], "/v1/localize");
  EXPECT_EQ(lines[3]["status"], 401);
  EXPECT_EQ(lines[4]["reason"], "bad_request");
  EXPECT_EQ(lines[4]["client"], "127.0.0.1");
  EXPECT_EQ(lines[5]["label"], "viewer");
  EXPECT_EQ(lines[5]["reason"], "forbidden");
  for (const nlohmann::json& line : lines) {
    EXPECT_THAT(line.dump(), Not(HasSubstr("secret")));
  }
}

TEST_F(AccessLines, SayWhyThereIsNoPose) {
  LocalizeQuery query = Query();
  query.prior->position = Geodetic::FromDegrees(10.0, 10.0, 0.0);
  LocalizeClient client(
      {.url = "http://127.0.0.1:" + std::to_string(guarded_->port()), .api_key = "app-secret"});
  EXPECT_FALSE(client.LocalizeFeatures(query).localized);
  EXPECT_TRUE(client.LocalizeFeatures(Query()).localized);
  const std::vector<nlohmann::json> lines = Lines();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["reason"], "NO_COVERAGE");
  EXPECT_EQ(lines[0]["status"], 200);
  EXPECT_TRUE(lines[1]["reason"].is_null());
}

}  // namespace
}  // namespace cairn
