// Asks keyframes of the map what a session would take from them, before it is published. Private to
// ingest.
#ifndef CAIRN_INGEST_GATE_SESSION_H_
#define CAIRN_INGEST_GATE_SESSION_H_

#include <cstddef>
#include <functional>
#include <memory>

#include "ingest/place/ask_keyframes.h"
#include "ingest/place/tile_memory.h"
#include "ingest/session_plan.h"
#include "ingest/session_tile_builder.h"
#include "storage/map/map_store.h"

namespace cairn {

// Returns whether the map may have keyframes to ask, and the gate may refuse what they lose.
bool AsksKeyframes(const SessionPlan& plan);

// Returns the built tile of plan.tiles[tile_idx]. Safe to call from any thread.
using LoadBuiltTile = std::function<BuiltTile(size_t tile_idx)>;

// Asks the map's keyframes near the photos of the session, in the tiles that the plan would publish
// and their neighbors in the latest version. `load` returns the built tile of plan.tiles[tile_idx];
// tiles are asked for more than once. The map is only read, and not locked. Does nothing if
// plan.gate allows to lose all answers, or if the plan changes nothing. Reports "answers". Throws
// as RequireAnswers, unless the session is kept apart: then its owner knows that it contradicts the
// map, and the answers are only counted. Tiles that `memory` has are not decoded again.
KeyframeAnswers RequireKeyframes(const SessionPlan& plan, const LoadBuiltTile& load,
                                 const MapStore& store, const std::shared_ptr<TileMemory>& memory,
                                 int num_threads, const IngestProgress& progress);

}  // namespace cairn

#endif  // CAIRN_INGEST_GATE_SESSION_H_
