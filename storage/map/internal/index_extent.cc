#include "storage/map/internal/index_extent.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "storage/inspection/geo_box.h"
#include "storage/map/internal/map_rows.h"
#include "storage/map/internal/version_queries.h"

namespace cairn {
namespace {

constexpr char kCoverageIndex[] = "rtree_coverage_geom";
// The first strip is wider than a tile, so that it holds something unless many tiles are gone.
constexpr double kFirstStripDeg = 3e-3;

// West, east, south and north. The strip along an edge is what lies beyond a coordinate `?`.
struct Edge {
  double inwards;  // 1 if the strip grows to larger coordinates, -1 otherwise.
  const char* sqlite_column;
  const char* sqlite_strip;
  const char* postgres_column;
  const char* postgres_strip;
};
constexpr std::array<Edge, 4> kEdges = {{
    {1.0, "min(minx)", "minx <= ?", "min(ST_XMin(geom))",
     "geom && ST_MakeEnvelope(-1000, -1000, ?, 1000, 4326)"},
    {-1.0, "max(maxx)", "maxx >= ?", "max(ST_XMax(geom))",
     "geom && ST_MakeEnvelope(?, -1000, 1000, 1000, 4326)"},
    {1.0, "min(miny)", "miny <= ?", "min(ST_YMin(geom))",
     "geom && ST_MakeEnvelope(-1000, -1000, 1000, ?, 4326)"},
    {-1.0, "max(maxy)", "maxy >= ?", "max(ST_YMax(geom))",
     "geom && ST_MakeEnvelope(-1000, ?, 1000, 1000, 4326)"},
}};

using EdgeValues = std::array<double, kEdges.size()>;  // In degrees.

// Returns the outermost coordinate at an edge, or nothing if no strip of at most `span_deg` holds
// any row.
std::optional<double> Outermost(db::Connection* connection, const std::string& sql, double inwards,
                                double outer_deg, double span_deg) {
  for (double strip_deg = kFirstStripDeg;; strip_deg *= 2.0) {
    db::Statement row = connection->Prepare(sql);
    row.Bind(outer_deg + inwards * strip_deg).Step();
    if (!row.IsNull(0)) {
      return row.Double(0);
    }
    if (strip_deg > span_deg + 2.0 * kIndexSlackDeg) {
      return std::nullopt;
    }
  }
}

// Returns the outermost coordinates of an index, or nothing if the index is empty. `index` is an
// R*Tree in SQLite, a table with the column `geom` in PostgreSQL.
std::optional<EdgeValues> Edges(db::Connection* connection, const std::string& index,
                                const EdgeValues& outer_deg) {
  const bool is_sqlite = connection->dialect() == db::Dialect::kSqlite;
  EdgeValues found_deg{};
  for (size_t i = 0; i < kEdges.size(); ++i) {
    const Edge& edge = kEdges[i];
    const std::string sql = fmt::format("SELECT {} FROM {} WHERE {}",
                                        is_sqlite ? edge.sqlite_column : edge.postgres_column,
                                        index, is_sqlite ? edge.sqlite_strip : edge.postgres_strip);
    const double span_deg = outer_deg[i / 2 * 2 + 1] - outer_deg[i / 2 * 2];
    const auto found = Outermost(connection, sql, edge.inwards, outer_deg[i], span_deg);
    if (!found) {
      return std::nullopt;
    }
    found_deg[i] = *found;
  }
  return found_deg;
}

// Returns the squares of the tiles that may be the outermost at an edge.
std::vector<GeoBox> SquaresAtEdges(db::Connection* connection, const EdgeValues& edges_deg) {
  const bool is_sqlite = connection->dialect() == db::Dialect::kSqlite;
  std::vector<GeoBox> squares;
  for (size_t i = 0; i < kEdges.size(); ++i) {
    db::Statement rows = connection->Prepare(
        is_sqlite
            ? fmt::format("SELECT id FROM {} WHERE {}", kCoverageIndex, kEdges[i].sqlite_strip)
            : fmt::format("SELECT tile_id FROM coverage WHERE {}", kEdges[i].postgres_strip));
    rows.Bind(edges_deg[i] + kEdges[i].inwards * kIndexSlackDeg);
    while (rows.Step()) {
      squares.push_back(rows::ReadTileId(*connection, rows.Int64(0)).Bounds());
    }
  }
  return squares;
}

// True where longitudes are plain numbers and the box around tiles is that of their extremes.
bool IsPlain(const GeoBox& box) {
  constexpr double kMaxLonRad = 3.1, kMaxLatRad = 1.4;
  return !box.CrossesAntimeridian() && box.west_rad > -kMaxLonRad && box.east_rad < kMaxLonRad &&
         box.east_rad - box.west_rad < kPi && box.south_rad > -kMaxLatRad &&
         box.north_rad < kMaxLatRad;
}

}  // namespace

GeometryEnvelope IndexExtent(db::Connection* connection, const std::string& index,
                             const GeometryEnvelope& outer) {
  const auto edges = Edges(connection, index, {outer.min_x, outer.max_x, outer.min_y, outer.max_y});
  if (!edges) {
    return {};
  }
  const auto [min_x, max_x, min_y, max_y] = *edges;
  return {.min_x = min_x, .max_x = max_x, .min_y = min_y, .max_y = max_y, .is_empty = false};
}

std::optional<GeoBox> BoundsWithin(db::Connection* connection, const GeoBox& outer) {
  if (!IsPlain(outer)) {
    return queries::BoundsOfTiles(connection);
  }
  const bool is_sqlite = connection->dialect() == db::Dialect::kSqlite;
  const auto edges = Edges(connection, is_sqlite ? kCoverageIndex : "coverage",
                           {outer.west_rad * kDegPerRad, outer.east_rad * kDegPerRad,
                            outer.south_rad * kDegPerRad, outer.north_rad * kDegPerRad});
  return edges ? BoxAroundAll(SquaresAtEdges(connection, *edges)) : std::nullopt;
}

}  // namespace cairn
