// SQL functions and virtual tables that show a map to people.
//
//   ST_IsEmpty, ST_MinX, ST_MaxX, ST_MinY, ST_MaxY (geometry)
//       The functions that the R*Tree triggers of a GeoPackage call.
//   cairn_tile_name(tile_id)            "32N-03104-35120"
//   cairn_tile_id(name)                 The inverse of cairn_tile_name.
//   cairn_tile_at(lat_deg, lon_deg)     Id of the tile that contains a position.
//   cairn_tile_lat(tile_id), cairn_tile_lon(tile_id)   The center, degrees.
//   cairn_distance_m(lat1_deg, lon1_deg, lat2_deg, lon2_deg)   Distance on the ground.
//   cairn_landmarks, cairn_landmarks(tile_id)   Decoded landmarks; see landmark_table.cc.
#ifndef CAIRN_STORAGE_INSPECTION_REGISTER_H_
#define CAIRN_STORAGE_INSPECTION_REGISTER_H_

struct sqlite3;

namespace cairn::inspection {

// Each function returns an SQLite result code.
int RegisterGeometryFunctions(sqlite3* db);
int RegisterTileFunctions(sqlite3* db);
int RegisterLandmarkTable(sqlite3* db);

// Registers all of the above.
int RegisterInspection(sqlite3* db);

}  // namespace cairn::inspection

#endif  // CAIRN_STORAGE_INSPECTION_REGISTER_H_
