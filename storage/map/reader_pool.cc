#include "storage/map/reader_pool.h"

#include <chrono>
#include <utility>

#include "core/error.h"
#include "storage/map/map_file.h"
#include "storage/map/map_queries.h"

namespace cairn {
namespace {

constexpr std::chrono::seconds kMaxWait{10};

}  // namespace

ReaderPool::ReaderPool(std::unique_ptr<sqlite::Connection> first, sqlite::Access access,
                       PinnedFile file)
    : path_(first->path()), file_(std::move(file)), access_(access) {
  idle_.push_back(std::move(first));
}

std::unique_ptr<sqlite::Connection> ReaderPool::TakeIdle() {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) {
    return nullptr;
  }
  std::unique_ptr<sqlite::Connection> connection = std::move(idle_.back());
  idle_.pop_back();
  return connection;
}

std::unique_ptr<sqlite::Connection> ReaderPool::Take() {
  if (auto idle = TakeIdle()) {
    return idle;
  }
  if (IsInPlace()) {
    auto connection = ReopenMapFile(path_, access_);
    if (IsInPlace()) {  // Nothing has been read through this connection yet.
      return connection;
    }
  }
  return WaitForIdle();
}

std::unique_ptr<sqlite::Connection> ReaderPool::WaitForIdle() {
  std::unique_lock lock(mutex_);
  if (!given_back_.wait_for(lock, kMaxWait, [this] { return !idle_.empty(); })) {
    throw Error(ErrorCode::kUnavailable,
                path_ + ": the file was replaced, and all its open connections are in use");
  }
  std::unique_ptr<sqlite::Connection> connection = std::move(idle_.back());
  idle_.pop_back();
  return connection;
}

void ReaderPool::GiveBack(std::unique_ptr<sqlite::Connection> connection) {
  {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(connection));
  }
  given_back_.notify_one();
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
