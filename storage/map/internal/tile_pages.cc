#include "storage/map/internal/tile_pages.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "storage/inspection/geo_box.h"
#include "storage/map/internal/map_queries.h"
#include "storage/map/internal/map_rows.h"
#include "storage/map/internal/version_queries.h"

namespace cairn::queries {
namespace {

// The bounds of this many tiles are computed in about 40 ms.
constexpr int64_t kMinExamined = 5000;

constexpr std::string_view kIdsInBoxSql =
    "SELECT id FROM rtree_coverage_geom "
    "WHERE maxx >= ? AND minx <= ? AND maxy >= ? AND miny <= ? LIMIT ?";
constexpr std::string_view kIdsInBoxPostgresSql =
    "SELECT tile_id FROM coverage WHERE geom && ST_MakeEnvelope(?1, ?3, ?2, ?4, 4326) LIMIT ?5";
constexpr std::string_view kIdsAfterSql =
    "SELECT tile_id FROM coverage WHERE tile_id > ? ORDER BY tile_id LIMIT ?";

// Appends at most `limit` ids whose indexed rectangles meet the box, moved by some turns of the
// longitude.
void AppendIdsInBox(db::Connection* connection, const GeoBox& box, double turn_deg, int64_t limit,
                    std::vector<int64_t>* ids) {
  constexpr double kTurnDeg = 360.0;
  const double west_deg = box.west_rad * kDegPerRad + turn_deg;
  const double east_deg =
      box.east_rad * kDegPerRad + turn_deg + (box.CrossesAntimeridian() ? kTurnDeg : 0.0);
  if (east_deg < -kTurnDeg || west_deg > kTurnDeg) {
    return;  // Indexed longitudes lie in [-360, 360].
  }
  db::Statement rows = connection->Prepare(
      connection->dialect() == db::Dialect::kSqlite ? kIdsInBoxSql : kIdsInBoxPostgresSql);
  rows.Bind(west_deg, east_deg, box.south_rad * kDegPerRad, box.north_rad * kDegPerRad, limit);
  while (rows.Step()) {
    ids->push_back(rows.Int64(0));
  }
}

// Returns the ids that the index finds, in ascending order, or nothing if there are more than
// `max_ids`.
std::optional<std::vector<int64_t>> FewIdsInBox(db::Connection* connection, const GeoBox& box,
                                                int64_t max_ids) {
  std::vector<int64_t> ids;
  for (const double turn_deg : {-360.0, 0.0, 360.0}) {
    AppendIdsInBox(connection, box, turn_deg, max_ids + 1, &ids);
    if (static_cast<int64_t>(ids.size()) > max_ids) {
      return std::nullopt;
    }
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

std::vector<int64_t> IdsAfter(db::Connection* connection, int64_t after, int64_t limit) {
  std::vector<int64_t> ids;
  db::Statement rows = connection->Prepare(kIdsAfterSql);
  rows.Bind(after, limit);
  while (rows.Step()) {
    ids.push_back(rows.Int64(0));
  }
  return ids;
}

// The ids of a page, and whether the map may have more behind them.
struct IdPage {
  std::vector<int64_t> ids;
  std::optional<TileId> resume_after;
};

// Takes the ids that meet the box, up to the limit. `has_more` says that the map has tiles behind
// the last candidate.
IdPage TakePage(db::Connection* connection, const TilePageRequest& request,
                const std::vector<int64_t>& candidates, bool has_more) {
  IdPage page;
  std::optional<TileId> last;
  for (const int64_t id : candidates) {
    const TileId tile_id = rows::ReadTileId(*connection, id);
    if (request.box && !BoxesMeet(tile_id.Bounds(), *request.box)) {
      last = tile_id;
      continue;
    }
    if (static_cast<int64_t>(page.ids.size()) == request.limit) {
      page.resume_after = last;
      return page;
    }
    page.ids.push_back(id);
    last = tile_id;
  }
  if (has_more) {
    page.resume_after = last;
  }
  return page;
}

IdPage FindIdPage(db::Connection* connection, const TilePageRequest& request) {
  const int64_t num_examined = std::max(kMinExamined, request.limit + 1);
  const int64_t after = request.after ? static_cast<int64_t>(request.after->value()) : -1;
  if (request.box) {
    if (auto few = FewIdsInBox(connection, *request.box, num_examined)) {
      few->erase(few->begin(), std::upper_bound(few->begin(), few->end(), after));
      return TakePage(connection, request, *few, /*has_more=*/false);
    }
  }
  const int64_t num_read = request.box ? num_examined : request.limit + 1;
  const std::vector<int64_t> ids = IdsAfter(connection, after, num_read);
  return TakePage(connection, request, ids,
                  /*has_more=*/static_cast<int64_t>(ids.size()) == num_read);
}

}  // namespace

std::string_view TileIdsInBoxSql() { return kIdsInBoxSql; }
std::string_view TileIdsAfterSql() { return kIdsAfterSql; }

TilePage FindTilePage(db::Connection* connection, const TilePageRequest& request,
                      MapVersion as_of) {
  IdPage found = FindIdPage(connection, request);
  TilePage page{.tiles = {}, .resume_after = found.resume_after};
  if (!found.ids.empty()) {
    page.tiles = TilesWithIds(connection, found.ids, as_of).tiles;
    SortById(&page.tiles);
  }
  return page;
}

}  // namespace cairn::queries
