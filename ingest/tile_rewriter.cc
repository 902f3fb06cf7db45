#include "ingest/tile_rewriter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "core/error.h"
#include "ingest/merging/admit_landmarks.h"
#include "ingest/merging/merge_tiles.h"
#include "ingest/merging/viewpoints.h"
#include "ingest/tiling/tile_edit.h"
#include "ingest/write_tile.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

// The session's keyframes of a tile, with the cameras that took them.
struct SessionKeyframes {
  std::vector<KeyframeId> ids;
  std::map<KeyframeId, const Camera*> cameras;
};

SessionKeyframes AddKeyframes(const TileSource& source, TileId tile_id, MapUpdate* update) {
  SessionKeyframes keyframes;
  for (const int image_idx : source.session->images_of_tile.at(tile_id)) {
    const ReconImage& image = source.reconstruction->images[image_idx];
    KeyframeRecord record;
    record.session_id = source.session_id;
    record.tile_id = tile_id;
    record.image_name = image.name;
    record.camera = source.reconstruction->cameras[image.camera_idx];
    record.cam_from_ecef = source.session->cam_from_ecef[image_idx];
    keyframes.ids.push_back(update->AddKeyframe(record));
    keyframes.cameras[keyframes.ids.back()] = &source.reconstruction->cameras[image.camera_idx];
  }
  return keyframes;
}

// The landmarks of the session that the tile takes.
Tile Admit(const Tile& known, const Tile& fresh, const IngestOptions& options,
           TileChanges* changes) {
  std::set<LandmarkId> known_ids(known.landmark_ids.begin(), known.landmark_ids.end());
  const auto num_merged = std::count_if(fresh.landmark_ids.begin(), fresh.landmark_ids.end(),
                                        [&](LandmarkId id) { return known_ids.contains(id); });
  Tile admitted = fresh;
  if (options.joining == SessionJoining::kJoin && known.num_landmarks() > 0) {
    admitted = PickLandmarks(fresh, AdmitLandmarks(known, fresh, options.upkeep.enough_landmarks));
  }
  changes->num_merged += num_merged;
  changes->num_new += static_cast<int64_t>(admitted.num_landmarks()) - num_merged;
  changes->num_not_needed += static_cast<int64_t>(fresh.num_landmarks() - admitted.num_landmarks());
  return admitted;
}

// The tile without landmarks that probably exist no more.
Tile Fade(const Tile& tile, const TileRewriteContext& context, TileChanges* changes) {
  const UpkeepOptions& upkeep = context.options->upkeep;
  std::vector<uint32_t> existing;
  for (uint32_t i = 0; i < tile.num_landmarks(); ++i) {
    if (ExistenceProbability(tile.SightingsOf(i), *context.session_times, upkeep.persistence) >=
        upkeep.least_existence) {
      existing.push_back(i);
    }
  }
  changes->num_faded += static_cast<int64_t>(tile.num_landmarks() - existing.size());
  return existing.size() == tile.num_landmarks() ? tile : PickLandmarks(tile, existing);
}

// The tile without keyframes that newer ones replace.
Tile ReplaceKeyframes(const Tile& tile, const TileRewriteContext& context, MapUpdate* update,
                      TileChanges* changes) {
  const std::vector<KeyframeId> replaced =
      ReplacedKeyframes(tile, context.options->upkeep.viewpoints);
  for (const KeyframeId id : replaced) {
    update->RemoveKeyframe(id);
  }
  changes->num_keyframes_replaced += static_cast<int64_t>(replaced.size());
  const std::set<KeyframeId> gone(replaced.begin(), replaced.end());
  return PickKeyframes(tile,
                       [&](const TileKeyframe& keyframe) { return !gone.contains(keyframe.id); });
}

// Observations over the whole reconstruction, for landmarks that only the session at hand has seen;
// for others the sights that a session like those so far can expect, at least the selection's
// minimum.
std::vector<double> RateLandmarks(const Tile& tile, const TileRewriteContext& context) {
  const TileSource& source = *context.source;
  std::map<LandmarkId, uint32_t> recon_idx;
  for (size_t i = 0; i < source.landmark_ids.size(); ++i) {
    recon_idx[source.landmark_ids[i]] = source.session->landmarks[i].recon_idx;
  }
  const bool is_alone = std::all_of(
      tile.sightings.begin(), tile.sightings.end(),
      [&](const LandmarkSighting& sighting) { return sighting.session_id == source.session_id; });
  std::vector<double> rates(tile.num_landmarks());
  for (size_t i = 0; i < rates.size(); ++i) {
    if (is_alone) {
      const uint32_t idx = recon_idx.at(tile.landmark_ids[i]);
      rates[i] = static_cast<double>(source.reconstruction->landmarks[idx].observations.size());
    } else {
      rates[i] = std::max<double>(context.options->selection.min_observations,
                                  ExpectedSights(tile.SightingsOf(i), *context.session_times,
                                                 context.options->upkeep.persistence));
    }
  }
  return rates;
}

// The tile cut down to its budget.
Tile Select(const Tile& tile, const TileRewriteContext& context, TileChanges* changes) {
  VisibilityGraph graph;
  graph.num_observations = RateLandmarks(tile, context);
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    const std::span<const uint32_t> landmarks = tile.LandmarksOfKeyframe(k);
    graph.landmarks_of_keyframe.emplace_back(landmarks.begin(), landmarks.end());
  }
  std::vector<int> num_descriptors(tile.num_landmarks());
  for (size_t i = 0; i < num_descriptors.size(); ++i) {
    num_descriptors[i] = static_cast<int>(tile.descriptor_begin[i + 1] - tile.descriptor_begin[i]);
  }
  const std::vector<uint32_t> selection = context.selector->Select(graph, num_descriptors);
  changes->num_evicted += static_cast<int64_t>(tile.num_landmarks() - selection.size());
  return PickLandmarks(tile, selection);
}

// The tile with the session in it, before selection.
Tile JoinSession(const Tile& known, const TileRewriteContext& context, TileId tile_id,
                 MapUpdate* update, TileChanges* changes) {
  const TileSource& source = *context.source;
  const SessionKeyframes keyframes = AddKeyframes(source, tile_id, update);
  const Tile fresh = BuildTile(source, tile_id, keyframes.ids);
  const Tile admitted = Admit(known, fresh, *context.options, changes);
  Tile tile = MergeTiles(known, admitted, *source.codec, *source.summarizer,
                         context.options->upkeep.merging);
  if (context.options->joining == SessionJoining::kApart || known.num_landmarks() == 0) {
    return tile;
  }
  NoteChances(
      CountChances(tile, source.session_id, keyframes.cameras, context.options->upkeep.viewpoints),
      source.session_id, &tile);
  tile = Fade(tile, context, changes);
  return ReplaceKeyframes(tile, context, update, changes);
}

}  // namespace

void TileChanges::Add(const TileChanges& other) {
  num_merged += other.num_merged;
  num_new += other.num_new;
  num_not_needed += other.num_not_needed;
  num_faded += other.num_faded;
  num_evicted += other.num_evicted;
  num_keyframes_replaced += other.num_keyframes_replaced;
  num_bytes_before += other.num_bytes_before;
  num_bytes_after += other.num_bytes_after;
}

std::optional<Tile> LoadWithoutSession(TileId tile_id, SessionId without, const MapUpdate& update) {
  const std::optional<TileRecord> record = update.FindTile(tile_id);
  if (!record) {
    return std::nullopt;
  }
  Tile tile = DecodeTile(update.LoadPayload(record->payload_id));
  return without == SessionId{} ? tile : WithoutSession(std::move(tile), without);
}

TileChanges RewriteTile(const TileRewriteContext& context, TileId tile_id, MapUpdate* update,
                        Tile* written) {
  TileChanges changes;
  const Codebook& codebook = context.source->codec->codebook();
  if (const auto record = update->FindTile(tile_id)) {
    changes.num_bytes_before = record->num_bytes;
  }
  Tile tile = LoadWithoutSession(tile_id, context.replaced_session, *update)
                  .value_or(EmptyTile(tile_id, codebook.id, codebook.num_subspaces));
  if (context.source->session->images_of_tile.contains(tile_id)) {
    if (tile.codebook_id != codebook.id) {
      throw Error(
          ErrorCode::kConflict,
          fmt::format("tile {} is coded with codebook {}, new sessions with {}; ingest into "
                      "a new map",
                      tile_id.ToString(), Value(tile.codebook_id), Value(codebook.id)));
    }
    tile = JoinSession(tile, context, tile_id, update, &changes);
    tile = Select(tile, context, &changes);
  }
  changes.num_bytes_after = WriteTile(tile, codebook, update);
  *written = std::move(tile);
  return changes;
}

}  // namespace cairn
