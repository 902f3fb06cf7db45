// The comparison of two maps. Private to ingest.
#ifndef CAIRN_INGEST_MAPS_MEET_MAPS_H_
#define CAIRN_INGEST_MAPS_MEET_MAPS_H_

#include <unordered_map>
#include <vector>

#include "ingest/maps/merge_source.h"
#include "ingest/place/compare_with_map.h"
#include "ingest/tiles/link_landmarks.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/ids.h"

namespace cairn {

// Localizes keyframes of `b` in `a` as those of a session (CompareWithMap): see FeaturesOfKeyframe
// for what the queries have. Only keyframes in tiles of b that lie near tiles of a count. Tiles of
// b come in the codes of a.
MapComparison CompareMaps(const MergeSource& a, const MergeSource& b, int num_threads);

// Returns the landmarks of b that a has, too, with their ids there; see ProposeLinks for what two
// landmarks must have in common. Each landmark has at most one link: the links with the nearest
// descriptors are taken first. `codec` is that of both.
std::unordered_map<LandmarkId, LandmarkId> LinkMaps(const MergeSource& a, const MergeSource& b,
                                                    const std::vector<TileId>& tiles,
                                                    const DescriptorCodec& codec,
                                                    const LinkOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_MEET_MAPS_H_
