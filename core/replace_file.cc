#include "core/replace_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <random>

#include "core/error.h"

namespace cairn {
namespace {

[[noreturn]] void ThrowIo(const std::string& path, int error) {
  throw Error(ErrorCode::kIo, fmt::format("{}: {}", path, std::strerror(error)));
}

void WriteAll(int fd, std::span<const uint8_t> bytes, const std::string& path) {
  while (!bytes.empty()) {
    const ssize_t num_written = write(fd, bytes.data(), bytes.size());
    if (num_written < 0 && errno != EINTR) {
      ThrowIo(path, errno);
    }
    bytes = bytes.subspan(num_written < 0 ? 0 : static_cast<size_t>(num_written));
  }
  if (fsync(fd) != 0) {
    ThrowIo(path, errno);
  }
}

// A file under a name that no other process takes; it is deleted with the object unless renamed.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::string& path) {
    std::random_device random;
    name_ = fmt::format("{}.{:08x}{:08x}{}", path, random(), random(), kUnfinishedSuffix);
    fd_ = open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    if (fd_ < 0) {
      ThrowIo(name_, errno);
    }
  }
  ~UnfinishedFile() {
    close(fd_);
    unlink(name_.c_str());
  }
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  int fd() const { return fd_; }
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  int fd_ = -1;
};

}  // namespace

void ReplaceFile(const std::string& path, std::span<const uint8_t> bytes) {
  const UnfinishedFile file(path);
  WriteAll(file.fd(), bytes, file.name());
  if (std::rename(file.name().c_str(), path.c_str()) != 0) {
    const int error = errno;
    if (error != ENOENT || !std::filesystem::exists(path)) {
      ThrowIo(path, error);
    }
  }
}

}  // namespace cairn
