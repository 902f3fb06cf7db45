#include "storage/map/pinned_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <utility>

namespace cairn {

PinnedFile::PinnedFile(const std::string& path) : fd_(open(path.c_str(), O_PATH | O_CLOEXEC)) {}

PinnedFile::~PinnedFile() {
  if (fd_ >= 0) {
    close(fd_);
  }
}

PinnedFile::PinnedFile(PinnedFile&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

PinnedFile& PinnedFile::operator=(PinnedFile&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

bool PinnedFile::IsAt(const std::string& path) const {
  struct stat pinned {};
  struct stat there {};
  return fd_ >= 0 && fstat(fd_, &pinned) == 0 && stat(path.c_str(), &there) == 0 &&
         pinned.st_dev == there.st_dev && pinned.st_ino == there.st_ino;
}

}  // namespace cairn
