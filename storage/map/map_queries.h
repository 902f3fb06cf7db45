// What snapshots, updates and checks read from a map's tables; private to storage. Every function
// works in the transaction that is open on the connection, and throws Error(kMapDamaged) for values
// that no writer of ours makes.
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

// The hot ones, for the EXPLAIN QUERY PLAN tests.
std::string_view CurrentVersionSql();
std::string_view FindTilesSql();
std::string_view FindTileSql();
std::string_view TilesOfSessionSql();
std::string_view KeyframesOfSessionSql();

MapVersion CurrentVersion(sqlite::Connection* connection);
MapInfo Info(sqlite::Connection* connection);

std::vector<TileRecord> FindTiles(sqlite::Connection* connection, const GeoBox& box);
std::vector<TileRecord> AllTiles(sqlite::Connection* connection, int64_t limit);
// As they are in the file, which need not be those of tiles.
std::vector<int64_t> AllTileIds(sqlite::Connection* connection);
std::optional<TileRecord> FindTile(sqlite::Connection* connection, TileId tile_id);
LargeVector<uint8_t> LoadPayload(sqlite::Connection* connection, PayloadId payload_id);

// The id of the latest codebook, 0 if there is none.
CodebookId CurrentCodebookId(sqlite::Connection* connection);
std::shared_ptr<const Codebook> LoadCodebook(sqlite::Connection* connection,
                                             CodebookId codebook_id);

std::vector<CodebookId> CodebookIds(sqlite::Connection* connection);

std::vector<SessionRecord> Sessions(sqlite::Connection* connection);
std::optional<SessionRecord> FindSession(sqlite::Connection* connection, const std::string& name);
std::vector<TileId> TilesOfSession(sqlite::Connection* connection, SessionId session_id);
std::optional<KeyframeRecord> FindKeyframe(sqlite::Connection* connection, KeyframeId keyframe_id);
std::vector<KeyframeRecord> KeyframesOfSession(sqlite::Connection* connection,
                                               SessionId session_id);

}  // namespace cairn::queries

#endif  // CAIRN_STORAGE_MAP_MAP_QUERIES_H_
