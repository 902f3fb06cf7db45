#include "storage/map/internal/head_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "core/error.h"
#include "storage/inspection/geo_box.h"
#include "storage/inspection/geopackage.h"
#include "storage/map/internal/accuracy_table.h"
#include "storage/map/internal/index_extent.h"
#include "storage/map/internal/map_file.h"
#include "storage/map/internal/map_queries.h"
#include "storage/map/internal/version_queries.h"
#include "storage/map/utc_time.h"
#include "storage/tile/content_digest.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

int64_t RowId(TileId tile_id) { return static_cast<int64_t>(tile_id.value()); }

// Runs an INSERT ... RETURNING and returns the id.
int64_t InsertedId(db::Statement& inserted) {
  inserted.Step();
  const int64_t id = inserted.Int64(0);
  inserted.Step();
  return id;
}

// Formats numbers as "[1.5,2,3]". Each number is as short as an exact round trip allows.
std::string FormatNumbers(const std::vector<double>& numbers) {
  return fmt::format("[{}]", fmt::join(numbers, ","));
}

// Returns the id of the row with equal intrinsics. Inserts a row if there is none.
int64_t CameraRow(db::Connection* connection, const Camera& camera) {
  const std::string model = CameraModelName(camera.model());
  const int64_t width_px = camera.width_px();
  const int64_t height_px = camera.height_px();
  const std::string params = FormatNumbers(camera.params());
  db::Statement found = connection->Prepare(
      "SELECT camera_id FROM cairn_cameras "
      "WHERE model = ? AND width_px = ? AND height_px = ? AND params = ?");
  if (found.Bind(model, width_px, height_px, params).Step()) {
    return found.Int64(0);
  }
  db::Statement inserted = connection->Prepare(
      "INSERT INTO cairn_cameras (model, width_px, height_px, params) VALUES (?, ?, ?, ?) "
      "RETURNING camera_id");
  return InsertedId(inserted.Bind(model, width_px, height_px, params));
}

// Returns the heading of the optical axis: degrees clockwise from north, in [0, 360).
double HeadingDeg(const Rigid3d& cam_from_ecef, const Geodetic& position) {
  const Eigen::Vector3d axis_in_enu =
      EcefFromEnu(position).rotation.conjugate() *
      (cam_from_ecef.rotation.conjugate() * Eigen::Vector3d::UnitZ());
  const double heading_deg = std::atan2(axis_in_enu.x(), axis_in_enu.y()) * kDegPerRad;
  return heading_deg < 0.0 ? heading_deg + 360.0 : heading_deg;
}

// If this update moved the row to the past, deletes the row there and returns its `since`.
// Otherwise returns the version that the update becomes.
template <typename... Keys>
int64_t TakeBack(db::Connection* connection, std::string_view sql, int64_t next_version,
                 const Keys&... keys) {
  db::Statement row = connection->Prepare(sql);
  return row.Bind(next_version, keys...).Step() ? row.Int64(0) : next_version;
}

// Returns the number of the next version. The file may hold any number.
int64_t NextVersion(db::Connection* connection) {
  constexpr int64_t kMaxVersion = int64_t{1} << 62;
  const int64_t current = Value(queries::LatestVersion(connection));
  if (current < 1 || current >= kMaxVersion) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("{}: the latest version has the invalid number {}", connection->name(),
                            current));
  }
  return current + 1;
}

}  // namespace

HeadWriter::HeadWriter(db::Connection* connection)
    : connection_(connection),
      next_version_(NextVersion(connection)),
      totals_(queries::LatestRecord(connection).totals),
      extents_(connection->dialect() == db::Dialect::kSqlite
                   ? std::make_unique<LayerExtents>(connection)
                   : nullptr) {}

SessionId HeadWriter::InsertSession(const SessionRecord& session) {
  const int64_t since =
      TakeBack(connection_,
               "DELETE FROM cairn_past_sessions WHERE until = ? AND session_id = ? RETURNING since",
               next_version_, Value(session.id));
  const std::string now = UtcNow();
  db::Statement inserted = connection_->Prepare(
      "INSERT INTO cairn_sessions (session_id, name, source, created_at, recorded_at, "
      "content_digest, num_images, num_landmarks, georef_median_residual_m, since) "
      "VALUES (nullif(?, 0), ?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING session_id");
  inserted.Bind(Value(session.id), session.name, session.source,
                session.created_at.empty() ? now : session.created_at,
                session.recorded_at.empty() ? now : session.recorded_at, session.content_digest,
                session.num_images, session.num_landmarks, session.georef_median_residual_m, since);
  totals_.AddSessions(1);
  const auto session_id = SessionId(InsertedId(inserted));
  if (session.accuracy) {
    accuracy_table::Keep(connection_, session_id, *session.accuracy);
  }
  return session_id;
}

void HeadWriter::RetireSession(SessionId session_id) {
  connection_
      ->Prepare(
          "INSERT INTO cairn_past_sessions (session_id, since, until, name, source, created_at, "
          "recorded_at, content_digest, num_images, num_landmarks, georef_median_residual_m) "
          "SELECT session_id, since, ?1, name, source, created_at, recorded_at, content_digest, "
          "num_images, num_landmarks, georef_median_residual_m FROM cairn_sessions "
          "WHERE session_id = ?2 AND since < ?1")
      .Bind(next_version_, Value(session_id))
      .Run();
  db::Statement gone =
      connection_->Prepare("DELETE FROM cairn_sessions WHERE session_id = ? RETURNING session_id");
  if (gone.Bind(Value(session_id)).Step()) {
    totals_.AddSessions(-1);
  }
}

KeyframeId HeadWriter::InsertKeyframe(const KeyframeRecord& keyframe) {
  const int64_t since = TakeBack(
      connection_,
      "DELETE FROM cairn_past_keyframes WHERE until = ? AND keyframe_id = ? RETURNING since",
      next_version_, Value(keyframe.id));
  const Rigid3d& pose = keyframe.cam_from_ecef;
  const Geodetic position = GeodeticFromEcef(pose.Inverse().translation);
  const std::vector<uint8_t> geometry = PointGeometry(position);
  db::Statement inserted = connection_->Prepare(
      "INSERT INTO keyframes (keyframe_id, geom, session_id, tile_id, image_name, lat_deg, "
      "lon_deg, h_m, heading_deg) VALUES (nullif(?, 0), ?, ?, ?, ?, ?, ?, ?, ?) "
      "RETURNING keyframe_id");
  inserted.Bind(Value(keyframe.id), db::Geometry{geometry}, Value(keyframe.session_id),
                RowId(keyframe.tile_id), keyframe.image_name, position.lat_deg(),
                position.lon_deg(), position.h_m, HeadingDeg(pose, position));
  const int64_t keyframe_id = InsertedId(inserted);
  connection_
      ->Prepare(
          "INSERT INTO cairn_keyframe_poses (keyframe_id, camera_id, qw, qx, qy, qz, tx_m, "
          "ty_m, tz_m, since) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .Bind(keyframe_id, CameraRow(connection_, keyframe.camera), pose.rotation.w(),
            pose.rotation.x(), pose.rotation.y(), pose.rotation.z(), pose.translation.x(),
            pose.translation.y(), pose.translation.z(), since)
      .Run();
  totals_.AddKeyframes(1);
  if (extents_) {
    extents_->keyframes.Add(*EnvelopeOfGeometry(geometry));
  }
  return KeyframeId(keyframe_id);
}

void HeadWriter::RetireKeyframe(KeyframeId keyframe_id) {
  db::Statement place =
      connection_->Prepare("SELECT lon_deg, lat_deg FROM keyframes WHERE keyframe_id = ?");
  if (!place.Bind(Value(keyframe_id)).Step()) {
    return;
  }
  const double lon_deg = place.Double(0), lat_deg = place.Double(1);
  connection_
      ->Prepare(
          "INSERT INTO cairn_past_keyframes (keyframe_id, since, until, session_id, tile_id, "
          "image_name, camera_id, qw, qx, qy, qz, tx_m, ty_m, tz_m) "
          "SELECT k.keyframe_id, p.since, ?1, k.session_id, k.tile_id, k.image_name, p.camera_id, "
          "p.qw, p.qx, p.qy, p.qz, p.tx_m, p.ty_m, p.tz_m FROM keyframes AS k "
          "JOIN cairn_keyframe_poses AS p ON p.keyframe_id = k.keyframe_id "
          "WHERE k.keyframe_id = ?2 AND p.since < ?1")
      .Bind(next_version_, Value(keyframe_id))
      .Run();
  for (const char* sql : {"DELETE FROM cairn_keyframe_poses WHERE keyframe_id = ?",
                          "DELETE FROM keyframes WHERE keyframe_id = ?"}) {
    connection_->Prepare(sql).Bind(Value(keyframe_id)).Run();
  }
  totals_.AddKeyframes(-1);
  if (extents_) {
    extents_->keyframes.Remove({lon_deg, lon_deg, lat_deg, lat_deg, false});
  }
}

PayloadId HeadWriter::StorePayload(std::span<const uint8_t> payload) {
  const std::string digest = ContentDigest(payload);
  db::Statement row =
      connection_->Prepare("SELECT payload_id FROM cairn_payloads WHERE digest = ?");
  if (row.Bind(digest).Step()) {
    const auto payload_id = PayloadId(row.Int64(0));
    const LargeVector<uint8_t> stored = queries::LoadPayload(connection_, payload_id);
    if (!std::equal(payload.begin(), payload.end(), stored.begin(), stored.end())) {
      throw Error(ErrorCode::kMapDamaged, fmt::format("{}: payload {} does not match its digest",
                                                      connection_->name(), Value(payload_id)));
    }
    return payload_id;
  }
  db::Statement inserted = connection_->Prepare(
      "INSERT INTO cairn_payloads (digest, bytes) VALUES (?, ?) RETURNING payload_id");
  return PayloadId(InsertedId(inserted.Bind(digest, payload)));
}

void HeadWriter::NoteSessions(TileId tile_id, std::span<const uint8_t> payload) {
  std::set<SessionId> session_ids;
  try {
    session_ids = SessionsInPayload(payload);
  } catch (const Error&) {
    return;  // MapStore::Check reports damaged payloads.
  }
  for (const SessionId session_id : session_ids) {
    connection_
        ->Prepare(
            "INSERT INTO cairn_session_tiles (session_id, tile_id) VALUES (?, ?) "
            "ON CONFLICT DO NOTHING")
        .Bind(Value(session_id), RowId(tile_id))
        .Run();
  }
}

PayloadId HeadWriter::PutTile(TileRecord tile, std::span<const uint8_t> payload) {
  tile.payload_id = StorePayload(payload);
  tile.num_bytes = std::ssize(payload);
  NoteSessions(tile.tile_id, payload);
  PutStoredTile(tile);
  return tile.payload_id;
}

void HeadWriter::PutStoredTile(const TileRecord& tile) {
  const std::optional<TileRecord> known = queries::FindTile(connection_, tile.tile_id);
  if (known && known->payload_id == tile.payload_id) {
    return;  // A record follows from its payload.
  }
  RetireTile(tile.tile_id);
  InsertTile(tile);
}

void HeadWriter::InsertTile(const TileRecord& tile) {
  const int64_t since =
      TakeBack(connection_,
               "DELETE FROM cairn_past_tiles WHERE until = ? AND tile_id = ? AND payload_id = ? "
               "RETURNING since",
               next_version_, RowId(tile.tile_id), Value(tile.payload_id));
  const std::vector<uint8_t> geometry = TileGeometry(tile.tile_id);
  connection_
      ->Prepare(
          "INSERT INTO coverage (tile_id, geom, tile, num_landmarks, num_descriptors, "
          "num_keyframes, num_bytes, min_h_m, max_h_m) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .Bind(RowId(tile.tile_id), db::Geometry{geometry}, tile.tile_id.ToString(),
            tile.num_landmarks, tile.num_descriptors, tile.num_keyframes, tile.num_bytes,
            tile.min_h_m, tile.max_h_m)
      .Run();
  const GeoBox& bounds = tile.landmark_bounds;
  connection_
      ->Prepare(
          "INSERT INTO cairn_tiles (tile_id, payload_id, codebook_id, landmarks_south_deg, "
          "landmarks_west_deg, landmarks_north_deg, landmarks_east_deg, since) "
          "VALUES (?, ?, ?, ?, ?, ?, ?, ?)")
      .Bind(RowId(tile.tile_id), Value(tile.payload_id), Value(tile.codebook_id),
            bounds.south_rad * kDegPerRad, bounds.west_rad * kDegPerRad,
            bounds.north_rad * kDegPerRad, bounds.east_rad * kDegPerRad, since)
      .Run();
  totals_.AddTile(tile);
  if (extents_) {
    extents_->coverage.Add(*EnvelopeOfGeometry(geometry));
  }
}

void HeadWriter::RetireTile(TileId tile_id) {
  const std::optional<TileRecord> tile = queries::FindTile(connection_, tile_id);
  if (!tile) {
    return;
  }
  connection_
      ->Prepare(
          "INSERT INTO cairn_past_tiles (tile_id, since, until, tile, payload_id, codebook_id, "
          "num_landmarks, num_descriptors, num_keyframes, num_bytes, min_h_m, max_h_m, "
          "landmarks_south_deg, landmarks_west_deg, landmarks_north_deg, landmarks_east_deg) "
          "SELECT c.tile_id, t.since, ?1, c.tile, t.payload_id, t.codebook_id, c.num_landmarks, "
          "c.num_descriptors, c.num_keyframes, c.num_bytes, c.min_h_m, c.max_h_m, "
          "t.landmarks_south_deg, t.landmarks_west_deg, t.landmarks_north_deg, "
          "t.landmarks_east_deg FROM cairn_tiles AS t JOIN coverage AS c ON c.tile_id = t.tile_id "
          "WHERE t.tile_id = ?2 AND t.since < ?1")
      .Bind(next_version_, RowId(tile_id))
      .Run();
  connection_->Prepare("DELETE FROM cairn_tiles WHERE tile_id = ?").Bind(RowId(tile_id)).Run();
  connection_->Prepare("DELETE FROM coverage WHERE tile_id = ?").Bind(RowId(tile_id)).Run();
  totals_.RemoveTile(*tile);
  if (extents_) {
    extents_->coverage.Remove(*EnvelopeOfGeometry(TileGeometry(tile_id)));
  }
  DropUnusedPayload(tile->payload_id);
}

int64_t HeadWriter::DropUnusedPayload(PayloadId payload_id) {
  db::Statement row = connection_->Prepare(
      "DELETE FROM cairn_payloads WHERE payload_id = ?1 "
      "AND NOT EXISTS (SELECT 1 FROM cairn_tiles WHERE payload_id = ?1) "
      "AND NOT EXISTS (SELECT 1 FROM cairn_past_tiles WHERE payload_id = ?1) "
      "RETURNING length(bytes)");
  return row.Bind(Value(payload_id)).Step() ? row.Int64(0) : 0;
}

CodebookId HeadWriter::StoreCodebook(const Codebook& codebook, CodebookId codebook_id) {
  const std::vector<uint8_t> bytes = EncodeCodebook(codebook);
  const std::string digest = ContentDigest(bytes);
  if (const CodebookId known = queries::FindCodebook(connection_, digest); known != CodebookId{}) {
    return known;
  }
  db::Statement inserted = connection_->Prepare(
      "INSERT INTO cairn_codebooks (codebook_id, created_at, digest, bytes) "
      "VALUES (nullif(?, 0), ?, ?, ?) RETURNING codebook_id");
  return CodebookId(InsertedId(inserted.Bind(Value(codebook_id), UtcNow(), digest, bytes)));
}

void HeadWriter::SetCurrentCodebook(CodebookId codebook_id) {
  connection_->Prepare("UPDATE cairn_map SET codebook_id = nullif(?, 0)")
      .Bind(Value(codebook_id))
      .Run();
}

void HeadWriter::AddVersion(const VersionNote& note) {
  if (!totals_.KnowsBounds()) {
    const std::optional<GeoBox>& outer = totals_.totals().bounds;
    totals_.SetBounds(outer ? BoundsWithin(connection_, *outer)
                            : queries::BoundsOfTiles(connection_));
  }
  queries::InsertVersion(connection_, MapVersion(next_version_), note, totals_.totals());
  if (extents_) {
    extents_->Write(connection_);
  }
}

void AddFirstVersion(db::Connection* connection) {
  connection
      ->Prepare(
          "INSERT INTO cairn_map (map_id, format_version, oldest_reader_version, created_at, "
          "next_landmark_id) VALUES (1, ?, ?, ?, 1)")
      .Bind(kMapFormatVersion, kOldestReaderVersion, UtcNow())
      .Run();
  queries::InsertVersion(connection, MapVersion(1), {.kind = VersionKind::kCreate}, MapTotals());
}

}  // namespace cairn
