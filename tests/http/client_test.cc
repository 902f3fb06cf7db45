// Tests the client against servers that are not Cairn's.
#include "http/client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "core/cell_name.h"
#include "core/error.h"
#include "support/canned_server.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

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

// The cells that a client sends with its queries to a server that names `answered_cell` in each
// answer. The first query has a prior.
std::vector<std::string> CellsSent(const std::string& answered_cell) {
  std::vector<std::string> sent;
  const testing::CannedServer server(
      [&](const httplib::Request& request, httplib::Response& response) {
        sent.push_back(request.get_header_value("X-Cairn-Cell"));
        response.set_header("X-Cairn-Cell", answered_cell);
        response.set_content("{}", "application/json");
      });
  LocalizeClient client({.url = server.url()});
  LocalizeQuery query;
  query.prior.emplace();
  query.prior->position = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);
  EXPECT_THROW(client.LocalizeImages(query, {{}}), Error);  // "{}" is no answer.
  query.prior.reset();
  EXPECT_THROW(client.LocalizeImages(query, {{}}), Error);
  return sent;
}

TEST(LocalizeClient, SendsTheCellOfThePriorOrElseOfTheLastAnswer) {
  const std::string cell = CellName(Geodetic::FromDegrees(47.3769, 8.5417, 408.0));
  EXPECT_THAT(CellsSent("32N-00001-00002"), ElementsAre(cell, "32N-00001-00002"));
}

TEST(LocalizeClient, AsksTheFrontAgainIfItsServerDied) {
  int num_requests = 0;
  const testing::CannedServer server([&](const httplib::Request&, httplib::Response& response) {
    response.status = ++num_requests == 1 ? 502 : 200;
  });
  LocalizeClient client({.url = server.url()});
  EXPECT_NO_THROW(client.Get("/version"));
  EXPECT_EQ(num_requests, 2);
}

TEST(LocalizeClient, AFrontWithoutServersIsAnError) {
  const testing::CannedServer server(
      [&](const httplib::Request&, httplib::Response& response) { response.status = 502; });
  LocalizeClient client({.url = server.url()});
  EXPECT_THROW(client.Get("/version"), Error);
}

TEST(LocalizeClient, DoesNotRepeatACellThatIsNone) {
  for (const std::string& bad : {std::string("x"), std::string(4000, 'N')}) {
    EXPECT_THAT(CellsSent(bad)[1], "");
  }
}

TEST(LocalizeClient, SaysWhenNoServerAnswers) {
  LocalizeQuery query;
  query.features.descriptors.resize(0, 128);
  try {
    LocalizeClient({.url = "http://127.0.0.1:1", .timeout_ms = 2000}).LocalizeFeatures(query);
    ADD_FAILURE() << "answered";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kUnavailable);
    EXPECT_THAT(e.what(), HasSubstr("http://127.0.0.1:1"));
  }
}

TEST(LocalizeClient, AsksUnderThePathOfTheUrl) {
  std::string path;
  const testing::CannedServer server(
      [&](const httplib::Request& request, httplib::Response&) { path = request.path; });
  LocalizeClient({.url = server.url() + "/"}).Get("/version");
  EXPECT_EQ(path, "/version");
  LocalizeClient({.url = server.url() + "/vps/"}).Get("/version");
  EXPECT_EQ(path, "/vps/version");
}

TEST(LocalizeClient, RefusesUrlsThatAreNone) {
  for (const char* url : {"", "http://", "localhost:8080", "ftp://h", "http://h/a b"}) {
    EXPECT_THROW(LocalizeClient({.url = url}), Error) << url;
  }
}

// The error of a client with a key whose server answers so.
Error ErrorFor(int status, const std::string& body, const std::string& key = "cairn_abc") {
  const testing::CannedServer server([&](const httplib::Request&, httplib::Response& response) {
    response.status = status;
    response.set_header("Retry-After", "3600");
    response.set_content(body, "application/problem+json");
  });
  try {
    LocalizeClient({.url = server.url(), .api_key = key}).Get("/version");
  } catch (const Error& error) {
    return error;
  }
  return Error(ErrorCode::kInternal, "no error");
}

TEST(LocalizeClient, SaysWhereARedirectPoints) {
  const testing::CannedServer server([&](const httplib::Request&, httplib::Response& response) {
    response.status = 301;
    response.set_header("Location", "https://map.example/vps/version");
  });
  try {
    LocalizeClient({.url = server.url()}).Get("/version");
    ADD_FAILURE() << "answered";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("301 and points to https://map.example/vps; give that"));
  }
}

TEST(LocalizeClient, NeverRepeatsItsKey) {
  const std::string echo =
      R"({"detail":"unknown: cairn_abc","hint":"is cairn_abccairn_abc right?"})";
  EXPECT_THAT(ErrorFor(401, echo).what(), HasSubstr("unknown: [API key]"));
  EXPECT_THAT(ErrorFor(401, echo).what(), Not(HasSubstr("cairn_abc")));
}

TEST(LocalizeClient, SaysHowToGiveAKey) {
  const std::string needed = R"({"detail":"this route needs an API key"})";
  EXPECT_THAT(ErrorFor(401, needed, "").what(), HasSubstr("--api-key-file or CAIRN_API_KEY"));
  EXPECT_THAT(ErrorFor(401, needed).what(), Not(HasSubstr("--api-key-file")));
}

TEST(LocalizeClient, WaitsForItsRateButNotForItsQuota) {
  int num_requests = 0;
  const testing::CannedServer server([&](const httplib::Request&, httplib::Response& response) {
    response.status = ++num_requests < 3 ? 429 : 200;
    response.set_header("Retry-After", "2");
    response.set_content("fine", "text/plain");
  });
  std::vector<int64_t> pauses_s;
  LocalizeClient client({.url = server.url(), .wait = [&](std::chrono::seconds pause) {
                           pauses_s.push_back(pause.count());
                         }});
  EXPECT_EQ(client.Get("/version"), "fine");
  EXPECT_THAT(pauses_s, ElementsAre(2, 2));
  const Error quota = ErrorFor(429, R"({"detail":"as many as it may send a day"})");
  EXPECT_EQ(quota.code(), ErrorCode::kUnavailable);
  EXPECT_THAT(quota.what(), HasSubstr("a day"));
}

}  // namespace
}  // namespace cairn
