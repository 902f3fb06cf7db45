// A statement of PostgreSQL with its parameters and rows.
#ifndef CAIRN_STORAGE_DATABASE_POSTGRES_POSTGRES_CURSOR_H_
#define CAIRN_STORAGE_DATABASE_POSTGRES_POSTGRES_CURSOR_H_

#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "storage/database/postgres/postgres_connection.h"
#include "storage/database/postgres/result_row.h"
#include "storage/database/statement.h"

namespace cairn::postgres {

// Runs at the first Step. Values are read as ResultRow reads them.
class PostgresCursor : public db::Cursor {
 public:
  PostgresCursor(PostgresConnection* connection, std::string sql)
      : connection_(connection), sql_(std::move(sql)), rows_(nullptr, &PQclear) {}

  void BindAt(int index, int64_t value) override;
  void BindAt(int index, double value) override;
  void BindAt(int index, std::string_view value) override;
  void BindAt(int index, std::span<const uint8_t> value) override;
  void BindAt(int index, db::Geometry value) override;
  void BindAt(int index, std::nullptr_t null) override;
  bool Step() override;
  int64_t Int64(int column) const override { return Row().Int64(column); }
  double Double(int column) const override { return Row().Double(column); }
  double Number(int column) const override { return Row().Double(column); }
  std::string Text(int column) const override { return Row().Text(column); }
  std::vector<uint8_t> Blob(int column) const override;
  bool IsNull(int column) const override { return Row().IsNull(column); }

  // The bytes of a bytea column of the current row, valid until the next step.
  std::span<const uint8_t> BytesView(int column) const { return Row().Bytes(column); }

 private:
  Parameter& At(int index);
  // Sets a parameter to `bytes`, which the cursor keeps.
  void Keep(int index, Oid type, std::string bytes);
  ResultRow Row() const { return {rows_.get(), row_, &connection_->name()}; }

  PostgresConnection* connection_;
  std::string sql_;
  std::vector<Parameter> parameters_;
  std::deque<std::string> kept_;
  Result rows_;
  int row_ = -1;
};

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_DATABASE_POSTGRES_POSTGRES_CURSOR_H_
