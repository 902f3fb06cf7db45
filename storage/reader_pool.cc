#include "storage/reader_pool.h"

#include <utility>

#include "storage/map_file.h"
#include "storage/map_queries.h"

namespace cairn {

ReaderPool::ReaderPool(std::unique_ptr<sqlite::Connection> first, sqlite::Access access)
    : path_(first->path()), access_(access) {
  idle_.push_back(std::move(first));
}

std::unique_ptr<sqlite::Connection> ReaderPool::Take() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      std::unique_ptr<sqlite::Connection> connection = std::move(idle_.back());
      idle_.pop_back();
      return connection;
    }
  }
  return ReopenMapFile(path_, access_);
}

void ReaderPool::GiveBack(std::unique_ptr<sqlite::Connection> connection) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(connection));
}

std::shared_ptr<const Codebook> ReaderPool::LoadCodebook(sqlite::Connection* connection,
                                                         CodebookId codebook_id) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = codebooks_.find(codebook_id); found != codebooks_.end()) {
      return found->second;
    }
  }
  std::shared_ptr<const Codebook> codebook = queries::LoadCodebook(connection, codebook_id);
  const std::lock_guard lock(mutex_);
  return codebooks_.emplace(codebook_id, std::move(codebook)).first->second;
}

}  // namespace cairn
