#include "ingest/session_tile_builder.h"

#include "ingest/tiles/build_tile.h"

namespace cairn {
namespace {

std::vector<KeyframeRecord> KeyframesOf(const TileShard& shard, SessionId session_id) {
  std::vector<KeyframeRecord> records;
  for (size_t i = 0; i < shard.keyframe_ids.size(); ++i) {
    const ReconImage& image = shard.reconstruction.images[i];
    KeyframeRecord& record = records.emplace_back();
    record.id = shard.keyframe_ids[i];
    record.session_id = session_id;
    record.tile_id = shard.tile_id;
    record.image_name = image.name;
    record.camera = shard.reconstruction.cameras[image.camera_idx];
    record.cam_from_ecef = shard.session.cam_from_ecef[i];
  }
  return records;
}

}  // namespace

SessionTileBuilder::SessionTileBuilder(const SessionPlan& plan)
    : plan_(plan),
      codec_(plan.codebook),
      summarizer_(MakeAppearanceSummarizer(plan.options.appearance)),
      selector_(MakeLandmarkSelector(plan.options.selection)) {}

BuiltTile SessionTileBuilder::Build(const TileShard& shard) const {
  const TileSource source{&shard.reconstruction, &shard.session,   &codec_,
                          summarizer_.get(),     plan_.session.id, shard.landmark_ids};
  const TileRewriteContext context{&plan_.options,       &source,
                                   selector_.get(),      plan_.replaced_session,
                                   &plan_.session_times, IsJudged(plan_.comparison)};
  return {RewriteTile(context, shard), KeyframesOf(shard, plan_.session.id)};
}

}  // namespace cairn
