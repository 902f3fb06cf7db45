// The second step of an ingest: builds the tiles of a plan, one by one.
#ifndef CAIRN_INGEST_SESSION_TILE_BUILDER_H_
#define CAIRN_INGEST_SESSION_TILE_BUILDER_H_

#include <memory>
#include <vector>

#include "ingest/session_plan.h"
#include "ingest/tile_rewriter.h"
#include "ingest/tiles/appearance.h"
#include "ingest/tiles/landmark_selection.h"
#include "ingest/tiles/tile_shard.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {

// A tile that is ready to be published.
struct BuiltTile {
  RewrittenTile tile;
  std::vector<KeyframeRecord> keyframes;  // Of the session, with their reserved ids.
};

// Knows no map. Immutable; safe to use from any thread. The plan must outlive it.
class SessionTileBuilder {
 public:
  // The plan must not be one that changes nothing.
  explicit SessionTileBuilder(const SessionPlan& plan);

  // Depends on the plan and the shard only. Throws as RewriteTile.
  BuiltTile Build(const TileShard& shard) const;

 private:
  const SessionPlan& plan_;
  DescriptorCodec codec_;
  std::unique_ptr<AppearanceSummarizer> summarizer_;
  std::unique_ptr<LandmarkSelector> selector_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_SESSION_TILE_BUILDER_H_
