// The reading connections of an open map; private to storage.
#ifndef CAIRN_STORAGE_READER_POOL_H_
#define CAIRN_STORAGE_READER_POOL_H_

#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "storage/codebook.h"
#include "storage/ids.h"
#include "storage/sqlite/connection.h"

namespace cairn {

// Connections are opened as needed and kept for reuse with their compiled statements: as many as
// there were snapshots at one time. Also keeps decoded codebooks, which never change. Safe to call
// from any thread.
class ReaderPool {
 public:
  // `first` has passed the checks of OpenMapFile with `access`.
  ReaderPool(std::unique_ptr<sqlite::Connection> first, sqlite::Access access);

  const std::string& path() const { return path_; }

  std::unique_ptr<sqlite::Connection> Take();
  void GiveBack(std::unique_ptr<sqlite::Connection> connection);

  // Reads through `connection` what is not kept yet.
  std::shared_ptr<const Codebook> LoadCodebook(sqlite::Connection* connection,
                                               CodebookId codebook_id);

 private:
  const std::string path_;
  const sqlite::Access access_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<sqlite::Connection>> idle_;
  std::unordered_map<CodebookId, std::shared_ptr<const Codebook>> codebooks_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_READER_POOL_H_
