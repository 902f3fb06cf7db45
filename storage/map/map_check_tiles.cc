// The part of the check that decodes codebooks and payloads.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>

#include "core/error.h"
#include "core/geodesy.h"
#include "storage/map/describe_tile.h"
#include "storage/map/map_check.h"
#include "storage/map/map_queries.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

// Tolerances for values that another machine computed from the same numbers.
constexpr double kSlackRad = 1e-9;  // 6 mm on the ground.
constexpr double kSlackM = 0.01;

bool SameBounds(const GeoBox& a, const GeoBox& b) {
  const auto near = [](double x, double y) {
    return std::abs(std::remainder(x - y, 2.0 * std::numbers::pi)) <= kSlackRad;
  };
  return near(a.south_rad, b.south_rad) && near(a.west_rad, b.west_rad) &&
         near(a.north_rad, b.north_rad) && near(a.east_rad, b.east_rad);
}

// Compares the tables' record of a tile with its payload.
class TileCheck {
 public:
  TileCheck(sqlite::Connection* connection, const TileRecord& record, Findings* findings)
      : connection_(connection), record_(record), findings_(findings) {}

  void Run() {
    const Tile tile = DecodeTile(queries::LoadPayload(connection_, record_.payload_id));
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
      findings_->Add("tile " + record_.tile_id.ToString(), problem);
    }
  }

  void CheckCodebook(const Tile& tile) {
    Require(record_.codebook_id == queries::CurrentCodebookId(connection_),
            "it is coded with an outdated codebook, so queries cannot use it");
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
    sqlite::Statement next = connection_->Prepare("SELECT next_landmark_id FROM cairn_map");
    const uint64_t next_id = next.Step() ? static_cast<uint64_t>(next.Int64(0)) : 0;
    bool are_reserved = true;
    for (const LandmarkId id : tile.landmark_ids) {
      are_reserved = are_reserved && Value(id) >= 1 && Value(id) < next_id;
    }
    Require(are_reserved, "it has landmark ids that the map has not reserved");
    SessionId known{};
    bool have_sessions = true;
    for (const SessionId id : tile.landmark_sessions) {
      have_sessions = have_sessions && (id == known || HasSession(id));
      known = id;
    }
    Require(have_sessions, "it has landmarks of sessions that are not in the map");
  }

  bool HasSession(SessionId id) {
    return connection_->Prepare("SELECT 1 FROM cairn_sessions WHERE session_id = ?")
        .Bind(Value(id))
        .Step();
  }

  void CheckKeyframe(const TileKeyframe& keyframe, TileId tile_id) {
    std::optional<KeyframeRecord> row;
    try {
      row = queries::FindKeyframe(connection_, keyframe.id);
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

  sqlite::Connection* connection_;
  const TileRecord& record_;
  Findings* findings_;
};

}  // namespace

void CheckCodebooks(sqlite::Connection* connection, Findings* findings) {
  for (const CodebookId id : queries::CodebookIds(connection)) {
    try {
      queries::LoadCodebook(connection, id);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kMapDamaged) {
        throw;
      }
      findings->Add(fmt::format("codebook {}", Value(id)), error.what());
    }
  }
}

void CheckTile(sqlite::Connection* connection, int64_t tile_id, Findings* findings) {
  std::string name = std::to_string(tile_id);
  try {
    const TileId id = TileId::FromValue(static_cast<uint64_t>(tile_id));
    name = id.ToString();
    if (const std::optional<TileRecord> record = queries::FindTile(connection, id)) {
      TileCheck(connection, *record, findings).Run();
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kMapDamaged && error.code() != ErrorCode::kBadInput) {
      throw;
    }
    findings->Add("tile " + name, error.what());
  }
}

}  // namespace cairn
