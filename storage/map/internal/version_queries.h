// Reads and writes the versions of a map; private to storage. The rules of map_queries.h hold.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_VERSION_QUERIES_H_
#define CAIRN_STORAGE_MAP_INTERNAL_VERSION_QUERIES_H_

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "storage/database/connection.h"
#include "storage/map/map_store.h"
#include "storage/map/map_versions.h"

namespace cairn::queries {

// The SQL of the frequent queries, for the tests of EXPLAIN QUERY PLAN.
std::string_view LatestVersionSql();
std::string_view LatestVersionsSql();
std::string_view ChangedTilesSql();
std::string_view PastTilesWithIdsSql();
std::string_view PastTilesOfPageSql();

MapVersion LatestVersion(db::Connection* connection);
// Returns the newest `limit` versions up to `as_of`, newest first.
std::vector<VersionRecord> Versions(db::Connection* connection, int64_t limit, MapVersion as_of);
VersionRecord LatestRecord(db::Connection* connection);
// Throws as RequireVersion.
VersionRecord FindVersion(db::Connection* connection, MapVersion version);
bool HasVersion(db::Connection* connection, MapVersion version);

// Returns the codebook for new sessions as of a version, or 0 if the version has none.
CodebookId CodebookOfVersion(db::Connection* connection, MapVersion version);

// Throws Error(kNotFound), which names the versions of the map, if `version` is not among them.
void RequireVersion(db::Connection* connection, MapVersion version);

// Returns the tiles whose payloads differ, ordered by id. Throws as RequireVersion.
std::vector<TileChange> Diff(db::Connection* connection, MapVersion from, MapVersion to);

// A tile of the past, and the versions [since, until) that had it.
struct PastTile {
  TileRecord tile;
  MapVersion since{};
  MapVersion until{};
};

// These return the rows of the past that `version` had, ordered by id. They read only rows that
// later versions removed. `ids` are in ascending order; ids of a page are above `after` and at most
// `last`.
std::vector<TileRecord> PastTiles(db::Connection* connection, MapVersion version);
std::vector<TileRecord> PastTilesWithIds(db::Connection* connection, MapVersion version,
                                         const std::vector<int64_t>& ids);
std::vector<TileRecord> PastTilesOfPage(db::Connection* connection, MapVersion version,
                                        int64_t after, int64_t last);
std::vector<SessionRecord> PastSessions(db::Connection* connection, MapVersion version);
std::vector<KeyframeRecord> PastKeyframes(db::Connection* connection, MapVersion version);
std::vector<KeyframeRecord> PastKeyframesOfTile(db::Connection* connection, MapVersion version,
                                                TileId tile_id);
std::vector<KeyframeRecord> PastKeyframesOfSession(db::Connection* connection, MapVersion version,
                                                   SessionId session_id);

// Sorts tiles by id and drops repeated ids.
void SortById(std::vector<TileRecord>* tiles);

// Returns all tiles of the past, ordered by id and version.
std::vector<PastTile> AllPastTiles(db::Connection* connection);
// Returns a keyframe as of a version, from the tables of the latest version or of the past.
std::optional<KeyframeRecord> FindKeyframeOf(db::Connection* connection, MapVersion version,
                                             KeyframeId keyframe_id);

// Returns the box around the squares of all tiles. Reads every tile id.
std::optional<GeoBox> BoundsOfTiles(db::Connection* connection);

// The author is the user of the process.
void InsertVersion(db::Connection* connection, MapVersion version, const VersionNote& note,
                   const MapTotals& totals);

}  // namespace cairn::queries

#endif  // CAIRN_STORAGE_MAP_INTERNAL_VERSION_QUERIES_H_
