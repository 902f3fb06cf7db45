#include <cstdint>
#include <optional>
#include <span>

#include "storage/inspection/geopackage.h"
#include "storage/inspection/register.h"
#include "storage/inspection/sqlite_api.h"

namespace cairn::inspection {
namespace {

using Bound = double GeometryEnvelope::*;

std::optional<GeometryEnvelope> EnvelopeOfValue(sqlite3_value* value) {
  if (sqlite3_value_type(value) != SQLITE_BLOB) {
    return std::nullopt;
  }
  const auto* bytes = static_cast<const uint8_t*>(sqlite3_value_blob(value));
  return EnvelopeOfGeometry({bytes, static_cast<size_t>(sqlite3_value_bytes(value))});
}

// Returns NULL if the value is not a geometry, as GDAL does.
void IsEmpty(sqlite3_context* context, int /*num_values*/, sqlite3_value** values) {
  if (const auto envelope = EnvelopeOfValue(values[0])) {
    sqlite3_result_int(context, envelope->is_empty ? 1 : 0);
  }
}

// Returns NULL also for an empty geometry. The function's user data selects the bound.
void BoundOf(sqlite3_context* context, int /*num_values*/, sqlite3_value** values) {
  const auto envelope = EnvelopeOfValue(values[0]);
  if (envelope && !envelope->is_empty) {
    const auto bound = *static_cast<const Bound*>(sqlite3_user_data(context));
    sqlite3_result_double(context, (*envelope).*bound);
  }
}

struct BoundFunction {
  const char* name;
  Bound bound;
};

constexpr BoundFunction kBoundFunctions[] = {
    {"ST_MinX", &GeometryEnvelope::min_x},
    {"ST_MaxX", &GeometryEnvelope::max_x},
    {"ST_MinY", &GeometryEnvelope::min_y},
    {"ST_MaxY", &GeometryEnvelope::max_y},
};

}  // namespace

int RegisterGeometryFunctions(sqlite3* db) {
  constexpr int kFlags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS;
  int result = sqlite3_create_function_v2(db, "ST_IsEmpty", 1, kFlags, nullptr, &IsEmpty, nullptr,
                                          nullptr, nullptr);
  for (const BoundFunction& function : kBoundFunctions) {
    if (result != SQLITE_OK) {
      break;
    }
    result = sqlite3_create_function_v2(db, function.name, 1, kFlags,
                                        const_cast<Bound*>(&function.bound), &BoundOf, nullptr,
                                        nullptr, nullptr);
  }
  return result;
}

}  // namespace cairn::inspection
