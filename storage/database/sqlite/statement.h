// A prepared statement with typed, checked access to its columns.
#ifndef CAIRN_STORAGE_DATABASE_SQLITE_STATEMENT_H_
#define CAIRN_STORAGE_DATABASE_SQLITE_STATEMENT_H_

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct sqlite3_stmt;

namespace cairn::sqlite {

class Connection;

// Borrowed from a connection's cache; the destructor resets and returns the statement. A statement
// must not outlive its connection, and is used by the thread that uses the connection.
class Statement {
 public:
  Statement(Statement&& other) noexcept;
  Statement& operator=(Statement&&) = delete;
  ~Statement();

  // Binds the values in order, from parameter 1. Blobs are not copied: they must stay valid until
  // Step returns.
  template <typename... Values>
  Statement& Bind(const Values&... values) {
    int index = 0;
    (BindAt(++index, values), ...);
    return *this;
  }

  // Binds one value, to a parameter that counts from 1.
  void BindAt(int index, int64_t value);
  void BindAt(int index, double value);
  void BindAt(int index, std::string_view value);
  void BindAt(int index, std::span<const uint8_t> value);

  // Moves to the next row. Returns false after the last. Throws Error.
  bool Step();

  // Runs a statement that returns no rows, then resets it so that it can be bound and run again.
  void Run();

  // Return a column of the current row; columns count from 0. The tables are STRICT, so a value of
  // another type is damage. Throw Error(kMapDamaged).
  int64_t Int64(int column) const;
  double Double(int column) const;
  // Accepts an integer or a real, for tables that are not Cairn's.
  double Number(int column) const;
  std::string Text(int column) const;
  std::vector<uint8_t> Blob(int column) const;
  bool IsNull(int column) const;

 private:
  friend class Connection;
  Statement(Connection* connection, sqlite3_stmt* handle);
  void CheckType(int column, int type) const;
  void CheckBound(int result) const;

  Connection* connection_;
  sqlite3_stmt* handle_;
};

}  // namespace cairn::sqlite

#endif  // CAIRN_STORAGE_DATABASE_SQLITE_STATEMENT_H_
