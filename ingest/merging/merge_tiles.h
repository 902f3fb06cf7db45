// Joins what a new session saw from a tile with what the tile holds: landmarks of the same id
// become one.
#ifndef CAIRN_INGEST_MERGING_MERGE_TILES_H_
#define CAIRN_INGEST_MERGING_MERGE_TILES_H_

#include <cstdint>

#include "ingest/summarize/appearance.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/tile/tile.h"

namespace cairn {

struct MergeOptions {
  // Weight of all sights before the session: a session counts twice as much as the one before it.
  double old_weight_share = 0.5;
  // Two descriptors nearer than this share of the median distance between looks at one landmark say
  // the same.
  double same_look_share = 0.5;
  // No number of sessions makes a landmark more certain than this: their errors are not
  // independent.
  double least_sigma_m = 0.01;

  void Validate() const;
};

// Both tiles are of one tile id and codebook, and `fresh` comes from one session that `known` does
// not hold. The result has the landmarks of `known`, those that `fresh` has, too, merged in place,
// then the other landmarks of `fresh`; the keyframes of both, of `known` first.
//
// A merged landmark has the mean position by inverse variances. Of its descriptors, those that say
// the same are averaged by weight, and the heaviest are kept: as many as `summarizer` gives to a
// landmark with so many sights (by weight). Its history gets the sighting of
// `fresh`. Deterministic. Linear in both tiles.
Tile MergeTiles(const Tile& known, const Tile& fresh, const DescriptorCodec& codec,
                const AppearanceSummarizer& summarizer, const MergeOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_MERGING_MERGE_TILES_H_
