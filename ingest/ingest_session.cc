#include "ingest/ingest_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "core/error.h"
#include "core/printable.h"
#include "core/require.h"
#include "ingest/tiling/build_tile.h"
#include "ingest/tiling/placed_session.h"
#include "ingest/tiling/tile_edit.h"
#include "ingest/write_tile.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

void Report(const IngestProgress& progress, const char* phase, int64_t done, int64_t total) {
  if (progress) progress(phase, done, total);
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

// Deletes the session's rows. Returns the tiles that still hold its content.
std::set<TileId> DetachSession(SessionId session_id, MapUpdate* update) {
  const std::vector<TileId> tiles = update->TilesOfSession(session_id);
  update->RemoveSession(session_id);
  return {tiles.begin(), tiles.end()};
}

std::vector<KeyframeId> AddKeyframes(const TileSource& source, TileId tile_id, MapUpdate* update) {
  std::vector<KeyframeId> ids;
  for (const int image_idx : source.session->images_of_tile.at(tile_id)) {
    const ReconImage& image = source.reconstruction->images[image_idx];
    KeyframeRecord record;
    record.session_id = source.session_id;
    record.tile_id = tile_id;
    record.image_name = image.name;
    record.camera = source.reconstruction->cameras[image.camera_idx];
    record.cam_from_ecef = source.session->cam_from_ecef[image_idx];
    ids.push_back(update->AddKeyframe(record));
  }
  return ids;
}

// Number of a tile's keyframes that see each landmark.
std::vector<int> CountKeyframes(const Tile& tile) {
  std::vector<int> counts(tile.num_landmarks(), 0);
  for (const uint32_t landmark_idx : tile.keyframe_landmarks) ++counts[landmark_idx];
  return counts;
}

// Observations over the whole reconstruction for landmarks of the session at hand. Of other
// sessions a tile knows only its own keyframes; they passed the selection's minimum when they came,
// so they count for at least that.
std::vector<int> CountObservations(const Tile& tile, const TileSource& source,
                                   const LandmarkSelectionOptions& options) {
  std::vector<int> counts = CountKeyframes(tile);
  const bool is_alone = std::all_of(tile.landmark_sessions.begin(), tile.landmark_sessions.end(),
                                    [&](SessionId id) { return id == source.session_id; });
  for (size_t i = 0; i < counts.size(); ++i) {
    if (is_alone) {
      const uint64_t placed_idx = Value(tile.landmark_ids[i]) - Value(source.first_landmark_id);
      const uint32_t recon_idx = source.session->landmarks[placed_idx].recon_idx;
      counts[i] = static_cast<int>(source.reconstruction->landmarks[recon_idx].observations.size());
    } else {
      counts[i] = std::max(counts[i], options.min_observations);
    }
  }
  return counts;
}

// The tile cut down to the budget.
Tile SelectLandmarks(const Tile& tile, const TileSource& source, const LandmarkSelector& selector,
                     const LandmarkSelectionOptions& options) {
  VisibilityGraph graph;
  graph.num_observations = CountObservations(tile, source, options);
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    const std::span<const uint32_t> landmarks = tile.LandmarksOfKeyframe(k);
    graph.landmarks_of_keyframe.emplace_back(landmarks.begin(), landmarks.end());
  }
  std::vector<int> num_descriptors(tile.num_landmarks());
  for (size_t i = 0; i < num_descriptors.size(); ++i) {
    num_descriptors[i] = static_cast<int>(tile.descriptor_begin[i + 1] - tile.descriptor_begin[i]);
  }
  return PickLandmarks(tile, selector.Select(graph, num_descriptors));
}

// A tile of the map without a session; nothing if the map has no such tile.
std::optional<Tile> LoadWithoutSession(TileId tile_id, SessionId without, const MapUpdate& update) {
  const std::optional<TileRecord> record = update.FindTile(tile_id);
  if (!record) return std::nullopt;
  const Tile tile = DecodeTile(update.LoadPayload(record->payload_id));
  return WithoutSession(tile, without);
}

// Replaces the content of `old_session` (which may be 0) in a tile by that of the session at hand.
void RewriteTile(const TileSource& source, TileId tile_id, SessionId old_session,
                 const IngestOptions& options, MapUpdate* update, IngestReport* report) {
  const Codebook& codebook = source.codec->codebook();
  Tile tile = LoadWithoutSession(tile_id, old_session, *update)
                  .value_or(EmptyTile(tile_id, codebook.id, codebook.num_subspaces));
  if (source.session->images_of_tile.contains(tile_id)) {
    if (tile.codebook_id != codebook.id) {
      throw Error(
          ErrorCode::kConflict,
          fmt::format("tile {} is coded with codebook {}, new sessions with {}; ingest into "
                      "a new map",
                      tile_id.ToString(), Value(tile.codebook_id), Value(codebook.id)));
    }
    AppendTile(BuildTile(source, tile_id, AddKeyframes(source, tile_id, update)), &tile);
    const auto selector = MakeLandmarkSelector(options.selection);
    tile = SelectLandmarks(tile, source, *selector, options.selection);
  }
  report->num_payload_bytes += WriteTile(tile, codebook, update);
  if (tile.num_landmarks() > 0) {
    ++report->num_tiles_written;
    report->num_landmarks_written += static_cast<int64_t>(tile.num_landmarks());
    report->num_descriptors_written += static_cast<int64_t>(tile.num_descriptors());
  }
}

SessionRecord MakeSessionRecord(const Reconstruction& reconstruction,
                                const IngestOptions& options) {
  SessionRecord record;
  record.name = options.session_name;
  record.source = options.source;
  record.num_images = static_cast<int64_t>(reconstruction.images.size());
  record.num_landmarks = static_cast<int64_t>(reconstruction.landmarks.size());
  record.georef_median_residual_m = options.georef_median_residual_m;
  return record;
}

}  // namespace

void IngestOptions::Validate() const {
  RequireOption(!session_name.empty(), "ingest.session_name must not be empty");
  RequireOption(max_sigma_m > 0.0, "ingest.max_sigma_m must be positive");
  RequireOption(max_reprojection_error_px > 0.0,
                "ingest.max_reprojection_error_px must be positive");
  RequireOption(std::isfinite(georef_median_residual_m),
                "ingest.georef_median_residual_m must be finite");
  codebook.Validate();
  selection.Validate();
  appearance.Validate();
}

IngestReport IngestSession(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                           const IngestOptions& options, MapStore* store,
                           const IngestProgress& progress) {
  options.Validate();
  reconstruction.Validate();
  const PlacedSession session =
      PlaceSession(reconstruction, ecef_from_world,
                   {.min_observations = options.selection.min_observations,
                    .max_sigma_m = options.max_sigma_m,
                    .max_reprojection_error_px = options.max_reprojection_error_px});
  std::shared_ptr<const Codebook> codebook =
      FindOrTrainCodebook(reconstruction, options, *store, progress);

  MapUpdate update = store->BeginUpdate();
  const DescriptorCodec codec(PublishCodebook(std::move(codebook), reconstruction, &update));
  const auto summarizer = MakeAppearanceSummarizer(options.appearance);
  IngestReport report;
  std::set<TileId> tiles;
  SessionId old_session{};
  if (const auto record = update.FindSession(options.session_name)) {
    old_session = record->id;
    tiles = DetachSession(old_session, &update);
    report.replaced_session = true;
  }
  for (const auto& [tile_id, images] : session.images_of_tile) tiles.insert(tile_id);

  TileSource source{&reconstruction, &session, &codec, summarizer.get(), {}, {}};
  source.session_id = update.AddSession(MakeSessionRecord(reconstruction, options));
  source.first_landmark_id = update.ReserveLandmarkIds(session.landmarks.size());
  int64_t num_done = 0;
  for (const TileId tile_id : tiles) {
    Report(progress, "tiles", num_done++, static_cast<int64_t>(tiles.size()));
    RewriteTile(source, tile_id, old_session, options, &update, &report);
  }
  Report(progress, "tiles", num_done, num_done);

  report.session_id = source.session_id;
  report.num_images = static_cast<int64_t>(reconstruction.images.size());
  report.num_landmarks_read = static_cast<int64_t>(reconstruction.landmarks.size());
  report.num_landmarks_dropped =
      report.num_landmarks_read - static_cast<int64_t>(session.landmarks.size());
  report.map_version = update.Publish(
      {.kind = report.replaced_session ? VersionKind::kReplace : VersionKind::kIngest,
       .session = options.session_name,
       .summary =
           fmt::format("{} images into {} tiles", report.num_images, report.num_tiles_written)});
  return report;
}

MapVersion RemoveSession(const std::string& session_name, MapStore* store) {
  MapUpdate update = store->BeginUpdate();
  const std::optional<SessionRecord> record = update.FindSession(session_name);
  if (!record) {
    throw Error(ErrorCode::kNotFound,
                fmt::format("{}: has no session '{}'", store->path(), Excerpt(session_name)));
  }
  const std::shared_ptr<const Codebook> codebook = update.CurrentCodebook();
  if (codebook == nullptr) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("{}: has sessions but no codebook", store->path()));
  }
  for (const TileId tile_id : DetachSession(record->id, &update)) {
    if (const auto tile = LoadWithoutSession(tile_id, record->id, update)) {
      WriteTile(*tile, *codebook, &update);
    }
  }
  return update.Publish({.kind = VersionKind::kRemove, .session = session_name});
}

}  // namespace cairn
