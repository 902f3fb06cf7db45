// A folder beside the temporary files, deleted with the object. Private to ingest.
#ifndef CAIRN_INGEST_TEMPORARY_FOLDER_H_
#define CAIRN_INGEST_TEMPORARY_FOLDER_H_

#include <string>

namespace cairn {

// A process that is killed leaves its folder behind. The next object that anybody makes removes the
// user's folders of processes that are dead: a process holds a lock on its own.
class TemporaryFolder {
 public:
  // Throws Error(kIo) if the folder cannot be made.
  TemporaryFolder();
  ~TemporaryFolder();  // Removes the folder and all that is in it.
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int lock_fd_ = -1;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_TEMPORARY_FOLDER_H_
