#include "storage/map/internal/sqlite_backend.h"

#include <sqlite3.h>

#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "storage/database/sqlite/transaction.h"
#include "storage/map/internal/map_file.h"
#include "storage/map/internal/map_schema.h"
#include "storage/map/internal/sqlite_database.h"

namespace cairn {
namespace {

sqlite::Access AccessFor(OpenMode mode) {
  switch (mode) {
    case OpenMode::kReadOnly:
    case OpenMode::kServing:
      return sqlite::Access::kReadOnly;
    case OpenMode::kReadWrite:
      return sqlite::Access::kReadWrite;
    case OpenMode::kImmutable:
      return sqlite::Access::kImmutable;
  }
  throw Error(ErrorCode::kInternal, "unknown OpenMode");
}

std::unique_ptr<ReaderPool> OpenReaders(const std::string& path, sqlite::Access access) {
  PinnedFile file(path);
  std::unique_ptr<sqlite::Connection> first = OpenMapFile(path, &access);
  if (!file.IsAt(path)) {
    throw Error(ErrorCode::kConflict, path + ": was replaced while it was being opened; try again");
  }
  return std::make_unique<ReaderPool>(std::move(first), access, std::move(file));
}

class SqliteWriteTransaction : public WriteTransaction {
 public:
  explicit SqliteWriteTransaction(const std::string& path) : database_(OpenMapFileForUpdate(path)) {
    try {
      transaction_.emplace(database_.connection(), sqlite::Transaction::Kind::kImmediate);
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kConflict) {
        throw Error(
            ErrorCode::kConflict,
            path + ": another update of this map is running; try again when it has finished");
      }
      throw;
    }
    // The schema is checked inside the transaction, so no unchecked trigger can run later.
    RequireMapSchema(database_.connection());
  }

  db::Connection* connection() override { return &database_; }

  void Commit() override {
    transaction_->Commit();
    transaction_.reset();
    // Moves the log's pages into the file, except those that a reader still needs; a later
    // publication moves these.
    sqlite3_wal_checkpoint_v2(database_.connection()->handle(), nullptr, SQLITE_CHECKPOINT_PASSIVE,
                              nullptr, nullptr);
  }

 private:
  SqliteDatabase database_;
  std::optional<sqlite::Transaction> transaction_;  // Empty once committed.
};

}  // namespace

SqliteBackend::SqliteBackend(const std::string& path, OpenMode mode)
    : mode_(mode), readers_(OpenReaders(path, AccessFor(mode))) {}

std::unique_ptr<WriteTransaction> SqliteBackend::BeginUpdate() {
  if (mode_ != OpenMode::kReadWrite) {
    throw Error(ErrorCode::kConflict, name() + ": was opened read-only");
  }
  return std::make_unique<SqliteWriteTransaction>(name());
}

MapFileState SqliteBackend::FileState() const {
  if (readers_->IsInPlace()) {
    return MapFileState::kInPlace;
  }
  std::error_code error;
  return std::filesystem::exists(name(), error) ? MapFileState::kReplaced : MapFileState::kMissing;
}

}  // namespace cairn
