#include "http/service/access_log.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

AccessRecord RecordOf(std::string_view path, int status = 200) {
  return {
      .time = std::chrono::system_clock::time_point(std::chrono::milliseconds(1'764'150'476'045)),
      .client = "192.0.2.7",
      .label = "",
      .method = "GET",
      .path = path,
      .status = status,
      .num_bytes = 12,
      .seconds = 0.01234,
      .reason = "",
      .request_id = "r1"};
}

std::string LogText(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

int64_t CountLines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

// Reads what this process logs while it exists.
class OwnLog {
 public:
  OwnLog() : saved_(dup(STDERR_FILENO)) {
    if (saved_ < 0 || pipe(ends_) != 0 || dup2(ends_[1], STDERR_FILENO) < 0) {
      throw std::runtime_error("no pipe");
    }
  }
  ~OwnLog() {
    dup2(saved_, STDERR_FILENO);
    close(saved_);
    close(ends_[0]);
    close(ends_[1]);
  }
  OwnLog(const OwnLog&) = delete;
  OwnLog& operator=(const OwnLog&) = delete;

  // Waits for the line.
  std::string ReadLine() const {
    std::string line;
    char c = 0;
    while (read(ends_[0], &c, 1) == 1 && c != '\n') {
      line += c;
    }
    return line;
  }

 private:
  int saved_;
  int ends_[2];
};

TEST(AccessLog, ALineSaysWhoAskedForWhat) {
  AccessRecord record = RecordOf("/v1/localize");
  record.label = "acme";
  record.reason = "NO_COVERAGE";
  const json line = json::parse(AccessLine(record));
  EXPECT_EQ(line["time"], "2025-11-26T09:47:56.045Z");
  EXPECT_EQ(line["client"], "192.0.2.7");
  EXPECT_EQ(line["label"], "acme");
  EXPECT_EQ(line["method"], "GET");
  EXPECT_EQ(line["path"], "/v1/localize");
  EXPECT_EQ(line["status"], 200);
  EXPECT_EQ(line["bytes"], 12);
  EXPECT_EQ(line["ms"], 12.3);
  EXPECT_EQ(line["reason"], "NO_COVERAGE");
  EXPECT_EQ(line["id"], "r1");
  EXPECT_TRUE(json::parse(AccessLine(RecordOf("/")))["label"].is_null());
}

TEST(AccessLog, NobodyWritesLinesOfTheirOwn) {
  const std::string path = "/a\"}\n{\"time\":\"forged\"}\r\x1b[2J\xff\xe2\x80\xae";
  const std::string line = AccessLine(RecordOf(path));
  EXPECT_EQ(CountLines(line), 1);
  EXPECT_TRUE(
      std::all_of(line.begin(), line.end() - 1, [](char c) { return c >= ' ' && c <= '~'; }));
  EXPECT_EQ(json::parse(line).size(), 10u);
}

TEST(AccessLog, ALongPathIsCut) {
  const std::string path = "/" + std::string(4000, 'x');
  EXPECT_EQ(json::parse(AccessLine(RecordOf(path)))["path"], path.substr(0, 256));
  EXPECT_LT(AccessLine(RecordOf(std::string(4000, '\x01'))).size(), 2000u);
}

TEST(AccessLog, AppendsEveryLineInOrder) {
  const testing::TempDir dir;
  const std::string path = dir.File("access.log");
  std::ofstream(path) << "before\n";
  {
    AccessLog log(path);
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&log] {
        for (int j = 0; j < 250; ++j) {
          log.Add(RecordOf("/"));
        }
      });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    log.Add(RecordOf("/last"));
  }
  const std::string text = LogText(path);
  EXPECT_EQ(CountLines(text), 1002);
  EXPECT_THAT(text, ::testing::StartsWith("before\n"));
  EXPECT_THAT(text.substr(text.size() - 150), HasSubstr("/last"));
}

TEST(AccessLog, IsForItsOwnerAndGroup) {
  const testing::TempDir dir;
  const AccessLog log(dir.File("access.log"));
  struct stat info {};
  ASSERT_EQ(stat(dir.File("access.log").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0027, 0u);
}

TEST(AccessLog, GoesOnInANewFileAfterTheOldOneWasMoved) {
  const testing::TempDir dir;
  const std::string path = dir.File("access.log"), moved = dir.File("access.log.1");
  {
    AccessLog log(path);
    log.Add(RecordOf("/old"));
    std::filesystem::rename(path, moved);
    log.Reopen();
    log.Add(RecordOf("/new"));
  }
  EXPECT_THAT(LogText(path), HasSubstr("/new"));
  EXPECT_EQ(CountLines(LogText(path) + LogText(moved)), 2);
}

TEST(AccessLog, StaysWithItsFileIfThereIsNoNewOne) {
  const testing::TempDir dir;
  const std::string folder = dir.File("logs");
  std::filesystem::create_directory(folder);
  ::testing::internal::CaptureStderr();
  {
    AccessLog log(folder + "/access.log");
    std::filesystem::rename(folder, dir.File("moved"));
    log.Reopen();
    log.Add(RecordOf("/kept"));
  }
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("cannot open the access log"));
  EXPECT_THAT(LogText(dir.File("moved") + "/access.log"), HasSubstr("/kept"));
}

// The device takes no byte, as a full disk.
TEST(AccessLog, AFullDiskIsSaidOnce) {
  ::testing::internal::CaptureStderr();
  for (int i = 0; i < 2; ++i) {
    AccessLog log("/dev/full");
    for (int j = 0; j < 100; ++j) {
      log.Add(RecordOf("/"));
    }
  }
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(CountLines(text), 2) << text;
  EXPECT_THAT(text, HasSubstr("/dev/full cannot be written: No space left on device"));
}

TEST(AccessLog, SaysWhenLinesAreWrittenAgain) {
  const testing::TempDir dir;
  const std::string link = dir.File("access.log");
  std::filesystem::create_symlink("/dev/full", link);
  {
    const OwnLog own_log;
    AccessLog log(link);
    log.Add(RecordOf("/lost"));
    EXPECT_THAT(own_log.ReadLine(), HasSubstr("cannot be written: No space left on device"));
    std::filesystem::remove(link);
    log.Reopen();
    log.Add(RecordOf("/written"));
    EXPECT_THAT(own_log.ReadLine(), HasSubstr("is written again; 1 lines were lost"));
  }
  EXPECT_THAT(LogText(link), HasSubstr("/written"));
}

// A limit of the size of files breaks a line in the middle. Nobody has moved the file.
TEST(AccessLog, ABrokenLineEndsAlsoIfTheSameFileIsOpenedAgain) {
  const testing::TempDir dir;
  const std::string path = dir.File("access.log");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, SIG_IGN);
  {
    const OwnLog own_log;
    AccessLog log(path);
    const rlimit small{.rlim_cur = 100, .rlim_max = before.rlim_max};
    EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    log.Add(RecordOf("/broken"));
    EXPECT_THAT(own_log.ReadLine(), HasSubstr("cannot be written: File too large"));
    EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    log.Reopen();
    log.Add(RecordOf("/whole"));
    EXPECT_THAT(own_log.ReadLine(), HasSubstr("is written again; 1 lines were lost"));
  }
  std::signal(SIGXFSZ, SIG_DFL);
  const std::string text = LogText(path);
  ASSERT_EQ(CountLines(text), 2) << text;
  EXPECT_EQ(json::parse(text.substr(text.find('\n')))["path"], "/whole");
}

// What a reader does not take is lost; nobody waits for it, and its end ends nothing else.
TEST(AccessLog, IsBoundedIfNobodyReadsThePipe) {
  const testing::TempDir dir;
  const std::string path = dir.File("pipe");
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_THROW(AccessLog{path}, Error) << "a pipe without a reader";
  const int reader = open(path.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  ::testing::internal::CaptureStderr();
  {
    AccessLog log(path);
    for (int i = 0; i < 40'000; ++i) {  // 6 MB.
      log.Add(RecordOf("/"));
    }
    close(reader);
  }
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("lines are lost"));
}

TEST(AccessLog, NamesTheFileThatItCannotWrite) {
  try {
    AccessLog log("/no/such/folder/access.log");
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kIo);
    EXPECT_THAT(error.what(), HasSubstr("/no/such/folder/access.log"));
  }
}

}  // namespace
}  // namespace cairn
