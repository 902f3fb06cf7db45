// A server that says what a test wants.
#ifndef CAIRN_TESTS_SUPPORT_CANNED_SERVER_H_
#define CAIRN_TESTS_SUPPORT_CANNED_SERVER_H_

#include <httplib.h>

#include <string>
#include <thread>
#include <utility>

namespace cairn::testing {

// Calls `handler` for every GET and POST.
class CannedServer {
 public:
  explicit CannedServer(const httplib::Server::Handler& handler) {
    server_.Get("/.*", handler);
    server_.Post("/.*", handler);
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) {
      std::this_thread::yield();
    }
  }
  ~CannedServer() {
    server_.stop();
    thread_.join();
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }

 private:
  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_CANNED_SERVER_H_
