// A file that is built under a temporary name and gets its name in one step; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_UNFINISHED_FILE_H_
#define CAIRN_STORAGE_MAP_INTERNAL_UNFINISHED_FILE_H_

#include <string>

namespace cairn {

// The temporary name is `path` + ".unfinished". If a process died while it built such a file, the
// next process reuses the name. A lock on the file keeps others off it. Close all connections to
// the file before Finish and before the end of the object's life.
class UnfinishedFile {
 public:
  // Throws Error(kConflict) if `path` exists or another process builds it, Error(kIo) if the file
  // cannot be created.
  explicit UnfinishedFile(const std::string& path);
  ~UnfinishedFile();  // Removes the file unless it is finished.
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  // The temporary name, of an empty file at first.
  const std::string& name() const { return name_; }

  // Renames the file to `path`. Throws as the constructor.
  void Finish();

 private:
  std::string path_;
  std::string name_;
  int lock_fd_ = -1;
  bool is_finished_ = false;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_UNFINISHED_FILE_H_
