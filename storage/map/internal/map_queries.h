// Reads the tables of a map's latest version for snapshots, updates and checks. Private to storage.
// Functions with `as_of` leave out rows that are newer than this version. version_queries.h reads
// the rows that later versions removed. All functions throw Error(kMapDamaged) for values that
// Cairn never writes.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_MAP_QUERIES_H_
#define CAIRN_STORAGE_MAP_INTERNAL_MAP_QUERIES_H_

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "storage/database/connection.h"
#include "storage/map/map_store.h"

namespace cairn::queries {

// Later than all versions. As of kNewest, an update also sees its own rows.
inline constexpr MapVersion kNewest{std::numeric_limits<int64_t>::max()};

// The SQL of the frequent queries, for the tests of EXPLAIN QUERY PLAN.
std::string_view FindTilesSql();
std::string_view FindTileSql();
std::string_view TilesWithIdsSql();
std::string_view TilesOfSessionSql();
std::string_view KeyframesOfSessionSql();
std::string_view KeyframesOfTileSql();

// The totals of one version. Throws as RequireVersion.
MapInfo Info(db::Connection* connection, MapVersion version);

// Returns the tiles whose bounding boxes meet `box`, ordered by id.
std::vector<TileRecord> FindTiles(db::Connection* connection, const GeoBox& box, MapVersion as_of);
// Returns the first `limit` tiles by id.
std::vector<TileRecord> AllTiles(db::Connection* connection, int64_t limit, MapVersion as_of);

// The ids as a parameter of a query: the JSON or the array of which the SQL makes a table.
std::string IdList(const db::Connection& connection, const std::vector<int64_t>& ids);

struct TilesAndLatest {
  std::vector<TileRecord> tiles;
  MapVersion latest{};  // The latest version when the tiles were read, or later.
};
// Returns the tiles with these ids, in any order. Takes one round trip to a server.
TilesAndLatest TilesWithIds(db::Connection* connection, const std::vector<int64_t>& ids,
                            MapVersion as_of);
// Returns the ids as stored; in a damaged map they need not be valid tile ids.
std::vector<int64_t> AllTileIds(db::Connection* connection);
std::optional<TileRecord> FindTile(db::Connection* connection, TileId tile_id,
                                   MapVersion as_of = kNewest);
// Throws Error(kMapDamaged) if there is no such payload.
LargeVector<uint8_t> LoadPayload(db::Connection* connection, PayloadId payload_id);

// All landmarks of all versions have smaller ids.
LandmarkId NextLandmarkId(db::Connection* connection);

// Returns the id of the codebook for new sessions, or 0 if the map has none.
CodebookId CurrentCodebookId(db::Connection* connection);
std::shared_ptr<const Codebook> LoadCodebook(db::Connection* connection, CodebookId codebook_id);

std::vector<CodebookId> CodebookIds(db::Connection* connection);
// Throws Error(kMapDamaged) if there is no such codebook.
std::string CodebookDigest(db::Connection* connection, CodebookId codebook_id);
// Returns 0 if there is no codebook of this digest.
CodebookId FindCodebook(db::Connection* connection, const std::string& digest);

std::vector<SessionRecord> Sessions(db::Connection* connection, MapVersion as_of = kNewest);
std::optional<SessionRecord> FindSession(db::Connection* connection, const std::string& name,
                                         MapVersion as_of = kNewest);
std::vector<TileId> TilesOfSession(db::Connection* connection, SessionId session_id);
std::vector<KeyframeId> KeyframeIdsOfSession(db::Connection* connection, SessionId session_id);
std::optional<KeyframeRecord> FindKeyframe(db::Connection* connection, KeyframeId keyframe_id);
std::vector<KeyframeRecord> KeyframesOfSession(db::Connection* connection, SessionId session_id,
                                               MapVersion as_of = kNewest);
std::vector<KeyframeRecord> KeyframesOfTile(db::Connection* connection, TileId tile_id,
                                            MapVersion as_of = kNewest);

}  // namespace cairn::queries

#endif  // CAIRN_STORAGE_MAP_INTERNAL_MAP_QUERIES_H_
