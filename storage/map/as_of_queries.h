// Reads a version whatever has become of the latest one; private to storage.
#ifndef CAIRN_STORAGE_MAP_AS_OF_QUERIES_H_
#define CAIRN_STORAGE_MAP_AS_OF_QUERIES_H_

#include <optional>
#include <string>
#include <vector>

#include "storage/database/connection.h"
#include "storage/map/map_store.h"
#include "storage/map/tile_cells.h"

namespace cairn::as_of {

// These read the tables of the latest version first. If `version` is no longer the latest, they add
// what later versions removed. An update can be published between the two: a row that it removes
// was then read already, or is in the past by now, or both, so no transaction is needed.
//
// All throw Error(kUnavailable) if the version was pruned meanwhile, else what the functions of
// the same name in map_queries.h throw.
void RequireKept(db::Connection* connection, MapVersion version);
MapInfo Info(db::Connection* connection, MapVersion version);
std::vector<TileRecord> FindTiles(db::Connection* connection, const GeoBox& box,
                                  MapVersion version);
std::vector<TileRecord> AllTiles(db::Connection* connection, int64_t limit, MapVersion version);
std::optional<TileRecord> FindTile(db::Connection* connection, TileId tile_id, MapVersion version);
// The tiles of each cell.
std::vector<std::vector<TileRecord>> TilesOfCells(db::Connection* connection,
                                                  const std::vector<TileCell>& cells,
                                                  MapVersion version);
LargeVector<uint8_t> LoadPayload(db::Connection* connection, PayloadId payload_id,
                                 MapVersion version);
CodebookId CurrentCodebookId(db::Connection* connection, MapVersion version);
std::vector<SessionRecord> Sessions(db::Connection* connection, MapVersion version);
std::optional<SessionRecord> FindSession(db::Connection* connection, const std::string& name,
                                         MapVersion version);
std::vector<KeyframeRecord> KeyframesOfSession(db::Connection* connection, SessionId session_id,
                                               MapVersion version);
std::vector<KeyframeRecord> KeyframesOfTile(db::Connection* connection, TileId tile_id,
                                            MapVersion version);

}  // namespace cairn::as_of

#endif  // CAIRN_STORAGE_MAP_AS_OF_QUERIES_H_
