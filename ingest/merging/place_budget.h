// How large a tile may be once several sessions have seen it.
#ifndef CAIRN_INGEST_MERGING_PLACE_BUDGET_H_
#define CAIRN_INGEST_MERGING_PLACE_BUDGET_H_

#include <cstdint>
#include <optional>

#include "storage/tile/tile.h"

namespace cairn {

// About the bytes of the tile's payload, from its counts alone: the same for every version of the
// compressor, and additive in landmarks and keyframes.
int64_t EstimateBytes(const Tile& tile);

// Most bytes, as EstimateBytes counts them, that `known` may have after a session that gives it
// `admitted`. A tile grows freely until three sessions have seen it. From then on, it grows only by
// what the session's keyframes on new ground see and the tile does not know: new ground has no
// keyframe of the tile near by (ingest/tiling/near_view.h). Returns nothing for a tile that may
// grow freely.
std::optional<int64_t> BytesOfPlace(const Tile& known, const Tile& admitted);

}  // namespace cairn

#endif  // CAIRN_INGEST_MERGING_PLACE_BUDGET_H_
