#include "core/replace_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <random>

#include "core/check.h"
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
}

void WriteToDisk(int fd, const std::string& path) {
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

void GiveName(const UnfinishedFile& file, const std::string& path) {
  WriteToDisk(file.fd(), file.name());
  if (std::rename(file.name().c_str(), path.c_str()) != 0) {
    const int error = errno;
    if (error != ENOENT || !std::filesystem::exists(path)) {
      ThrowIo(path, error);
    }
  }
}

std::span<const uint8_t> BytesOf(std::string_view text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

}  // namespace

void ReplaceFile(const std::string& path, std::span<const uint8_t> bytes) {
  const UnfinishedFile file(path);
  WriteAll(file.fd(), bytes, file.name());
  GiveName(file, path);
}

struct FileReplacement::Impl {
  explicit Impl(const std::string& path_in) : path(path_in), file(path_in) {}

  void Flush() {
    WriteAll(file.fd(), BytesOf(buffer), file.name());
    buffer.clear();
  }

  std::string path;
  UnfinishedFile file;
  std::string buffer;
};

FileReplacement::FileReplacement(const std::string& path) : impl_(std::make_unique<Impl>(path)) {}

FileReplacement::~FileReplacement() = default;

void FileReplacement::Write(std::string_view bytes) {
  constexpr size_t kBufferBytes = size_t{1} << 18;
  impl_->buffer += bytes;
  size_ += bytes.size();
  if (impl_->buffer.size() >= kBufferBytes) {
    impl_->Flush();
  }
}

void FileReplacement::Overwrite(uint64_t position, std::string_view bytes) {
  CAIRN_CHECK(position + bytes.size() <= size_, "the bytes were written before");
  impl_->Flush();
  const int fd = impl_->file.fd();
  if (lseek(fd, static_cast<off_t>(position), SEEK_SET) < 0) {
    ThrowIo(impl_->file.name(), errno);
  }
  WriteAll(fd, BytesOf(bytes), impl_->file.name());
  if (lseek(fd, 0, SEEK_END) < 0) {
    ThrowIo(impl_->file.name(), errno);
  }
}

void FileReplacement::Commit() {
  impl_->Flush();
  GiveName(impl_->file, impl_->path);
}

}  // namespace cairn
