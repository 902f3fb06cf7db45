// A prepared statement with typed access to its columns.
#ifndef CAIRN_STORAGE_DATABASE_STATEMENT_H_
#define CAIRN_STORAGE_DATABASE_STATEMENT_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cairn::db {

// A geometry as a GeoPackage blob. Each database stores it in its own type of geometry.
struct Geometry {
  std::span<const uint8_t> bytes;
};

// The implementation of a statement by one database. Columns count from 0, parameters from 1.
// Reading a column as a wrong type throws Error(kMapDamaged).
class Cursor {
 public:
  virtual ~Cursor() = default;
  virtual void BindAt(int index, int64_t value) = 0;
  virtual void BindAt(int index, double value) = 0;
  virtual void BindAt(int index, std::string_view value) = 0;
  virtual void BindAt(int index, std::span<const uint8_t> value) = 0;  // Not copied.
  virtual void BindAt(int index, Geometry value) = 0;                  // Not copied.
  virtual void BindAt(int index, std::nullptr_t null) = 0;
  virtual bool Step() = 0;
  virtual int64_t Int64(int column) const = 0;
  virtual double Double(int column) const = 0;
  virtual double Number(int column) const = 0;  // An integer or a real.
  virtual std::string Text(int column) const = 0;
  virtual std::vector<uint8_t> Blob(int column) const = 0;
  virtual bool IsNull(int column) const = 0;
};

// Use a statement from the thread that uses its connection. The connection must outlive it.
class Statement {
 public:
  explicit Statement(std::unique_ptr<Cursor> cursor) : cursor_(std::move(cursor)) {}

  // Binds a value to one parameter.
  template <typename Bound>
  void BindAt(int index, const Bound& value) {
    cursor_->BindAt(index, value);
  }

  // Binds the values in order, from parameter 1. Blobs and geometries must stay valid until Step
  // returns. Bind each statement once.
  template <typename... Values>
  Statement& Bind(const Values&... values) {
    int index = 0;
    (BindAt(++index, values), ...);
    return *this;
  }

  // Moves to the next row. Returns false after the last row. Throws Error.
  bool Step() { return cursor_->Step(); }
  // Runs a statement and ignores its rows.
  void Run() { cursor_->Step(); }

  int64_t Int64(int column) const { return cursor_->Int64(column); }
  double Double(int column) const { return cursor_->Double(column); }
  double Number(int column) const { return cursor_->Number(column); }
  std::string Text(int column) const { return cursor_->Text(column); }
  std::vector<uint8_t> Blob(int column) const { return cursor_->Blob(column); }
  bool IsNull(int column) const { return cursor_->IsNull(column); }

 private:
  std::unique_ptr<Cursor> cursor_;
};

}  // namespace cairn::db

#endif  // CAIRN_STORAGE_DATABASE_STATEMENT_H_
