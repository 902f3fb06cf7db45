// Tests `cairn serve` when the reader of its log goes away or does not read.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <utility>

#include "cli/run_cairn.h"
#include "http/client.h"
#include "storage/map/map_store.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

// A server that logs each request to a pipe.
class ServeLog : public ::testing::Test {
 protected:
  ServeLog() {
    MapStore::Create(map_);
    EXPECT_EQ(pipe2(pipe_, O_CLOEXEC), 0);
  }
  ~ServeLog() override { CloseReader(); }

  // Takes the pipe's end for writing.
  BackgroundCairn Serve() {
    const int own_stderr = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0);
    dup2(pipe_[1], STDERR_FILENO);
    close(pipe_[1]);
    struct Restore {
      int fd;
      ~Restore() {
        dup2(fd, STDERR_FILENO);
        close(fd);
      }
    } const restore{own_stderr};
    return BackgroundCairn({"serve", map_, "--port", "0", "--log-level", "debug"});
  }
  void CloseReader() {
    if (pipe_[0] >= 0) {
      close(std::exchange(pipe_[0], -1));
    }
  }

  TempDir dir_;
  const std::string map_ = dir_.File("map.gpkg");
  int pipe_[2] = {-1, -1};
};

TEST_F(ServeLog, MayLoseItsReader) {
  BackgroundCairn server = Serve();
  LocalizeClient client(ClientOptions{.url = server.ReadLine()});
  CloseReader();
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(client.Get("/livez"), R"({"status":"ok"})");
  }
  EXPECT_EQ(server.Stop(SIGTERM), 0);
}

TEST_F(ServeLog, MayHaveAReaderThatDoesNotRead) {
  constexpr int kPipeBytes = 4096, kLineBytes = 40;
  ASSERT_GE(fcntl(pipe_[1], F_SETPIPE_SZ, kPipeBytes), kPipeBytes);
  BackgroundCairn server = Serve();
  LocalizeClient client(ClientOptions{.url = server.ReadLine(), .timeout_ms = 5'000});
  for (int i = 0; i < 2 * kPipeBytes / kLineBytes; ++i) {
    client.Get("/livez");
  }
  EXPECT_EQ(server.Stop(SIGTERM), 0);
}

}  // namespace
}  // namespace cairn::testing
