#include "http/service/access_log.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "core/logging.h"

namespace cairn {
namespace {

// Holds the lines of a second at 10,000 requests a second.
constexpr size_t kMaxPendingBytes = size_t{4} << 20;
// Longer than all paths of the API. JSON may need six bytes for one of them.
constexpr size_t kMaxPathBytes = 256;
// How long a pipe may be full before its lines are lost.
constexpr int kPipePatienceMs = 1000;

std::string TimeText(std::chrono::system_clock::time_point time) {
  using std::chrono::floor, std::chrono::milliseconds, std::chrono::seconds;
  const auto whole = floor<seconds>(time);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(whole)),
                     floor<milliseconds>(time - whole).count());
}

bool AreSameFile(int a, int b) {
  struct stat of_a {
  }, of_b{};
  return fstat(a, &of_a) == 0 && fstat(b, &of_b) == 0 && of_a.st_dev == of_b.st_dev &&
         of_a.st_ino == of_b.st_ino;
}

int64_t NumLines(std::string_view text) { return std::count(text.begin(), text.end(), '\n'); }

}  // namespace

std::string AccessLine(const AccessRecord& record) {
  nlohmann::ordered_json json = {{"time", TimeText(record.time)}, {"client", record.client}};
  json["label"] = record.label.empty() ? nlohmann::ordered_json() : record.label;
  json["method"] = record.method;
  json["path"] = record.path.substr(0, kMaxPathBytes);
  json["status"] = record.status;
  json["bytes"] = record.num_bytes;
  json["ms"] = std::round(1e4 * record.seconds) / 10.0;
  json["reason"] = record.reason.empty() ? nlohmann::ordered_json() : record.reason;
  json["id"] = record.request_id;
  return json.dump(-1, ' ', /*ensure_ascii=*/true,
                   nlohmann::ordered_json::error_handler_t::replace) +
         "\n";
}

AccessLog::AccessLog(const std::string& path) : path_(path), fd_(Open()) {
  if (fd_ < 0) {
    throw Error(ErrorCode::kIo,
                fmt::format("cannot write the access log {}: {}", path, std::strerror(errno)));
  }
  thread_ = std::thread([this] { Work(); });
}

AccessLog::~AccessLog() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
  close(fd_);
}

int AccessLog::Open() const {
  return open(path_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NONBLOCK | O_NOCTTY,
              S_IRUSR | S_IWUSR | S_IRGRP);
}

void AccessLog::Add(const AccessRecord& record) {
  const std::string line = AccessLine(record);
  bool was_idle = false;
  {
    const std::lock_guard lock(mutex_);
    if (lines_.size() + line.size() > kMaxPendingBytes) {
      ++num_left_out_;
      return;
    }
    was_idle = lines_.empty();
    lines_ += line;
  }
  if (was_idle) {
    wake_.notify_one();
  }
}

void AccessLog::Reopen() {
  {
    const std::lock_guard lock(mutex_);
    must_reopen_ = true;
  }
  wake_.notify_one();
}

void AccessLog::Work() {
  // A pipe whose reader has gone is an error of write, not the end of the process.
  sigset_t broken_pipe;
  sigemptyset(&broken_pipe);
  sigaddset(&broken_pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &broken_pipe, nullptr);
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stopping_ || must_reopen_ || !lines_.empty(); });
    const std::string lines = std::exchange(lines_, {});
    const int64_t num_left_out = std::exchange(num_left_out_, 0);
    const bool must_reopen = std::exchange(must_reopen_, false);
    const bool is_last = stopping_;
    lock.unlock();
    if (must_reopen) {
      OpenAgain();
    }
    if (!lines.empty()) {
      Write(lines);
    }
    if (num_left_out > 0) {
      CountLost("", num_left_out, EAGAIN);
    }
    lock.lock();
    if (is_last && lines_.empty()) {
      return;
    }
  }
}

void AccessLog::OpenAgain() {
  const int fd = Open();
  if (fd < 0) {
    LogError("cannot open the access log {} again: {}; it goes on in the file of before", path_,
             std::strerror(errno));
    return;
  }
  is_within_line_ = is_within_line_ && AreSameFile(fd, fd_);
  close(std::exchange(fd_, fd));
}

void AccessLog::Write(std::string_view lines) {
  constexpr std::string_view kEndOfLine = "\n";
  std::string_view end_of_broken_line = is_within_line_ ? kEndOfLine : "";
  if (WriteAll(&end_of_broken_line) && WriteAll(&lines)) {
    if (num_lost_ > 0) {
      LogWarning("the access log {} is written again; {} lines were lost", path_,
                 std::exchange(num_lost_, 0));
    }
    return;
  }
  CountLost(lines, 0, errno);
}

// Removes what has been written from `lines`. False, with errno, if the file takes no more.
bool AccessLog::WriteAll(std::string_view* lines) {
  while (!lines->empty()) {
    const ssize_t written = write(fd_, lines->data(), lines->size());
    if (written > 0) {
      is_within_line_ = (*lines)[static_cast<size_t>(written) - 1] != '\n';
      lines->remove_prefix(static_cast<size_t>(written));
    } else if (written < 0 && errno == EAGAIN) {
      pollfd pipe{.fd = fd_, .events = POLLOUT, .revents = 0};
      if (poll(&pipe, 1, kPipePatienceMs) <= 0) {
        errno = EAGAIN;
        return false;
      }
    } else if (written == 0 || errno != EINTR) {
      return false;
    }
  }
  return true;
}

void AccessLog::CountLost(std::string_view lines, int64_t num_others, int error) {
  if (num_lost_ == 0) {
    LogError("the access log {} cannot be written: {}; lines are lost until it can", path_,
             error == EAGAIN ? "it takes them too slowly" : std::strerror(error));
  }
  num_lost_ += NumLines(lines) + num_others;
}

}  // namespace cairn
