#include "ingest/gate_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <vector>

#include "core/geodesy.h"
#include "core/printable.h"
#include "ingest/scratch_map.h"
#include "ingest/session_placement.h"
#include "ingest/write_tile.h"

namespace cairn {
namespace {

// The engine searches 50 m around a keyframe.
constexpr double kSearchReachM = 60.0;

std::vector<Eigen::Vector3d> PlacesOfPhotos(const SessionPlan& plan,
                                            const std::function<BuiltTile(size_t tile_idx)>& load) {
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

// The map around the keyframes as it would be.
ScratchMap MapWithSession(const SessionPlan& plan,
                          const std::function<BuiltTile(size_t tile_idx)>& load,
                          const std::vector<KeyframeRecord>& keyframes, const MapSnapshot& base) {
  ScratchMap scratch;
  MapUpdate update = scratch.store().BeginUpdate();
  const CodebookId codebook_id = update.AddCodebook(*plan.codebook, plan.codebook->id);
  std::set<TileId> planned;
  for (size_t i = 0; i < plan.tiles.size(); ++i) {
    planned.insert(plan.tiles[i].tile_id);
    if (IsNear(plan.tiles[i].tile_id, keyframes)) {
      PutTile(load(i).tile.encoded, &update);
    }
  }
  std::set<TileId> copied;
  for (const KeyframeRecord& keyframe : keyframes) {
    const Geodetic place = GeodeticFromEcef(keyframe.cam_from_ecef.Inverse().translation);
    for (const TileRecord& tile : base.FindTiles(BoxAround(place, kSearchReachM))) {
      if (tile.codebook_id == codebook_id && !planned.contains(tile.tile_id) &&
          copied.insert(tile.tile_id).second) {
        update.PutTile(tile, base.LoadPayload(tile.payload_id));
      }
    }
  }
  update.Publish({.kind = VersionKind::kExtract});
  return scratch;
}

KeyframeAnswers Ask(const SessionPlan& plan, const std::function<BuiltTile(size_t tile_idx)>& load,
                    const MapStore& store, int num_threads) {
  const MapSnapshot base = store.Snapshot();
  const std::vector<KeyframeRecord> keyframes =
      KeyframesNear(base, PlacesOfPhotos(plan, load), Sim3d(), plan.replaced_session);
  if (keyframes.empty()) {
    return {};
  }
  const ScratchMap scratch = MapWithSession(plan, load, keyframes, base);
  const MapSnapshot after = scratch.store().Snapshot();
  return AskKeyframes(keyframes, {&store, &base}, {&scratch.store(), &after}, Sim3d(), num_threads);
}

}  // namespace

KeyframeAnswers RequireKeyframes(const SessionPlan& plan,
                                 const std::function<BuiltTile(size_t tile_idx)>& load,
                                 const MapStore& store, int num_threads,
                                 const IngestProgress& progress) {
  if (plan.is_unchanged || plan.gate.max_lost_share >= 1.0) {
    return {};
  }
  ReportProgress(progress, "answers", 0, 1);
  const KeyframeAnswers answers = Ask(plan, load, store, num_threads);
  if (plan.options.joining == SessionJoining::kJoin) {
    RequireAnswers(answers, plan.gate, fmt::format("session '{}'", Excerpt(plan.session.name)));
  }
  ReportProgress(progress, "answers", 1, 1);
  return answers;
}

}  // namespace cairn
