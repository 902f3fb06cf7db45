// Reads the content of any version that the map keeps; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_AS_OF_QUERIES_H_
#define CAIRN_STORAGE_MAP_INTERNAL_AS_OF_QUERIES_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "storage/database/connection.h"
#include "storage/map/map_store.h"

namespace cairn::as_of {

// These functions first read the tables of the latest version. If `version` is no longer the
// latest, they then add the rows of the past that `version` had. They need no transaction: if an
// update is published between the two reads, the first read or the second has the rows that the
// update removes.
//
// All throw Error(kUnavailable) if the version was pruned meanwhile, and otherwise the errors of
// the functions of the same name in map_queries.h.
void RequireKept(db::Connection* connection, MapVersion version);
MapInfo Info(db::Connection* connection, MapVersion version);
std::vector<TileRecord> FindTiles(db::Connection* connection, const GeoBox& box,
                                  MapVersion version);
std::vector<TileRecord> AllTiles(db::Connection* connection, int64_t limit, MapVersion version);
TilePage FindTilePage(db::Connection* connection, const TilePageRequest& request,
                      MapVersion version);
std::optional<TileRecord> FindTile(db::Connection* connection, TileId tile_id, MapVersion version);
// `ids` are in ascending order; the tiles are in any order.
std::vector<TileRecord> TilesWithIds(db::Connection* connection, const std::vector<int64_t>& ids,
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

#endif  // CAIRN_STORAGE_MAP_INTERNAL_AS_OF_QUERIES_H_
