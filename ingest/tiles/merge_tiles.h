// Merges the tile of a new session into the tile of the map.
#ifndef CAIRN_INGEST_TILES_MERGE_TILES_H_
#define CAIRN_INGEST_TILES_MERGE_TILES_H_

#include <cstdint>

#include "ingest/tiles/appearance.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/tile/tile.h"

namespace cairn {

struct MergeOptions {
  // Factor on the weights of all earlier observations: a session counts twice as much as the one
  // before.
  double old_weight_share = 0.5;
  // Two descriptors nearer than this share of the median distance between descriptors of one
  // landmark are averaged.
  double same_look_share = 0.5;
  // The smallest standard deviation of a merged position, because the errors of sessions are not
  // independent.
  double least_sigma_m = 0.01;

  void Validate() const;
};

// Both tiles have one tile id and one codebook. `known` holds no session of `fresh`. Landmarks of
// the same id are merged. The result has the landmarks of `known` in their order, then the other
// landmarks of `fresh`, and the keyframes of both in the same order.
//
// The position of a merged landmark is the mean by inverse variances. Similar descriptors are
// averaged by weight. The heaviest descriptors are kept, as many as `summarizer` grants for that
// weight of observations. The history gets the entries of `fresh`. Deterministic. Linear in both
// tiles.
Tile MergeTiles(const Tile& known, const Tile& fresh, const DescriptorCodec& codec,
                const AppearanceSummarizer& summarizer, const MergeOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_MERGE_TILES_H_
