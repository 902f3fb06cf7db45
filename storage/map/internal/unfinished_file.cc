#include "storage/map/internal/unfinished_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "core/error.h"

namespace cairn {
namespace {

[[noreturn]] void RefuseToMake(const std::string& path, int error) {
  if (error == EEXIST) {
    throw Error(ErrorCode::kConflict, path + ": already exists; remove it or choose another name");
  }
  throw Error(ErrorCode::kIo, path + ": cannot be created: " + std::strerror(error));
}

// Renames a file unless `to` exists. The check and the rename are one atomic step.
void Rename(const std::string& from, const std::string& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) {
    return;
  }
  if (errno != EINVAL && errno != ENOSYS) {
    RefuseToMake(to, errno);
  }
  // This file system does not support RENAME_NOREPLACE. Creating a hard link is atomic, too.
  if (link(from.c_str(), to.c_str()) != 0) {
    RefuseToMake(to, errno);
  }
  unlink(from.c_str());
}

// Returns true if `name` still stands for the open file.
bool IsAt(int fd, const std::string& name) {
  struct stat open_file {};
  struct stat named_file {};
  return fstat(fd, &open_file) == 0 && stat(name.c_str(), &named_file) == 0 &&
         open_file.st_dev == named_file.st_dev && open_file.st_ino == named_file.st_ino;
}

// Opens and locks the file, and creates it if needed.
int OpenLocked(const std::string& name, const std::string& path) {
  while (true) {
    const int fd = open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (fd < 0) {
      RefuseToMake(path, errno);
    }
    if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
      const int error = errno;
      close(fd);
      if (error != EWOULDBLOCK) {
        RefuseToMake(path, error);
      }
      throw Error(ErrorCode::kConflict, path + ": another process is creating this file");
    }
    if (IsAt(fd, name)) {
      return fd;
    }
    close(fd);  // Another process finished or removed the file in the meantime.
  }
}

}  // namespace

UnfinishedFile::UnfinishedFile(const std::string& path) : path_(path), name_(path + ".unfinished") {
  std::error_code ignored;
  if (std::filesystem::exists(path_, ignored)) {
    RefuseToMake(path_, EEXIST);
  }
  lock_fd_ = OpenLocked(name_, path_);
  // A process that died may have left content and logs.
  for (const char* suffix : {"-wal", "-shm", "-journal"}) {
    std::filesystem::remove(name_ + suffix, ignored);
  }
  if (ftruncate(lock_fd_, 0) != 0) {
    const int error = errno;
    close(lock_fd_);
    RefuseToMake(path_, error);
  }
}

UnfinishedFile::~UnfinishedFile() {
  if (!is_finished_) {
    std::error_code ignored;
    for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
      std::filesystem::remove(name_ + suffix, ignored);
    }
  }
  close(lock_fd_);
}

void UnfinishedFile::Finish() {
  Rename(name_, path_);
  is_finished_ = true;
}

}  // namespace cairn
