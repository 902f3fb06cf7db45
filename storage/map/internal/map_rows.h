// Converts rows of a map's tables to records; private to storage. Throws Error(kMapDamaged) on
// values that Cairn never writes.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_MAP_ROWS_H_
#define CAIRN_STORAGE_MAP_INTERNAL_MAP_ROWS_H_

#include <cstdint>
#include <vector>

#include "core/error.h"
#include "storage/database/connection.h"
#include "storage/map/map_store.h"

namespace cairn::rows {

// Calls `make`. If `make` rejects a value that was read from the map, throws Error(kMapDamaged).
template <typename Make>
auto MakeFromRow(const db::Connection& connection, const Make& make) {
  try {
    return make();
  } catch (const Error& error) {
    throw Error(ErrorCode::kMapDamaged, connection.name() + ": " + error.what());
  }
}

TileId ReadTileId(const db::Connection& connection, int64_t value);

// Columns: tile_id, payload_id, codebook_id, num_landmarks, num_descriptors, num_keyframes,
// num_bytes, min_h_m, max_h_m, landmarks_south_deg, _west_, _north_, _east_deg, digest.
TileRecord ReadTile(const db::Connection& connection, const db::Statement& row);
// All rows.
std::vector<TileRecord> ReadTiles(const db::Connection& connection, db::Statement* rows);

// Columns: session_id, name, source, created_at, recorded_at, content_digest, num_images,
// num_landmarks, georef_median_residual_m.
SessionRecord ReadSession(const db::Statement& row);

// Columns: keyframe_id, session_id, tile_id, image_name, model, width_px, height_px, params, qw,
// qx, qy, qz, tx_m, ty_m, tz_m.
KeyframeRecord ReadKeyframe(const db::Connection& connection, const db::Statement& row);

// Reads all rows of a statement whose parameters are bound.
std::vector<KeyframeRecord> ReadKeyframes(const db::Connection& connection, db::Statement* rows);

}  // namespace cairn::rows

#endif  // CAIRN_STORAGE_MAP_INTERNAL_MAP_ROWS_H_
