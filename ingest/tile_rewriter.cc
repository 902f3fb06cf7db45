#include "ingest/tile_rewriter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/error.h"
#include "ingest/merging/admit_landmarks.h"
#include "ingest/merging/merge_tiles.h"
#include "ingest/merging/place_budget.h"
#include "ingest/merging/viewpoints.h"
#include "ingest/tiling/tile_edit.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

// Each round comes within some percent of the wanted bytes.
constexpr int kMaxSelectionRounds = 6;

// The cameras that took the session's keyframes of a tile.
std::map<KeyframeId, const Camera*> CamerasOf(const TileSource& source, TileId tile_id,
                                              const std::vector<KeyframeId>& keyframe_ids) {
  std::map<KeyframeId, const Camera*> cameras;
  const std::vector<int>& images = source.session->images_of_tile.at(tile_id);
  for (size_t k = 0; k < images.size(); ++k) {
    const ReconImage& image = source.reconstruction->images[images[k]];
    cameras[keyframe_ids[k]] = &source.reconstruction->cameras[image.camera_idx];
  }
  return cameras;
}

// The landmarks of the session that the tile takes.
Tile Admit(const Tile& known, const Tile& fresh, const TileOptions& options, TileChanges* changes) {
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
Tile ReplaceKeyframes(const Tile& tile, const TileRewriteContext& context,
                      RewrittenTile* rewritten) {
  const std::vector<KeyframeId> replaced =
      ReplacedKeyframes(tile, context.options->upkeep.viewpoints);
  rewritten->replaced_keyframes = replaced;
  rewritten->changes.num_keyframes_replaced += std::ssize(replaced);
  const std::set<KeyframeId> gone(replaced.begin(), replaced.end());
  return PickKeyframes(tile,
                       [&](const TileKeyframe& keyframe) { return !gone.contains(keyframe.id); });
}

// Observations over the whole reconstruction, for landmarks that only the session at hand has seen;
// for others the sights that a session like those so far can expect, above the selection's minimum,
// so that the selection refuses none.
std::vector<double> RateLandmarks(const Tile& tile, const TileRewriteContext& context) {
  const TileSource& source = *context.source;
  std::map<LandmarkId, uint32_t> num_observations;
  for (size_t i = 0; i < source.landmark_ids.size(); ++i) {
    num_observations[source.landmark_ids[i]] = source.session->landmarks[i].num_observations;
  }
  const bool is_alone = std::all_of(
      tile.sightings.begin(), tile.sightings.end(),
      [&](const LandmarkSighting& sighting) { return sighting.session_id == source.session_id; });
  std::vector<double> rates(tile.num_landmarks());
  for (size_t i = 0; i < rates.size(); ++i) {
    if (is_alone) {
      rates[i] = num_observations.at(tile.landmark_ids[i]);
    } else {
      rates[i] = context.options->selection.min_observations +
                 ExpectedSights(tile.SightingsOf(i), *context.session_times,
                                context.options->upkeep.persistence);
    }
  }
  return rates;
}

// Reduces the budget of a selection that makes a tile of `bytes`, so that the tile gets to
// `max_bytes`. Keyframes stay whatever the budget is.
void ReduceBudget(const Tile& selected, int64_t bytes, int64_t max_bytes,
                  LandmarkSelectionOptions* options) {
  const int64_t fixed = EstimateBytes(PickLandmarks(selected, {}));
  const double share = std::clamp(static_cast<double>(max_bytes - fixed) /
                                      static_cast<double>(std::max<int64_t>(1, bytes - fixed)),
                                  0.5, 1.0);
  const auto reduce = [&](size_t count) {
    return std::max<int64_t>(1, static_cast<int64_t>(share * static_cast<double>(count)) - 1);
  };
  options->max_descriptors = reduce(selected.num_descriptors());
  if (options->max_landmarks > 0) {
    options->max_landmarks = reduce(selected.num_landmarks());
  }
}

// The tile cut down to its budget, and to `max_bytes` if given.
Tile Select(const Tile& tile, std::optional<int64_t> max_bytes, const TileRewriteContext& context,
            TileChanges* changes) {
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
  LandmarkSelectionOptions options = context.options->selection;
  Tile selected = PickLandmarks(tile, context.selector->Select(graph, num_descriptors));
  for (int round = 0; max_bytes && round < kMaxSelectionRounds; ++round) {
    const int64_t bytes = EstimateBytes(selected);
    if (bytes <= *max_bytes) {
      break;
    }
    ReduceBudget(selected, bytes, *max_bytes, &options);
    const auto selector = MakeLandmarkSelector(options);
    selected = PickLandmarks(tile, selector->Select(graph, num_descriptors));
  }
  changes->num_evicted += static_cast<int64_t>(tile.num_landmarks() - selected.num_landmarks());
  return selected;
}

// The tile with the session in it.
Tile JoinSession(const Tile& known, const TileRewriteContext& context, TileId tile_id,
                 const std::vector<KeyframeId>& keyframe_ids, RewrittenTile* rewritten) {
  const TileSource& source = *context.source;
  const Tile fresh = BuildTile(source, tile_id, keyframe_ids);
  const Tile admitted = Admit(known, fresh, *context.options, &rewritten->changes);
  Tile tile = MergeTiles(known, admitted, *source.codec, *source.summarizer,
                         context.options->upkeep.merging);
  if (context.options->joining == SessionJoining::kApart || known.num_landmarks() == 0) {
    return Select(tile, std::nullopt, context, &rewritten->changes);
  }
  NoteChances(CountChances(tile, source.session_id, CamerasOf(source, tile_id, keyframe_ids),
                           context.options->upkeep.viewpoints),
              source.session_id, &tile);
  tile = Fade(tile, context, &rewritten->changes);
  tile = ReplaceKeyframes(tile, context, rewritten);
  return Select(tile, BytesOfPlace(known, admitted), context, &rewritten->changes);
}

// The tile that a payload holds, without a session.
Tile DecodeWithoutSession(std::span<const uint8_t> payload, SessionId without) {
  Tile tile = DecodeTile(payload);
  return without == SessionId{} ? tile : WithoutSession(std::move(tile), without);
}

template <typename Map>
std::optional<Tile> LoadFrom(const Map& map, TileId tile_id, SessionId without) {
  const std::optional<TileRecord> record = map.FindTile(tile_id);
  if (!record) {
    return std::nullopt;
  }
  return DecodeWithoutSession(map.LoadPayload(record->payload_id), without);
}

void RequireCodebook(const Tile& tile, CodebookId codebook_id) {
  if (tile.codebook_id != codebook_id) {
    throw Error(ErrorCode::kConflict,
                fmt::format("tile {} is coded with codebook {}, new sessions with {}; ingest into "
                            "a new map",
                            tile.id.ToString(), Value(tile.codebook_id), Value(codebook_id)));
  }
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
  return LoadFrom(update, tile_id, without);
}

std::optional<Tile> LoadWithoutSession(TileId tile_id, SessionId without, const MapSnapshot& map) {
  return LoadFrom(map, tile_id, without);
}

RewrittenTile RewriteTile(const TileRewriteContext& context, TileId tile_id,
                          std::span<const uint8_t> base,
                          const std::vector<KeyframeId>& keyframe_ids) {
  const Codebook& codebook = context.source->codec->codebook();
  RewrittenTile rewritten;
  Tile tile = base.empty() ? EmptyTile(tile_id, codebook.id, codebook.num_subspaces)
                           : DecodeWithoutSession(base, context.replaced_session);
  if (context.source->session->images_of_tile.contains(tile_id)) {
    RequireCodebook(tile, codebook.id);
    tile = JoinSession(tile, context, tile_id, keyframe_ids, &rewritten);
  }
  rewritten.encoded = EncodeForMap(tile, codebook);
  rewritten.changes.num_bytes_before = std::ssize(base);
  rewritten.changes.num_bytes_after = std::ssize(rewritten.encoded.payload);
  return rewritten;
}

}  // namespace cairn
