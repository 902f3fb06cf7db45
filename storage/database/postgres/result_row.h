// Decodes the values of one row of a result, as PostgreSQL sends them in binary.
#ifndef CAIRN_STORAGE_DATABASE_POSTGRES_RESULT_ROW_H_
#define CAIRN_STORAGE_DATABASE_POSTGRES_RESULT_ROW_H_

#include <libpq-fe.h>

#include <cstdint>
#include <span>
#include <string>

namespace cairn::postgres {

// Object ids of PostgreSQL's types, fixed for all time (pg_type.dat).
inline constexpr Oid kBool = 16, kBytea = 17, kInt8 = 20, kInt4 = 23, kText = 25, kFloat8 = 701;

// A view. The server is not trusted: a value that is NULL, of another type or of the wrong length
// throws Error(kMapDamaged) with the name of the database and the column.
class ResultRow {
 public:
  ResultRow(const PGresult* result, int row, const std::string* database)
      : result_(result), row_(row), database_(database) {}

  int64_t Int64(int column) const;  // int8, int4 or boolean.
  double Double(int column) const;
  std::string Text(int column) const;
  std::span<const uint8_t> Bytes(int column) const;  // Valid as long as the result.
  bool IsNull(int column) const;

 private:
  std::span<const uint8_t> View(int column, Oid type) const;
  // The value as a big-endian number.
  uint64_t Number(int column, Oid type, size_t num_bytes) const;
  [[noreturn]] void Refuse(int column) const;

  const PGresult* result_;
  int row_;
  const std::string* database_;
};

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_DATABASE_POSTGRES_RESULT_ROW_H_
