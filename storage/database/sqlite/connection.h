// A connection to an SQLite database file.
#ifndef CAIRN_STORAGE_DATABASE_SQLITE_CONNECTION_H_
#define CAIRN_STORAGE_DATABASE_SQLITE_CONNECTION_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "storage/database/sqlite/statement.h"

struct sqlite3;
struct sqlite3_stmt;

namespace cairn::sqlite {

enum class Access {
  kCreate,  // Creates the file if it does not exist.
  kReadWrite,
  kReadOnly,
  // Read-only, without locks and without a write-ahead log; nobody may change the file.
  kImmutable,
  kMemory,  // A new, empty database in memory; the path is only a name for messages.
};

// Foreign keys are enforced. Schemas are not trusted: triggers and views may use only functions and
// tables that SQLite marks as innocuous, and pages are checked as they are read.
//
// The work of a statement is limited in proportion to the file size. A statement exceeds the limit
// if damaged pages form a cycle or a view never ends; it then fails with Error(kMapDamaged).
//
// Use each connection from one thread at a time.
class Connection {
 public:
  // `busy_timeout_ms` is how long to wait for another connection's lock. Throws Error.
  Connection(const std::string& path, Access access, int busy_timeout_ms);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  sqlite3* handle() const { return handle_; }
  const std::string& path() const { return path_; }

  // Lets triggers and views use R*Trees, which SQLite 3.40 does not mark as innocuous.
  void TrustSchema();

  // Removes the work limit. For statements that people write, which have a time limit instead.
  void LiftWorkLimit();

  // Returns the current size of the file and its write-ahead log, bytes.
  uint64_t FileBytes() const;

  // Runs statements and ignores their rows.
  void Execute(const std::string& script);

  // Prepares one of Cairn's own statements. If the SQL does not compile, the file does not have the
  // schema of a map: throws Error(kMapDamaged). Each connection compiles a statement once.
  Statement Prepare(std::string_view sql);

  int64_t LastInsertId() const;
  // Returns the number of rows that the last INSERT, UPDATE or DELETE changed.
  int64_t NumChanges() const;

 private:
  friend class Statement;
  // SQLite calls OnProgress every kStepsACall steps of a statement. A result other than 0 ends the
  // statement.
  static int OnProgress(void* connection);
  bool MayGoOn();
  void ResetSteps();
  // Resets the statement and keeps it for the next Prepare of the same text.
  void GiveBack(sqlite3_stmt* statement) noexcept;
  void Close() noexcept;

  std::string path_;
  sqlite3* handle_ = nullptr;
  std::unordered_map<std::string, sqlite3_stmt*> idle_statements_;
  int num_statements_ = 0;  // Number of borrowed statements.
  // Steps since no statement was borrowed: those of a statement and of the statements in its loops.
  int64_t num_steps_ = 0;
  int64_t max_steps_ = 0;
};

}  // namespace cairn::sqlite

#endif  // CAIRN_STORAGE_DATABASE_SQLITE_CONNECTION_H_
