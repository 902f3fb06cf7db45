#include "ingest/gate_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include "core/geodesy.h"
#include "core/printable.h"
#include "engine/tiles/map_tiles.h"
#include "ingest/session_placement.h"
#include "storage/tile/content_digest.h"

namespace cairn {
namespace {

// The engine searches 50 m around a keyframe.
constexpr double kSearchReachM = 60.0;

std::vector<Eigen::Vector3d> PlacesOfPhotos(const SessionPlan& plan, const LoadBuiltTile& load) {
  std::vector<Eigen::Vector3d> places;
  for (size_t i = 0; i < plan.tiles.size(); ++i) {
    for (const KeyframeRecord& keyframe : load(i).keyframes) {
      places.push_back(keyframe.cam_from_ecef.Inverse().translation);
    }
  }
  return places;
}

bool IsNear(TileId tile_id, const std::vector<KeyframeRecord>& keyframes) {
  constexpr double kTileRadiusM = 0.71 * TileId::kSideM;
  const Geodetic anchor = tile_id.Anchor();
  return std::any_of(keyframes.begin(), keyframes.end(), [&](const KeyframeRecord& keyframe) {
    return GroundDistanceM(anchor,
                           GeodeticFromEcef(keyframe.cam_from_ecef.Inverse().translation)) <=
           kTileRadiusM + kSearchReachM;
  });
}

// The map around the keyframes as it would be: tiles of the plan, and of the map where the plan
// changes nothing.
class TilesWithSession : public MapTiles {
 public:
  TilesWithSession(const SessionPlan& plan, const LoadBuiltTile& load,
                   const std::vector<KeyframeRecord>& keyframes, const RememberedTiles& base)
      : plan_(plan), load_(load), base_(base) {
    for (size_t i = 0; i < plan.tiles.size(); ++i) {
      const TileId tile_id = plan.tiles[i].tile_id;
      BuiltHere& planned = planned_[tile_id];
      planned.plan_idx = i;
      if (IsNear(tile_id, keyframes)) {
        const EncodedTile built = load(i).tile.encoded;
        planned.is_there = !built.payload.empty();
        planned.record = built.record;
        planned.record.digest = ContentDigest(built.payload);
        planned.bounds = tile_id.Bounds();
      }
    }
  }

  std::shared_ptr<const Codebook> CurrentCodebook() const override { return plan_.codebook; }

  std::vector<TileRecord> FindTiles(const GeoBox& box) const override {
    std::vector<TileRecord> tiles;
    for (TileRecord& record : base_.FindTiles(box)) {
      if (record.codebook_id == plan_.codebook->id && !planned_.contains(record.tile_id)) {
        tiles.push_back(std::move(record));
      }
    }
    for (const auto& [tile_id, planned] : planned_) {
      if (planned.is_there && planned.bounds.south_rad <= box.north_rad &&
          planned.bounds.north_rad >= box.south_rad) {
        tiles.push_back(planned.record);
      }
    }
    std::ranges::sort(tiles, {}, &TileRecord::tile_id);
    return tiles;
  }

  StoredTile LoadTile(const TileRecord& record) const override {
    const auto planned = planned_.find(record.tile_id);
    if (planned == planned_.end()) {
      return base_.LoadTile(record);
    }
    StoredTile tile;
    tile.decoded = base_.memory()->Decoded(record.digest, [&] {
      const std::vector<uint8_t> payload = load_(planned->second.plan_idx).tile.encoded.payload;
      return LargeVector<uint8_t>(payload.begin(), payload.end());
    });
    return tile;
  }

 private:
  struct BuiltHere {
    size_t plan_idx = 0;
    bool is_there = false;  // Near the keyframes, and not empty.
    TileRecord record;
    GeoBox bounds;
  };

  const SessionPlan& plan_;
  const LoadBuiltTile& load_;
  const RememberedTiles& base_;
  std::map<TileId, BuiltHere> planned_;
};

KeyframeAnswers Ask(const SessionPlan& plan, const LoadBuiltTile& load, const MapStore& store,
                    const std::shared_ptr<TileMemory>& memory, int num_threads) {
  const MapSnapshot snapshot = store.Snapshot();
  const std::vector<KeyframeRecord> keyframes =
      KeyframesNear(snapshot, PlacesOfPhotos(plan, load), Sim3d(), plan.replaced_session);
  if (keyframes.empty()) {
    return {};
  }
  const RememberedTiles base(snapshot, memory);
  return AskKeyframes(keyframes, base, TilesWithSession(plan, load, keyframes, base), Sim3d(),
                      num_threads);
}

}  // namespace

bool AsksKeyframes(const SessionPlan& plan) {
  return !plan.is_unchanged && !plan.adds_codebook && plan.gate.max_lost_share < 1.0;
}

KeyframeAnswers RequireKeyframes(const SessionPlan& plan, const LoadBuiltTile& load,
                                 const MapStore& store, const std::shared_ptr<TileMemory>& memory,
                                 int num_threads, const IngestProgress& progress) {
  if (!AsksKeyframes(plan)) {
    return {};
  }
  ReportProgress(progress, "answers", 0, 1);
  const KeyframeAnswers answers = Ask(plan, load, store, memory, num_threads);
  if (plan.options.joining == SessionJoining::kJoin) {
    RequireAnswers(answers, plan.gate, fmt::format("session '{}'", Excerpt(plan.session.name)));
  }
  ReportProgress(progress, "answers", 1, 1);
  return answers;
}

}  // namespace cairn
