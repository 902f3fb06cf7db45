#include "storage/map/internal/reader_pool.h"

#include <chrono>
#include <utility>

#include "core/error.h"
#include "storage/map/internal/map_file.h"
#include "storage/map/internal/sqlite_database.h"

namespace cairn {
namespace {

constexpr std::chrono::seconds kMaxWait{10};

}  // namespace

ReaderPool::ReaderPool(std::unique_ptr<sqlite::Connection> first, sqlite::Access access,
                       PinnedFile file)
    : path_(first->path()), file_(std::move(file)), access_(access) {
  idle_.push_back(std::make_unique<SqliteDatabase>(std::move(first)));
}

std::unique_ptr<db::Connection> ReaderPool::TakeIdle() {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) {
    return nullptr;
  }
  std::unique_ptr<db::Connection> connection = std::move(idle_.back());
  idle_.pop_back();
  return connection;
}

std::unique_ptr<db::Connection> ReaderPool::Take() {
  if (auto idle = TakeIdle()) {
    return idle;
  }
  if (IsInPlace()) {
    auto connection = std::make_unique<SqliteDatabase>(ReopenMapFile(path_, access_));
    if (IsInPlace()) {  // Nothing has been read through this connection yet.
      return connection;
    }
  }
  return WaitForIdle();
}

std::unique_ptr<db::Connection> ReaderPool::WaitForIdle() {
  std::unique_lock lock(mutex_);
  if (!given_back_.wait_for(lock, kMaxWait, [this] { return !idle_.empty(); })) {
    throw Error(ErrorCode::kUnavailable,
                path_ + ": the file was replaced, and all its open connections are in use");
  }
  std::unique_ptr<db::Connection> connection = std::move(idle_.back());
  idle_.pop_back();
  return connection;
}

void ReaderPool::GiveBack(std::unique_ptr<db::Connection> connection) {
  {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(connection));
  }
  given_back_.notify_one();
}

}  // namespace cairn
