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
  kMemory,     // A new, empty database in memory; the path is a name for messages.
};

// Foreign keys are enforced. Schemas are not trusted: triggers and views may use only what is
// marked as innocuous, and pages are checked as they are read.
//
// No file makes a statement run for ever. A statement of ours does work in proportion to the size
// of the file; one that does far more, because the pages of a file refer to each other in circles
// or a view never ends, is broken off with Error(kMapDamaged). One thread at a time.
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

  // From now on statements may do as much work as they like. For the statements of people, who have
  // a time limit instead.
  void LiftWorkLimit();

  // Size of the file and its write-ahead log now, bytes.
  uint64_t FileBytes() const;

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
  // SQLite calls it every so many steps of a statement; anything but 0 ends the statement.
  static int OnProgress(void* connection);
  bool MayGoOn();
  void ResetSteps();
  // Resets the statement and keeps it for the next Prepare of the same text.
  void GiveBack(sqlite3_stmt* statement) noexcept;
  void Close() noexcept;

  std::string path_;
  sqlite3* handle_ = nullptr;
  std::unordered_map<std::string, sqlite3_stmt*> idle_statements_;
  int num_statements_ = 0;  // Borrowed.
  int64_t num_steps_ = 0;   // Since none was borrowed: of a statement and those in its loops.
  int64_t max_steps_ = 0;
};

}  // namespace cairn::sqlite

#endif  // CAIRN_STORAGE_SQLITE_CONNECTION_H_
