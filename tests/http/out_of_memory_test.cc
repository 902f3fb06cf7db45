// Tests a server that runs out of memory, in a separate process.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "core/memory_reserve.h"
#include "http/raw_socket.h"
#include "http/server_fixture.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsSanitized = true;  // Sanitizers need terabytes of addresses.
#else
constexpr bool kIsSanitized = false;
#endif

// Serves until it is killed; the port goes down the pipe.
[[noreturn]] void Serve(const ServerOptions& options, int pipe_fd) {
  SetUpMemoryReserve(size_t{16} << 20);
  Server server(options);
  server.Start();
  const int port = server.port();
  if (write(pipe_fd, &port, sizeof(port)) != sizeof(port)) {
    _exit(1);
  }
  while (true) {
    pause();
  }
}

class HttpOutOfMemory : public testing::ServerFixture {
 protected:
  // Before the fixture's own server has threads, which a fork would not take along.
  static void SetUpTestSuite() {
    ServerFixture::SetUpTestSuite();
    server_.reset();
    int pipe_fds[2];
    ASSERT_EQ(pipe(pipe_fds), 0);
    pid_ = fork();
    if (pid_ == 0) {
      Serve(Options(), pipe_fds[1]);
    }
    close(pipe_fds[1]);  // Before reading, which otherwise waits for ever for a server that died.
    ASSERT_EQ(read(pipe_fds[0], &port_, sizeof(port_)), static_cast<ssize_t>(sizeof(port_)));
    close(pipe_fds[0]);
  }
  static void TearDownTestSuite() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    ServerFixture::TearDownTestSuite();
  }

  static bool IsAlive() { return waitpid(pid_, nullptr, WNOHANG) == 0; }

  // Lets the server's address space grow by this much from where it is.
  static void AllowBytes(rlim_t num_bytes) {
    std::ifstream status(fmt::format("/proc/{}/statm", pid_));
    rlim_t num_pages = 0;
    status >> num_pages;
    const rlimit limit{num_pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + num_bytes,
                       RLIM_INFINITY};
    ASSERT_EQ(prlimit(pid_, RLIMIT_AS, &limit, nullptr), 0);
  }

  static std::string Post(const std::string& body) {
    testing::RawSocket socket(port_);
    socket.Send(
        fmt::format("POST /v1/localize HTTP/1.1\r\nHost: x\r\nConnection: close\r\n"
                    "Content-Type: multipart/form-data; boundary=B\r\n"
                    "Content-Length: {}\r\n\r\n",
                    body.size()));
    socket.Send(body);
    return socket.ReadAll();
  }

  static pid_t pid_;
  static int port_;
};

pid_t HttpOutOfMemory::pid_ = -1;
int HttpOutOfMemory::port_ = 0;

// A picture that takes 1.9 MB to send and ten times that to find features in.
std::string LargePicture() {
  constexpr int kWidth = 1600, kHeight = 1200;
  std::string image = fmt::format("P5 {} {} 255\n", kWidth, kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    image += static_cast<char>(i * 7 % 251);
  }
  return fmt::format(
             "--B\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n"
             R"({{"camera":{{"model":"SIMPLE_PINHOLE","size":[{},{}],"modelParams":[900,800,600]}}}})"
             "\r\n--B\r\nContent-Disposition: form-data; name=\"image\"\r\n\r\n",
             kWidth, kHeight) +
         image + "\r\n--B--\r\n";
}

TEST_F(HttpOutOfMemory, IsA503AndTheServerLives) {
  if (kIsSanitized) {
    GTEST_SKIP() << "sanitizers do not run under a limit of addresses";
  }
  const std::string body = LargePicture();
  int num_refused = 0;
  for (const rlim_t room : {rlim_t{0}, rlim_t{1} << 20, rlim_t{5} << 20, rlim_t{20} << 20}) {
    AllowBytes(room);
    std::vector<std::string> answers(16);
    std::vector<std::thread> threads;
    for (std::string& answer : answers) {
      threads.emplace_back([&] { answer = Post(body); });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    for (const std::string& answer : answers) {
      if (!answer.starts_with("HTTP/1.1 503")) {
        continue;
      }
      ++num_refused;
      EXPECT_THAT(answer, HasSubstr("application/problem+json"));
      EXPECT_THAT(answer, HasSubstr("out of memory"));
    }
    ASSERT_TRUE(IsAlive()) << room;
  }
  EXPECT_GT(num_refused, 0);
  AllowBytes(rlim_t{4} << 30);
  EXPECT_THAT(Post(body), ::testing::StartsWith("HTTP/1.1 200"));
  LocalizeClient client({.url = fmt::format("http://127.0.0.1:{}", port_)});
  EXPECT_TRUE(client.LocalizeFeatures(Query()).localized);
}

}  // namespace
}  // namespace cairn
