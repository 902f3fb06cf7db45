#include <exception>
#include <string>
#include <string_view>

#include "core/geodesy.h"
#include "core/tile_id.h"
#include "storage/inspection/register.h"
#include "storage/inspection/sqlite_api.h"

namespace cairn::inspection {
namespace {

using Function = void (*)(sqlite3_context* context, sqlite3_value** values);

// Runs a function. A NULL argument gives NULL; an exception becomes an SQL error.
template <Function kFunction>
void Call(sqlite3_context* context, int num_values, sqlite3_value** values) {
  for (int i = 0; i < num_values; ++i) {
    if (sqlite3_value_type(values[i]) == SQLITE_NULL) {
      return;
    }
  }
  try {
    kFunction(context, values);
  } catch (const std::exception& error) {
    sqlite3_result_error(context, error.what(), -1);
  }
}

TileId TileOf(sqlite3_value* value) {
  return TileId::FromValue(static_cast<uint64_t>(sqlite3_value_int64(value)));
}

Geodetic PositionOf(sqlite3_value* lat_deg, sqlite3_value* lon_deg) {
  const Geodetic position =
      Geodetic::FromDegrees(sqlite3_value_double(lat_deg), sqlite3_value_double(lon_deg), 0.0);
  ValidateGeodetic(position, "position");
  return position;
}

void TileName(sqlite3_context* context, sqlite3_value** values) {
  const std::string name = TileOf(values[0]).ToString();
  sqlite3_result_text(context, name.data(), static_cast<int>(name.size()), SQLITE_TRANSIENT);
}

void TileIdOfName(sqlite3_context* context, sqlite3_value** values) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_value_text(values[0]));
  const std::string_view name(text, static_cast<size_t>(sqlite3_value_bytes(values[0])));
  sqlite3_result_int64(context, static_cast<sqlite3_int64>(TileId::Parse(name).value()));
}

void TileAt(sqlite3_context* context, sqlite3_value** values) {
  const TileId tile_id = TileId::Containing(PositionOf(values[0], values[1]));
  sqlite3_result_int64(context, static_cast<sqlite3_int64>(tile_id.value()));
}

void TileLat(sqlite3_context* context, sqlite3_value** values) {
  sqlite3_result_double(context, TileOf(values[0]).Anchor().lat_deg());
}

void TileLon(sqlite3_context* context, sqlite3_value** values) {
  sqlite3_result_double(context, TileOf(values[0]).Anchor().lon_deg());
}

void Distance(sqlite3_context* context, sqlite3_value** values) {
  sqlite3_result_double(
      context, GroundDistanceM(PositionOf(values[0], values[1]), PositionOf(values[2], values[3])));
}

struct Entry {
  const char* name;
  int num_values;
  void (*function)(sqlite3_context*, int, sqlite3_value**);
};

constexpr Entry kEntries[] = {
    {"cairn_tile_name", 1, &Call<&TileName>}, {"cairn_tile_id", 1, &Call<&TileIdOfName>},
    {"cairn_tile_at", 2, &Call<&TileAt>},     {"cairn_tile_lat", 1, &Call<&TileLat>},
    {"cairn_tile_lon", 1, &Call<&TileLon>},   {"cairn_distance_m", 4, &Call<&Distance>},
};

}  // namespace

int RegisterTileFunctions(sqlite3* db) {
  constexpr int kFlags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS;
  int result = SQLITE_OK;
  for (const Entry& entry : kEntries) {
    if (result == SQLITE_OK) {
      result = sqlite3_create_function_v2(db, entry.name, entry.num_values, kFlags, nullptr,
                                          entry.function, nullptr, nullptr, nullptr);
    }
  }
  return result;
}

int RegisterInspection(sqlite3* db) {
  for (const auto& register_part :
       {&RegisterGeometryFunctions, &RegisterTileFunctions, &RegisterLandmarkTable}) {
    if (const int result = register_part(db); result != SQLITE_OK) {
      return result;
    }
  }
  return SQLITE_OK;
}

}  // namespace cairn::inspection
