// Reads the tables of a map for snapshots, updates and checks. Private to storage. Every function
// runs in the transaction that is open on the connection, and throws Error(kMapDamaged) for values
// that Cairn never writes.
#ifndef CAIRN_STORAGE_MAP_MAP_QUERIES_H_
#define CAIRN_STORAGE_MAP_MAP_QUERIES_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "storage/map/map_store.h"
#include "storage/sqlite/connection.h"

namespace cairn::queries {

// The SQL of the frequent queries, for the tests of EXPLAIN QUERY PLAN.
std::string_view FindTilesSql();
std::string_view FindTileSql();
std::string_view TilesOfSessionSql();
std::string_view KeyframesOfSessionSql();
std::string_view KeyframesOfTileSql();

MapInfo Info(sqlite::Connection* connection);

std::vector<TileRecord> FindTiles(sqlite::Connection* connection, const GeoBox& box);
std::vector<TileRecord> AllTiles(sqlite::Connection* connection, int64_t limit);
// Returns the ids as stored; in a damaged map they need not be valid tile ids.
std::vector<int64_t> AllTileIds(sqlite::Connection* connection);
std::optional<TileRecord> FindTile(sqlite::Connection* connection, TileId tile_id);
LargeVector<uint8_t> LoadPayload(sqlite::Connection* connection, PayloadId payload_id);

// Returns the id of the codebook for new sessions, or 0 if the map has none.
CodebookId CurrentCodebookId(sqlite::Connection* connection);
std::shared_ptr<const Codebook> LoadCodebook(sqlite::Connection* connection,
                                             CodebookId codebook_id);

std::vector<CodebookId> CodebookIds(sqlite::Connection* connection);
// Throws Error(kMapDamaged) if there is no such codebook.
std::string CodebookDigest(sqlite::Connection* connection, CodebookId codebook_id);

std::vector<SessionRecord> Sessions(sqlite::Connection* connection);
std::optional<SessionRecord> FindSession(sqlite::Connection* connection, const std::string& name);
std::vector<TileId> TilesOfSession(sqlite::Connection* connection, SessionId session_id);
std::vector<KeyframeId> KeyframeIdsOfSession(sqlite::Connection* connection, SessionId session_id);
std::optional<KeyframeRecord> FindKeyframe(sqlite::Connection* connection, KeyframeId keyframe_id);
std::vector<KeyframeRecord> KeyframesOfSession(sqlite::Connection* connection,
                                               SessionId session_id);
std::vector<KeyframeRecord> KeyframesOfTile(sqlite::Connection* connection, TileId tile_id);

}  // namespace cairn::queries

#endif  // CAIRN_STORAGE_MAP_MAP_QUERIES_H_
