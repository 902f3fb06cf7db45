// A file that stays the same one, whatever becomes of its name.
#ifndef CAIRN_STORAGE_MAP_PINNED_FILE_H_
#define CAIRN_STORAGE_MAP_PINNED_FILE_H_

#include <string>

namespace cairn {

// Remembers which file a name stood for. Does not open the file, so that closing it takes no locks
// from others in this process, but keeps the system from giving its number to another file.
class PinnedFile {
 public:
  // Of a name that stands for nothing, or for what may not be looked at, nothing is pinned.
  explicit PinnedFile(const std::string& path);
  ~PinnedFile();
  PinnedFile(PinnedFile&& other) noexcept;
  PinnedFile& operator=(PinnedFile&& other) noexcept;

  // The name stands for the pinned file; false if nothing is pinned.
  bool IsAt(const std::string& path) const;

 private:
  int fd_ = -1;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_PINNED_FILE_H_
