#include "storage/database/postgres/result_row.h"

#include <bit>
#include <cstddef>

#include "core/error.h"

namespace cairn::postgres {

void ResultRow::Refuse(int column) const {
  const char* name = PQfname(result_, column);
  throw Error(ErrorCode::kMapDamaged, *database_ + ": column " + (name != nullptr ? name : "?") +
                                          " holds a value of the wrong type");
}

std::span<const uint8_t> ResultRow::View(int column, Oid type) const {
  if (PQftype(result_, column) != type || IsNull(column)) {
    Refuse(column);
  }
  return {reinterpret_cast<const uint8_t*>(PQgetvalue(result_, row_, column)),
          static_cast<size_t>(PQgetlength(result_, row_, column))};
}

uint64_t ResultRow::Number(int column, Oid type, size_t num_bytes) const {
  const std::span<const uint8_t> bytes = View(column, type);
  if (bytes.size() != num_bytes) {
    Refuse(column);
  }
  uint64_t value = 0;
  for (const uint8_t byte : bytes) {
    value = value << 8 | byte;
  }
  return value;
}

int64_t ResultRow::Int64(int column) const {
  switch (PQftype(result_, column)) {
    case kInt8:
      return static_cast<int64_t>(Number(column, kInt8, 8));
    case kInt4:
      return static_cast<int32_t>(Number(column, kInt4, 4));
    case kBool:
      return static_cast<int64_t>(Number(column, kBool, 1));
    default:
      Refuse(column);
  }
}

double ResultRow::Double(int column) const {
  return std::bit_cast<double>(Number(column, kFloat8, 8));
}

std::string ResultRow::Text(int column) const {
  const std::span<const uint8_t> text = View(column, kText);
  return {text.begin(), text.end()};
}

std::span<const uint8_t> ResultRow::Bytes(int column) const { return View(column, kBytea); }

bool ResultRow::IsNull(int column) const { return PQgetisnull(result_, row_, column) != 0; }

}  // namespace cairn::postgres
