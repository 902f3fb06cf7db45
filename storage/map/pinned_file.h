// A handle that identifies a file even after its path is renamed or replaced.
#ifndef CAIRN_STORAGE_MAP_PINNED_FILE_H_
#define CAIRN_STORAGE_MAP_PINNED_FILE_H_

#include <string>

namespace cairn {

// Remembers which file a path referred to. While the handle exists, the file system cannot reuse
// the file's inode number. The handle is opened without access to the content, so closing it does
// not release locks that this process holds on the file.
class PinnedFile {
 public:
  // Pins nothing if the path does not exist or may not be accessed.
  explicit PinnedFile(const std::string& path);
  ~PinnedFile();
  PinnedFile(PinnedFile&& other) noexcept;
  PinnedFile& operator=(PinnedFile&& other) noexcept;

  // Returns true if the path refers to the pinned file; false if nothing is pinned.
  bool IsAt(const std::string& path) const;

 private:
  int fd_ = -1;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_PINNED_FILE_H_
