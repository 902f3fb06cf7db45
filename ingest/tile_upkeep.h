// The upkeep of a tile once its sessions are joined: landmarks fade, keyframes give way, and a
// selection meets the budget. Private to ingest.
#ifndef CAIRN_INGEST_TILE_UPKEEP_H_
#define CAIRN_INGEST_TILE_UPKEEP_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "ingest/ingest_options.h"
#include "ingest/tiles/landmark_history.h"
#include "ingest/tiles/landmark_selection.h"
#include "storage/tile/tile.h"

namespace cairn {

// Returns the tile without landmarks that probably exist no more.
Tile WithoutFaded(const Tile& tile, const UpkeepOptions& upkeep, const SessionTimes& times);

// Returns the tile without these keyframes.
Tile WithoutKeyframes(const Tile& tile, const std::vector<KeyframeId>& keyframes);

// Returns, for each landmark, the observations that a future session can expect, plus
// `min_observations`: any landmark of a map was seen often enough once, so that the selection
// refuses none.
std::vector<double> RateByHistory(const Tile& tile, const SessionTimes& times,
                                  const PersistenceOptions& persistence, int min_observations);

// Returns the tile cut down to the budget of `selector`, which has `options`, and to `max_bytes`,
// as EstimateBytes counts them, if given, but to no less than half of the descriptors. `rates` has
// the worth of each landmark, in observations.
Tile SelectLandmarks(const Tile& tile, std::vector<double> rates, std::optional<int64_t> max_bytes,
                     const LandmarkSelectionOptions& options, const LandmarkSelector& selector);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILE_UPKEEP_H_
