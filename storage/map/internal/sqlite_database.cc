#include "storage/map/internal/sqlite_database.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "storage/database/sqlite/blob.h"

namespace cairn {
namespace {

class SqliteCursor : public db::Cursor {
 public:
  explicit SqliteCursor(sqlite::Statement statement) : statement_(std::move(statement)) {}

  void BindAt(int index, int64_t value) override { statement_.BindAt(index, value); }
  void BindAt(int index, double value) override { statement_.BindAt(index, value); }
  void BindAt(int index, std::string_view value) override { statement_.BindAt(index, value); }
  void BindAt(int index, std::span<const uint8_t> value) override {
    statement_.BindAt(index, value);
  }
  void BindAt(int index, db::Geometry value) override { statement_.BindAt(index, value.bytes); }
  void BindAt(int /*index*/, std::nullptr_t /*null*/) override {
  }  // Parameters are NULL until they are bound.
  bool Step() override { return statement_.Step(); }
  int64_t Int64(int column) const override { return statement_.Int64(column); }
  double Double(int column) const override { return statement_.Double(column); }
  double Number(int column) const override { return statement_.Number(column); }
  std::string Text(int column) const override { return statement_.Text(column); }
  std::vector<uint8_t> Blob(int column) const override { return statement_.Blob(column); }
  bool IsNull(int column) const override { return statement_.IsNull(column); }

 private:
  sqlite::Statement statement_;
};

}  // namespace

uint64_t SqliteDatabase::BytesOnDisk() {
  std::error_code ignored;
  return std::filesystem::file_size(connection_->path(), ignored);
}

db::Statement SqliteDatabase::Prepare(std::string_view sql) {
  return db::Statement(std::make_unique<SqliteCursor>(connection_->Prepare(sql)));
}

std::optional<LargeVector<uint8_t>> SqliteDatabase::ReadBytes(const char* table,
                                                              const char* /*key_column*/,
                                                              int64_t key) {
  return sqlite::ReadBlob(connection_.get(), table, "bytes", key);
}

}  // namespace cairn
