// One connection to an SQLite database file.
#ifndef CAIRN_STORAGE_SQLITE_CONNECTION_H_
#define CAIRN_STORAGE_SQLITE_CONNECTION_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "storage/sqlite/statement.h"

struct sqlite3;
struct sqlite3_stmt;

namespace cairn::sqlite {

enum class Access {
  kCreate,  // Makes the file if it is not there.
  kReadWrite,
  kReadOnly,
  kImmutable,  // Read-only, without locks or a write-ahead log: nobody may change the file.
};

// Foreign keys are enforced. Schemas are not trusted: triggers and views may use only what is
// marked as innocuous. One thread at a time.
class Connection {
 public:
  // `busy_timeout_ms` is how long a lock of another connection is waited for. Throws Error.
  Connection(const std::string& path, Access access, int busy_timeout_ms);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  sqlite3* handle() const { return handle_; }
  const std::string& path() const { return path_; }

  // Lets triggers and views use R*Trees, which SQLite 3.40 does not mark as innocuous.
  void TrustSchema();

  // Runs statements whose rows, if any, do not matter.
  void Execute(const std::string& script);

  // A statement of our own making; SQL that does not compile means that the schema is not what we
  // made: Error(kMapDamaged). Compiled once a connection.
  Statement Prepare(std::string_view sql);

  int64_t LastInsertId() const;
  // Rows that the last INSERT, UPDATE or DELETE changed.
  int64_t NumChanges() const;

 private:
  friend class Statement;
  // Resets the statement and keeps it for the next Prepare of the same text.
  void GiveBack(sqlite3_stmt* statement) noexcept;
  void Close() noexcept;

  std::string path_;
  sqlite3* handle_ = nullptr;
  std::unordered_map<std::string, sqlite3_stmt*> idle_statements_;
};

}  // namespace cairn::sqlite

#endif  // CAIRN_STORAGE_SQLITE_CONNECTION_H_
