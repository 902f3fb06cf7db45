// The results of stages on disk, so that a run that was killed goes on where it was.
#ifndef CAIRN_MAPPING_WORK_FOLDER_H_
#define CAIRN_MAPPING_WORK_FOLDER_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cairn {

// A folder of files, each with the digest of what it was made from and a checksum:
// docs/formats/mapping_work_v2.md. A file is there as a whole or not at all. Load and Store may be
// called from several threads with different names.
class WorkFolder {
 public:
  // Makes the folder, locks it against other processes until the object is gone, and removes the
  // unfinished results that a killed process left. Throws Error(kConflict) if another process uses
  // the folder, and Error(kIo).
  explicit WorkFolder(const std::string& path);
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  // The bytes that were stored under `name` for `key`. Nothing if there are none, if they were
  // stored for another key, or if they are damaged: the stage then runs again.
  std::optional<std::vector<uint8_t>> Load(const std::string& name, const std::string& key) const;

  // `name` has no '/', and is one of docs/formats/mapping_work_v2.md: the unfinished file of
  // another name would not be removed. Replaces what was stored under it. Throws Error(kIo), e.g.
  // on a full disk.
  void Store(const std::string& name, const std::string& key, std::span<const uint8_t> bytes) const;

  std::string PathOf(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
  int lock_fd_ = -1;
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_WORK_FOLDER_H_
