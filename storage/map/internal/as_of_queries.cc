#include "storage/map/internal/as_of_queries.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "core/error.h"
#include "storage/inspection/geo_box.h"
#include "storage/map/internal/map_queries.h"
#include "storage/map/internal/tile_pages.h"
#include "storage/map/internal/version_queries.h"

namespace cairn::as_of {
namespace {

TileId IdOf(const TileRecord& tile) { return tile.tile_id; }
SessionId IdOf(const SessionRecord& session) { return session.id; }
KeyframeId IdOf(const KeyframeRecord& keyframe) { return keyframe.id; }

int64_t ValueOf(TileId tile_id) { return static_cast<int64_t>(tile_id.value()); }

// Adds the rows of past(connection, version, args...) to `records`, which were read from the tables
// of the latest version when it was `latest` or before. Sorts by id and drops repeated rows.
template <typename Record, typename Past, typename... Args>
void AddPastBefore(MapVersion latest, db::Connection* connection, MapVersion version,
                   std::vector<Record>* records, const Past& past, const Args&... args) {
  if (latest == version) {
    return;
  }
  if (latest < version) {
    throw Error(ErrorCode::kUnavailable,
                fmt::format("{}: the server has lost version {}; try again", connection->name(),
                            Value(version)));
  }
  std::vector<Record> removed = past(connection, version, args...);
  std::move(removed.begin(), removed.end(), std::back_inserter(*records));
  RequireKept(connection, version);
  std::stable_sort(records->begin(), records->end(),
                   [](const Record& a, const Record& b) { return IdOf(a) < IdOf(b); });
  records->erase(std::unique(records->begin(), records->end(),
                             [](const Record& a, const Record& b) { return IdOf(a) == IdOf(b); }),
                 records->end());
}

template <typename Record, typename Past, typename... Args>
void AddPast(db::Connection* connection, MapVersion version, std::vector<Record>* records,
             const Past& past, const Args&... args) {
  AddPastBefore(queries::LatestVersion(connection), connection, version, records, past, args...);
}

void KeepThoseIn(const GeoBox& box, std::vector<TileRecord>* tiles) {
  std::erase_if(*tiles,
                [&](const TileRecord& tile) { return !BoxesMeet(tile.tile_id.Bounds(), box); });
}

template <typename Record>
std::optional<Record> FirstOf(std::vector<Record> records) {
  return records.empty() ? std::nullopt : std::optional<Record>(std::move(records.front()));
}

template <typename Record>
std::vector<Record> ListOf(std::optional<Record> record) {
  std::vector<Record> list;
  if (record) {
    list.push_back(*std::move(record));
  }
  return list;
}

}  // namespace

void RequireKept(db::Connection* connection, MapVersion version) {
  if (!queries::HasVersion(connection, version)) {
    throw Error(ErrorCode::kUnavailable,
                fmt::format("{}: version {} was pruned while it was being read; try again",
                            connection->name(), Value(version)));
  }
}

MapInfo Info(db::Connection* connection, MapVersion version) {
  try {
    return queries::Info(connection, version);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kNotFound) {
      RequireKept(connection, version);
    }
    throw;
  }
}

std::vector<TileRecord> FindTiles(db::Connection* connection, const GeoBox& box,
                                  MapVersion version) {
  std::vector<TileRecord> tiles = queries::FindTiles(connection, box, version);
  AddPast(connection, version, &tiles, queries::PastTiles);
  KeepThoseIn(box, &tiles);
  return tiles;
}

std::vector<TileRecord> AllTiles(db::Connection* connection, int64_t limit, MapVersion version) {
  std::vector<TileRecord> tiles = queries::AllTiles(connection, limit, version);
  AddPast(connection, version, &tiles, queries::PastTiles);
  tiles.resize(std::min(tiles.size(), static_cast<size_t>(std::max<int64_t>(limit, 0))));
  return tiles;
}

TilePage FindTilePage(db::Connection* connection, const TilePageRequest& request,
                      MapVersion version) {
  TilePage page = queries::FindTilePage(connection, request, version);
  constexpr int64_t kLastId = std::numeric_limits<int64_t>::max();
  const int64_t after = request.after ? ValueOf(*request.after) : -1;
  const int64_t last = page.resume_after ? ValueOf(*page.resume_after) : kLastId;
  AddPast(connection, version, &page.tiles, queries::PastTilesOfPage, after, last);
  if (request.box) {
    KeepThoseIn(*request.box, &page.tiles);
  }
  if (page.tiles.size() > static_cast<size_t>(request.limit)) {
    page.tiles.resize(request.limit);
    page.resume_after = page.tiles.back().tile_id;
  }
  return page;
}

std::optional<TileRecord> FindTile(db::Connection* connection, TileId tile_id, MapVersion version) {
  std::vector<TileRecord> tiles = ListOf(queries::FindTile(connection, tile_id, version));
  AddPast(connection, version, &tiles, queries::PastTilesWithIds, std::vector{ValueOf(tile_id)});
  return FirstOf(std::move(tiles));
}

std::vector<TileRecord> TilesWithIds(db::Connection* connection, const std::vector<int64_t>& ids,
                                     MapVersion version) {
  queries::TilesAndLatest found = queries::TilesWithIds(connection, ids, version);
  AddPastBefore(found.latest, connection, version, &found.tiles, queries::PastTilesWithIds, ids);
  return std::move(found.tiles);
}

LargeVector<uint8_t> LoadPayload(db::Connection* connection, PayloadId payload_id,
                                 MapVersion version) {
  try {
    return queries::LoadPayload(connection, payload_id);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kMapDamaged) {
      RequireKept(connection, version);
    }
    throw;
  }
}

CodebookId CurrentCodebookId(db::Connection* connection, MapVersion version) {
  const CodebookId codebook_id = queries::CodebookOfVersion(connection, version);
  RequireKept(connection, version);
  return codebook_id;
}

std::vector<SessionRecord> Sessions(db::Connection* connection, MapVersion version) {
  std::vector<SessionRecord> sessions = queries::Sessions(connection, version);
  AddPast(connection, version, &sessions, queries::PastSessions);
  return sessions;
}

std::optional<SessionRecord> FindSession(db::Connection* connection, const std::string& name,
                                         MapVersion version) {
  std::vector<SessionRecord> sessions = ListOf(queries::FindSession(connection, name, version));
  AddPast(connection, version, &sessions, queries::PastSessions);
  std::erase_if(sessions, [&](const SessionRecord& session) { return session.name != name; });
  return FirstOf(std::move(sessions));
}

std::vector<KeyframeRecord> KeyframesOfSession(db::Connection* connection, SessionId session_id,
                                               MapVersion version) {
  std::vector<KeyframeRecord> keyframes =
      queries::KeyframesOfSession(connection, session_id, version);
  AddPast(connection, version, &keyframes, queries::PastKeyframesOfSession, session_id);
  return keyframes;
}

std::vector<KeyframeRecord> KeyframesOfTile(db::Connection* connection, TileId tile_id,
                                            MapVersion version) {
  std::vector<KeyframeRecord> keyframes = queries::KeyframesOfTile(connection, tile_id, version);
  AddPast(connection, version, &keyframes, queries::PastKeyframesOfTile, tile_id);
  return keyframes;
}

}  // namespace cairn::as_of
