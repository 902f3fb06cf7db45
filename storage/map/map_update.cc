#include <fmt/format.h>
#include <sqlite3.h>

#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "core/angles.h"
#include "core/check.h"
#include "core/error.h"
#include "core/printable.h"
#include "storage/geometry/geopackage.h"
#include "storage/map/map_file.h"
#include "storage/map/map_internal.h"
#include "storage/map/map_queries.h"
#include "storage/map/map_schema.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

// Formats numbers as "[1.5,2,3]". Each number is as short as an exact round trip allows.
std::string FormatNumbers(const std::vector<double>& numbers) {
  return fmt::format("[{}]", fmt::join(numbers, ","));
}

// Returns the id of the row with equal intrinsics. Inserts a row if there is none.
int64_t CameraRow(sqlite::Connection* connection, const Camera& camera) {
  const std::string model = CameraModelName(camera.model());
  const int64_t width_px = camera.width_px();
  const int64_t height_px = camera.height_px();
  const std::string params = FormatNumbers(camera.params());
  sqlite::Statement found = connection->Prepare(
      "SELECT camera_id FROM cairn_cameras "
      "WHERE model = ? AND width_px = ? AND height_px = ? AND params = ?");
  if (found.Bind(model, width_px, height_px, params).Step()) {
    return found.Int64(0);
  }
  connection
      ->Prepare(
          "INSERT INTO cairn_cameras (model, width_px, height_px, params) VALUES (?, ?, ?, ?)")
      .Bind(model, width_px, height_px, params)
      .Run();
  return connection->LastInsertId();
}

bool IsUtcTime(sqlite::Connection* connection, const std::string& text) {
  sqlite::Statement row = connection->Prepare("SELECT ?1 IS strftime('%Y-%m-%dT%H:%M:%SZ', ?1)");
  row.Bind(text).Step();
  return row.Int64(0) != 0;
}

bool IsLowerHex(const std::string& text) {
  return text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

void RequireValid(const SessionRecord& session, sqlite::Connection* connection) {
  if (!session.recorded_at.empty() && !IsUtcTime(connection, session.recorded_at)) {
    throw Error(ErrorCode::kInvalidArgument, "session '" + Excerpt(session.name) +
                                                 "': recorded_at '" + Excerpt(session.recorded_at) +
                                                 "' is not a time like 2026-01-31T12:00:00Z");
  }
  if (!IsLowerHex(session.content_digest)) {
    throw Error(ErrorCode::kInvalidArgument, "session '" + Excerpt(session.name) +
                                                 "': content_digest is not lower-case hexadecimal");
  }
}

// Returns the heading of the optical axis: degrees clockwise from north, in [0, 360).
double HeadingDeg(const Rigid3d& cam_from_ecef, const Geodetic& position) {
  const Eigen::Vector3d axis_in_enu =
      EcefFromEnu(position).rotation.conjugate() *
      (cam_from_ecef.rotation.conjugate() * Eigen::Vector3d::UnitZ());
  const double heading_deg = std::atan2(axis_in_enu.x(), axis_in_enu.y()) * kDegPerRad;
  return heading_deg < 0.0 ? heading_deg + 360.0 : heading_deg;
}

// Updates gpkg_contents, from which GeoPackage readers learn a layer's extent and last change
// without reading the layer.
void UpdateContents(sqlite::Connection* connection) {
  connection->Execute(
      "UPDATE gpkg_contents SET last_change = strftime('%Y-%m-%dT%H:%M:%fZ', 'now') "
      "WHERE table_name IN ('coverage', 'keyframes', 'cairn_sessions');"
      "UPDATE gpkg_contents SET (min_x, min_y, max_x, max_y) = "
      "(SELECT min(minx), min(miny), max(maxx), max(maxy) FROM rtree_coverage_geom) "
      "WHERE table_name = 'coverage';"
      "UPDATE gpkg_contents SET (min_x, min_y, max_x, max_y) = "
      "(SELECT min(minx), min(miny), max(maxx), max(maxy) FROM rtree_keyframes_geom) "
      "WHERE table_name = 'keyframes';");
}

}  // namespace

MapUpdate::Impl::Impl(const std::string& path) : connection(OpenMapFileForUpdate(path)) {
  try {
    transaction.emplace(connection.get(), sqlite::Transaction::Kind::kImmediate);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kConflict) {
      throw Error(ErrorCode::kConflict,
                  path + ": another update of this map is running; try again when it has finished");
    }
    throw;
  }
  // The schema is checked inside the transaction, so the triggers that run later are the checked
  // ones.
  RequireMapSchema(connection.get());
}

MapUpdate::MapUpdate(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapUpdate::MapUpdate(MapUpdate&&) noexcept = default;
MapUpdate::~MapUpdate() = default;

std::optional<TileRecord> MapUpdate::FindTile(TileId tile_id) const {
  return queries::FindTile(impl_->connection.get(), tile_id);
}

LargeVector<uint8_t> MapUpdate::LoadPayload(PayloadId payload_id) const {
  return queries::LoadPayload(impl_->connection.get(), payload_id);
}

std::optional<SessionRecord> MapUpdate::FindSession(const std::string& name) const {
  return queries::FindSession(impl_->connection.get(), name);
}

std::vector<SessionRecord> MapUpdate::Sessions() const {
  return queries::Sessions(impl_->connection.get());
}

std::vector<KeyframeRecord> MapUpdate::KeyframesOfTile(TileId tile_id) const {
  return queries::KeyframesOfTile(impl_->connection.get(), tile_id);
}

std::vector<TileId> MapUpdate::TilesOfSession(SessionId session_id) const {
  return queries::TilesOfSession(impl_->connection.get(), session_id);
}

std::shared_ptr<const Codebook> MapUpdate::CurrentCodebook() const {
  const CodebookId codebook_id = queries::CurrentCodebookId(impl_->connection.get());
  return codebook_id == CodebookId{} ? nullptr
                                     : queries::LoadCodebook(impl_->connection.get(), codebook_id);
}

CodebookId MapUpdate::AddCodebook(const Codebook& codebook) {
  const std::vector<uint8_t> bytes = EncodeCodebook(codebook);
  impl_->connection
      ->Prepare(
          "INSERT INTO cairn_codebooks (created_at, bytes) "
          "VALUES (strftime('%Y-%m-%dT%H:%M:%SZ', 'now'), ?)")
      .Bind(bytes)
      .Run();
  return CodebookId(impl_->connection->LastInsertId());
}

SessionId MapUpdate::AddSession(const SessionRecord& session) {
  RequireValid(session, impl_->connection.get());
  if (FindSession(session.name)) {
    throw Error(ErrorCode::kConflict, impl_->connection->path() +
                                          ": already has a session named '" +
                                          Excerpt(session.name) + "'");
  }
  impl_->connection
      ->Prepare(
          "INSERT INTO cairn_sessions (name, source, created_at, recorded_at, content_digest, "
          "num_images, num_landmarks, georef_median_residual_m) "
          "VALUES (?1, ?2, strftime('%Y-%m-%dT%H:%M:%SZ', 'now'), "
          "coalesce(nullif(?3, ''), strftime('%Y-%m-%dT%H:%M:%SZ', 'now')), ?4, ?5, ?6, ?7)")
      .Bind(session.name, session.source, session.recorded_at, session.content_digest,
            session.num_images, session.num_landmarks, session.georef_median_residual_m)
      .Run();
  return SessionId(impl_->connection->LastInsertId());
}

void MapUpdate::RemoveSession(SessionId session_id) {
  sqlite::Connection& connection = *impl_->connection;
  connection
      .Prepare(
          "DELETE FROM cairn_keyframe_poses WHERE keyframe_id IN "
          "(SELECT keyframe_id FROM keyframes WHERE session_id = ?)")
      .Bind(Value(session_id))
      .Run();
  connection.Prepare("DELETE FROM keyframes WHERE session_id = ?").Bind(Value(session_id)).Run();
  connection.Prepare("DELETE FROM cairn_sessions WHERE session_id = ?")
      .Bind(Value(session_id))
      .Run();
  connection.Execute(
      "DELETE FROM cairn_cameras WHERE NOT EXISTS "
      "(SELECT 1 FROM cairn_keyframe_poses AS p WHERE p.camera_id = cairn_cameras.camera_id)");
}

KeyframeId MapUpdate::AddKeyframe(const KeyframeRecord& keyframe) {
  sqlite::Connection& connection = *impl_->connection;
  const Rigid3d& pose = keyframe.cam_from_ecef;
  const Geodetic position = GeodeticFromEcef(pose.Inverse().translation);
  const std::vector<uint8_t> geometry = PointGeometry(position);
  connection
      .Prepare(
          "INSERT INTO keyframes (geom, session_id, tile_id, image_name, lat_deg, lon_deg, "
          "h_m, heading_deg) VALUES (?, ?, ?, ?, ?, ?, ?, ?)")
      .Bind(geometry, Value(keyframe.session_id), static_cast<int64_t>(keyframe.tile_id.value()),
            keyframe.image_name, position.lat_deg(), position.lon_deg(), position.h_m,
            HeadingDeg(pose, position))
      .Run();
  const int64_t keyframe_id = connection.LastInsertId();
  connection
      .Prepare(
          "INSERT INTO cairn_keyframe_poses (keyframe_id, camera_id, qw, qx, qy, qz, tx_m, "
          "ty_m, tz_m) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .Bind(keyframe_id, CameraRow(&connection, keyframe.camera), pose.rotation.w(),
            pose.rotation.x(), pose.rotation.y(), pose.rotation.z(), pose.translation.x(),
            pose.translation.y(), pose.translation.z())
      .Run();
  return KeyframeId(keyframe_id);
}

void MapUpdate::RemoveKeyframe(KeyframeId keyframe_id) {
  sqlite::Connection& connection = *impl_->connection;
  sqlite::Statement camera =
      connection.Prepare("SELECT camera_id FROM cairn_keyframe_poses WHERE keyframe_id = ?");
  if (!camera.Bind(Value(keyframe_id)).Step()) {
    return;
  }
  const int64_t camera_id = camera.Int64(0);
  for (const char* sql : {"DELETE FROM cairn_keyframe_poses WHERE keyframe_id = ?",
                          "DELETE FROM keyframes WHERE keyframe_id = ?"}) {
    connection.Prepare(sql).Bind(Value(keyframe_id)).Run();
  }
  connection
      .Prepare(
          "DELETE FROM cairn_cameras WHERE camera_id = ?1 AND NOT EXISTS "
          "(SELECT 1 FROM cairn_keyframe_poses WHERE camera_id = ?1)")
      .Bind(camera_id)
      .Run();
}

LandmarkId MapUpdate::ReserveLandmarkIds(uint64_t count) {
  constexpr uint64_t kMaxCount = uint64_t{1} << 48;  // Far below the limit of 63 bits.
  CAIRN_CHECK(count <= kMaxCount, "a map cannot number this many landmarks");
  sqlite::Statement row = impl_->connection->Prepare(
      "UPDATE cairn_map SET next_landmark_id = next_landmark_id + ? RETURNING next_landmark_id");
  row.Bind(static_cast<int64_t>(count));
  if (!row.Step()) {
    throw Error(ErrorCode::kMapDamaged,
                impl_->connection->path() + ": the table cairn_map is empty");
  }
  const auto next_id = static_cast<uint64_t>(row.Int64(0));
  row.Step();
  return LandmarkId(next_id - count);
}

PayloadId MapUpdate::PutTile(const TileRecord& tile, std::span<const uint8_t> payload) {
  RemoveTile(tile.tile_id);
  sqlite::Connection& connection = *impl_->connection;
  connection.Prepare("INSERT INTO cairn_payloads (bytes) VALUES (?)").Bind(payload).Run();
  const int64_t payload_id = connection.LastInsertId();
  const auto tile_id = static_cast<int64_t>(tile.tile_id.value());
  const std::vector<uint8_t> geometry = TileGeometry(tile.tile_id);
  connection
      .Prepare(
          "INSERT INTO coverage (tile_id, geom, tile, num_landmarks, num_descriptors, "
          "num_keyframes, num_bytes, min_h_m, max_h_m) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .Bind(tile_id, geometry, tile.tile_id.ToString(), tile.num_landmarks, tile.num_descriptors,
            tile.num_keyframes, std::ssize(payload), tile.min_h_m, tile.max_h_m)
      .Run();
  const GeoBox& bounds = tile.landmark_bounds;
  connection
      .Prepare(
          "INSERT INTO cairn_tiles (tile_id, payload_id, codebook_id, landmarks_south_deg, "
          "landmarks_west_deg, landmarks_north_deg, landmarks_east_deg) "
          "VALUES (?, ?, ?, ?, ?, ?, ?)")
      .Bind(tile_id, payload_id, Value(tile.codebook_id), bounds.south_rad * kDegPerRad,
            bounds.west_rad * kDegPerRad, bounds.north_rad * kDegPerRad,
            bounds.east_rad * kDegPerRad)
      .Run();
  return PayloadId(payload_id);
}

void MapUpdate::RemoveTile(TileId tile_id) {
  const std::optional<TileRecord> tile = FindTile(tile_id);
  if (!tile) {
    return;
  }
  const auto id = static_cast<int64_t>(tile_id.value());
  impl_->connection->Prepare("DELETE FROM cairn_tiles WHERE tile_id = ?").Bind(id).Run();
  impl_->connection->Prepare("DELETE FROM coverage WHERE tile_id = ?").Bind(id).Run();
  impl_->connection->Prepare("DELETE FROM cairn_payloads WHERE payload_id = ?")
      .Bind(Value(tile->payload_id))
      .Run();
}

MapVersion MapUpdate::Publish() {
  CAIRN_CHECK(impl_->transaction.has_value(), "the update was already published");
  UpdateContents(impl_->connection.get());
  impl_->connection->Execute(
      "INSERT INTO cairn_versions (version, created_at) "
      "SELECT max(version) + 1, strftime('%Y-%m-%dT%H:%M:%SZ', 'now') FROM cairn_versions");
  const MapVersion version = queries::CurrentVersion(impl_->connection.get());
  impl_->transaction->Commit();
  impl_->transaction.reset();
  // Moves the log's pages into the file, except those that a reader still needs; a later
  // publication moves these.
  sqlite3_wal_checkpoint_v2(impl_->connection->handle(), nullptr, SQLITE_CHECKPOINT_PASSIVE,
                            nullptr, nullptr);
  return version;
}

}  // namespace cairn
