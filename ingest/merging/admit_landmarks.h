// Which new landmarks a tile takes from a session that the map knows in part.
#ifndef CAIRN_INGEST_MERGING_ADMIT_LANDMARKS_H_
#define CAIRN_INGEST_MERGING_ADMIT_LANDMARKS_H_

#include <cstdint>
#include <vector>

#include "storage/tile/tile.h"

namespace cairn {

// Landmarks of `fresh` that `known` has, and as many of the others as its keyframes need to see
// `enough_landmarks` each; those that most keyframes saw come first. A keyframe that sees less than
// a quarter of `enough_landmarks` that the map knows stands on new ground: the tile takes all that
// it sees. Where the map already knows what a keyframe sees, only what is known is updated: the map
// grows with change, not with visits (Buerki et al., "Map management for efficient long-term visual
// localization in outdoor environments", 2018). Ascending indices into the landmarks of `fresh`.
// Linear but for one sort.
std::vector<uint32_t> AdmitLandmarks(const Tile& known, const Tile& fresh, int enough_landmarks);

}  // namespace cairn

#endif  // CAIRN_INGEST_MERGING_ADMIT_LANDMARKS_H_
