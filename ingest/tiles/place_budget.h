// How large a tile may be once several sessions have seen it.
#ifndef CAIRN_INGEST_TILES_PLACE_BUDGET_H_
#define CAIRN_INGEST_TILES_PLACE_BUDGET_H_

#include <cstdint>
#include <optional>

#include "storage/tile/tile.h"

namespace cairn {

// Sessions of the same streets make a place at most this many times as large as one of them. See
// docs/decisions/0028-a-place-has-its-size-after-three-sessions.md.
inline constexpr double kBytesOverOneSession = 1.25;

// About the bytes of the tile's payload, from its counts alone: the same for every version of the
// compressor, and additive in landmarks and keyframes.
int64_t EstimateBytes(const Tile& tile);

// Most bytes, as EstimateBytes counts them, that `known` may have after a session that sees `fresh`
// in it and gives it `admitted`. A tile grows freely until three sessions have seen it. From then
// on, it may have the larger one of two sizes:
//  - its size, and what the session's keyframes on new ground see and the tile does not know. New
//    ground has no keyframe of the tile near by (ingest/tiles/near_view.h);
//  - the size that sessions like this one alone give a place: kBytesOverOneSession times that of
//    `fresh`. So a session that sees much more than the ones before it is taken in.
// Returns nothing for a tile that may grow freely.
std::optional<int64_t> BytesOfPlace(const Tile& known, const Tile& fresh, const Tile& admitted);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_PLACE_BUDGET_H_
