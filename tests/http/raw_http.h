// Requests as text to the server of a suite, and the parts of its replies.
#ifndef CAIRN_TESTS_HTTP_RAW_HTTP_H_
#define CAIRN_TESTS_HTTP_RAW_HTTP_H_

#include <gtest/gtest.h>

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "http/raw_socket.h"
#include "http/server_fixture.h"

namespace cairn::testing {

struct Reply {
  int status = 0;
  std::string head;
  std::string body;
};

inline Reply Split(const std::string& text) {
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

class RawHttpTest : public ServerFixture {
 protected:
  static Reply Send(const std::string& bytes) {
    RawSocket socket(port());
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

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_HTTP_RAW_HTTP_H_
