#include "ingest/plan_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "core/error.h"
#include "core/geodesy.h"
#include "core/printable.h"
#include "ingest/codebook/choose_codebook.h"
#include "ingest/place/in_map_accuracy.h"
#include "ingest/session_digest.h"
#include "ingest/session_placement.h"
#include "ingest/tile_rewriter.h"
#include "ingest/tiles/link_landmarks.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/map/utc_time.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

void RequireFits(const Codebook& codebook, const Reconstruction& reconstruction) {
  const int dim = reconstruction.descriptor_dim();
  if (codebook.descriptor_type != reconstruction.descriptor_type || codebook.raw_dim() != dim) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("the reconstruction has {}-D descriptors of type '{}', the map holds "
                            "{}-D ones of type '{}'; use the same extractor or a map of its own",
                            dim, reconstruction.descriptor_type, codebook.raw_dim(),
                            Excerpt(codebook.descriptor_type)));
  }
}

std::string RecordingTimeOf(const IngestOptions& options) {
  if (!options.recorded_at.empty()) {
    return options.recorded_at;
  }
  return options.now.empty() ? UtcNow() : options.now;
}

SessionRecord MakeSessionRecord(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                                const IngestOptions& options) {
  SessionRecord record;
  record.name = options.session_name;
  record.source = options.source;
  record.recorded_at = RecordingTimeOf(options);
  record.content_digest = DigestOf(reconstruction) + DigestOf(ecef_from_world, options) +
                          PhotosDigestOf(reconstruction);
  record.num_images = std::ssize(reconstruction.images);
  record.num_landmarks = std::ssize(reconstruction.landmarks);
  record.georef_median_residual_m = options.georef_median_residual_m;
  return record;
}

// Returns true if most photos of the session `known` have a photo of the same name here.
bool HasPhotosOf(const SessionRecord& known, const Reconstruction& reconstruction,
                 const MapSnapshot& base) {
  std::set<std::string> names;
  for (const ReconImage& image : reconstruction.images) {
    names.insert(image.name);
  }
  const std::vector<KeyframeRecord> keyframes = base.KeyframesOfSession(known.id);
  const auto num_known = std::ranges::count_if(keyframes, [&](const KeyframeRecord& keyframe) {
    return names.contains(keyframe.image_name);
  });
  return 2 * num_known > std::ssize(keyframes);
}

// Returns true if the keyframes of the session `known` have images of the sizes that they have
// here. Digests leave the sizes out. What a photo should see depends on them (CountChances).
bool HasSizesOf(const SessionRecord& known, const Reconstruction& reconstruction,
                const MapSnapshot& base) {
  std::map<std::string, const Camera*> camera_of_name;
  for (const ReconImage& image : reconstruction.images) {
    camera_of_name[image.name] = &reconstruction.cameras[image.camera_idx];
  }
  return std::ranges::all_of(base.KeyframesOfSession(known.id), [&](const auto& keyframe) {
    const auto found = camera_of_name.find(keyframe.image_name);
    return found == camera_of_name.end() ||
           (found->second->width_px() == keyframe.camera.width_px() &&
            found->second->height_px() == keyframe.camera.height_px());
  });
}

// The record of the session. If it was not said when the photos were taken, and the map has them
// already under this name, they were taken when the map says.
SessionRecord RecordOf(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                       const IngestOptions& options, const std::optional<SessionRecord>& known,
                       const MapSnapshot& base) {
  SessionRecord record = MakeSessionRecord(reconstruction, ecef_from_world, options);
  if (!known || !options.recorded_at.empty()) {
    return record;
  }
  if (AreOneIngest(record.content_digest, known->content_digest)) {
    record.recorded_at = known->recorded_at;
    return record;
  }
  if (!HasPhotosOf(*known, reconstruction, base)) {
    return record;
  }
  IngestOptions as_known = options;
  as_known.recorded_at = known->recorded_at;
  return MakeSessionRecord(reconstruction, ecef_from_world, as_known);
}

// Takes the map's codebook, or chooses one if the map has none. Its id stays 0 if it needs a new
// one.
void FindCodebook(const Reconstruction& reconstruction, const IngestOptions& options,
                  const MapSnapshot& base, const IngestProgress& progress, SessionPlan* plan) {
  plan->codebook = base.CurrentCodebook();
  if (plan->codebook == nullptr) {
    ReportProgress(progress, "codebook", 0, 1);
    auto chosen = std::make_shared<Codebook>(*ChooseCodebook(reconstruction, options.codebook));
    chosen->id = base.FindCodebook(*chosen);
    plan->codebook = std::move(chosen);
    plan->adds_codebook = true;
    ReportProgress(progress, "codebook", 1, 1);
  }
  RequireFits(*plan->codebook, reconstruction);
}

// What the map says about where the session stands. A session that is to be replaced has no say.
MapComparison Compare(const Reconstruction& reconstruction, const PlacedSession& session,
                      const IngestOptions& options, const KnownTiles& known) {
  if (options.joining == SessionJoining::kApart) {
    return {};
  }
  return CompareWithMap(reconstruction, session, known,
                        {.position_accuracy_m = options.agreement.position_accuracy_m,
                         .num_threads = options.num_threads});
}

// Links of all landmarks of the session to those of the map, tile by tile.
std::vector<LandmarkId> LinkSession(const Reconstruction& reconstruction,
                                    const PlacedSession& session, const SessionPlan& plan,
                                    const KnownTiles& map, const IngestProgress& progress) {
  std::vector<LinkProposal> proposals;
  if (plan.options.joining == SessionJoining::kJoin) {
    const DescriptorCodec codec(plan.codebook);
    int64_t num_done = 0;
    for (const auto& [tile_id, images] : session.images_of_tile) {
      ReportProgress(progress, "links", num_done++, std::ssize(session.images_of_tile));
      const std::shared_ptr<const Tile> known = map.Find(tile_id);
      if (known == nullptr || known->codebook_id != plan.codebook->id) {
        continue;
      }
      const std::vector<LinkProposal> of_tile =
          ProposeLinks(reconstruction, session, *known, codec, plan.options.upkeep.linking);
      proposals.insert(proposals.end(), of_tile.begin(), of_tile.end());
    }
  }
  return ResolveLinks(reconstruction, session, std::move(proposals));
}

// Where the map has the landmarks that `ids` name; empty for 0.
std::vector<std::optional<Eigen::Vector3d>> KnownPlaces(const PlacedSession& session,
                                                        const std::vector<LandmarkId>& ids,
                                                        const KnownTiles& map) {
  std::unordered_map<LandmarkId, Eigen::Vector3d> place_of_id;
  for (const auto& [tile_id, images] : session.images_of_tile) {
    if (const std::shared_ptr<const Tile> known = map.Find(tile_id)) {
      const Rigid3d ecef_from_tile = EcefFromEnu(tile_id.Anchor());
      for (size_t i = 0; i < known->num_landmarks(); ++i) {
        place_of_id.emplace(known->landmark_ids[i],
                            ecef_from_tile * known->x_in_tile[i].cast<double>());
      }
    }
  }
  std::vector<std::optional<Eigen::Vector3d>> places;
  for (const LandmarkId id : ids) {
    const auto found = place_of_id.find(id);
    places.push_back(found == place_of_id.end() ? std::nullopt : std::optional(found->second));
  }
  return places;
}

// Adjusts the session with the landmarks that it shares with the map.
void AdjustToMap(const Reconstruction& reconstruction, const IngestOptions& options,
                 const KnownTiles& map, const IngestProgress& progress, SessionPlan* plan,
                 PlacedSession* session) {
  if (options.fitting != SessionFitting::kAdjust || !IsAnchored(plan->comparison.anchoring) ||
      !IsJudged(plan->comparison)) {
    return;
  }
  const std::vector<LandmarkId> ids = LinkSession(reconstruction, *session, *plan, map, progress);
  plan->adjustment = AdjustSession(
      reconstruction, KnownPlaces(*session, ids, map), options.num_threads, session,
      [&](int done, int most) { ReportProgress(progress, "adjustment", done, most); });
  ReportProgress(progress, "adjustment", 1, 1);
  AssignTiles(reconstruction, session);
}

IdCounts CountNewIds(const SessionPlan& plan, const PlacedSession& session,
                     const std::vector<LandmarkId>& landmark_ids) {
  IdCounts counts;
  counts.num_codebooks = plan.codebook->id == CodebookId{} ? 1 : 0;
  counts.num_sessions = 1;
  for (const auto& [tile_id, images] : session.images_of_tile) {
    counts.num_keyframes += std::ssize(images);
  }
  counts.num_landmarks =
      static_cast<uint64_t>(std::count(landmark_ids.begin(), landmark_ids.end(), LandmarkId{}));
  return counts;
}

// Gives ids to the session, to the landmarks without a link and, if needed, to the codebook.
void NumberContent(const FirstIds& first, SessionPlan* plan,
                   std::vector<LandmarkId>* landmark_ids) {
  plan->first_ids = first;
  plan->session.id = first.session;
  if (plan->codebook->id == CodebookId{}) {
    auto numbered = std::make_shared<Codebook>(*plan->codebook);
    numbered->id = first.codebook;
    plan->codebook = std::move(numbered);
  }
  uint64_t next = Value(first.landmark);
  for (LandmarkId& id : *landmark_ids) {
    if (id == LandmarkId{}) {
      id = LandmarkId(next++);
    }
  }
}

// The tiles in which the session stands and those in which the replaced one stood.
std::vector<PlannedTile> PlanTiles(const PlacedSession& session, const SessionPlan& plan,
                                   const MapSnapshot& base) {
  std::set<TileId> tile_ids;
  if (plan.replaced_session != SessionId{}) {
    const std::vector<TileId> stale = base.TilesOfSession(plan.replaced_session);
    tile_ids.insert(stale.begin(), stale.end());
  }
  for (const auto& [tile_id, images] : session.images_of_tile) {
    tile_ids.insert(tile_id);
  }
  std::vector<PlannedTile> tiles;
  int64_t next_keyframe = Value(plan.first_ids.keyframe);
  for (const TileId tile_id : tile_ids) {
    PlannedTile tile;
    tile.tile_id = tile_id;
    tile.first_keyframe = KeyframeId(next_keyframe);
    if (const std::optional<TileRecord> known = base.FindTile(tile_id)) {
      tile.base_digest = known->digest;
      tile.work += known->num_landmarks;
    }
    if (const auto own = session.images_of_tile.find(tile_id);
        own != session.images_of_tile.end()) {
      tile.num_keyframes = std::ssize(own->second);
      for (const int image_idx : own->second) {
        tile.work += std::ssize(session.observations_of_image[image_idx]);
      }
    }
    next_keyframe += tile.num_keyframes;
    if (tile.num_keyframes > 0 || !tile.base_digest.empty()) {
      tiles.push_back(std::move(tile));
    }
  }
  return tiles;
}

std::vector<SessionRecord> OthersThan(SessionId session_id, std::vector<SessionRecord> sessions) {
  std::erase_if(sessions, [&](const SessionRecord& session) { return session.id == session_id; });
  return sessions;
}

SessionTimes TimesWith(const SessionPlan& plan, const std::vector<SessionRecord>& known) {
  std::vector<SessionRecord> sessions = OthersThan(plan.replaced_session, known);
  sessions.push_back(plan.session);
  return TimesOf(sessions);
}

// The accuracy of what the map has in the session's tiles; empty if the map does not know it.
std::optional<SessionAccuracy> AccuracyThere(const PlacedSession& session, SessionId replaced,
                                             const RememberedTiles& base) {
  std::set<SessionId> sessions;
  for (const auto& [tile_id, images] : session.images_of_tile) {
    if (const std::shared_ptr<const Tile> tile = base.Find(tile_id)) {
      sessions.merge(SessionsInTile(*tile));
    }
  }
  sessions.erase(replaced);
  return AccuracyOf(sessions, base.map());
}

// The accuracy of the session where it settled; empty if nobody knows how it was placed. A session
// that follows the map stands on Earth as the map does, and is as far off in the map as the two
// disagree.
std::optional<SessionAccuracy> AccuracyOf(const Reconstruction& reconstruction,
                                          const PlacedSession& settled, double scale,
                                          const SessionPlan& plan, const IngestOptions& options,
                                          const RememberedTiles& base) {
  if (options.earth_accuracy_m == 0.0) {
    return std::nullopt;
  }
  SessionAccuracy accuracy = {
      .in_map_m = EstimateInMapAccuracy(reconstruction, settled, scale).value_or(0.0),
      .on_earth_m = options.earth_accuracy_m,
      .on_earth_rad = options.earth_accuracy_rad};
  if (IsJudged(plan.comparison)) {
    accuracy.in_map_m = std::max(accuracy.in_map_m, plan.comparison.fit.disagreement_m);
    const auto there = AccuracyThere(settled, plan.replaced_session, base);
    if (there) {
      accuracy.on_earth_m = there->on_earth_m;
      accuracy.on_earth_rad = there->on_earth_rad;
    }
  }
  return accuracy;
}

// Compares the session with the map, moves and links it, and fills in the rest of the plan.
void SettleAndNumber(const PlacedSession& placed, double scale, const IngestOptions& options,
                     MapStore* store, const IngestProgress& progress, PlannedSession* planned) {
  const Reconstruction& reconstruction = *planned->reconstruction;
  const MapSnapshot& base = *planned->base;
  const KnownTiles& known = *planned->known;
  SessionPlan& plan = planned->plan;
  ReportProgress(progress, "comparison", 0, 1);
  plan.comparison = Compare(reconstruction, placed, options, known);
  RequireAgreement(plan.comparison, options.agreement,
                   AccuracyOf(plan.comparison, options.agreement.position_accuracy_m,
                              options.georef_median_residual_m,
                              OthersThan(plan.replaced_session, base.Sessions())),
                   fmt::format("session '{}'", Excerpt(plan.session.name)));
  PlacedSession settled = SettleSession(placed, reconstruction, &plan.comparison);
  AdjustToMap(reconstruction, options, known, progress, &plan, &settled);
  plan.session.accuracy = AccuracyOf(reconstruction, settled, scale, plan, options, known.stored());
  planned->landmark_ids = LinkSession(reconstruction, settled, plan, known, progress);
  planned->session = JoinLinked(settled, &planned->landmark_ids);
  plan.id_counts = CountNewIds(plan, planned->session, planned->landmark_ids);
  NumberContent(store->ReserveIds(plan.id_counts, options.patience), &plan, &planned->landmark_ids);
  plan.tiles = PlanTiles(planned->session, plan, base);
  plan.session_times = TimesWith(plan, base.Sessions());
}

}  // namespace

TileShard PlannedSession::Shard(size_t tile_idx) const {
  const PlannedTile& tile = plan.tiles[tile_idx];
  TileShard shard =
      CutShard(*reconstruction, session, landmark_ids, tile.tile_id, tile.first_keyframe);
  if (!tile.base_digest.empty()) {
    const std::optional<TileRecord> record = base->FindTile(tile.tile_id);
    shard.base = record ? base->LoadPayload(record->payload_id) : LargeVector<uint8_t>();
    if (shard.base.empty()) {
      throw Error(ErrorCode::kMapDamaged,
                  fmt::format("tile {} has no payload", tile.tile_id.ToString()));
    }
    shard.known = known->Find(tile.tile_id);
  }
  return shard;
}

PlannedSession PlanSession(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                           const IngestOptions& options, MapStore* store,
                           const IngestProgress& progress) {
  options.Validate();
  reconstruction.Validate();
  const PlacedSession placed = PlaceSession(reconstruction, ecef_from_world, PlacementOf(options));
  PlannedSession planned;
  planned.reconstruction = &reconstruction;
  planned.base = std::make_shared<const MapSnapshot>(store->Snapshot());
  SessionPlan& plan = planned.plan;
  plan.map_created_at = planned.base->Info().created_at;
  plan.base_version = planned.base->version();
  const std::optional<SessionRecord> same = planned.base->FindSession(options.session_name);
  plan.session = RecordOf(reconstruction, ecef_from_world, options, same, *planned.base);
  plan.options = options;
  plan.gate = options.gate;
  plan.num_landmarks_dropped = plan.session.num_landmarks - std::ssize(placed.landmarks);
  RequireNotElsewhere(plan.session, options.joining, planned.base->Sessions());
  if (same) {
    if (AreOneIngest(same->content_digest, plan.session.content_digest) &&
        HasSizesOf(*same, reconstruction, *planned.base)) {
      plan.session = *same;
      plan.is_unchanged = true;
      return planned;
    }
    plan.replaced_session = same->id;
  }
  WarnOfSharedPhotos(plan.session, planned.base->Sessions());
  FindCodebook(reconstruction, options, *planned.base, progress, &plan);
  planned.known = std::make_shared<const KnownTiles>(*planned.base, plan.replaced_session);
  SettleAndNumber(placed, ecef_from_world.scale, options, store, progress, &planned);
  return planned;
}

}  // namespace cairn
