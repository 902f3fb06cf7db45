// The part of the check that decodes codebooks and payloads.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "core/angles.h"
#include "core/error.h"
#include "core/geodesy.h"
#include "storage/map/describe_tile.h"
#include "storage/map/internal/map_check.h"
#include "storage/map/internal/map_queries.h"
#include "storage/map/internal/version_queries.h"
#include "storage/tile/content_digest.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

// Tolerances for values that another machine computed from the same numbers.
constexpr double kBoundsSlackRad = 1e-9;  // 6 mm on the ground.
constexpr double kSlackM = 0.01;

// Compares the tables' record of a tile with its payload.
class TileCheck {
 public:
  // `version` is any version that has the tile.
  TileCheck(db::Connection* connection, const TileRecord& record, MapVersion version,
            std::string where, Findings* findings)
      : connection_(connection),
        record_(record),
        version_(version),
        where_(std::move(where)),
        findings_(findings) {}

  void Run() {
    const LargeVector<uint8_t> payload = queries::LoadPayload(connection_, record_.payload_id);
    const Tile tile = DecodeTile(payload);
    CheckDigest(payload);
    Require(tile.id == record_.tile_id, "its payload belongs to another tile");
    Require(tile.codebook_id == record_.codebook_id, "its payload names another codebook");
    CheckCodebook(tile);
    if (tile.num_landmarks() == 0 || tile.num_keyframes() == 0) {
      Require(false, "its payload is empty");
      return;
    }
    CheckRecord(DescribeTile(tile));
    CheckLandmarks(tile);
    for (const TileKeyframe& keyframe : tile.keyframes) {
      CheckKeyframe(keyframe, tile.id);
    }
  }

 private:
  void Require(bool condition, const char* problem) {
    if (!condition) {
      findings_->Add(where_, problem);
    }
  }

  void CheckDigest(std::span<const uint8_t> payload) {
    db::Statement row =
        connection_->Prepare("SELECT digest FROM cairn_payloads WHERE payload_id = ?");
    const bool is_digest =
        row.Bind(Value(record_.payload_id)).Step() && row.Text(0) == ContentDigest(payload);
    Require(is_digest, "its payload does not match its digest");
    Require(std::ssize(payload) == record_.num_bytes,
            "its payload does not have the size that the tables give");
  }

  void CheckCodebook(const Tile& tile) {
    Require(record_.codebook_id == queries::CodebookOfVersion(connection_, version_),
            "it is not coded with its version's codebook, so queries cannot use it");
    Require(
        queries::LoadCodebook(connection_, record_.codebook_id)->num_subspaces == tile.code_size,
        "its codes do not fit its codebook");
  }

  void CheckRecord(const TileRecord& of_payload) {
    Require(of_payload.num_landmarks == record_.num_landmarks &&
                of_payload.num_descriptors == record_.num_descriptors &&
                of_payload.num_keyframes == record_.num_keyframes,
            "its counts do not match its payload");
    Require(std::abs(of_payload.min_h_m - record_.min_h_m) <= kSlackM &&
                std::abs(of_payload.max_h_m - record_.max_h_m) <= kSlackM,
            "its heights do not match its keyframes");
    Require(SameBounds(of_payload.landmark_bounds, record_.landmark_bounds),
            "its landmark bounds do not match its landmarks");
  }

  void CheckLandmarks(const Tile& tile) {
    db::Statement next = connection_->Prepare("SELECT next_landmark_id FROM cairn_map");
    const uint64_t next_id = next.Step() ? static_cast<uint64_t>(next.Int64(0)) : 0;
    bool are_reserved = true;
    for (const LandmarkId id : tile.landmark_ids) {
      are_reserved = are_reserved && Value(id) >= 1 && Value(id) < next_id;
    }
    Require(are_reserved, "it has landmark ids that the map has not reserved");
    SessionId known{};
    bool have_sessions = true;
    for (const HistoryEntry& entry : tile.history) {
      const SessionId id = entry.session_id;
      have_sessions = have_sessions && (id == SessionId{} || id == known || HasSession(id));
      known = id;
    }
    Require(have_sessions, "it has landmarks of sessions that are not in the map");
  }

  bool HasSession(SessionId id) {
    return connection_
        ->Prepare(
            "SELECT 1 FROM cairn_sessions WHERE session_id = ?1 AND since <= ?2 UNION ALL "
            "SELECT 1 FROM cairn_past_sessions "
            "WHERE session_id = ?1 AND until > ?2 AND since = "
            "(SELECT max(since) FROM cairn_past_sessions WHERE session_id = ?1 AND since <= ?2)")
        .Bind(Value(id), Value(version_))
        .Step();
  }

  void CheckKeyframe(const TileKeyframe& keyframe, TileId tile_id) {
    std::optional<KeyframeRecord> row;
    try {
      row = queries::FindKeyframeOf(connection_, version_, keyframe.id);
    } catch (const Error&) {
      return;  // The check of the layers reports this.
    }
    Require(row.has_value(), "a keyframe of its payload is not in the map");
    if (!row) {
      return;
    }
    Require(row->tile_id == tile_id && row->session_id == keyframe.session_id,
            "a keyframe of its payload belongs to another tile or session");
    const Rigid3d difference =
        row->cam_from_ecef * EcefFromEnu(tile_id.Anchor()) * keyframe.cam_from_tile.Inverse();
    const double angle_rad = 2.0 * difference.rotation.vec().norm();
    Require(difference.translation.norm() <= kSlackM && angle_rad <= 1e-4,
            "a keyframe of its payload has a different pose in the map");
  }

  db::Connection* connection_;
  const TileRecord& record_;
  const MapVersion version_;
  const std::string where_;
  Findings* findings_;
};

}  // namespace

bool SameBounds(const GeoBox& a, const GeoBox& b) {
  const auto near = [](double x, double y) {
    return std::abs(std::remainder(x - y, 2.0 * kPi)) <= kBoundsSlackRad;
  };
  return near(a.south_rad, b.south_rad) && near(a.west_rad, b.west_rad) &&
         near(a.north_rad, b.north_rad) && near(a.east_rad, b.east_rad);
}

void CheckCodebooks(db::Connection* connection, Findings* findings) {
  for (const CodebookId id : queries::CodebookIds(connection)) {
    const std::string where = fmt::format("codebook {}", Value(id));
    findings->Run(where, [&] {
      if (queries::CodebookDigest(connection, id) !=
          ContentDigest(EncodeCodebook(*queries::LoadCodebook(connection, id)))) {
        findings->Add(where, "does not match its digest");
      }
    });
  }
}

void CheckTile(db::Connection* connection, int64_t tile_id, Findings* findings) {
  std::string where = "tile " + std::to_string(tile_id);
  findings->Run(where, [&] {
    const TileId id = TileId::FromValue(static_cast<uint64_t>(tile_id));
    where = "tile " + id.ToString();
    if (const std::optional<TileRecord> record = queries::FindTile(connection, id)) {
      TileCheck(connection, *record, queries::LatestVersion(connection), where, findings).Run();
    }
  });
}

void CheckPastTile(db::Connection* connection, const queries::PastTile& tile, Findings* findings) {
  const auto last = MapVersion(Value(tile.until) - 1);
  const std::string where =
      fmt::format("tile {} as of version {}", tile.tile.tile_id.ToString(), Value(last));
  findings->Run(where, [&] { TileCheck(connection, tile.tile, last, where, findings).Run(); });
}

}  // namespace cairn
