// Tests the client against servers that are not Cairn's.
#include "http/client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "core/error.h"
#include "http/plain_http.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

// Answers each request with 400 and this body.
class RefusingServer {
 public:
  explicit RefusingServer(const std::string& body) {
    server_.Get("/.*", [body](const httplib::Request&, httplib::Response& response) {
      response.status = 400;
      response.set_content(body, "application/problem+json");
    });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
  }
  ~RefusingServer() {
    server_.stop();
    thread_.join();
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }

 private:
  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
};

std::string MessageFor(const std::string& body) {
  const RefusingServer server(body);
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
