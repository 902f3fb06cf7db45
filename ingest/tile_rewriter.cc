#include "ingest/tile_rewriter.h"

#include <fmt/format.h>

#include <map>
#include <utility>
#include <vector>

#include "core/error.h"
#include "ingest/join_tiles.h"
#include "ingest/tile_upkeep.h"
#include "ingest/tiles/tile_edit.h"
#include "ingest/tiles/viewpoints.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

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

// The session's own observations over the whole reconstruction.
std::vector<double> RateByObservations(const Tile& tile, const TileSource& source) {
  std::map<LandmarkId, uint32_t> num_observations;
  for (size_t i = 0; i < source.landmark_ids.size(); ++i) {
    num_observations[source.landmark_ids[i]] = source.session->landmarks[i].num_observations;
  }
  std::vector<double> rates(tile.num_landmarks());
  for (size_t i = 0; i < rates.size(); ++i) {
    rates[i] = num_observations.at(tile.landmark_ids[i]);
  }
  return rates;
}

// The tile with the session beside what it has.
JoinedTile AppendSession(const Tile& known, const Tile& fresh, const TileRewriteContext& context) {
  const TileOptions& options = *context.options;
  JoinedTile joined;
  Tile tile = known;
  AppendTile(fresh, &tile);
  joined.changes.num_new = static_cast<int64_t>(fresh.num_landmarks());
  joined.tile =
      SelectLandmarks(tile,
                      known.num_landmarks() == 0
                          ? RateByObservations(tile, *context.source)
                          : RateByHistory(tile, *context.session_times, options.upkeep.persistence,
                                          options.selection.min_observations),
                      std::nullopt, options.selection, *context.selector);
  joined.changes.num_evicted =
      static_cast<int64_t>(tile.num_landmarks() - joined.tile.num_landmarks());
  return joined;
}

// The tile with the session in it.
JoinedTile JoinSession(const Tile& known, const TileRewriteContext& context, TileId tile_id,
                       const std::vector<KeyframeId>& keyframe_ids) {
  const TileSource& source = *context.source;
  const TileOptions& options = *context.options;
  const Tile fresh = BuildTile(source, tile_id, keyframe_ids);
  if (options.joining == SessionJoining::kApart || known.num_landmarks() == 0) {
    return AppendSession(known, fresh, context);
  }
  const auto note_chances = [&](Tile* tile) {
    NoteChances(CountChances(*tile, source.session_id, CamerasOf(source, tile_id, keyframe_ids),
                             options.upkeep.viewpoints),
                source.session_id, tile);
  };
  return JoinTiles(known, fresh, note_chances,
                   {.upkeep = &options.upkeep,
                    .selection = &options.selection,
                    .codec = source.codec,
                    .summarizer = source.summarizer,
                    .selector = context.selector,
                    .session_times = context.session_times,
                    .is_judged = context.is_judged});
}

// What the map knows in the tile without the session that is replaced.
Tile KnownOf(const TileShard& shard, SessionId replaced, const Codebook& codebook) {
  if (shard.known != nullptr) {
    return *shard.known;
  }
  if (shard.base.empty()) {
    return EmptyTile(shard.tile_id, codebook.id, codebook.num_subspaces);
  }
  Tile tile = DecodeTile(shard.base);
  return replaced == SessionId{} ? tile : WithoutSession(std::move(tile), replaced);
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

RewrittenTile RewriteTile(const TileRewriteContext& context, const TileShard& shard) {
  const Codebook& codebook = context.source->codec->codebook();
  RewrittenTile rewritten;
  Tile tile = KnownOf(shard, context.replaced_session, codebook);
  if (context.source->session->images_of_tile.contains(shard.tile_id)) {
    RequireCodebook(tile, codebook.id);
    JoinedTile joined = JoinSession(tile, context, shard.tile_id, shard.keyframe_ids);
    tile = std::move(joined.tile);
    rewritten.replaced_keyframes = std::move(joined.replaced_keyframes);
    rewritten.changes = joined.changes;
  }
  rewritten.encoded = EncodeForMap(tile, codebook);
  rewritten.changes.num_bytes_before = std::ssize(shard.base);
  rewritten.changes.num_bytes_after = std::ssize(rewritten.encoded.payload);
  return rewritten;
}

}  // namespace cairn
