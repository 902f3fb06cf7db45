#include "ingest/temporary_folder.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr char kPrefix[] = "cairn-ingest-";

void RemoveAll(const std::string& path) {
  std::error_code ignored;
  fs::remove_all(path, ignored);
}

int OpenFolder(const std::string& path) {
  return open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

// Returns true if the open folder is this user's and still has a name.
bool IsOwn(int fd) {
  struct stat status {};
  return fstat(fd, &status) == 0 && status.st_uid == geteuid() && status.st_nlink > 0;
}

std::vector<std::string> FoldersIn(const fs::path& parent) {
  std::vector<std::string> paths;
  std::error_code ignored;
  for (fs::directory_iterator entry(parent, ignored); entry != fs::directory_iterator();
       entry.increment(ignored)) {
    if (entry->path().filename().string().starts_with(kPrefix)) {
      paths.push_back(entry->path().string());
    }
  }
  return paths;
}

void RemoveFoldersOfTheDead(const fs::path& parent) {
  for (const std::string& path : FoldersIn(parent)) {
    const int fd = OpenFolder(path);
    if (fd < 0) {
      continue;
    }
    if (IsOwn(fd) && flock(fd, LOCK_EX | LOCK_NB) == 0) {
      RemoveAll(path);
    }
    close(fd);
  }
}

std::string MakeFolder(const fs::path& parent) {
  std::string path = (parent / (std::string(kPrefix) + "XXXXXX")).string();
  if (mkdtemp(path.data()) == nullptr) {
    throw Error(ErrorCode::kIo, path + ": cannot make a temporary folder: " + std::strerror(errno));
  }
  return path;
}

// Returns the open and locked folder; -1 if another process took it for one of the dead before the
// lock was there, and removed it.
int LockNew(const std::string& path) {
  const int fd = OpenFolder(path);
  if (fd < 0 && errno != ENOENT) {
    const int error = errno;
    RemoveAll(path);
    throw Error(ErrorCode::kIo, path + ": cannot be opened: " + std::strerror(error));
  }
  if (fd < 0) {
    return fd;
  }
  flock(fd, LOCK_EX);  // A file system without locks has no other process that removes the folder.
  if (!IsOwn(fd)) {
    close(fd);
    return -1;
  }
  return fd;
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  std::error_code error;
  const fs::path parent = fs::temp_directory_path(error);
  if (error) {
    throw Error(ErrorCode::kIo, "the directory for temporary files: " + error.message());
  }
  RemoveFoldersOfTheDead(parent);
  do {
    path_ = MakeFolder(parent);
    lock_fd_ = LockNew(path_);
  } while (lock_fd_ < 0);
}

TemporaryFolder::~TemporaryFolder() {
  RemoveAll(path_);
  close(lock_fd_);
}

}  // namespace cairn
