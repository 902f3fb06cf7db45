// The part of the check that reads every row of the layers.
#include <cmath>
#include <optional>
#include <string>

#include "core/angles.h"
#include "core/error.h"
#include "core/geodesy.h"
#include "storage/inspection/geopackage.h"
#include "storage/map/internal/map_check.h"
#include "storage/map/internal/map_queries.h"

namespace cairn {
namespace {

constexpr double kSlackDeg = 1e-7;  // A centimeter; machines may round differently.
// R*Trees round boxes outwards to floats. Near 360 degrees, floats are 3e-5 degrees apart.
constexpr double kIndexSlackDeg = 1e-4;

// Returns true if the box of an R*Tree row contains the envelope with at most kIndexSlackDeg to
// spare. The box is in columns `first` to `first` + 3: min x, max x, min y, max y. The columns are
// NULL if the R*Tree has no row; another check reports that.
bool IsIndexed(const db::Statement& row, int first, const GeometryEnvelope& envelope) {
  if (row.IsNull(first)) {
    return true;
  }
  const auto is_outward = [](double slack_deg) {
    return slack_deg >= -1e-9 && slack_deg <= kIndexSlackDeg;
  };
  return is_outward(envelope.min_x - row.Double(first)) &&
         is_outward(row.Double(first + 1) - envelope.max_x) &&
         is_outward(envelope.min_y - row.Double(first + 2)) &&
         is_outward(row.Double(first + 3) - envelope.max_y);
}

bool SameEnvelope(const GeometryEnvelope& a, const GeometryEnvelope& b) {
  const auto near = [](double x, double y) { return std::abs(x - y) <= kSlackDeg; };
  return a.is_empty == b.is_empty && near(a.min_x, b.min_x) && near(a.max_x, b.max_x) &&
         near(a.min_y, b.min_y) && near(a.max_y, b.max_y);
}

// What a query selects of the geometry of a row. In a file: the geometry and its indexed box. Of
// PostgreSQL, which keeps its index itself: the envelope of the geometry. The columns of boxes and
// envelopes are min x, max x, min y, max y.
struct GeometryColumns {
  db::Dialect dialect;
  int first;  // Of the selected columns.
};

// Returns nothing if the row has no valid geometry.
std::optional<GeometryEnvelope> EnvelopeOf(const db::Statement& row,
                                           const GeometryColumns& columns) {
  const int first = columns.first;
  if (columns.dialect == db::Dialect::kSqlite) {
    return EnvelopeOfGeometry(row.Blob(first));
  }
  if (row.IsNull(first)) {
    return std::nullopt;
  }
  return GeometryEnvelope{row.Double(first), row.Double(first + 1), row.Double(first + 2),
                          row.Double(first + 3), false};
}

// Compares the geometry and the indexed box of a row with the expected envelope.
void CheckGeometry(const db::Statement& row, const GeometryColumns& columns,
                   const GeometryEnvelope& expected, const std::string& where, Findings* findings) {
  const std::optional<GeometryEnvelope> envelope = EnvelopeOf(row, columns);
  if (!envelope || !SameEnvelope(*envelope, expected)) {
    findings->Add(where, "its geometry is in the wrong place");
  }
  if (columns.dialect == db::Dialect::kSqlite && !IsIndexed(row, columns.first + 1, expected)) {
    findings->Add(where, "its box in the spatial index does not match it");
  }
}

// Selects the columns of a layer, then its GeometryColumns.
std::string SelectRows(db::Dialect dialect, const std::string& columns, const std::string& layer,
                       const std::string& id) {
  if (dialect == db::Dialect::kPostgres) {
    return "SELECT " + columns +
           ", ST_XMin(geom), ST_XMax(geom), ST_YMin(geom), ST_YMax(geom) FROM " + layer;
  }
  return "SELECT " + columns + ", geom, minx, maxx, miny, maxy FROM " + layer +
         " LEFT JOIN rtree_" + layer + "_geom ON id = " + id;
}

// The columns are tile_id, tile, and those of the geometry.
void CheckSquare(const db::Statement& row, db::Dialect dialect, const std::string& where,
                 Findings* findings) {
  const TileId tile_id = TileId::FromValue(static_cast<uint64_t>(row.Int64(0)));
  if (row.Text(1) != tile_id.ToString()) {
    findings->Add(where, "its name does not match its id");
  }
  CheckGeometry(row, {dialect, 2}, *EnvelopeOfGeometry(TileGeometry(tile_id)), where, findings);
}

// A position on the border of two squares may belong to either tile.
bool StandsIn(const Geodetic& position, TileId tile_id) {
  constexpr double kSquareSlackRad = kSlackDeg / kDegPerRad;
  for (const double south_rad : {0.0, -kSquareSlackRad, kSquareSlackRad}) {
    for (const double west_rad : {0.0, -kSquareSlackRad, kSquareSlackRad}) {
      const Geodetic near = {position.lat_rad + south_rad, position.lon_rad + west_rad,
                             position.h_m};
      if (TileId::Containing(near) == tile_id) {
        return true;
      }
    }
  }
  return false;
}

// The columns are keyframe_id, lat_deg, lon_deg, h_m, heading_deg, and those of the geometry.
void CheckKeyframe(const db::Statement& row, db::Connection* connection, const std::string& where,
                   Findings* findings) {
  const std::optional<KeyframeRecord> keyframe =
      queries::FindKeyframe(connection, KeyframeId(row.Int64(0)));
  if (!keyframe) {
    return;  // The keyframe has no pose or no camera; another check reports that.
  }
  const Geodetic position = GeodeticFromEcef(keyframe->cam_from_ecef.Inverse().translation);
  ValidateGeodetic(position, "its pose");
  if (!StandsIn(position, keyframe->tile_id)) {
    findings->Add(where, "it stands outside its tile");
  }
  const double lat_deg = row.Double(1), lon_deg = row.Double(2), h_m = row.Double(3);
  const double off_lon_deg = std::remainder(lon_deg - position.lon_deg(), 360.0);
  if (!(std::abs(lat_deg - position.lat_deg()) <= kSlackDeg &&
        std::abs(off_lon_deg) * std::cos(position.lat_rad) <= kSlackDeg &&
        std::abs(h_m - position.h_m) <= 0.01)) {
    findings->Add(where, "its latitude, longitude and height do not match its pose");
  }
  CheckGeometry(row, {connection->dialect(), 5}, {lon_deg, lon_deg, lat_deg, lat_deg, false}, where,
                findings);
  const Eigen::Vector3d axis_in_enu =
      EcefFromEnu(position).rotation.conjugate() *
      (keyframe->cam_from_ecef.rotation.conjugate() * Eigen::Vector3d::UnitZ());
  const double heading_deg = std::atan2(axis_in_enu.x(), axis_in_enu.y()) * kDegPerRad;
  const double off_deg = std::remainder(row.Double(4) - heading_deg, 360.0);
  const bool has_heading = axis_in_enu.head<2>().norm() > 1e-3;
  if (has_heading && !(std::abs(off_deg) <= 0.01)) {
    findings->Add(where, "its heading does not match its pose");
  }
}

}  // namespace

void CheckLayers(db::Connection* connection, Findings* findings) {
  const db::Dialect dialect = connection->dialect();
  db::Statement squares =
      connection->Prepare(SelectRows(dialect, "tile_id, tile", "coverage", "tile_id"));
  while (squares.Step()) {
    const std::string where = "square " + std::to_string(squares.Int64(0));
    findings->Run(where, [&] { CheckSquare(squares, dialect, where, findings); });
  }
  db::Statement keyframes = connection->Prepare(SelectRows(
      dialect, "keyframe_id, lat_deg, lon_deg, h_m, heading_deg", "keyframes", "keyframe_id"));
  while (keyframes.Step()) {
    const std::string where = "keyframe " + std::to_string(keyframes.Int64(0));
    findings->Run(where, [&] { CheckKeyframe(keyframes, connection, where, findings); });
  }
}

}  // namespace cairn
