// Selects the landmarks that a new session adds to a tile of the map.
#ifndef CAIRN_INGEST_TILES_ADMIT_LANDMARKS_H_
#define CAIRN_INGEST_TILES_ADMIT_LANDMARKS_H_

#include <cstdint>
#include <vector>

#include "storage/tile/tile.h"

namespace cairn {

// Returns ascending indices into the landmarks of `fresh`:
//  - all landmarks that `known` has, too;
//  - further landmarks until each keyframe of `fresh` sees what it needs, known and new together:
//    55 % of the landmarks that it saw itself, at most `enough_landmarks`. Both numbers grow in
//    proportion once `fresh` has more than kBytesOverOneSession times the bytes of `known`, so that
//    a session that sees much more than the ones before it is taken in. Landmarks that most
//    keyframes see come first;
//  - all landmarks of a keyframe on new ground, which sees fewer than a quarter of what it needs
//    among those that `known` has.
// The map therefore grows with change and not with visits (Buerki et al., "Map management for
// efficient long-term visual localization in outdoor environments", 2018). Takes linear time, apart
// from one sort.
std::vector<uint32_t> AdmitLandmarks(const Tile& known, const Tile& fresh, int enough_landmarks);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_ADMIT_LANDMARKS_H_
