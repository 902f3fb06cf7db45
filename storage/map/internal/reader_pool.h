// The reading connections of an open map. Private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_READER_POOL_H_
#define CAIRN_STORAGE_MAP_INTERNAL_READER_POOL_H_

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "storage/database/connection.h"
#include "storage/database/sqlite/connection.h"
#include "storage/map/pinned_file.h"

namespace cairn {

// Opens connections as needed and keeps them, with their compiled statements, for reuse. The pool
// grows to the largest number of simultaneous reads. Safe to call from any thread.
class ReaderPool {
 public:
  // `first` has passed the checks of OpenMapFile with `access`. `file` pins the file that `first`
  // has open.
  ReaderPool(std::unique_ptr<sqlite::Connection> first, sqlite::Access access, PinnedFile file);

  const std::string& path() const { return path_; }
  // Returns true if the path still refers to the open file.
  bool IsInPlace() const { return file_.IsAt(path_); }

  // Borrows a connection. All connections read the same file. If another file has taken the path,
  // waits for a connection to be returned; throws Error(kUnavailable) if none is returned for a
  // long time.
  std::unique_ptr<db::Connection> Take();
  void GiveBack(std::unique_ptr<db::Connection> connection);

 private:
  std::unique_ptr<db::Connection> TakeIdle();
  std::unique_ptr<db::Connection> WaitForIdle();

  const std::string path_;
  const PinnedFile file_;
  const sqlite::Access access_;
  std::mutex mutex_;
  std::condition_variable given_back_;
  std::vector<std::unique_ptr<db::Connection>> idle_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_READER_POOL_H_
