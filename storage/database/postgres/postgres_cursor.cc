#include "storage/database/postgres/postgres_cursor.h"

#include <bit>
#include <cstddef>
#include <utility>

namespace cairn::postgres {
namespace {

std::string BigEndian(uint64_t value) {
  std::string bytes;
  for (int shift = 56; shift >= 0; shift -= 8) {
    bytes += static_cast<char>(value >> shift);
  }
  return bytes;
}

// The WKB in a GeoPackage blob, behind the header and its envelope (OGC 12-128r17, clause 2.1.3).
std::span<const uint8_t> WkbOf(std::span<const uint8_t> blob) {
  constexpr size_t kHeaderBytes = 8;
  constexpr size_t kEnvelopeBytes[] = {0, 32, 48, 48, 64, 0, 0, 0};
  const size_t begin = kHeaderBytes + kEnvelopeBytes[blob[3] >> 1 & 7];
  return blob.subspan(begin);
}

}  // namespace

Parameter& PostgresCursor::At(int index) {
  if (parameters_.size() < static_cast<size_t>(index)) {
    parameters_.resize(index);
  }
  return parameters_[index - 1];
}

void PostgresCursor::Keep(int index, Oid type, std::string bytes) {
  kept_.push_back(std::move(bytes));
  At(index) = {type, kept_.back().data(), static_cast<int>(kept_.back().size())};
}

void PostgresCursor::BindAt(int index, int64_t value) {
  Keep(index, kInt8, BigEndian(static_cast<uint64_t>(value)));
}

void PostgresCursor::BindAt(int index, double value) {
  Keep(index, kFloat8, BigEndian(std::bit_cast<uint64_t>(value)));
}

void PostgresCursor::BindAt(int index, std::string_view value) {
  Keep(index, kText, std::string(value));
}

void PostgresCursor::BindAt(int index, std::span<const uint8_t> value) {
  // An empty vector has no data, but is not NULL.
  At(index) = {kBytea, value.empty() ? "" : reinterpret_cast<const char*>(value.data()),
               static_cast<int>(value.size())};
}

// PostGIS converts WKB in a bytea to a geometry.
void PostgresCursor::BindAt(int index, db::Geometry value) { BindAt(index, WkbOf(value.bytes)); }

void PostgresCursor::BindAt(int index, std::nullptr_t /*null*/) { At(index) = {}; }

bool PostgresCursor::Step() {
  if (rows_ == nullptr) {
    rows_ = connection_->Run(sql_, parameters_);
  }
  return ++row_ < PQntuples(rows_.get());
}

std::vector<uint8_t> PostgresCursor::Blob(int column) const {
  const std::span<const uint8_t> bytes = Row().Bytes(column);
  return {bytes.begin(), bytes.end()};
}

}  // namespace cairn::postgres
