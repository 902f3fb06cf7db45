#include "ingest/ingest_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/merging/link_landmarks.h"
#include "ingest/scratch_map.h"
#include "ingest/session_digest.h"
#include "ingest/session_placement.h"
#include "ingest/tiling/build_tile.h"
#include "ingest/tiling/placed_session.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

void Report(const IngestProgress& progress, const char* phase, int64_t done, int64_t total) {
  if (progress) {
    progress(phase, done, total);
  }
}

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

// The map's codebook, or a new one (id 0) if the map has none.
std::shared_ptr<const Codebook> FindOrTrainCodebook(const Reconstruction& reconstruction,
                                                    const IngestOptions& options,
                                                    const MapStore& store,
                                                    const IngestProgress& progress) {
  std::shared_ptr<const Codebook> codebook = store.Snapshot().CurrentCodebook();
  if (codebook == nullptr) {
    Report(progress, "codebook", 0, 1);
    codebook = std::make_shared<const Codebook>(TrainCodebook(reconstruction, options.codebook));
    Report(progress, "codebook", 1, 1);
  }
  RequireFits(*codebook, reconstruction);
  return codebook;
}

// The map's codebook if it has got one by now, else `trained`, added to the map.
std::shared_ptr<const Codebook> PublishCodebook(std::shared_ptr<const Codebook> trained,
                                                const Reconstruction& reconstruction,
                                                MapUpdate* update) {
  if (std::shared_ptr<const Codebook> current = update->CurrentCodebook()) {
    RequireFits(*current, reconstruction);
    return current;
  }
  Codebook codebook = *trained;
  codebook.id = update->AddCodebook(codebook);
  return std::make_shared<const Codebook>(std::move(codebook));
}

// The session of this name that the map holds. Throws if another one has the same content, unless
// the session is to be kept apart.
std::optional<SessionRecord> FindSameSession(const std::string& digest,
                                             const IngestOptions& options,
                                             const MapUpdate& update) {
  const std::string content = digest.substr(0, kContentDigestSize);
  for (const SessionRecord& session : update.Sessions()) {
    if (options.joining == SessionJoining::kJoin && session.name != options.session_name &&
        session.content_digest.starts_with(content)) {
      throw Error(
          ErrorCode::kConflict,
          fmt::format("the map has the same reconstruction as session '{}'; keep it apart from "
                      "what the map knows (--apart) if it belongs there twice",
                      Excerpt(session.name)));
    }
  }
  return update.FindSession(options.session_name);
}

// What the map says about where the session stands. A session that is to be replaced has no say.
MapComparison Compare(const Reconstruction& reconstruction, const PlacedSession& session,
                      const std::optional<SessionRecord>& replaced, const IngestOptions& options,
                      const MapUpdate& update, const MapStore& store) {
  if (options.joining == SessionJoining::kApart) {
    return {};
  }
  if (!replaced) {
    return CompareWithMap(reconstruction, session, store, options.comparison);
  }
  const ScratchMap others = MapWithoutSession(session, replaced->id, update, store);
  return CompareWithMap(reconstruction, session, others.store(), options.comparison);
}

// Links of all landmarks of the session to those of the map, tile by tile.
std::vector<LandmarkId> LinkSession(const Reconstruction& reconstruction,
                                    const PlacedSession& session, SessionId replaced,
                                    const DescriptorCodec& codec, const IngestOptions& options,
                                    const MapUpdate& update, const IngestProgress& progress) {
  std::vector<LinkProposal> proposals;
  if (options.joining == SessionJoining::kJoin) {
    int64_t num_done = 0;
    const auto num_tiles = static_cast<int64_t>(session.images_of_tile.size());
    for (const auto& [tile_id, images] : session.images_of_tile) {
      Report(progress, "links", num_done++, num_tiles);
      const std::optional<Tile> known = LoadWithoutSession(tile_id, replaced, update);
      if (!known || known->codebook_id != codec.codebook().id) {
        continue;
      }
      const std::vector<LinkProposal> of_tile =
          ProposeLinks(reconstruction, session, *known, codec, options.upkeep.linking);
      proposals.insert(proposals.end(), of_tile.begin(), of_tile.end());
    }
  }
  return ResolveLinks(reconstruction, session, std::move(proposals));
}

// Gives new ids to landmarks without a link. Returns the first of them.
LandmarkId NumberNewLandmarks(std::vector<LandmarkId>* ids, MapUpdate* update) {
  const auto num_new = std::count(ids->begin(), ids->end(), LandmarkId{});
  const LandmarkId first = update->ReserveLandmarkIds(static_cast<uint64_t>(num_new));
  uint64_t next = Value(first);
  for (LandmarkId& id : *ids) {
    if (id == LandmarkId{}) {
      id = LandmarkId(next++);
    }
  }
  return first;
}

std::vector<LandmarkId> IdsInReconstruction(const Reconstruction& reconstruction,
                                            const PlacedSession& session,
                                            const std::vector<LandmarkId>& ids) {
  std::vector<LandmarkId> in_reconstruction(reconstruction.landmarks.size(), LandmarkId{});
  for (size_t i = 0; i < ids.size(); ++i) {
    in_reconstruction[session.landmarks[i].recon_idx] = ids[i];
  }
  return in_reconstruction;
}

// Deletes the session's rows. Returns the tiles that still hold its content.
std::set<TileId> DetachSession(const std::optional<SessionRecord>& session, MapUpdate* update) {
  if (!session) {
    return {};
  }
  const std::vector<TileId> tiles = update->TilesOfSession(session->id);
  update->RemoveSession(session->id);
  return {tiles.begin(), tiles.end()};
}

SessionRecord MakeSessionRecord(const Reconstruction& reconstruction, const std::string& digest,
                                const IngestOptions& options) {
  SessionRecord record;
  record.name = options.session_name;
  record.source = options.source;
  record.recorded_at = options.recorded_at;
  record.content_digest = digest;
  record.num_images = static_cast<int64_t>(reconstruction.images.size());
  record.num_landmarks = static_cast<int64_t>(reconstruction.landmarks.size());
  record.georef_median_residual_m = options.georef_median_residual_m;
  return record;
}

void CountTile(const Tile& tile, const TileChanges& changes, IngestReport* report) {
  report->changes.Add(changes);
  report->num_payload_bytes += changes.num_bytes_after;
  if (tile.num_landmarks() > 0) {
    ++report->num_tiles_written;
    report->num_landmarks_written += static_cast<int64_t>(tile.num_landmarks());
    report->num_descriptors_written += static_cast<int64_t>(tile.num_descriptors());
  }
}

std::string SummaryOf(const IngestReport& report) {
  return fmt::format("{} images into {} tiles: {} landmarks merged, {} new, {} faded, {} evicted",
                     report.num_images, report.num_tiles_written, report.changes.num_merged,
                     report.changes.num_new, report.changes.num_faded, report.changes.num_evicted);
}

// Rewrites the tiles in which the session stands and those in which the replaced one stood.
void RewriteTiles(const TileRewriteContext& context, std::set<TileId> tiles,
                  const IngestProgress& progress, MapUpdate* update, IngestReport* report) {
  for (const auto& [tile_id, images] : context.source->session->images_of_tile) {
    tiles.insert(tile_id);
  }
  const auto num_tiles = static_cast<int64_t>(tiles.size());
  int64_t num_done = 0;
  for (const TileId tile_id : tiles) {
    Report(progress, "tiles", num_done++, num_tiles);
    Tile written;
    const TileChanges changes = RewriteTile(context, tile_id, update, &written);
    CountTile(written, changes, report);
  }
  Report(progress, "tiles", num_tiles, num_tiles);
}

}  // namespace

IngestReport IngestSession(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                           const IngestOptions& options, MapStore* store,
                           const IngestProgress& progress) {
  options.Validate();
  reconstruction.Validate();
  const PlacedSession placed =
      PlaceSession(reconstruction, ecef_from_world,
                   {.min_observations = options.selection.min_observations,
                    .max_sigma_m = options.max_sigma_m,
                    .max_reprojection_error_px = options.max_reprojection_error_px});
  const std::string digest = DigestOf(reconstruction) + DigestOf(ecef_from_world, options);
  std::shared_ptr<const Codebook> trained =
      FindOrTrainCodebook(reconstruction, options, *store, progress);

  MapUpdate update = store->BeginUpdate();
  IngestReport report;
  report.num_images = static_cast<int64_t>(reconstruction.images.size());
  report.num_landmarks_read = static_cast<int64_t>(reconstruction.landmarks.size());
  report.num_landmarks_dropped =
      report.num_landmarks_read - static_cast<int64_t>(placed.landmarks.size());
  const std::optional<SessionRecord> same = FindSameSession(digest, options, update);
  if (same && same->content_digest == digest) {
    report.session_id = same->id;
    report.map_version = store->Snapshot().version();
    report.is_unchanged = true;
    return report;
  }

  const DescriptorCodec codec(PublishCodebook(std::move(trained), reconstruction, &update));
  const SessionId replaced = same ? same->id : SessionId{};
  report.replaced_session = same.has_value();
  Report(progress, "comparison", 0, 1);
  report.comparison = Compare(reconstruction, placed, same, options, update, *store);
  RequireAgreement(report.comparison, options);
  const PlacedSession settled = SettleSession(placed, report.comparison, reconstruction);
  std::vector<LandmarkId> ids =
      LinkSession(reconstruction, settled, replaced, codec, options, update, progress);
  const PlacedSession joined = JoinLinked(settled, &ids);
  report.first_new_landmark = NumberNewLandmarks(&ids, &update);
  report.landmark_ids = IdsInReconstruction(reconstruction, joined, ids);

  const std::set<TileId> stale_tiles = DetachSession(same, &update);
  report.session_id = update.AddSession(MakeSessionRecord(reconstruction, digest, options));
  const auto summarizer = MakeAppearanceSummarizer(options.appearance);
  const auto selector = MakeLandmarkSelector(options.selection);
  const SessionTimes times = TimesOf(update.Sessions());
  const TileSource source{&reconstruction,  &joined,           &codec,
                          summarizer.get(), report.session_id, ids};
  RewriteTiles({&options, &source, selector.get(), replaced, &times}, stale_tiles, progress,
               &update, &report);
  report.map_version = update.Publish(
      {.kind = report.replaced_session ? VersionKind::kReplace : VersionKind::kIngest,
       .session = options.session_name,
       .summary = SummaryOf(report)});
  return report;
}

}  // namespace cairn
