#include "ingest/place/position_table.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/printable.h"

namespace cairn {
namespace {

constexpr uint64_t kMaxTableBytes = uint64_t{256} << 20;

// Runs `read` and prefixes the path to the message of an error.
template <typename Read>
auto WithTablePath(const std::string& path, const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", path, error.what()));
  }
}

}  // namespace

PositionTable::PositionTable(const std::string& path, std::initializer_list<const char*> required)
    : path_(path),
      text_(ReadTextFile(path, kMaxTableBytes)),
      rows_(WithTablePath(path, [&] { return CsvReader(text_); })) {
  if (!NextRow()) {
    Throw("the header is missing");
  }
  for (size_t i = 0; i < rows_.cells().size(); ++i) {
    column_of_name_.emplace(rows_.cells()[i], i);
  }
  for (const char* name : required) {
    if (!Has(name)) {
      Throw(fmt::format("the header has no column '{}'; expected {} and optionally accuracy_m",
                        name, fmt::join(required, ", ")));
    }
  }
  num_columns_ = rows_.cells().size();
}

bool PositionTable::NextRow() {
  if (!WithTablePath(path_, [&] { return rows_.Next(); })) {
    return false;
  }
  if (num_columns_ != 0 && rows_.cells().size() != num_columns_) {
    Throw(fmt::format("{} columns, but the header has {}; put a name with a '{}' in quotes",
                      rows_.cells().size(), num_columns_, rows_.separator()));
  }
  return true;
}

double PositionTable::Number(const char* name) const {
  const std::optional<double> value = rows_.Number(ColumnOf(name));
  if (!value || !std::isfinite(*value)) {
    Throw(fmt::format("column {}: '{}' is not a number", name, Excerpt(Text(name))));
  }
  return *value;
}

Geodetic PositionTable::Position(const std::string& what) const {
  const Geodetic position =
      Geodetic::FromDegrees(Number("lat_deg"), Number("lon_deg"), Number("h_m"));
  try {
    ValidateGeodetic(position, Excerpt(what).c_str());
  } catch (const Error& e) {
    Throw(e.what());
  }
  return position;
}

double PositionTable::AccuracyOr(double default_m) const {
  const double accuracy_m = Has("accuracy_m") ? Number("accuracy_m") : default_m;
  if (!(accuracy_m > 0.0)) {
    Throw("column accuracy_m: must be positive");
  }
  return accuracy_m;
}

void PositionTable::Throw(const std::string& what) const {
  throw Error(ErrorCode::kBadInput, fmt::format("{}: line {}: {}", path_, rows_.line(), what));
}

}  // namespace cairn
